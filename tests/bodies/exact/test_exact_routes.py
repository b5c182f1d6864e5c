"""Scenes with exact beams on both routes: rates, implicit evaluations, energy, momenta and derivatives.

The literal route sums over sections in numpy, dense; the kernels sweep along the beam. States are random and far from
rest: axes turn by a radian along a beam.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
import kanefe_fem as fem
from exact_lines import BASES, coupled_section, random_beam
from kanefe.bodies.exact.beam import ExactBeam
from kanefe.equations.model import Model
from kanefe.literal.route import LiteralRoute
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.tangents import constant_tangents

T = 0.37
SAME = 1e-10
"""Share of the largest acceleration that the routes may differ by: round-off times the condition of the mass, 1e5."""


def loaded(beam: ExactBeam, seed: int, joint: kf.Joint | None = None) -> kf.System:
    """Return a beam that moves and carries a body at its tip and one in its middle."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=(0.3, 1.0, -9.81))
    member = scene.add_flexible_body(
        "beam",
        beam,
        joint=kf.Free() if joint is None else joint,
        modal_coordinates=0.3 * rng.normal(size=beam.free_count),
        modal_speeds=rng.normal(size=beam.free_count),
    )
    inertia = 0.01 * np.eye(3)
    scene.add_rigid_body(
        "tip", 0.3, inertia, com=(0.1, 0, 0.05), parent=member.interface("tip"), joint=kf.Revolute("x", speed=2.0)
    )
    scene.add_rigid_body("middle", 0.2, inertia, parent=member.interface("middle"), joint=kf.Spherical())
    scene.add_force(member.interface("middle"), (1.0, -2.0, 0.5), follows=True)
    scene.add_torque(member.interface("tip"), (0.2, 0.1, -0.3))
    return scene


def springs(scene: kf.System) -> None:
    """Put a spring from the tip to the ground, one along the beam, and a bushing between two of its sections."""
    beam = scene.body("beam")
    scene.add_spring("stay", scene.ground, beam.interface("tip"), stiffness=30.0, damping=2.0, rest_length=0.5)
    scene.add_spring("chord", beam.interface("root"), beam.interface("tip"), stiffness=50.0, damping=1.0)
    scene.add_bushing(
        "bushing",
        beam.interface("root"),
        beam.interface("middle"),
        stiffness=(20.0, 10.0, 5.0),
        damping=(1.0, 2.0, 0.5),
    )


def contact(scene: kf.System) -> None:
    """Let a ball on the tip press into a table that is tilted and high enough."""
    beam = scene.body("beam")
    top = scene.add_surface("top", scene.ground, kf.shapes.Plane("z"), at=(0.0, 0.0, 5.0))
    skin = scene.add_surface("skin", beam.interface("tip"), kf.shapes.Sphere(0.05), at=(0.02, 0.0, 0.0))
    scene.add_contact(
        "contact", skin, top, normal=kf.HuntCrossley(2.0, damping=0.1), friction=kf.Coulomb(0.3, stiffness=10.0)
    )


def drive(scene: kf.System) -> None:
    """Add a driven arm with a beam on it."""
    motion = kf.Motion(lambda t: np.sin(t), lambda t: np.cos(t), lambda t: -np.sin(t))
    arm = scene.add_rigid_body("arm", 1.0, 0.1, joint=kf.Revolute("z", motion=motion))
    driven = random_beam(11, "shear-rigid", "splines")
    scene.add_flexible_body(
        "driven", driven, parent=arm, at=(0.2, 0.0, 0.0), modal_coordinates=0.1 * np.ones(driven.free_count)
    )


EXTRAS = {"plain": lambda scene: None, "springs": springs, "contact": contact, "drive": drive}


@pytest.mark.parametrize("extra", EXTRAS)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("theory", ["shear-deformable", "stretching", "shear-rigid"])
def test_routes_agree(theory: str, basis: str, extra: str) -> None:
    scene = loaded(random_beam(3, theory, basis), seed=len(theory))
    EXTRAS[extra](scene)
    assert_same(scene.freeze(), seed=5)


def test_routes_agree_in_a_plane() -> None:
    axes = np.array(((0.6, -0.8, 0.0), (0.8, 0.6, 0.0), (0.0, 0.0, 1.0)))
    section = fem.Section.from_stiffness(
        EA=300.0, GA_y=200.0, EI_z=4.0, rho_A=1.0, rho_I=(1e-2, 2e-2), centre_of_mass=(0.02, 0.0)
    )
    for joint in (kf.Free(), kf.Planar(), kf.Revolute("z")):
        beam = fem.exact_beam(
            1.3,
            section,
            theory="shear-deformable",
            planar=True,
            basis=3,
            curvature=(0.0, 0.0, 0.7),
            axes=axes,
        )
        scene = kf.System(gravity=(0.3, -9.0, 0.0))
        eta = 0.3 * np.random.default_rng(1).normal(size=beam.free_count)
        member = scene.add_flexible_body("beam", beam, joint=joint, modal_coordinates=eta, modal_speeds=eta[::-1])
        scene.add_spring("stay", scene.ground.frame(at=(2.0, 1.0, 0.0)), member.interface("tip"), stiffness=30.0)
        assert_same(scene.freeze(), seed=6)


def test_what_is_left_in_memory_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    empty = np.empty

    def dirty(*args: Any, **options: Any) -> np.ndarray:
        made = empty(*args, **options)
        if made.dtype.kind in "fc":
            made[...] = np.nan
        return made

    scene = loaded(random_beam(3, "shear-deformable", "mixed"), seed=4)
    model = scene.freeze()
    clean = model.rhs(T, model.initial_state)
    monkeypatch.setattr(np, "empty", dirty)
    again = scene.freeze()
    np.testing.assert_array_equal(again.rhs(T, again.initial_state), clean)
    assert np.isfinite(again.jacobian(T, again.initial_state)).all()


@pytest.mark.parametrize("theory", ["shear-deformable", "shear-rigid"])
def test_routes_agree_with_a_loop_through_the_beam(theory: str) -> None:
    scene = kf.System(gravity=(0, 0, -9.81))
    # curved: a straight one without stretch is at a dead point of these loops
    beam = fem.exact_beam(
        1.3,
        coupled_section(),
        theory=theory,
        basis=3,
        interfaces={"middle": 0.5, "tip": 1.3},
        curvature=(0.3, 0.8, 0.5),
    )
    member = scene.add_flexible_body("beam", beam, joint=kf.Revolute("y"))
    tip, middle, stay = (np.array(at) for at in (beam.nodes[-1], beam.interface("middle").position, (0.3, 1.0, 0.2)))
    rod = scene.add_rigid_body("rod", 0.5, 0.1, at=tip - (0.0, 0.3, 1.0), joint=kf.Spherical())
    scene.add_loop_joint("pin", kf.Spherical(), member.interface("tip"), rod.frame(at=(0.0, 0.3, 1.0)))
    length = float(np.linalg.norm(middle - stay))
    scene.add_distance("stay", scene.ground.frame(at=stay), member.interface("middle"), length)
    assert_same(scene.freeze(), seed=None)
    # in a run the beam bends and stays closed
    state = scene.simulate((0.0, 0.2), rtol=1e-8, progress=False).at(0.2)
    assert_same(scene.freeze(0.2, start=state), seed=None)


def test_derivatives_of_a_chain_do_not_depend_on_their_order() -> None:
    """A beam that a direction does not change keeps its sections: nothing is kept of one that changes."""
    scene = kf.System(gravity=(0.3, 1.0, -9.81))
    rng, carrier = np.random.default_rng(4), scene.ground
    for number, planar in enumerate((False, True, False)):
        beam = random_beam(number, "shear-deformable", "mixed")
        if planar:
            section = fem.Section.from_stiffness(EA=300.0, EI_z=4.0, rho_A=1.0, rho_I=(1e-2, 2e-2))
            beam = fem.exact_beam(1.0, section, planar=True, basis=2)
        eta, rates = rng.normal(size=(2, beam.free_count))
        member = scene.add_flexible_body(
            f"beam {number}", beam, parent=carrier, joint=kf.Revolute("y"), modal_coordinates=eta, modal_speeds=rates
        )
        carrier = member.interface("tip")
    model = scene.freeze()
    assert_derivatives(model, model.initial_state)
    y = np.concatenate((model.initial_state, np.zeros(QUADRATURES)))
    directions = np.eye(len(y))
    alone = np.vstack([model.route.partial_derivatives(T, y, row[None]) for row in directions])
    for order in (np.arange(len(y)), rng.permutation(len(y))):
        found = model.route.partial_derivatives(T, y, directions[order])
        np.testing.assert_array_equal(found, alone[order])


def assert_same(model: Model, seed: int | None) -> None:
    """Compare everything that both routes have, with other speeds by a seed, which loops would not allow."""
    assert model.route.name == "order n"
    literal = LiteralRoute(model)
    n, m = model.coordinate_count, model.free_count
    y = model.initial_state.copy()
    if seed is not None:
        y[n : n + m] += np.random.default_rng(seed).normal(size=m)
    ours, theirs = model.route.evaluate(T, y)[0], literal.evaluate(T, y).rates[: len(y)]
    du = theirs[n : n + m]
    assert np.abs(du).max() > 1.0  # a scene in which nothing happens would agree
    np.testing.assert_allclose(ours[: len(y)], theirs, rtol=0, atol=SAME * np.abs(du).max())
    for mine, other in zip(model.route.energy(T, y), literal.energy(T, y), strict=True):
        assert mine == pytest.approx(other, rel=1e-12, abs=1e-12)
    for mine, other in zip(model.route.momenta(T, y), literal.momenta(T, y), strict=True):
        np.testing.assert_allclose(mine, other, rtol=0, atol=1e-12)
    assert_derivatives(model, y)
    if seed is not None and not model.loads and not model.driven_count:
        assert_implicit(model, y, du)


def assert_derivatives(model: Model, y: np.ndarray) -> None:
    """Compare the Jacobian, of complex steps, with central differences along a direction."""
    direction = np.random.default_rng(7).normal(size=len(y))
    h = 1e-6
    difference = (model.rhs(T, y + h * direction) - model.rhs(T, y - h * direction)) / (2.0 * h)
    found = model.jacobian(T, y) @ direction
    # round-off of rates over 1e-6, and third derivatives times 1e-12
    np.testing.assert_allclose(found, difference, rtol=0, atol=1e-6 * np.abs(difference).max())


def assert_implicit(model: Model, y: np.ndarray, du: np.ndarray) -> None:
    """Compare a linearly implicit evaluation with the dense one: (M + c C + k K) z = F + C a + K b."""
    n, m = model.coordinate_count, model.free_count
    K, C = constant_tangents(model)
    a, b = np.random.default_rng(8).normal(size=(2, m))
    vectors = np.zeros((4, len(y) + 2))
    vectors[0, : len(y)] = y
    vectors[2, n : n + m], vectors[3, n : n + m] = a, b
    damping, stiffness = 1e-2, 3e-4
    model.route.sweep_implicitly(T, vectors, damping, stiffness)
    M = model.mass_matrix(T, y)
    expected = np.linalg.solve(M + damping * C + stiffness * K, M @ du + C @ a + K @ b)
    np.testing.assert_allclose(vectors[1, n : n + m], expected, rtol=0, atol=SAME * np.abs(expected).max())
