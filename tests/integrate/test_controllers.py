"""Sampled controllers: the exact sequence of a held drive, delays, what is read, the log, and what is refused."""

import pickle
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.auto.explicit_rates import look_at_state
from kanefe.integrate.auto.trials import Stretch, went_over
from kanefe.states.state import State
from kanefe_fem import Material, Rectangle, beam_body, straight_beam
from steel_beams import steel_bar

EVERY, MASS = 0.02, 2.0
READS = ("joint_coordinates cart", "joint_speeds cart")


def pull(t: float, reads: np.ndarray, memory: dict[str, Any]) -> float:
    memory["sum"] = memory.get("sum", 0.0) + EVERY * reads[0]
    return 30.0 * (1.0 - reads[0]) - 4.0 * reads[1] - 5.0 * memory["sum"]


def cart(function: Callable[..., Any] = pull, **options: Any) -> kf.System:
    scene = kf.System()
    scene.add_rigid_body("cart", MASS, joint=kf.Prismatic("x"))
    given = {"every": EVERY, "reads": READS, "drives": "motor cart"} | options
    scene.add_controller("pull", function, **given)
    return scene


def held_exactly(samples: int, late: float = 0.0) -> np.ndarray:
    """Return position and speed at samples: the force of the sample before until `late`, then that of this one."""
    x = v = force = 0.0
    memory: dict[str, Any] = {}
    found = []
    for k in range(samples):
        found.append((x, v))
        new = pull(k * EVERY, np.array((x, v)), memory)
        for h, acting in ((late, force), (EVERY - late, new)):
            x, v = x + h * v + 0.5 * h * h * acting / MASS, v + h * acting / MASS
        force = new
    return np.array(found)


@pytest.mark.parametrize("method", ["auto", "rk4", "radau5", "extrapolation", "generalised-alpha"])
def test_a_drive_is_held_from_sample_to_sample(method: str) -> None:
    step = {"step": EVERY / 2.5} if method == "rk4" else {}
    result = cart().simulate((0.0, 0.5), method=method, output_step=0.07, **step)
    log = result.controllers["pull"]
    np.testing.assert_allclose(log.times, EVERY * np.arange(25), rtol=0, atol=1e-14)
    # a constant force is exact for all methods but generalised-alpha, whose jumps of acceleration cost its tolerance
    atol = 1e-4 if method == "generalised-alpha" else 1e-11
    np.testing.assert_allclose(log.reads, held_exactly(25), rtol=0, atol=atol)
    assert abs(result.energy.balance_error).max() < (1e-3 if method == "generalised-alpha" else 1e-5)


def test_drives_begin_to_act_after_the_delay() -> None:
    late = 0.3 * EVERY
    log = cart(delay=late).simulate((0.0, 0.3)).controllers["pull"]
    np.testing.assert_allclose(log.reads, held_exactly(15, late), rtol=0, atol=1e-11)
    # of more than a sample: the first force comes with the fourth sample
    log = cart(delay=3 * EVERY).simulate((0.0, 0.3)).controllers["pull"]
    assert not log.reads[:4].any()
    np.testing.assert_allclose(log.reads[4, 1], EVERY * 30.0 / MASS, rtol=1e-10)


def test_a_run_is_the_same_for_any_outputs_and_each_run_forgets() -> None:
    scene = cart()
    first, second = (scene.copy().simulate((0.0, 0.4), output_step=step) for step in (0.4, 0.013))
    np.testing.assert_allclose(first.controllers["pull"].drives, second.controllers["pull"].drives, rtol=0, atol=1e-11)


def arm() -> kf.System:
    """Return an arm in space, with a controller that reads and drives all kinds of things."""
    scene = kf.System(gravity=(0, 0, -9.81))
    base = scene.add_rigid_body(
        "base", 2.0, 0.3, com=(0.1, 0, 0), joint=kf.Universal(position=(0.3, 0.2), speed=(1, 2))
    )
    scene.add_rigid_body("end", 1.0, 0.2, com=(0.2, 0.1, 0), parent=base, at=(0.5, 0, 0.1), joint=kf.Revolute("y"))
    reads = ("position end", "velocity end x", "angular_velocity end z'", "acceleration end y", "joint_speeds base")
    drives = {"T": "motor end", "side": "force end y'", "turn": "torque base z"}
    scene.add_controller("all", lambda t, reads, memory: (2.0, 1.0 + t, -3.0), every=0.05, reads=reads, drives=drives)
    return scene


def test_what_is_read_and_driven_is_what_the_result_tells() -> None:
    result = arm().simulate((0.0, 0.2), output_step=0.05)
    log = result.controllers["all"]
    assert log.read_names[0] == "position end x [m]"
    assert log.drive_names == ("T [N m]", "side [N]", "turn [N m]")
    k = slice(0, 4)
    np.testing.assert_allclose(log.reads[:, :3], result.position("end")[k], atol=1e-13)
    np.testing.assert_allclose(log.reads[:, 3], result.velocity("end")[k, 0], atol=1e-13)
    np.testing.assert_allclose(log.reads[:, 4], result.angular_velocity("end")[k, 2], atol=1e-13)
    np.testing.assert_allclose(log.reads[:, 6:], result.joint_speeds("base")[k], atol=1e-13)
    # accelerations of a result are with the drives that act from the sample on, in the literal route as in sweeps
    assert result.run is not None
    model = result.run.model
    for i in range(4):
        q, u, z = model.parts(result.run.states[i])
        np.testing.assert_allclose(z, (2.0, 1.0 + 0.05 * i, -3.0), atol=1e-14)
        frame, du = State(model, 0.05 * i, q, u, z).motions[1], model.literal.evaluate(0.05 * i, result.run.states[i])
        a = frame.A_NF @ (frame.V @ du.rates[len(q) : len(q) + len(u)] + frame.Z)
        np.testing.assert_allclose(result.acceleration("end")[i], a, atol=1e-10)
    assert abs(result.energy.balance_error).max() < 1e-6  # of some joules, at rtol 1e-6


def test_logs_are_saved_and_pickled(tmp_path: Path) -> None:
    result = cart().simulate((0.0, 0.1))
    result.save(tmp_path / "run.h5")
    for kept in (kf.load_result(tmp_path / "run.h5"), pickle.loads(pickle.dumps(result))):
        log, before = kept.controllers["pull"], result.controllers["pull"]
        assert log.read_names == before.read_names
        np.testing.assert_array_equal(log.drives, before.drives)


def test_events_and_samples_share_a_run() -> None:
    passing = kf.Event("middle", lambda t, state: state.joint_coordinates("cart")[0] - 0.3, direction=1)
    result = cart().simulate((0.0, 0.5), events=passing)
    crossing = result.events["middle"][0]
    np.testing.assert_allclose(
        np.interp(crossing, result.times, result.joint_coordinates("cart")[:, 0]), 0.3, atol=1e-4
    )
    np.testing.assert_allclose(result.controllers["pull"].reads, held_exactly(25), rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"every": 0.0}, "every of controller 'pull' must be above zero"),
        ({"delay": -1.0}, "delay of controller 'pull' must be zero or more"),
        ({"reads": "joint_coordinate cart"}, "reads 'joint_coordinate cart': there is no 'joint_coordinate'"),
        ({"reads": "position car"}, "no body called 'car'. It has: cart"),
        ({"reads": ()}, "must be one or more texts"),
        ({"drives": "gravity x"}, "does not drive a gravity. Remedy: force"),
        ({"drives": "motor cart 1"}, r"no such free coordinate. There are: 0 \(distance\)"),
        ({"drives": "force cart q"}, "'q' is not an axis"),
        ({"function": lambda t, reads: 0.0}, r"needs a function f\(t, reads, memory\)"),
        ({"function": 3.0}, "needs a function"),
    ],
)
def test_what_makes_no_sense_is_refused_at_the_door(options: dict[str, Any], words: str) -> None:
    with pytest.raises(kf.ModelError, match=words):
        cart(**options)


def test_what_a_run_cannot_do_is_told(tmp_path: Path) -> None:
    with pytest.raises(
        kf.ModelError, match=r"controller 'pull' must give one finite number \(motor cart \[N\]\); at t ="
    ):
        cart(lambda t, reads, memory: (1.0, 2.0)).simulate((0.0, 0.1))
    with pytest.raises(kf.ModelError, match="does not end its steps at the samples"):
        cart().simulate((0.0, 0.1), method="scipy-bdf")
    with pytest.raises(kf.ModelError, match="have no checkpoints"):
        cart().simulate((0.0, 0.1), checkpoint=tmp_path / "run.ckpt")
    scene = cart()
    with pytest.raises(kf.ModelError, match="already has a controller 'pull'"):
        scene.add_controller("pull", pull, every=EVERY, reads=READS, drives="motor cart")


def test_a_result_says_what_share_of_the_time_users_functions_took() -> None:
    def slow(t: float, *_: Any) -> float:
        time.sleep(1e-3)
        return 1.0

    scene = cart(slow)
    scene.add_motor(scene.body("cart"), slow)
    result = scene.simulate((0.0, 0.1))
    parts = result.statistics["seconds_by_part"]
    for name, calls in (("controllers", 5), ("Python functions", result.statistics["evaluations"])):
        assert parts[name] >= 1e-3 * calls
        assert f"{name} {parts[name]:.3g} ({parts[name] / result.statistics['seconds']:.0%})" in str(result)


def _held_level() -> kf.System:
    """Return a flexible bar whose motor a controller holds at 1 kHz."""
    scene = steel_bar(reduction=kf.CraigBampton(modes=12), damping=kf.ModalDamping(0.05))
    reads = ("joint_coordinates bar", "joint_speeds bar")

    def level(t: float, reads: np.ndarray, memory: dict) -> float:
        return -20.0 * reads[0] - 0.5 * reads[1]

    scene.add_controller("level", level, every=1e-3, reads=reads, drives="motor bar")
    return scene


def test_radau_keeps_its_jacobian_and_factors_over_samples() -> None:
    run = _held_level().simulate((0.0, 0.2), method="radau5", rtol=1e-4, output_step=0.2)
    assert run.statistics["jacobians"] < 20  # there are 200 samples
    assert run.statistics["factorisations"] < run.statistics["steps"]


def _swung() -> kf.System:
    """Return an arm of two flexible bars that a controller swings at 1 kHz, each along a smooth way."""
    model = straight_beam(0.5, Rectangle(0.045, 0.06), Material(E=70e9, nu=0.33, rho=2700.0), elements=6)
    bar = beam_body(model, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=6), kf.ModalDamping(0.02))
    scene = kf.System(gravity=(0, 0, -9.81))
    first = scene.add_flexible_body("first", bar, joint=kf.Revolute("y"))
    elbow = kf.Revolute("y", position=0.8)
    second = scene.add_flexible_body("second", bar, parent=first.interface("tip"), joint=elbow)
    scene.add_rigid_body("tool", 1.5, 2e-3, parent=second.interface("tip"))

    def swing(t: float, reads: np.ndarray, memory: dict) -> tuple[float, float]:
        x = t / 0.6
        way, rate = x**3 * (10 - 15 * x + 6 * x * x), 50 * x * x * (1 - x) ** 2
        wanted = -0.9 * way, -0.9 * rate, 0.8 - 0.6 * way, -0.6 * rate
        missed = np.array(wanted) - reads
        return 800.0 * missed[0] + 50.0 * missed[1], 200.0 * missed[2] + 12.0 * missed[3]

    reads = tuple(f"{what} {name}" for name in ("first", "second") for what in ("joint_coordinates", "joint_speeds"))
    scene.add_controller("swing", swing, every=1e-3, reads=reads, drives=("motor first", "motor second"))
    return scene


def test_a_sample_of_a_moving_arm_does_not_end_steps_and_matrices_of_before() -> None:
    """Its mass changes with the elbow: a jump that moves stiff modes pushes the joints once, which is no divergence."""
    scene = _swung()
    run, fine = (
        scene.copy().simulate((0.0, 0.1), method="radau5", rtol=rtol, output_step=0.1) for rtol in (1e-3, 1e-5)
    )
    assert run.statistics["rejected"] < 10  # at 100 samples; there were 41
    assert run.statistics["jacobians"] < 10  # there were 44
    np.testing.assert_allclose(run.position("tool"), fine.position("tool"), atol=1e-3)


def test_what_is_held_is_no_function_of_the_state() -> None:
    assert not look_at_state(_held_level().freeze())


def test_a_trial_goes_over_the_samples_of_its_stretch_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[tuple[float, float, list[float]]] = []

    def spying(rival: object, stretch: Stretch, end: tuple[float, np.ndarray], *others: object) -> object:
        seen.append((stretch.t, end[0], [t for t, _ in stretch.samples]))
        return went_over(rival, stretch, end, *others)

    monkeypatch.setattr("kanefe.integrate.auto.tried_methods.went_over", spying)
    _held_level().simulate((0.0, 0.2), rtol=1e-8, output_step=0.2)
    assert any(samples for _, _, samples in seen)
    for start, end, samples in seen:
        assert all(start <= t <= end for t in samples)


@pytest.mark.parametrize("rtol", [1e-5, 1e-6, 1e-8])
def test_auto_has_no_jacobians_made_anew_at_each_sample(rtol: float) -> None:
    scene = _held_level()
    run, fine = (
        scene.simulate((0.0, 0.2), method=method, rtol=r, output_step=0.2)
        for method, r in (("auto", rtol), ("dop853", 1e-9))
    )
    assert run.statistics["method"].startswith("extrapolation")
    assert "controllers restart every method each 0.001 s" in run.statistics["reason"] or rtol == 1e-5
    assert run.statistics["jacobians"] < 20  # those of trials; there are 200 samples
    # the bar falls by 5 cm; a hundred runs from sample to sample, each with errors of rtol
    np.testing.assert_allclose(run.joint_coordinates("bar"), fine.joint_coordinates("bar"), atol=100 * rtol)
