"""Coupling forces: {du, F_u} solved together, elimination, and balances that know neither (Eq. 31-35, 39)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.bodies.slopes import SLOPE_MEASURES, slope_measure
from kanefe.equations.model import Model
from kanefe.fe_model.damping import RayleighDamping
from kanefe.frames import rotation_matrix, skew
from kanefe.kane.assemble import accelerations, assemble
from kanefe.kane.coupling import accelerations_and_coupling_forces, coupling_matrix, recovered_forces
from kanefe.kane.inertia import body_partial_velocities, nodal_partial_velocities
from kanefe.kane.reactions import joint_reactions, moved_wrench
from kanefe.scene.scene import FlexibleMember
from kanefe.states.interactions import unit_wrenches
from kanefe.states.kinematics import interface_motion, sweep_outward
from kanefe.states.state import State
from scenes import (
    chain_scene,
    derivatives,
    flexible_scene,
    floating_scene,
    lattice_model,
    path,
    planar_scene,
    random_state,
    rigid_scene,
)

T = 0.4
CB = kf.CraigBampton(modes=4)
DAMPED = RayleighDamping(0.1, 0.002)
THREE_HINGES = {"root": "hinged", "middle": "hinged", "tip": "hinged"}
ONE_BY_ONE = {"root": kf.Interface(("x", "y", "z", "rx", "rz")), "tip": kf.Interface(("z",)), "middle": "clamped"}
SLIDER = {"root": kf.Interface(("x", "y", "z", "rx", "ry")), "tip": kf.Interface(("y", "z", "rx"))}
TURN = rotation_matrix(np.array([0.8, 0.3, -0.4, 0.33]))
TURNED = {
    "root": kf.Interface(("x", "y", "z", "rx", "rz"), axes=TURN),
    "tip": kf.Interface(("z", "rx"), axes=TURN.T, kind="average"),
}
BOTH_ENDS = {"root": "clamped", "tip": "clamped"}

SCENES: dict[str, Callable[[int], kf.System]] = {
    "clamped": flexible_scene,
    "clamped, damped": lambda seed: flexible_scene(seed, damping=DAMPED),
    "clamped, reduced": lambda seed: flexible_scene(seed, reduction=CB, damping=kf.ModalDamping(0.05)),
    "clamped, no modes": lambda seed: flexible_scene(seed, reduction=kf.CraigBampton(modes=0)),
    "on a hinge": lambda seed: flexible_scene(seed, joint=kf.Revolute((1, 2, 3))),
    "both ends clamped": lambda seed: flexible_scene(seed, interfaces=BOTH_ENDS),
    "both ends clamped, reduced": lambda seed: flexible_scene(seed, interfaces=BOTH_ENDS, reduction=CB),
    "three hinged interfaces": lambda seed: flexible_scene(seed, interfaces=THREE_HINGES),
    "components one by one": lambda seed: flexible_scene(seed, interfaces=ONE_BY_ONE),
    "slider and hinge, tait-bryan": lambda seed: flexible_scene(seed, interfaces=SLIDER, slopes="tait-bryan"),
    "turned interfaces": lambda seed: flexible_scene(seed, interfaces=TURNED),
    "turned interfaces, reduced, tait-bryan": lambda seed: flexible_scene(
        seed, interfaces=TURNED, reduction=CB, slopes="tait-bryan"
    ),
    "chain": chain_scene,
    "chain, reduced": lambda seed: chain_scene(seed, "tait-bryan", reduction=CB, damping=DAMPED),
    "planar": planar_scene,
    "planar, reduced": lambda seed: planar_scene(seed, reduction=kf.CraigBampton(modes=2)),
    "planar, nodal form": lambda seed: planar_scene(seed, rotations=True),
    "nodal form": lambda seed: flexible_scene(seed, rotations=True, reduction=CB),
}


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("scene", SCENES)
def test_solving_together_equals_elimination_and_recovery(scene: str, seed: int) -> None:
    model = SCENES[scene](seed).freeze()
    q, u = random_state(model, seed + 5)
    du, F_u = accelerations_and_coupling_forces(State(model, T, q, u))
    eliminated = accelerations(State(model, T, q, u))
    _, recovered = recovered_forces(State(model, T, q, u), eliminated)
    assert len(F_u) == model.fixed_count > 0
    # two factorisations of matrices with condition numbers up to some 1e4: 1e-16 * 1e4, relative to the largest
    assert du == pytest.approx(eliminated, abs=1e-12 * abs(du).max())
    assert F_u == pytest.approx(recovered, abs=1e-12 * abs(F_u).max())


def fixed_wrench(model: Model, name: str, q: np.ndarray, F_u: np.ndarray) -> np.ndarray:
    """Return the resultant of a body's coupling forces about the origin of G, in axes of G, shape (6,).

    The forces act where the interfaces are: a partly released one is off its undeformed place.
    """
    terms = model.flexible_terms(name)
    start = model.free_count + model.driven_count
    total = np.zeros(6)
    for frame in terms.body.interfaces:
        columns = [c - terms.body.free_count + terms.fixed.start - start for c in frame.fixed_columns]
        motion = frame.motion[:, : terms.body.free_count] @ q[terms.eta]
        wrench = np.zeros(6)
        wrench[list(frame.fixed_components)] = F_u[columns]
        wrench = np.concatenate((frame.axes @ wrench[:3], frame.axes @ wrench[3:]))
        # a moment that holds some slopes does no work on the others: M . T dtheta = lambda . dtheta
        wrench[3:] = np.linalg.solve(model.slopes.tangent(motion[3:]).T, wrench[3:])
        total[:3] += wrench[:3]
        total[3:] += wrench[3:] + np.cross(frame.position + motion[:3], wrench[:3])
    return total


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("scene", SCENES)
def test_coupling_forces_are_what_the_balance_of_the_body_needs(scene: str, seed: int) -> None:
    model = SCENES[scene](seed).freeze()
    q, u = random_state(model, seed + 5)
    du = accelerations(State(model, T, q, u))
    _, F_u = recovered_forces(State(model, T, q, u), du)
    reactions = joint_reactions(State(model, T, q, u), du)
    for number, body in enumerate(model.bodies):
        if body.flexible:
            wrench = fixed_wrench(model, body.name, q, F_u)
            in_plane = [0, 1, 5] if "planar" in scene else list(range(6))  # a planar interface has no other components
            scale = abs(reactions[number]).max()
            # accelerations of a stiff body differ by 1e-12 between the routes
            assert wrench[in_plane] == pytest.approx(reactions[number][in_plane], abs=1e-11 * scale)


@pytest.mark.parametrize("scene", SCENES)
def test_joint_reactions_give_the_motors_their_forces(scene: str) -> None:
    # Independent of the projected equations: along a free axis the reaction is the motor's force, none without a motor.
    model = SCENES[scene](3).freeze()
    q, u = random_state(model, 5)
    du = accelerations(State(model, T, q, u))
    driving, _ = recovered_forces(State(model, T, q, u), du)
    for body, reaction in zip(model.bodies, joint_reactions(State(model, T, q, u), du), strict=True):
        if not len(body.joint.speed_names):
            continue
        V, W = body.joint.partial_velocities(body.joint_coordinates(T, q))
        _, A_FM = body.joint.pose(body.joint_coordinates(T, q))
        along = (A_FM.T @ V).T @ reaction[:3] + (A_FM.T @ W).T @ reaction[3:]
        motor = sum(load.value(T) for load in body.joint_loads)
        expected = driving[body.speeds - model.free_count] + motor if body.is_driven else motor
        assert along == pytest.approx(np.broadcast_to(expected, along.shape), abs=1e-10 * (1 + abs(reaction).max()))


def balance_by_finite_differences(
    model: Model,
    numbers: list[int],
    q: np.ndarray,
    u: np.ndarray,
    du: np.ndarray,
    loads: list[tuple[int, object, np.ndarray]],
) -> np.ndarray:
    """Return the wrench on the first body, about its origin in its axes, that the motion of some bodies needs.

    From positions alone: each mass point and centre of mass is followed in N along the motion, and differentiated.
    `loads` are forces in N on frames of flexible bodies (body, interface) or bodies (body, None).
    """
    moved = path(model, q, u, du)
    step = 2e-3  # accelerations reach some 100 m/s2, so that motions of 4 steps stay small: round-off 1e-16 / 4e-6

    def frames(s: float):
        return sweep_outward(model, T + s, moved(s), model.all_speeds(T + s, u + s * du))

    origin = frames(0.0)[numbers[0]]
    force, moment = np.zeros(3), np.zeros(3)
    for i in numbers:
        body = model.bodies[i]
        if body.rigid:
            p = body.rigid.com
            _, a = derivatives(lambda s, i=i, p=p: frames(s)[i].p_NoFo_N + frames(s)[i].A_NF @ p, step)
            spin, _ = derivatives(lambda s, i=i, b=body: frames(s)[i].A_NF @ (b.rigid.inertia @ frames(s)[i].w), step)
            f = body.rigid.mass * (a - model.gravity)
            r = frames(0.0)[i].p_NoFo_N + frames(0.0)[i].A_NF @ p - origin.p_NoFo_N
            force, moment = force + f, moment + np.cross(r, f) + spin
        else:
            terms = body.flexible

            def points(s: float, i: int = i, terms=terms) -> np.ndarray:
                psi = terms.body.inertia_basis[:, : terms.body.free_count]
                r = terms.body.inertia_points + (psi @ moved(s)[terms.eta]).reshape(-1, 3)
                return frames(s)[i].p_NoFo_N + r @ frames(s)[i].A_NF.T

            _, a = derivatives(points, step)
            f = terms.body.inertia_mass @ (a - model.gravity)
            force, moment = force + f.sum(axis=0), moment + np.cross(points(0.0) - origin.p_NoFo_N, f).sum(axis=0)
    full = model.all_speeds(T, u)
    for i, interface, f in loads:
        frame = frames(0.0)[i]
        if interface is not None:
            frame = interface_motion(frame, interface, model.bodies[i].flexible, q, full, model.slopes)
        force, moment = force - f, moment - np.cross(frame.p_NoFo_N - origin.p_NoFo_N, f)
    return np.concatenate((origin.A_NF.T @ force, origin.A_NF.T @ moment))


@pytest.mark.parametrize(
    "interfaces",
    [None, BOTH_ENDS, THREE_HINGES, ONE_BY_ONE, SLIDER],
    ids=["clamped", "both ends", "three hinges", "one by one", "slider"],
)
@pytest.mark.parametrize("seed", range(2))
def test_coupling_forces_balance_the_motion_of_every_mass_point(interfaces: dict | None, seed: int) -> None:
    scene = flexible_scene(seed, interfaces=interfaces, loads=False)
    member = FlexibleMember(scene, 1, "arm", body=scene._entries[1].flexible)
    at_node, at_tip = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.2, -0.7])
    scene.add_force(member.node(4), at_node)
    scene.add_force(member.interface("tip"), at_tip)
    model = scene.freeze()
    q, u = random_state(model, seed + 5)
    du = accelerations(State(model, T, q, u))
    _, F_u = recovered_forces(State(model, T, q, u), du)
    body = model.flexible_terms("arm").body
    loads = [(1, body.node_frame(4), at_node), (1, body.interface("tip"), at_tip)]
    needed = balance_by_finite_differences(model, [1, 2], q, u, du, loads)
    # second differences with round-off 5e-11 of lengths of order 1, against accelerations of order 100
    assert fixed_wrench(model, "arm", q, F_u) == pytest.approx(needed, abs=1e-8 * abs(needed).max())


def carried_wrench(model: Model, q: np.ndarray, u: np.ndarray, du: np.ndarray, name: str) -> np.ndarray:
    """Return what the bodies on an interface of the first flexible body do to it, about it, in axes of G."""
    state = State(model, T, q, u)
    number = next(i for i, body in enumerate(model.bodies) if body.flexible)
    n = state.motion(number, model.bodies[number].flexible.body.interface(name))
    total = np.zeros(6)
    for child, reaction in enumerate(joint_reactions(state, du)):
        held = model.bodies[child].parent_interface
        if model.bodies[child].parent == number and held is not None and held.name == name:
            total -= moved_wrench(reaction, state.motions[child], n)
    A_Gn = state.motions[number].A_NF.T @ n.A_NF
    return np.concatenate((A_Gn @ total[:3], A_Gn @ total[3:]))


@pytest.mark.parametrize("seed", range(2))
def test_two_clamped_ends_share_forces_as_the_nodes_of_the_mesh_say(seed: int) -> None:
    # How the ends share is statically indeterminate: M a + C v + K u at the nodes of each end tells, for small
    # displacements (u x f, of second order, is no part of linear elasticity). C = b K, whose nodal form is internal.
    full = lattice_model(seed)
    scene = flexible_scene(seed, interfaces=BOTH_ENDS, damping=RayleighDamping(stiffness=0.01), loads=False)
    model = scene.freeze()
    q, u = random_state(model, seed, amplitude=1e-8)
    terms = model.flexible_terms("arm")
    u[: terms.speeds.start] = u[terms.speeds.stop :] = 0.0  # only the deformation has a rate: C alone is large
    du = accelerations(State(model, T, q, u))
    _, F_u = recovered_forces(State(model, T, q, u), du)
    G = sweep_outward(model, T, q, model.all_speeds(T, u))[1]
    eta, deta = q[terms.eta], u[terms.speeds]
    V, Z = nodal_partial_velocities(terms.body, body_partial_velocities(terms, G), G, eta, deta)
    weight = np.tile(G.A_NF.T @ model.gravity, len(full.nodes))
    psi = terms.body.basis[:, : terms.body.free_count]
    forces = full.mass @ (V @ du + Z - weight) + full.stiffness @ (psi @ (eta + 0.01 * deta))
    # the tip carries a body, whose force is no part of F_u
    carried = carried_wrench(model, q, u, du, "tip")
    for number, name in enumerate(BOTH_ENDS):
        frame, nodes = terms.body.interface(name), full.groups[name].nodes
        f = forces.reshape(-1, 3)[nodes]
        moment = np.cross(full.nodes[nodes] - frame.position, f).sum(axis=0)
        needed = np.concatenate((f.sum(axis=0), moment)) - (carried if name == "tip" else 0.0)
        # second order in 1e-8, and round-off of forces of the order of 100
        assert F_u[6 * number : 6 * number + 6] == pytest.approx(needed, abs=1e-7 * abs(F_u).max())


def test_force_at_a_carrying_interface_is_the_reaction_of_what_it_carries() -> None:
    model = flexible_scene(1, loads=False).freeze()
    q, u = random_state(model, 2)
    du = accelerations(State(model, T, q, u))
    interface = model.flexible_terms("arm").body.interface("tip")
    wrench = carried_wrench(model, q, u, du, "tip")
    G = sweep_outward(model, T, q, model.all_speeds(T, u))[1]
    n = interface_motion(G, interface, model.flexible_terms("arm"), q, model.all_speeds(T, u), model.slopes)
    tip = sweep_outward(model, T, q, model.all_speeds(T, u))[2]
    needed = balance_by_finite_differences(model, [2], q, u, du, [])  # about the tip's origin, in its axes
    A = G.A_NF.T @ tip.A_NF
    r = G.A_NF.T @ (tip.p_NoFo_N - n.p_NoFo_N)
    force = -A @ needed[:3]
    moment = -A @ needed[3:] + np.cross(r, force)
    assert wrench == pytest.approx(np.concatenate((force, moment)), abs=1e-8 * abs(needed).max())


def test_statically_clamped_at_both_ends_the_supports_share_the_weight() -> None:
    scene = kf.System(gravity=(0.0, 0.0, -10.0))
    body = flexible_scene(0, interfaces=BOTH_ENDS)._entries[1].flexible
    scene.add_flexible_body("arm", body)
    model = scene.freeze()
    k = body.free_count
    _, weight = assemble(State(model, 0.0, np.zeros(k), np.zeros(k)))
    q = np.linalg.solve(body.stiffness[:k, :k], weight)
    _, F_u = recovered_forces(State(model, 0.0, q, np.zeros(k)), np.zeros(k))
    assert F_u[[2, 8]].min() > 0  # each end carries a share
    # a static solve of a small system
    assert F_u[:3] + F_u[6:9] == pytest.approx([0.0, 0.0, 10.0 * body.mass], abs=1e-11)


# -- the matrix itself (Eq. 31-34)


def test_coupling_matrix_moves_forces_to_the_origin_of_r() -> None:
    rng = np.random.default_rng(0)
    A = rotation_matrix(rng.standard_normal(4))
    positions = [rng.standard_normal(3), rng.standard_normal(3)]
    forces = rng.standard_normal(12)
    matrix = coupling_matrix(A, positions, [np.eye(6)] * 2)
    force = A @ forces[:3] + A @ forces[6:9]
    moment = sum(np.cross(r, A @ f) for r, f in zip(positions, (forces[:3], forces[6:9]), strict=True))
    moment += A @ forces[3:6] + A @ forces[9:]
    assert matrix @ forces == pytest.approx(np.concatenate((force, moment)), abs=1e-14)


def test_a_hinge_has_no_moment_columns() -> None:
    rng = np.random.default_rng(1)
    A, r = rotation_matrix(rng.standard_normal(4)), rng.standard_normal(3)
    hinge = coupling_matrix(A, [r], [unit_wrenches((0, 1, 2), np.eye(3), np.eye(3))])
    clamped = coupling_matrix(A, [r], [unit_wrenches(tuple(range(6)), np.eye(3), np.eye(3))])
    assert clamped == pytest.approx(np.block([[A, np.zeros((3, 3))], [skew(r) @ A, A]]), abs=1e-15)
    assert hinge.shape == (6, 3)
    assert np.array_equal(hinge, clamped[:, :3])
    about_z = coupling_matrix(A, [r], [unit_wrenches((0, 1, 2, 3, 4), np.eye(3), np.eye(3))])
    assert np.array_equal(about_z, clamped[:, :5])
    model = flexible_scene(0, interfaces=THREE_HINGES).freeze()
    assert model.fixed_count == 9
    assert [f.fixed_components for f in model.flexible_terms("arm").body.interfaces] == [(0, 1, 2)] * 3


@pytest.mark.parametrize("slopes", SLOPE_MEASURES)
def test_moments_that_hold_slopes_do_no_work_on_released_ones(slopes: str) -> None:
    tangent = slope_measure(slopes).tangent(np.array([0.0, 0.6, -0.4]))
    moments = unit_wrenches((3,), tangent, np.eye(3))[3:]
    assert moments.T @ tangent == pytest.approx(np.array([[1.0, 0.0, 0.0]]), abs=1e-14)


def test_scenes_without_fixed_interfaces_have_no_coupling_forces() -> None:
    for scene in (rigid_scene(0), floating_scene(0)):
        model = scene.freeze()
        q, u = random_state(model, 1)
        du, F_u = accelerations_and_coupling_forces(State(model, T, q, u))
        assert F_u.shape == (0,)
        assert du == pytest.approx(accelerations(State(model, T, q, u)), abs=1e-12 * (1 + abs(du).max()))
