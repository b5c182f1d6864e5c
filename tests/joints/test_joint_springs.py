"""Springs and dampers across joints: closed forms, energy, and what a drive must overcome."""

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.auto.choice import choose
from kanefe.integrate.auto.stiffest_rate import stiffest_rate
from kanefe.integrate.options import RunOptions


@pytest.mark.parametrize("method", ["dop853", "generalised-alpha"])
def test_a_damped_oscillator_moves_as_in_closed_form(method):
    m, k, c, rest = 2.0, 50.0, 1.2, 0.1
    scene = kf.System()
    scene.add_rigid_body("mass", m, joint=kf.Prismatic("x", position=0.4, forces=kf.CoordinateForce(k, c, rest)))
    result = scene.simulate((0.0, 2.0), rtol=1e-8, method=method)
    decay, w = c / (2 * m), math.sqrt(k / m - (c / (2 * m)) ** 2)
    t = result.times
    exact = rest + 0.3 * np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    # dop853: 1e-8 a step; generalised-alpha of order 2: 1e-8 a step over some 500 steps
    within = 1e-5
    assert result.joint_coordinates("mass")[:, 0] == pytest.approx(exact, abs=within)
    assert abs(result.energy.balance_error).max() < k * 0.3 * within  # what that is of the spring's energy
    assert result.energy.dissipated[-1] > 1.0
    assert result.energy.elastic[0] == pytest.approx(0.5 * k * 0.3**2, rel=1e-14)


def test_a_stiff_spring_holds_no_step_of_the_implicit_method():
    # 16 kHz against a slow swing: steps that resolved the spring would be 1e5; it is damped, so it comes to rest
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    arm = scene.add_rigid_body("arm", 1.0, 0.1, com=(0.3, 0, 0), joint=kf.Revolute("z"))
    stiff = kf.Revolute("z", forces=kf.CoordinateForce(1e6, 1.0))
    scene.add_rigid_body("end", 0.1, 1e-4, parent=arm, at=(0.6, 0, 0), joint=stiff)
    result = scene.simulate((0.0, 1.0), rtol=1e-5, method="generalised-alpha")
    assert result.statistics["evaluations"] < 5000
    assert abs(result.joint_coordinates("end")).max() < 1e-5


def test_a_drive_overcomes_the_spring_and_its_work_is_booked():
    k, c = 3.0, 0.5
    scene = kf.System()
    hinge = kf.Revolute("z", motion=kf.Motion.steady(2.0), forces=kf.CoordinateForce(k, c))
    scene.add_rigid_body("wheel", 1.0, 0.2, joint=hinge)
    result = scene.simulate((0.0, 1.5), rtol=1e-9)
    # no inertia torque at a steady rate: the drive carries spring and damper alone
    assert result.driving_force("wheel") == pytest.approx(k * 2.0 * result.times + c * 2.0, abs=1e-12)
    assert abs(result.energy.balance_error).max() < 1e-9


def test_a_joint_without_spring_runs_no_spring_code(monkeypatch):
    def fail(*arguments):
        raise AssertionError("asked for the force along a coordinate of a joint without one")

    for name in ("force", "potential", "dissipation", "slopes"):
        monkeypatch.setattr(kf.CoordinateForce, name, fail)
    scene = kf.System(gravity=(0, -9.81, 0))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    assert scene.simulate((0.0, 0.1)).energy.elastic.max() == 0.0


def test_auto_sees_the_frequency_of_the_scene():
    # a 1 g wheel on 1e4 N m/rad: w = sqrt(1e4 / 1e-6) = 1e5 rad/s, though no flexible body is there
    scene = kf.System()
    scene.add_rigid_body("wheel", 0.001, 1e-6, joint=kf.Revolute("z", position=1e-3, forces=kf.CoordinateForce(1e4)))
    assert stiffest_rate(scene.freeze(), 0.0) == pytest.approx(1e5, rel=1e-12)
    # nothing damps it, so that the extrapolation might let it grow
    assert choose(scene.freeze(), RunOptions(t_span=(0.0, 1.0), rtol=1e-3)).name in ("radau5", "dop853")
    damped = kf.System()
    damped.add_rigid_body("wheel", 0.001, 1e-6, joint=kf.Revolute("z", forces=kf.CoordinateForce(damping=2.0)))
    assert stiffest_rate(damped.freeze(), 0.0) == pytest.approx(2.0 / 1e-6, rel=1e-12)
