"""Functions of the user that raise, change their shape or write to the state end a run that is kept up to there."""

import math
import warnings

import numpy as np
import pytest

import kanefe as kf
from bouncing_scenes import swinging_rod

LATER = 0.5
"""When the functions go wrong, s: after many steps."""


def driven(position) -> kf.System:
    """Return a rod that is turned as a function says."""
    scene = kf.System()
    joint = kf.Revolute("z", motion=kf.Motion(position, lambda t: 0.0, lambda t: 0.0))
    scene.add_rigid_body("rod", 1.0, 1.0 / 12.0, com=(0.5, 0.0, 0.0), joint=joint)
    return scene


def pushed(torque) -> kf.System:
    """Return a pendulum with a torque that is a function."""
    scene = swinging_rod()
    scene.add_torque(scene.body("rod"), torque)
    return scene


def hung(force) -> kf.System:
    """Return a point on a spring whose force is a function of its length; it is 1.2 m long at 0.2 s."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_spring("cord", scene.ground, scene.add_point("weight", 1.0, at=(0, 0, -1)), force=force)
    return scene


def broken(is_late: bool) -> float:
    """Raise an error if it is late."""
    if is_late:
        raise ValueError("my own mistake")
    return 1.0


def written(t, state) -> tuple[float, float, float]:
    """Write to the state."""
    if t > LATER:
        state.q[0] = 3.0
    return 0.0, 0.0, 1.0


def of_event(function, action=None) -> dict[str, kf.Event]:
    """Return the options of a run with one event."""
    return {"events": kf.Event("mark", function, action=action)}


def at_half(t, state) -> float:
    return t - LATER


RAISED = r"raised ValueError: my own mistake \(broken, line \d+ of test_bad_functions.py\). Remedy: mend broken"
CASES = {
    "a load raises": (pushed, lambda t: (0, 0, broken(t > LATER)), {}, f"the torque on 'rod' at t = 0.5.* {RAISED}"),
    "a motion raises": (driven, lambda t: broken(t > LATER) - 1.0, {}, f"motion of body 'rod' at t = 0.* {RAISED}"),
    "a spring raises": (hung, lambda length, rate: broken(length > 1.2), {}, f"spring 'cord' at t = 0.2.* {RAISED}"),
    "an event raises": (
        swinging_rod,
        None,
        of_event(lambda t, state: broken(t > LATER)),
        f"the function of event 'mark' at t = 0.5.* {RAISED}",
    ),
    "an action raises": (
        swinging_rod,
        None,
        of_event(at_half, lambda t, state: broken(True)),
        f"the action of event 'mark' at t = 0.5 s {RAISED}",
    ),
    "a load changes its shape": (
        pushed,
        lambda t: (0, 0, 1.0) if t < LATER else (0, 1.0),
        {},
        r"the torque on 'rod' must give three finite numbers; at t = 0.5.*it gave \(0, 1.0\)",
    ),
    "a motion changes its shape": (
        driven,
        lambda t: 0.0 if t < LATER else np.zeros(2),
        {},
        r"the motion of body 'rod' must give finite numbers; its position at t = 0.5.* is \[0. 0.\]",
    ),
    "a spring changes its shape": (
        hung,
        lambda length, rate: 1.0 if length < 1.2 else np.zeros(2),
        {},
        "the force of spring 'cord' must be one finite number; at t = 0.2",
    ),
    "an action gives a text": (
        swinging_rod,
        None,
        of_event(at_half, lambda t, state: "stop"),
        "the action of event 'mark' must return 2 finite numbers.* at t = 0.5 s it gave 'stop'. Remedy: a changed copy",
    ),
    "a load writes to the state": (
        pushed,
        written,
        {},
        "the torque on 'rod' at t = 0.5.* raised ValueError: .*read-only .*Remedy: change a copy",
    ),
    "an action writes to the state": (
        swinging_rod,
        None,
        of_event(at_half, lambda t, state: state.q.fill(1.0)),
        "the action of event 'mark' at t = 0.5 s raised ValueError: .*read-only.*Remedy: change a copy",
    ),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_bad_function_is_named_with_time_and_remedy_and_the_run_is_kept(case, method):
    make, function, options, message = CASES[case]
    scene = make() if function is None else make(function)
    with pytest.warns(kf.SimulationWarning, match=message):
        result = scene.simulate((0.0, 1.0), method=method, **options)
    assert result.status.kind == "failed"
    assert len(result.times) > 50
    assert 0.1 < result.times[-1] < 0.75  # the step before that in which it went wrong
    assert np.isfinite(result.position(result.run.model.bodies[0].name)).all()


def test_what_goes_wrong_at_the_start_comes_through():
    with pytest.raises(ValueError, match="my own mistake") as raised:
        swinging_rod().simulate((0.0, 1.0), **of_event(lambda t, state: broken(True)))
    assert raised.value.__notes__ == ["the function of event 'mark' at t = 0 s"]


def test_an_error_of_the_library_is_none_of_the_user(monkeypatch):
    """It comes through, with all that says where it was raised."""
    scene, count = pushed(lambda t: (0, 0, math.sin(t))), []

    def fails(*given):
        count.append(0)
        if len(count) > 50:
            raise TypeError("of the library")
        return evaluate(*given)

    route = type(scene.freeze().route)
    evaluate = route.evaluate
    fails.__code__ = fails.__code__.replace(co_filename=route.evaluate.__code__.co_filename)
    monkeypatch.setattr(route, "evaluate", fails)
    with warnings.catch_warnings(), pytest.raises(TypeError, match="of the library"):
        scene.simulate((0.0, 1.0))
