"""Where steps end: at knots of tables where that is cheaper than to find them out, and where functions of time change.

Between changes functions of the time cost no step: they are sampled before the run.
"""

import math
from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.jumps import NO_CHANGES
from kanefe.tree.scales import displacement_scales
from kanefe_fem.beams.body import beam_body
from steel_beams import steel_beam


def _shaken(motion: kf.Motion) -> kf.System:
    """Return a pendulum whose pivot is driven."""
    scene = kf.System(gravity=(0, 0, -9.81))
    base = scene.add_rigid_body("base", 10.0, 1.0, joint=kf.Prismatic("z", motion=motion))
    scene.add_rigid_body("pendulum", 0.1, 1e-3, com=(0.1, 0, 0), parent=base, joint=kf.Revolute("y"))
    return scene


def _sweep(t: np.ndarray) -> np.ndarray:
    """Return a millimetre of shaking from 5 to 45 Hz in a second, m."""
    return 1e-3 * np.sin(2.0 * np.pi * (5.0 + 20.0 * t) * t)


def _flow(result: kf.Result) -> float:
    """Return the largest energy that was in the scene, J."""
    return float(np.abs(result.energy.kinetic).max())


@pytest.mark.parametrize(
    ("method", "most_rejected", "most_lost"),
    # tries to pass over several knots fail, in 2 of 8, then of 16, ...; radau5 wants shorter steps than from knot to
    # knot, and looks less far ahead; what extrapolation loses is the work of its lowest orders. Across knots there
    # were 7.6, 2.3 and 1.2 rejected steps a knot, and 3e-5, 1e-5 and 3e-3 were lost. Once such a try passes with an
    # error of less than the tolerance, of 1e-8 of a steady part of the energy
    [("dop853", 0.02, 2e-9), ("radau5", 0.15, 1e-6), ("extrapolation", 0.02, 1e-4)],
)
def test_steps_end_at_the_knots_that_matter(method: str, most_rejected: float, most_lost: float) -> None:
    breakpoints = np.linspace(0.0, 1.0, 1001)
    scene = _shaken(kf.Motion.table(breakpoints, _sweep(breakpoints)))
    result = scene.simulate((0.0, 1.0), method=method, rtol=1e-8, output_step=0.01)
    counts = result.statistics
    assert counts["rejected"] < most_rejected * len(breakpoints)
    if method == "dop853":  # one step of high order serves from knot to knot
        assert counts["steps"] < 1.05 * len(breakpoints)
    # the work of the drive, which no tolerance holds, is as good as the steps
    assert np.abs(result.energy.balance_error).max() < most_lost * _flow(result)


def test_the_motion_is_that_of_the_spline() -> None:
    breakpoints = np.linspace(0.0, 1.0, 201)
    table = kf.Motion.table(breakpoints, _sweep(breakpoints))
    tight, loose = (
        _shaken(table).simulate((0.0, 1.0), method="dop853", rtol=rtol, output_step=0.01).joint_coordinates("pendulum")
        for rtol in (1e-12, 1e-8)
    )
    assert np.abs(tight - loose).max() < 1e-7


def test_steps_pass_over_knots_that_do_not_matter() -> None:
    fine = np.linspace(0.0, 1.0, 5001)
    scene = _shaken(kf.Motion.table(fine, 0.01 * np.sin(2.0 * fine)))
    counts = scene.simulate((0.0, 1.0), method="dop853", rtol=1e-6, output_step=0.1).statistics
    assert counts["rejected"] == 0
    assert counts["steps"] < 0.65 * len(fine)  # two pieces at a time: so often tables are looked at


def test_a_run_goes_on_from_before_a_knot() -> None:
    # a step that an event cuts short is taken up again at a time before the knots that it has passed
    breakpoints = np.linspace(0.0, 1.0, 201)
    table = kf.Motion.table(breakpoints, _sweep(breakpoints))
    event = kf.Event("level", lambda t, state: state.joint_coordinates("pendulum")[0] - 0.3)
    plain, stopped = (
        _shaken(table).simulate((0.0, 1.0), rtol=1e-9, output_step=0.01, events=events) for events in ((), (event,))
    )
    assert len(stopped.events["level"]) >= 1
    swings = [result.joint_coordinates("pendulum") for result in (plain, stopped)]
    assert np.abs(swings[0] - swings[1]).max() < 1e-7


SPAN = 20.0


def _pushed(force: Callable[[float], float], *, damping: float = 0.02) -> tuple[kf.System, list[float]]:
    """Return a clamped beam pushed sideways at its tip by a function of time, and the times it is asked for."""
    reduction, asked = kf.CraigBampton(modes=4), []
    damped = kf.ModalDamping(damping) if damping else None
    body = beam_body(steel_beam(), {"root": "clamped", "tip": "rigid"}, reduction=reduction, damping=damped)
    scene = kf.System()
    arm = scene.add_flexible_body("arm", body, joint=kf.Fixed())

    def pushing(t: float) -> tuple[float, float, float]:
        asked.append(t)
        return 0.0, force(t), 0.0

    scene.add_force(arm.interface("tip"), pushing)
    return scene, asked


def _largest(scene: kf.System, **options: object) -> float:
    return float(np.abs(scene.simulate((0.0, SPAN), output_step=0.01, **options).modal_coordinates("arm")).max())


def _waves(t: float) -> float:
    return 20.0 * math.sin(105.0 * t) if t < 0.3 else 0.0


def _blow(t: float) -> float:
    return 20.0 if 7.3 < t < 7.35 else 0.0


def _bell(t: float) -> float:
    return 20.0 * math.exp(-(((t - 9.0) / 0.05) ** 2))


@pytest.mark.parametrize("force", [_waves, _blow, _bell])
@pytest.mark.parametrize("method", ["radau5", "extrapolation", "auto"])
def test_a_short_load_is_not_stepped_over(force: Callable[[float], float], method: str) -> None:
    tight = _largest(_pushed(force)[0], method="radau5", rtol=1e-7)
    # loose runs follow a vibration to some percent; what is stepped over is missed whole, or by two thirds
    assert _largest(_pushed(force)[0], method=method, rtol=1e-3) == pytest.approx(tight, rel=0.15)


@pytest.mark.parametrize("method", ["dop853", "radau5", "extrapolation", "auto"])
def test_a_blow_moves_what_is_rigid(method: str) -> None:
    scene = kf.System()
    block = scene.add_rigid_body("block", 2.0, joint=kf.Prismatic("y"))
    scene.add_force(block, lambda t: (0.0, _blow(t), 0.0))
    end = scene.simulate((0.0, SPAN), method=method, rtol=1e-3, output_step=1.0).joint_coordinates("block")[-1, 0]
    # a constant force is exact in each method, and steps end at both sides of the blow to the last digit
    assert end == pytest.approx(20.0 * 0.05 / 2.0 * (SPAN - 7.325), rel=1e-9)


@pytest.mark.parametrize("rtol", [1e-3, 1e-4])
def test_what_a_short_load_leaves_in_an_undamped_beam_vibrates_on(rtol: float) -> None:
    scene = _pushed(_waves, damping=0.0)[0]
    result = scene.simulate((0.0, SPAN), rtol=rtol, output_step=0.01)
    sizes = np.abs(result.modal_coordinates("arm")).max(axis=1)
    assert result.statistics["method"] == "radau5"
    assert "steps that functions and controllers require" in result.statistics["reason"]
    whole = displacement_scales(scene.freeze())[0]  # what moves the beam by its length
    # a hundredth of that, in some 330 periods, of which each may lose a part of the tolerance
    assert sizes[:200].max() - sizes[-200:].max() < 10.0 * rtol * whole


@pytest.mark.parametrize("method", ["radau5", "extrapolation"])
def test_smooth_loads_cost_no_steps(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, asked = _pushed(lambda t: 20.0 * math.sin(2.0 * t))
    counts = scene.simulate((0.0, SPAN), method=method, rtol=1e-3).statistics
    assert len(asked) < counts["evaluations"] + 1050  # 961 looks, and some at each extreme
    monkeypatch.setattr("kanefe.integrate.breakpoints.changes_of", lambda *_: NO_CHANGES)
    unlooked = _pushed(lambda t: 20.0 * math.sin(2.0 * t))[0].simulate((0.0, SPAN), method=method, rtol=1e-3)
    assert [counts[name] for name in ("steps", "evaluations")] == [
        unlooked.statistics[name] for name in ("steps", "evaluations")
    ]


def test_a_change_of_a_driven_joint_ends_a_step() -> None:
    def jerk(t: float) -> float:
        return 50.0 if 0.4 < t < 0.405 else 0.0

    def speed(t: float) -> float:
        return 50.0 * min(max(t - 0.4, 0.0), 0.005)

    def place(t: float) -> float:
        return speed(t) * (t - 0.4) / 2.0 if t < 0.405 else 50.0 * 0.005 * (t - 0.4025)

    scene = _shaken(kf.Motion(place, speed, jerk))
    loose, tight = (
        scene.copy().simulate((0.0, 1.0), method="dop853", rtol=rtol, output_step=0.01).joint_coordinates("pendulum")
        for rtol in (1e-3, 1e-9)
    )
    assert np.abs(loose - tight).max() < 0.01 * np.abs(tight).max()


def test_functions_that_are_not_known_later_are_asked_as_far_as_the_run_goes() -> None:
    def known(t: float) -> float:
        if t > 5.0:
            raise RuntimeError("no record beyond 5 s")
        return _waves(t)

    scene, _ = _pushed(known)
    ending = kf.Event("4 s", lambda t, state: t - 4.0, terminal=True)
    assert scene.simulate((0.0, SPAN), rtol=1e-3, events=(ending,)).times[-1] == pytest.approx(4.0)
