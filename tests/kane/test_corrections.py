"""Where the paper's equations had to be corrected: the printed form fails, ours holds (see EQUATIONS.md).

Eq. 40 and 46 are tested with the beams.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

import kanefe as kf
from kanefe.bodies.rigid import rigid_mass
from kanefe.bodies.slopes import tait_bryan_angles, tait_bryan_euler_parameters
from kanefe.equations.model import Model
from kanefe.fe_model.damping import RayleighDamping
from kanefe.frames import (
    euler_parameters,
    euler_parameters_from_rotation_vector,
    multiply,
    rotation_matrix,
    rotation_matrix_rate,
    skew,
)
from kanefe.kane.assemble import accelerations, assemble
from kanefe.kane.coupling import (
    accelerations_and_coupling_forces,
    carrier_frame,
    coupling_force_columns,
    coupling_matrix,
)
from kanefe.kane.energy import momenta
from kanefe.kane.inertia import body_partial_velocities, nodal_partial_velocities, rigid_inertia
from kanefe.states.kinematics import FrameMotion, sweep_outward
from kanefe.states.state import State
from scenes import derivatives, flexible_scene, lattice_body, lattice_model, random_inertia, random_state, unit_axis

ROUND_OFF = 1e-13
SEED = 6


def turn(seed: int) -> np.ndarray:
    e = np.random.default_rng(seed).standard_normal(4)
    return e / np.linalg.norm(e)


def conjugate(e: np.ndarray) -> np.ndarray:
    return e * (1, -1, -1, -1)


# -- Eq. 6, 7 and 8


def printed_eq_6(e: np.ndarray) -> np.ndarray:
    e0, e1, e2, e3 = e
    return 2 * np.array(
        [
            [e0**2 + e1**2 - 0.5, e1 * e2 - e0 * e3, e1 * e3 + e0 * e2],
            [e1 * e2 + e0 * e3, e0**2 + e2**2 - 0.5, e2 * e3 + e0 * e1],
            [e1 * e3 + e0 * e2, e2 * e3 + e0 * e1, e0**2 + e3**2 - 0.5],
        ]
    )


def test_eq_6_has_wrong_signs_in_our_copy() -> None:
    e = turn(1)
    printed = printed_eq_6(e)
    assert abs(printed.T @ printed - np.eye(3)).max() > 0.1
    different = np.argwhere(abs(printed - rotation_matrix(e)) > ROUND_OFF)
    assert different.tolist() == [[1, 2], [2, 0]]
    assert rotation_matrix(e).T @ rotation_matrix(e) == pytest.approx(np.eye(3), abs=ROUND_OFF)


def test_eq_6_maps_from_the_turned_frame_not_to_it() -> None:
    # Eq. 6 calls the matrix of "b seen from a" the transformation from a to b. b's x axis is (0, 1, 0) in a, so such a
    # transformation must take (0, 1, 0) to (1, 0, 0).
    A = rotation_matrix(euler_parameters((0, 0, 1), np.pi / 2))
    assert abs(A @ (0, 1, 0) - (1, 0, 0)).max() > 0.9
    assert A @ (1, 0, 0) == pytest.approx((0, 1, 0), abs=ROUND_OFF)


def test_eq_7_fails_with_the_names_of_eq_6() -> None:
    e_ab, e_bc = turn(2), turn(3)
    e_ac = multiply(e_ab, e_bc)  # the rotations one after the other, each about the axes reached
    axes_of_c_in_a = Rotation.from_quat(np.roll(e_ab, -1)) * Rotation.from_quat(np.roll(e_bc, -1))
    assert rotation_matrix(e_ac) == pytest.approx(axes_of_c_in_a.as_matrix(), abs=ROUND_OFF)

    def eq_6(orientation: np.ndarray) -> np.ndarray:
        """Return T_(b<-a) from the orientation of b seen from a."""
        return rotation_matrix(orientation)

    # T_(a<-b) by the names of Eq. 6 takes the orientation of a seen from b
    T_ac, T_ab, T_bc = (eq_6(conjugate(e)) for e in (e_ac, e_ab, e_bc))
    assert abs(T_ac - T_ab @ T_bc).max() > 0.1
    A_ac, A_ab, A_bc = (rotation_matrix(e) for e in (e_ac, e_ab, e_bc))
    assert A_ab @ A_bc == pytest.approx(A_ac, abs=ROUND_OFF)


def test_eq_8_fails_with_the_names_of_eq_7() -> None:
    e_ab, w_ab_b = turn(4), np.array([0.3, -1.1, 0.7])
    A_ab = rotation_matrix(e_ab)
    rate, _ = derivatives(lambda t: rotation_matrix(multiply(e_ab, euler_parameters_from_rotation_vector(w_ab_b * t))))
    w_ba_b, w_ba_a = -w_ab_b, -A_ab @ w_ab_b  # "omega of a with respect to b", in b and in a
    # printed, with T_(a<-b) = A_ab as Eq. 7 needs it
    assert abs(skew(w_ba_b) @ A_ab - rate).max() > 0.1
    assert abs(A_ab @ skew(w_ba_a) - rate).max() > 0.1
    # order-8 differences: round-off over the step
    assert rotation_matrix_rate(A_ab, w_ab_b) == pytest.approx(rate, abs=1e-12)
    # printed, with T_(a<-b) = A_ba as Eq. 6 has it, it holds: the two cannot share one naming
    A_ba, rate_ba = A_ab.T, rate.T
    assert skew(w_ba_b) @ A_ba == pytest.approx(rate_ba, abs=1e-12)
    assert A_ba @ skew(w_ba_a) == pytest.approx(rate_ba, abs=1e-12)


# -- Eq. 17 and 37


def test_eq_17_prints_a_matrix_where_the_gyroscopic_moment_belongs() -> None:
    rng = np.random.default_rng(5)
    inertia, w, alpha = random_inertia(rng), rng.standard_normal(3), rng.standard_normal(3)
    printed = skew(w) @ inertia @ skew(w)
    assert printed.shape == (3, 3)  # a moment has shape (3,)

    def momentum(t: float) -> np.ndarray:
        A = rotation_matrix(euler_parameters_from_rotation_vector(w * t + 0.5 * alpha * t * t))
        return A @ inertia @ (w + alpha * t)

    moment, _ = derivatives(momentum)
    eye, zero = np.eye(3), np.zeros(3)
    R = FrameMotion(eye, zero, zero, w, np.zeros((3, 3)), eye, zero, zero)
    M, F = rigid_inertia(rigid_mass("b", 1.0, inertia, zero), R, zero)
    # order-8 differences: round-off over the step
    assert M @ alpha - F == pytest.approx(moment, abs=1e-11)
    # a steady spin about a principal axis needs no moment; the printed matrix does not vanish
    axis = np.linalg.eigh(inertia)[1][:, 0]
    assert abs(skew(axis) @ inertia @ skew(axis)).max() > 0.01
    R = replace(R, w=axis)
    assert rigid_inertia(rigid_mass("b", 1.0, inertia, zero), R, zero)[1] == pytest.approx(np.zeros(3), abs=1e-14)


# -- Eq. 23


def printed_eq_23(e: np.ndarray) -> np.ndarray:
    e0, e1, e2, e3 = e
    return np.array(
        [
            np.arctan2(2 * (e2 * e3 + e0 * e1), 0.5 - (e1**2 + e2**2)),
            np.arcsin(2 * (e1 * e3 - e0 * e2)),
            np.arctan2(2 * (e1 * e2 + e0 * e3), 0.5 - (e2**2 + e3**2)),
        ]
    )


def test_eq_23_doubles_two_small_angles_and_turns_the_third_round() -> None:
    theta = np.array([1e-6, 2e-6, -3e-6])
    e = tait_bryan_euler_parameters(theta)
    # second order in the angles: 1e-11
    assert printed_eq_23(e) == pytest.approx(theta * [2, -1, 2], abs=2e-11)
    assert tait_bryan_angles(e) == pytest.approx(theta, abs=1e-15)


def test_corrected_eq_23_gives_the_angles_back() -> None:
    theta = np.array([0.7, -1.2, 2.5])
    x, y, z = (expm(skew(angle * axis)) for angle, axis in zip(theta, np.eye(3), strict=True))
    e = tait_bryan_euler_parameters(theta)
    assert rotation_matrix(e) == pytest.approx(z @ y @ x, abs=ROUND_OFF)  # about the fixed axes x, then y, then z
    assert tait_bryan_angles(e) == pytest.approx(theta, abs=ROUND_OFF)
    assert abs(printed_eq_23(e) - theta).max() > 0.1


# -- Eq. 35


def deformed(amplitude: float = 0.1, speed: float = 1.0, **body: object) -> tuple[Model, np.ndarray, np.ndarray]:
    scene = flexible_scene(SEED, loads=False, **body)
    scene.gravity[:] = 0.0
    model = scene.freeze()
    return model, *random_state(model, 7, amplitude, speed)


def test_eq_35_needs_v_and_w_side_by_side() -> None:
    model, q, u = deformed()
    state, body = State(model, 0.0, q, u, is_wide=True), model.bodies[1]
    motions = state.motions
    R = carrier_frame(state, body, body.flexible, motions[1])
    frame = body.flexible.body.interface("root")
    G = motions[1]
    r = R.A_NF.T @ (G.p_NoFo_N + G.A_NF @ frame.position - R.p_NoFo_N)
    coupling = coupling_matrix(R.A_NF.T @ G.A_NF, [r], [np.eye(6)])
    with pytest.raises(ValueError, match="mismatch"):
        R.V.T @ R.W.T @ coupling
    reaction = np.hstack((R.V.T, R.W.T)) @ coupling
    # a coupling force on the interface and its reaction on R cancel on every speed but the interface's own
    J = body_partial_velocities(body.flexible, G)
    at_interface = J[:3] - skew(frame.position) @ J[3:6], J[3:6]
    motion = np.vstack(at_interface) + frame.motion @ J[6:]
    assert motion.T - reaction == pytest.approx(coupling_force_columns(state, body, body.flexible), abs=ROUND_OFF)
    free = slice(0, model.free_count)
    assert abs(reaction[free]).max() > 0.1
    assert (motion.T - reaction)[free] == pytest.approx(np.zeros((model.free_count, 6)), abs=ROUND_OFF)


# -- Eq. 36: stiffness on the rigid columns


NODAL_MATRICES = {
    "K": lambda: lattice_model(SEED).stiffness,
    "C = a M": lambda: 0.5 * lattice_model(SEED).mass,
    "C = b K": lambda: 0.01 * lattice_model(SEED).stiffness,
}


def printed_forces(model: Model, q: np.ndarray, u: np.ndarray, matrix: str) -> np.ndarray:
    """Return -V^n^T K (q_n - q_n0), or -V^n^T C V^n u, with K and C of all nodes of the arm."""
    terms = model.flexible_terms("arm")
    G = sweep_outward(model, 0.0, q, model.all_speeds(0.0, u))[1]
    V, _ = nodal_partial_velocities(terms.body, body_partial_velocities(terms, G), G, q[terms.eta], u[terms.speeds])
    motion = terms.body.basis[:, : terms.body.free_count] @ q[terms.eta] if matrix == "K" else V @ u
    return -V.T @ (NODAL_MATRICES[matrix]() @ motion)


def rigid_columns(model: Model) -> slice:
    return model.bodies[0].speeds  # the hub's free joint


def test_eq_36_lets_elastic_forces_turn_the_body() -> None:
    sizes = (0.01, 0.1)
    moments = []
    for amplitude in sizes:
        model, q, u = deformed(amplitude=amplitude, speed=0.0)
        printed = printed_forces(model, q, u, "K")[rigid_columns(model)]
        assert printed[:3] == pytest.approx(np.zeros(3), abs=1e-12)  # no net force: K u is in balance
        moments.append(np.linalg.norm(printed[3:]))
    # u x (K u) is of second order in the amplitude: ten times larger, a hundred times the moment
    assert moments[1] / moments[0] == pytest.approx(100.0, rel=1e-6)
    assert moments[1] > 1e-2

    # That moment on the hub would spin up a system that nothing touches.
    model, q, u = deformed(amplitude=0.1, speed=0.0)
    M, F = assemble(State(model, 0.0, q, u))
    elastic = np.zeros_like(F)
    at = model.bodies[1].flexible.speeds
    elastic[at] = F[at]  # without speed and gravity the only forces are elastic
    assert pytest.approx(elastic, abs=1e-15) == F

    def momentum_rate(forces: np.ndarray) -> float:
        du = np.linalg.solve(M, forces)
        return float(np.linalg.norm(momenta(State(model, 0.0, q, du))[1]))  # p = M u is linear, and u is zero now

    printed = printed_forces(model, q, u, "K")
    assert printed[at] == pytest.approx(F[at], abs=1e-10)  # both agree on the elastic speeds
    assert momentum_rate(printed) > 1e-2
    # accelerations of some 100 times masses of order 1, in double precision
    assert momentum_rate(F) < 1e-11


# -- Eq. 27 and 36: damping of the absolute velocity


@pytest.mark.parametrize(
    ("kind", "amplitude"),
    [
        pytest.param("C = a M", 0.0, id="mass-proportional damping brakes rigid motion"),
        pytest.param("C = b K", 0.1, id="stiffness-proportional damping brakes the rotation of a deformed body"),
    ],
)
def test_eq_27_damps_rigid_motion(kind: str, amplitude: float) -> None:
    model, q, u = deformed(amplitude=amplitude)
    u[model.bodies[1].flexible.speeds] = 0.0  # not deforming: nothing for a structure to damp
    printed = printed_forces(model, q, u, kind)
    assert printed @ u < -1e-3  # power is lost
    damped, _, _ = deformed(damping=NODAL_MATRICES[kind]())
    assert damped.flexible_terms("arm").damping is not None
    assert np.array_equal(assemble(State(damped, 0.0, q, u))[1], assemble(State(model, 0.0, q, u))[1])


def test_stiffness_damping_is_right_in_eq_27_only_at_zero_deformation() -> None:
    model, q, u = deformed(amplitude=0.0)
    u[model.bodies[1].flexible.speeds] = 0.0
    assert printed_forces(model, q, u, "C = b K") == pytest.approx(np.zeros(model.free_count), abs=1e-12)


@pytest.mark.parametrize("damping", [RayleighDamping(mass=0.5, stiffness=0.01), kf.ModalDamping(0.1)])
def test_our_damping_keeps_the_momenta_of_a_free_scene(damping: object) -> None:
    scene = kf.System()
    arm = scene.add_flexible_body("arm", lattice_body(3, damping=damping), joint=kf.Free())
    scene.add_rigid_body(
        "tip", 0.5, 0.01, parent=arm.interface("tip"), joint=kf.Revolute(unit_axis(np.random.default_rng(1)))
    )
    model = scene.freeze()
    q, u = random_state(model, 2)
    du = accelerations(State(model, 0.0, q, u))

    def both(s: float) -> np.ndarray:
        return np.concatenate(momenta(State(model, 0.0, model.advance(q, u * s + 0.5 * du * s * s), u + du * s)))

    rate, _ = derivatives(both, 1e-3)
    # momenta of order 1, steps of 1e-3: round-off 1e-15 / 1e-3, truncation less
    assert rate == pytest.approx(np.zeros(6), abs=1e-9)


def test_the_paper_s_unknowns_are_solved_with_the_corrected_equations() -> None:
    model, q, u = deformed()
    du, _ = accelerations_and_coupling_forces(State(model, 0.0, q, u))
    assert du == pytest.approx(accelerations(State(model, 0.0, q, u)), rel=1e-10, abs=1e-10)
