"""Tolerances are relative to what is large in a scene: its size, a radian, the amplitude that moves a body by its size.

A scene is built of other lengths, masses and stiffnesses, and moves alike in them: it must take the same steps. The
factors are powers of two, so that not even round-off differs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.integrate.methods.table import METHODS
from kanefe.reduction import flexible_body
from kanefe.tree.scales import moving_length, scene_energy, scene_length, state_scales
from scenes import lattice_model

MILLI, KILO = 2.0**-10, 2.0**10


def bar(length: float, mass: float) -> dict[str, Any]:
    """Return a rigid bar of lengths and masses so many times larger."""
    return {"mass": mass, "inertia": 0.1 * mass * length**2, "com": (0.5 * length, 0.0, 0.0)}


def pushed_pendulum(length: float, mass: float) -> kf.System:
    """Return a double pendulum on a slide, with a damper, from rest: speeds and work begin at zero."""
    scene = kf.System(gravity=(0.0, -9.81 * length, 0.0))
    slide = scene.add_rigid_body("slide", mass, joint=kf.Prismatic("x"))
    scene.add_force(slide, (3.0 * mass * length, 0.0, 0.0))
    first = scene.add_rigid_body("first", **bar(length, mass), parent=slide, joint=kf.Revolute("z"))
    damper = kf.CoordinateForce(damping=0.2 * mass * length**2)
    joint = kf.Revolute("z", forces=damper)
    scene.add_rigid_body("second", **bar(length, mass), parent=first, at=(length, 0.0, 0.0), joint=joint)
    return scene


def lattice(length: float, mass: float) -> kf.FlexibleBody:
    model = lattice_model(1)
    field = model.mass_field
    assert field is not None
    whole = replace(
        model,
        nodes=length * model.nodes,
        stiffness=sp.csr_matrix(mass * model.stiffness),
        mass=sp.csr_matrix(mass * model.mass),
        mass_field=replace(field, points=length * field.points, mass=sp.csr_matrix(mass * field.mass)),
        groups={name: replace(group, position=length * group.position) for name, group in model.groups.items()},
    )
    return flexible_body(
        whole,
        {"root": "clamped", "tip": "rigid"},
        reduction=kf.CraigBampton(modes=3),
        damping=kf.RayleighDamping(0.1, 1e-5),
    )


def flexible_arm(length: float, mass: float) -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81 * length))
    arm = scene.add_flexible_body("first", lattice(length, mass), joint=kf.Revolute("y"))
    scene.add_rigid_body("second", **bar(length, mass), parent=arm.interface("tip"))
    return scene


def mechanism(length: float, mass: float) -> kf.System:
    """Return a slider-crank off its axis, held by a pin with three rows too many."""
    scene = kf.System(gravity=(0.0, -9.81 * length, 0.0))
    one = scene.add_rigid_body("first", **bar(length, mass), joint=kf.Revolute("z", position=1.0))
    at = (length, 0.0, 0.0)
    two = scene.add_rigid_body("second", **bar(length, mass), parent=one, at=at, joint=kf.Revolute("z"))
    slider = scene.add_rigid_body("slider", mass, at=(2.0 * length, 0.25 * length, 0.0), joint=kf.Prismatic("x"))
    scene.add_loop_joint("pin", kf.Revolute("z"), two.frame(at=at), slider)
    return scene


def tumbling(length: float, mass: float) -> kf.System:
    """Return a free body without any length but its radii of gyration."""
    scene = kf.System()
    inertia = mass * length**2 * np.array([1.0, 2.0, 2.5])
    joint = kf.Free(velocity=(length, 0.0, 0.0), angular_velocity=(0.1, 2.0, 0.0))
    scene.add_rigid_body("first", mass, inertia, joint=joint)
    return scene


def falling(length: float, mass: float) -> kf.System:
    """Return a point, of which only the start tells a length, on a spring."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81 * length))
    force = kf.CoordinateForce(stiffness=30.0 * mass)
    scene.add_point("first", mass, joint=kf.Prismatic("z", position=length, forces=force))
    return scene


SCENES = (pushed_pendulum, flexible_arm, mechanism, tumbling, falling)


def cost(scene: kf.System, method: str) -> tuple[int, int, kf.Result]:
    result = scene.simulate((0.0, 1.0), method=method, rtol=1e-5, output_step=0.25)
    assert result.status.is_finished
    return result.statistics["steps"], result.statistics["rejected"], result


@pytest.mark.parametrize(
    "method", [name for name, row in METHODS.items() if row.has_error_control and not row.is_plugged]
)
@pytest.mark.parametrize("build", SCENES, ids=lambda build: build.__name__)
def test_a_scene_of_another_size_takes_the_same_steps(build: Callable[[float, float], kf.System], method: str) -> None:
    steps, rejected, usual = cost(build(1.0, 1.0), method)
    for length, mass in ((MILLI, MILLI**3), (KILO, KILO), (1.0, KILO)):
        *found, other = cost(build(length, mass), method)
        assert found == [steps, rejected]
        # pivots of factorisations, and with them round-off, are chosen by the numbers in a column, whatever their units
        np.testing.assert_allclose(other.position("first") / length, usual.position("first"), rtol=0, atol=1e-10)


@pytest.mark.parametrize("build", SCENES, ids=lambda build: build.__name__)
def test_lengths_and_energies_of_scenes_follow_their_size(build: Callable[[float, float], kf.System]) -> None:
    model, other = build(1.0, 1.0).freeze(), build(MILLI, KILO).freeze()
    length = scene_length(model)
    assert 0.1 < length < 10.0
    assert scene_length(other) == pytest.approx(MILLI * length, rel=1e-14)
    energy = scene_energy(model, length)
    assert scene_energy(other, MILLI * length) == pytest.approx(KILO * MILLI**2 * energy, rel=1e-14)


def test_what_has_no_size_is_measured_by_a_metre_and_a_joule() -> None:
    scene = kf.System()
    scene.add_point("point", 1.0, joint=kf.Prismatic("x", speed=1.0))
    assert scene_length(scene.freeze()) == 1.0


@pytest.mark.parametrize("mark", [0.0, 1e4])
def test_what_counts_as_large_does_not_depend_on_where_a_scene_is_built(mark: float) -> None:
    found = []
    for far in (0.0, 1e5):
        scene = kf.System()
        root = scene.ground.frame(at=(far, 0.0, 0.0))
        scene.add_rigid_body("mark", 1.0, 1.0, at=(0.0, mark, 0.0))
        first = scene.add_rigid_body("first", 1.0, 0.1, parent=root, joint=kf.Revolute("z"), com=(0.3, 0.0, 0.0))
        scene.add_rigid_body("second", 1.0, 0.1, parent=first, at=(0.5, 0.0, 0.0), joint=kf.Prismatic("x"))
        model = scene.freeze()
        assert moving_length(model) == 0.5
        found.append(state_scales(model))
    np.testing.assert_array_equal(*found)


def test_without_another_length_the_place_of_a_body_is_one() -> None:
    scene = kf.System()
    scene.add_point("point", 1.0, at=(1e-3, 0.0, 0.0), joint=kf.Prismatic("x", speed=1.0))
    assert moving_length(scene.freeze()) == scene_length(scene.freeze()) == 1e-3
