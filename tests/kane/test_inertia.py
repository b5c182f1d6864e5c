"""Inertia of flexible bodies: exact moments, the nodal form, and both routes to it (Eq. 17, 29, 37, 38)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import kanefe as kf
from kanefe.frames import cross, rotation_matrix, skew
from kanefe.kane.assemble import assemble
from kanefe.kane.coupling import recovered_forces
from kanefe.kane.energy import kinetic_energy
from kanefe.kane.inertia import flexible_inertia_from_nodes
from kanefe.reduction import flexible_body
from kanefe.states.kinematics import sweep_outward
from kanefe.states.state import State
from kanefe_fem.beams.body import beam_model, straight_beam
from kanefe_fem.beams.sections import Rectangle, Tube
from kanefe_fem.materials.isotropic import Material
from scenes import (
    chain_scene,
    flexible_scene,
    floating_scene,
    lattice_body,
    lattice_model,
    planar_scene,
    random_state,
    rigid_scene,
)

CB = kf.CraigBampton(modes=4)
SCENES: dict[str, Callable[[int], kf.System]] = {
    "rigid": rigid_scene,
    "flexible": flexible_scene,
    "flexible, reduced": lambda seed: flexible_scene(seed, reduction=CB),
    "flexible, both ends clamped": lambda seed: flexible_scene(
        seed, interfaces={"root": "clamped", "middle": "clamped", "tip": kf.Interface(("x", "ry"))}
    ),
    "flexible on an interface, driven": chain_scene,
    "flexible on an interface, driven, reduced": lambda seed: chain_scene(seed, "tait-bryan", reduction=CB),
    "floating": floating_scene,
    "floating, unreduced": lambda seed: floating_scene(seed, reduction=None),
    "planar": planar_scene,
    "planar, reduced": lambda seed: planar_scene(seed, reduction=kf.CraigBampton(modes=2)),
    "planar with rotations": lambda seed: planar_scene(seed, rotations=True),
    "nodal form, translations": lambda seed: flexible_scene(seed, nodal=True),
    "nodal form, rotations": lambda seed: chain_scene(seed, rotations=True, reduction=CB),
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("scene", SCENES)
def test_moments_agree_with_the_sum_over_nodes(scene: str, seed: int) -> None:
    model = SCENES[scene](seed).freeze()
    q, u = random_state(model, seed + 10)
    for is_wide in (False, True):
        M, F = assemble(State(model, 0.7, q, u, is_wide=is_wide))
        M_nodes, F_nodes = assemble(State(model, 0.7, q, u, is_wide=is_wide), flexible_inertia_from_nodes)
        # the same sums in another order: round-off relative to the largest entry
        assert pytest.approx(M_nodes, abs=1e-13 * abs(M).max()) == M
        assert pytest.approx(F_nodes, abs=1e-13 * abs(F).max()) == F
        assert pytest.approx(M.T, abs=1e-14 * abs(M).max()) == M
        # free and driven speeds are independent motions: a positive definite mass matrix
        if not is_wide:
            assert np.linalg.eigvalsh(M)[0] > 0


@pytest.mark.parametrize("seed", range(3))
def test_kinetic_energy_is_that_of_the_moving_points(seed: int) -> None:
    model = chain_scene(seed).freeze()
    q, u = random_state(model, seed)
    full = model.all_speeds(0.3, u)
    total = 0.0
    for body, frame in zip(model.bodies, sweep_outward(model, 0.3, q, full), strict=True):
        if body.rigid:
            v = frame.v + cross(frame.w, body.rigid.com)
            total += 0.5 * (body.rigid.mass * v @ v + frame.w @ body.rigid.inertia @ frame.w)
        else:
            flexible, k = body.flexible.body, body.flexible.body.free_count
            psi = flexible.inertia_basis[:, :k]
            r = flexible.inertia_points + (psi @ q[body.flexible.eta]).reshape(-1, 3)
            v = frame.v + np.cross(frame.w, r) + (psi @ u[body.flexible.speeds]).reshape(-1, 3)
            total += 0.5 * np.sum(v * (flexible.inertia_mass @ v))
    assert kinetic_energy(State(model, 0.3, q, u)) == pytest.approx(total, rel=1e-13)  # the same sum in another order


@pytest.mark.parametrize("options", [{}, {"planar": True}, {"nodal": True}], ids=str)
def test_mass_centre_and_inertia_are_those_of_the_points(options: dict) -> None:
    model = lattice_model(4, **options)
    body = lattice_body(4, **options)
    width = len(model.components)
    scalar = model.mass.toarray()[::width, ::width]
    mass = scalar.sum()
    second = model.nodes.T @ scalar @ model.nodes
    assert body.mass == pytest.approx(mass, rel=1e-14)
    assert body.center_of_mass == pytest.approx(scalar.sum(axis=0) @ model.nodes / mass, abs=1e-14)
    assert body.inertia == pytest.approx(np.trace(second) * np.eye(3) - second, abs=1e-13)


def test_reduction_changes_neither_mass_nor_inertia() -> None:
    full, reduced = lattice_body(2), lattice_body(2, reduction=kf.CraigBampton(modes=1))
    assert reduced.mass == pytest.approx(full.mass, rel=1e-14)
    assert reduced.center_of_mass == pytest.approx(full.center_of_mass, abs=1e-14)
    assert reduced.inertia == pytest.approx(full.inertia, abs=1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_nodal_form_is_exact_for_translations(seed: int) -> None:
    exact, nodal = (flexible_scene(seed, nodal=nodal).freeze() for nodal in (False, True))
    q, u = random_state(exact, seed)
    assert [exact.flexible_terms("arm").body.is_exact, nodal.flexible_terms("arm").body.is_exact] == [True, False]
    M, F = assemble(State(exact, 0.0, q, u))
    M_nodal, F_nodal = assemble(State(nodal, 0.0, q, u))
    assert pytest.approx(M, abs=1e-13 * abs(M).max()) == M_nodal
    assert pytest.approx(F, abs=1e-13 * abs(F).max()) == F_nodal


# -- beams: the mass field against the nodal form

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
THIN = Rectangle(1e-4, 1e-4)  # rotary inertia of the sections is 1e-9 of the bar's


def gyroscopic_factor(elements: int, nodal: bool) -> float:
    """Return the torque about z of a bar spun with (wx, wy, 0) about its end, over m l^2 wx wy."""
    model = straight_beam(2.0, THIN, STEEL, elements=elements, theory="euler-bernoulli")
    body = flexible_body(replace(model, mass_field=None) if nodal else model, {"root": "clamped"})
    wx, wy = 3.0, -2.0
    k = body.free_count
    _, bias = body.moments.leading(k).terms(np.zeros(k), np.zeros(k), np.array([wx, wy, 0.0]))
    return float(bias[5] / (body.mass * 4.0 * wx * wy))


def test_mass_field_of_one_beam_element_has_the_gyroscopic_torque_of_a_bar() -> None:
    # 1/3 but for the rotary inertia of the sections, some 1e-9 of it
    assert gyroscopic_factor(1, nodal=False) == pytest.approx(1 / 3, abs=1e-8)


def test_nodal_form_of_one_beam_element_is_wrong_by_five_percent() -> None:
    # The printed Z_n takes alpha of a node for the second derivative of its slope: 0.35 by hand for one element.
    assert gyroscopic_factor(1, nodal=True) == pytest.approx(0.35, abs=1e-8)


def test_error_of_the_nodal_form_falls_with_the_square_of_the_element() -> None:
    errors = [gyroscopic_factor(n, nodal=True) - 1 / 3 for n in (2, 4, 8)]
    rates = np.log2(np.divide(errors[:-1], errors[1:]))
    assert rates == pytest.approx([2.0, 2.0], abs=1e-3)


def space_frame(E: float) -> tuple[kf.FiniteElementModel, float, np.ndarray, np.ndarray]:
    """Return a frame of tubes in space and its exact rigid mass, first moments and inertia about G's origin."""
    nodes = np.array([[0.3, -0.2, 0.1], [1.0, 0.1, 0.0], [1.2, 0.9, 0.4], [0.2, 0.5, 0.9], [0.9, 0.2, 1.1]])
    elements = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [2, 4]])
    tube = Tube(0.05, 0.004)
    model = beam_model(nodes, elements, tube, Material(E=E, nu=0.3, rho=7850.0))
    mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for i, j in elements:
        length = np.linalg.norm(nodes[j] - nodes[i])
        t, c = (nodes[j] - nodes[i]) / length, 0.5 * (nodes[i] + nodes[j])
        m = 7850.0 * tube.A * length
        mass, first = mass + m, first + m * c
        second += m * (np.outer(c, c) + length**2 / 12 * np.outer(t, t))
        second += 7850.0 * length * tube.I_y * (np.eye(3) - np.outer(t, t))  # round: the same across any direction
    return model, mass, first, np.trace(second) * np.eye(3) - second


@pytest.mark.parametrize("seed", range(4))
def test_frame_of_beams_has_the_wrench_of_the_rigid_body(seed: int) -> None:
    model, mass, first, inertia = space_frame(E=210e9)
    moments = flexible_body(model, {"root": "clamped"}).moments.leading(0)
    a, alpha, w = np.random.default_rng(seed).standard_normal((3, 3))
    M, bias = moments.terms(np.zeros(0), np.zeros(0), w)
    wrench = M @ np.concatenate((a, alpha)) + bias
    force = mass * a + np.cross(alpha, first) + np.cross(w, np.cross(w, first))
    moment = np.cross(first, a) + inertia @ alpha + np.cross(w, inertia @ w)
    # sums over five elements of closed forms
    assert wrench == pytest.approx(np.concatenate((force, moment)), rel=1e-12, abs=1e-12 * mass)


@pytest.mark.parametrize("seed", range(3))
def test_spun_stiff_frame_pulls_at_its_root_as_the_rigid_body(seed: int) -> None:
    # So stiff (1e9 times steel) that its deformation is below 1e-12 m: what is left is the rigid body.
    model, _mass, first, inertia = space_frame(E=2e20)
    rng = np.random.default_rng(seed)
    axis, rate, e = rng.standard_normal(3), 7.0, rng.standard_normal(4)
    axis /= np.linalg.norm(axis)
    scene = kf.System()
    joint = kf.Revolute(axis, motion=kf.Motion.steady(rate))
    root = model.group("root").position
    body = flexible_body(model, {"root": "clamped"}, reduction=CB)
    scene.add_flexible_body("frame", body, joint=joint, orientation=e)
    frozen = scene.freeze()
    q, u = np.zeros(frozen.coordinate_count), np.zeros(frozen.free_count)
    # in its steady deformation nothing accelerates in G
    _, F = assemble(State(frozen, 0.0, q, u))
    at = frozen.flexible_terms("frame")
    q[at.eta] = np.linalg.solve(body.stiffness[: len(q), : len(q)], F[at.speeds])
    driving, F_u = recovered_forces(State(frozen, 0.0, q, u), np.zeros(frozen.free_count))
    w = rate * axis  # of G: the joint's frame and G have the same axes, turned about the axis itself
    force = np.cross(w, np.cross(w, first))
    moment = np.cross(w, inertia @ w) - np.cross(root, force)
    assert F_u == pytest.approx(np.concatenate((force, moment)), abs=1e-10 * np.linalg.norm(force))
    # a steady spin needs no power: the moment about the axis is nil
    assert driving == pytest.approx([0.0], abs=1e-10 * np.linalg.norm(moment))


@pytest.mark.parametrize("seed", range(3))
def test_rigid_body_about_another_point(seed: int) -> None:
    rng = np.random.default_rng(seed)
    body = rigid_scene(seed).freeze().bodies[0].rigid
    M = body.spatial
    a, alpha = rng.standard_normal((2, 3))
    at_com = a + np.cross(alpha, body.com)
    force = body.mass * at_com
    moment = body.inertia @ alpha + np.cross(body.com, force)
    assert M @ np.concatenate((a, alpha)) == pytest.approx(np.concatenate((force, moment)), abs=1e-13)


def test_inertia_does_not_depend_on_where_the_axes_point() -> None:
    # The same body in turned axes: its wrench turns with it.
    model = lattice_model(3)
    A = rotation_matrix(np.array([0.5, -0.3, 0.7, 0.2]))
    turn = np.kron(np.eye(len(model.nodes)), A)
    turned = replace(
        model,
        nodes=model.nodes @ A.T,
        stiffness=model.stiffness.__class__(turn @ model.stiffness @ turn.T),
        mass_field=replace(model.mass_field, points=model.nodes @ A.T),
        groups={n: replace(g, position=A @ g.position) for n, g in model.groups.items()},
    )
    one, two = (flexible_body(m, {"middle": kf.Interface(("x", "y", "z")), "root": "clamped"}) for m in (model, turned))
    w = np.array([1.0, -2.0, 0.5])
    _, bias = one.moments.leading(0).terms(np.zeros(0), np.zeros(0), w)
    _, bias_turned = two.moments.leading(0).terms(np.zeros(0), np.zeros(0), A @ w)
    assert bias_turned == pytest.approx(np.concatenate((A @ bias[:3], A @ bias[3:])), abs=1e-13)
    assert two.frequencies == pytest.approx(one.frequencies, rel=1e-12)
    assert two.inertia == pytest.approx(A @ one.inertia @ A.T, abs=1e-13)
    assert skew(A @ w) == pytest.approx(A @ skew(w) @ A.T, abs=1e-13)
