"""Forces that are read from states of methods that step over stiff modes: as good as the positions."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from benchmarks.force_errors import drawn
from kanefe.kernels.constraints.tolerances import CLOSING
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

RATE, RADIUS, ROD = 40.0, 0.1, 0.35

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


@cache
def rod() -> kf.FlexibleBody:
    """Return a steel rod with the static shapes of inertial loads, of which the fastest is one of 60 kHz."""
    loads = ("tip", "angular acceleration", "centrifugal")
    beam = straight_beam(ROD, Rectangle(0.03, 0.01), STEEL, elements=4)
    interfaces, damping = {"root": "clamped", "tip": "rigid"}, kf.ModalDamping(0.05)
    return beam_body(beam, interfaces, kf.CraigBampton(modes=4, loads=loads), damping=damping)


def slider_crank(pull: Any = (1.0, 0.0, 0.0)) -> kf.System:
    """Return a crank at a constant rate that drives a slider, which is pulled, by a rod, from its dead centre."""
    scene = kf.System()
    crank = scene.add_rigid_body("crank", 0.5, 1e-3, joint=kf.Revolute("z", motion=kf.Motion.steady(RATE)))
    joint = kf.Revolute("z", speed=-RATE * (1.0 + RADIUS / ROD))
    bar = scene.add_flexible_body("rod", rod(), parent=crank, at=(RADIUS, 0, 0), joint=joint)
    slider = scene.add_rigid_body("slider", 2.0, joint=kf.Prismatic("x", position=RADIUS + ROD))
    scene.add_force(slider, pull)
    scene.add_loop_joint("pin", kf.Revolute("z"), bar.interface("tip"), slider)
    return scene


TURN = 2.0 * math.pi / RATE


def late_forces(**options: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the force of the pin and the torque of the drive in the third turn, when nothing vibrates any more."""
    times = np.linspace(2.0 * TURN, 3.0 * TURN, 101)
    run = slider_crank().simulate((0.0, 3.0 * TURN), output_times=times, **options)
    return run.loop_force("pin")[:, :3], np.reshape(run.driving_force("crank"), (-1, 1))


@cache
def right_forces() -> tuple[np.ndarray, np.ndarray]:
    return late_forces(method="radau5", rtol=1e-10)


@pytest.mark.parametrize(("method", "rtol"), [("radau5", 1e-4), ("radau5", 1e-6), ("extrapolation", 1e-4)])
def test_forces_of_a_linkage_are_as_good_as_its_tolerance(method: str, rtol: float) -> None:
    for found, right in zip(late_forces(method=method, rtol=rtol), right_forces(), strict=True):
        assert np.linalg.norm(found - right, axis=1).max() < 100.0 * rtol * np.linalg.norm(right, axis=1).max()


def test_what_is_settled_keeps_its_loops_closed() -> None:
    run = slider_crank().simulate((0.0, TURN), method="radau5", rtol=1e-4, output_step=TURN / 50)
    gap = run.position("rod", "tip")[:, 1]  # the slider runs along x
    assert abs(gap).max() < 100.0 * CLOSING.tolerance


def test_functions_in_python_do_not_change_what_is_settled() -> None:
    """The same run in the compiled loop, and from Python for a force that is a function of the user."""
    forces = []
    for scene in (slider_crank(), slider_crank(lambda t: (1.0, 0.0, 0.0))):
        run = scene.simulate((0.0, TURN), method="extrapolation", step=TURN / 400, output_step=TURN / 40)
        forces.append(run.loop_force("pin")[20:, :3])
    compiled, called = forces
    np.testing.assert_allclose(called, compiled, rtol=0, atol=1e-9 * abs(compiled).max())


def test_forces_between_the_nodes_of_a_step_are_as_good_as_at_them() -> None:
    """In a loop in space, whose slow modes the polynomial of a step does not meet within rtol."""
    forces = []
    for rtol in (1e-9, 1e-6):
        scene, seconds, _ = drawn(25)
        run = scene.simulate((0.0, seconds), output_step=seconds / 400, method="radau5", rtol=rtol)
        forces.append(run.loop_force("pin")[200:, :3])
    right, found = forces
    assert (
        np.linalg.norm(found - right, axis=1).max() < 60.0 * 1e-6 * np.linalg.norm(right, axis=1).max()
    )  # 24; was 130


@pytest.mark.parametrize("seed", [39, 108])
def test_modes_are_followed_as_exactly_as_their_forces_ask_for(seed: int) -> None:
    """Of bodies that are bent by a thousandth of their length and less, in a loop in space and in a tree."""
    forces = []
    for rtol in (1e-8, 1e-6):
        scene, seconds, _ = drawn(seed)
        run = scene.simulate((0.0, seconds), output_step=seconds / 400, method="radau5", rtol=rtol)
        forces.append(run.joint_reaction("bar")[200:, :3])
    right, found = forces
    # 7 and 0.4; were 48 and 840, the second of vibrations across the plane that come from nothing
    assert np.linalg.norm(found - right, axis=1).max() < 20.0 * 1e-6 * np.linalg.norm(right, axis=1).max()


def test_auto_tells_forces_of_flexible_loops_at_loose_tolerances() -> None:
    forces = []
    for rtol, method in ((1e-7, "radau5"), (1e-4, "auto")):
        scene, seconds, _ = drawn(42)
        run = scene.simulate((0.0, seconds), output_step=seconds / 400, method=method, rtol=rtol)
        forces.append(run.loop_force("pin")[200:, :3])
    right, found = forces
    # 0.05; of the extrapolation 242
    assert np.linalg.norm(found - right, axis=1).max() < 10.0 * 1e-4 * np.linalg.norm(right, axis=1).max()
