"""Forces along joint coordinates: spring, damper and stops, by themselves and in motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.integrate.auto.choice import choose
from kanefe.integrate.options import RunOptions
from robustness.tripod import tripod
from scenes import derivatives

STOPPED = {"limits": (-0.5, 1.0), "limit_stiffness": 100.0, "limit_damping": 8.0}
FORCES = {
    "spring": kf.CoordinateForce(3.0, 0.5, rest=0.2),
    "stops": kf.CoordinateForce(**STOPPED),
    "one stop": kf.CoordinateForce(limits=(None, 0.4), limit_stiffness=50.0),
    "everything": kf.CoordinateForce(3.0, 0.5, 0.2, **STOPPED),
}
POINTS = [(q, rate) for q in (-0.8, -0.3, 0.7, 1.3) for rate in (-7.0, -0.2, 0.0, 0.1, 6.0)]


@pytest.mark.parametrize("force", FORCES.values(), ids=FORCES)
def test_the_force_is_minus_the_slope_of_the_potential_less_what_dissipates(force: kf.CoordinateForce) -> None:
    for q, rate in POINTS:
        slope, _ = derivatives(lambda s, q=q: np.array(force.potential(q + s)), 0.005)
        conservative = -float(slope)
        # order-8 differences of a quadratic: round-off 1e-14 / 0.005
        assert (conservative - force.force(q, rate)) * rate == pytest.approx(force.dissipation(q, rate), abs=1e-10)
        assert force.dissipation(q, rate) >= -1e-14
        assert force.force(q, 0.0) == pytest.approx(conservative, abs=1e-10)


@pytest.mark.parametrize("force", FORCES.values(), ids=FORCES)
def test_slopes_are_those_of_the_force(force: kf.CoordinateForce) -> None:
    for q, rate in POINTS:
        by_q, _ = derivatives(lambda s, q=q, rate=rate: np.array(force.force(q + s, rate)), 0.002)
        by_rate, _ = derivatives(lambda s, q=q, rate=rate: np.array(force.force(q, rate + s)), 0.002)
        assert force.slopes(q, rate) == pytest.approx((-float(by_q), -float(by_rate)), abs=1e-9)


def test_a_stop_pushes_back_and_never_pulls() -> None:
    stop = FORCES["stops"]
    assert stop.force(1.1, 0.5) == pytest.approx(-(100.0 * 0.1 + 8.0 * 0.5), rel=1e-14)
    assert stop.force(-0.7, -0.5) == pytest.approx(100.0 * 0.2 + 8.0 * 0.5, rel=1e-14)
    assert stop.force(1.1, -5.0) == 0.0  # leaving faster than the damper lets it: no pull
    assert stop.force(-0.7, 5.0) == 0.0
    assert stop.force(0.99, 100.0) == 0.0
    assert FORCES["one stop"].force(-1e6, 0.0) == 0.0


def test_an_elastic_stop_throws_back_in_half_a_period() -> None:
    m, v, k, gap = 0.5, 2.0, 2e3, 0.3
    forces = kf.CoordinateForce(limits=(-gap, gap), limit_stiffness=k)
    scene = kf.System()
    scene.add_rigid_body("bead", m, joint=kf.Prismatic("x", speed=v, forces=forces))
    w = math.sqrt(k / m)
    hit, free = gap / v, math.pi / w
    result = scene.simulate((0.0, hit + free + 0.1), rtol=1e-9, output_step=0.002)
    x, t = result.joint_coordinates("bead")[:, 0], result.times
    touching = (t > hit - 1e-9) & (t < hit + free)
    exact = np.where(t < hit, v * t, gap - v * (t - hit - free))
    exact[touching] = gap + v / w * np.sin(w * (t[touching] - hit))
    assert x == pytest.approx(exact, abs=1e-7)  # the kinks cost a step's error each
    assert abs(result.energy.balance_error).max() < 1e-7
    assert result.energy.elastic.max() == pytest.approx(0.5 * m * v**2, rel=0.02)


def hard_stop(t: float, state: kf.SceneState) -> tuple[float, float, float]:
    beyond = max(0.0, float(state.joint_coordinates("mass")[0]) - 1e-3)
    return (-1e6 * beyond, 0.0, 0.0)


# free flight makes steps long, and 1 ms later the mass is in a spring of 160 Hz, for half a period
@pytest.mark.parametrize("is_function", [False, True])
@pytest.mark.parametrize("method", ["dop853", "extrapolation"])
def test_no_step_goes_through_a_stop(method: str, is_function: bool) -> None:
    scene = kf.System()
    force = None if is_function else kf.CoordinateForce(limits=(None, 1e-3), limit_stiffness=1e6)
    mass = scene.add_point("mass", 1.0, joint=kf.Prismatic("x", speed=1.0, forces=force))
    if is_function:
        scene.add_force(mass, hard_stop)
    result = scene.simulate((0.0, 0.01), method=method, rtol=1e-6)
    # rtol at the two kinks of the force, and what the estimate misses there
    assert result.velocity("mass")[-1, 0] == pytest.approx(-1.0, rel=1e-3)
    # it turns after 1 ms and half a period
    assert result.position("mass")[-1, 0] == pytest.approx(1e-3 - (0.01 - 1e-3 - math.pi * 1e-3), rel=1e-3)


@pytest.mark.parametrize("forces", [None, kf.CoordinateForce(limits=(-1.0, 1.0), limit_stiffness=1e6)])
def test_auto_leaves_stops_to_methods_that_see_them(forces: kf.CoordinateForce | None) -> None:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z", forces=forces))
    scene.add_flexible_body("bar", tripod((1.0, 1e3, 1e4), np.eye(3), damping=0.02), parent=hub)
    chosen = choose(scene.freeze(), RunOptions(t_span=(0.0, 10.0), rtol=1e-4)).name
    assert chosen == ("extrapolation" if forces is None else "radau5")


def test_a_damped_stop_takes_energy() -> None:
    forces = kf.CoordinateForce(limits=(None, 0.1), limit_stiffness=2e3, limit_damping=10.0)
    scene = kf.System()
    scene.add_rigid_body("bead", 0.5, joint=kf.Prismatic("x", speed=2.0, forces=forces))
    result = scene.simulate((0.0, 0.3), rtol=1e-9)
    assert -2.0 < result.joint_speeds("bead")[-1, 0] < -0.5
    assert abs(result.energy.balance_error).max() < 1e-6
    assert result.energy.dissipated[-1] > 0.1


@pytest.mark.parametrize(
    "joint",
    [
        kf.Cylindrical("z", position=(0.1, 0.2), forces=(kf.CoordinateForce(40.0), kf.CoordinateForce(3.0))),
        kf.Planar(position=(0.1, 0.0), angle=0.2, forces=(kf.CoordinateForce(40.0), None, kf.CoordinateForce(3.0))),
    ],
    ids=["cylindrical", "planar"],
)
def test_each_coordinate_has_its_own_spring(joint: kf.Cylindrical | kf.Planar) -> None:
    m, J = 2.0, 0.3
    scene = kf.System()
    scene.add_rigid_body("body", m, J, joint=joint)
    result = scene.simulate((0.0, 1.0), rtol=1e-9)
    q, t = result.joint_coordinates("body"), result.times
    assert q[:, 0] == pytest.approx(0.1 * np.cos(math.sqrt(40.0 / m) * t), abs=1e-7)
    assert q[:, -1] == pytest.approx(0.2 * np.cos(math.sqrt(3.0 / J) * t), abs=1e-7)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kf.CoordinateForce(-1.0), "stiffness of a joint coordinate must be finite and >= 0, not -1"),
        (lambda: kf.CoordinateForce(damping=np.inf), "damping of a joint coordinate must be finite and >= 0, not inf"),
        (lambda: kf.CoordinateForce(friction=-2.0), "friction of a joint coordinate must be finite and >= 0"),
        (lambda: kf.CoordinateForce(friction="dry"), "friction of a joint coordinate must be finite and >= 0"),
        (lambda: kf.CoordinateForce(rest=np.nan), "rest of a joint coordinate must be finite, not nan"),
        (
            lambda: kf.CoordinateForce(friction=1.0, friction_stiffness=0.0),
            "friction_stiffness .* finite and > 0",
        ),
        (
            lambda: kf.CoordinateForce(friction=1.0, friction_damping=np.nan),
            "friction_damping .* finite and > 0",
        ),
        (lambda: kf.CoordinateForce(static_friction=2.0), "static_friction without friction does nothing"),
        (
            lambda: kf.CoordinateForce(friction=2.0, static_friction=1.0),
            r"static_friction, 1, is below friction, 2\. Remedy: the larger",
        ),
        (
            lambda: kf.CoordinateForce(limits=(1.0, -1.0), limit_stiffness=1.0),
            r"the limits \(1, -1\) of a joint coordinate are reversed\. Remedy: the lower one first",
        ),
        (lambda: kf.CoordinateForce(limits=(0.0, 0.0), limit_stiffness=1.0), "are reversed"),
        (lambda: kf.CoordinateForce(limits=(0.0, 1.0)), r"need a stop to push back\. Remedy: give limit_stiffness"),
        (lambda: kf.CoordinateForce(limit_stiffness=1.0), r"without limits does nothing\. Remedy: give limits"),
        (lambda: kf.CoordinateForce(limits=(0.0,)), "limits of a joint coordinate must be two numbers"),
        (lambda: kf.CoordinateForce(limits="wide"), "limits of a joint coordinate must be two numbers"),
        (lambda: kf.CoordinateForce(limits=(0.0, np.nan)), "limits of a joint coordinate must be two numbers"),
        (
            lambda: kf.Planar(forces=(None, kf.CoordinateForce(1.0))),
            "forces of a planar joint must be 3 of CoordinateForce or None",
        ),
        (lambda: kf.Cylindrical("z", forces=kf.CoordinateForce(1.0)), "forces of a cylindrical joint must be 2 of"),
        (lambda: kf.Universal(motion=(None, 1.0)), "motion of a universal joint must be 2 of Motion or None"),
        (
            lambda: kf.Cylindrical("z", position=(0.0, 0.1), motion=(None, kf.Motion.steady(1.0))),
            r"the angle of a cylindrical joint that is driven by a motion takes its start from it\. Remedy: leave out",
        ),
        (
            lambda: kf.Planar(velocity=(1.0, 0.0), motion=(kf.Motion.steady(1.0), None, None)),
            "the x of a planar joint that is driven",
        ),
        (
            lambda: kf.Spherical(motion=kf.Motion.steady(1.0)),
            r"motion of a spherical joint must be a PoseMotion, a PoseTable or .* revolute and prismatic",
        ),
        (lambda: kf.Free(forces=kf.CoordinateForce(1.0)), "of a free joint cannot carry forces"),
        (lambda: kf.Translation(position=(1, 2)), "position of a translation joint must be 3 finite numbers"),
    ],
)
def test_bad_input_is_named(make: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()
