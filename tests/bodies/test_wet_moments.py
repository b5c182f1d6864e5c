"""A body in a fluid: Kirchhoff's equations against their own integration, energy, and what has no weight."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import scipy.sparse as sp

import kanefe as kf
from kanefe.kane.reactions import joint_reactions
from kanefe.states.state import State

NODES = np.array([[0.3, 0.1, 0.0], [-0.3, 0.1, 0.1], [0.0, -0.2, 0.2], [0.05, 0.0, -0.3]])
MASSES = [1.0, 2.0, 1.5, 0.7]
V, W = (0.6, 0.2, -0.3), (0.5, 1.0, -0.8)


def hull(stiffness, interfaces=None):
    """Return a body of four masses on bars, of which the fluid takes part along one direction at each."""
    K = np.zeros((12, 12))
    for i in range(4):
        for j in range(i):
            along = np.zeros(12)
            along[3 * i : 3 * i + 3] = NODES[i] - NODES[j]
            along[3 * j : 3 * j + 3] = NODES[j] - NODES[i]
            K += stiffness * np.outer(along, along) / np.sum((NODES[i] - NODES[j]) ** 2)
    model = kf.model_from_matrices(
        np.kron(np.diag(MASSES), np.eye(3)), K, NODES, groups={"three": [0, 1, 2], "one": [3]}
    )
    directions = np.random.default_rng(3).standard_normal((4, 3))
    fluid = sp.block_diag([5.0 * np.outer(n, n) for n in directions])
    return kf.flexible_body(replace(model, added_mass=sp.csr_matrix(fluid)), interfaces)


def run(body, **options):
    scene = kf.System()
    scene.add_flexible_body("hull", body, joint=kf.Free(velocity=V, angular_velocity=W))
    return scene.simulate((0.0, 0.25), method="radau5", rtol=1e-6, output_step=0.05)


def impulse_matrix(moments):
    dry, _ = moments.leading(0).terms(np.zeros(0), np.zeros(0), np.zeros(3))
    return dry + moments.fluid[:6, :6]


def test_a_stiff_body_turns_as_kirchhoffs_equations_say():
    body = hull(1e6)
    A = impulse_matrix(body.moments)

    def rate(_, x):
        P, w = A @ x, x[3:]
        return -np.linalg.solve(A, np.concatenate((np.cross(w, P[:3]), np.cross(w, P[3:]) + np.cross(x[:3], P[:3]))))

    result = run(body)
    exact = scipy.integrate.solve_ivp(rate, (0, 0.25), [*V, *W], t_eval=result.times, rtol=1e-10, atol=1e-12).y.T
    # the bars yield by the square of speeds over frequencies, (3 / (2 pi 62))^2, and the run is accurate to 1e-5
    assert abs(result.angular_velocity("hull") - exact[:, 3:]).max() < 2e-4
    assert abs(exact[-1, 3:] - exact[0, 3:]).max() > 1.0


def test_energy_and_impulse_of_a_soft_body_and_its_fluid_are_kept():
    result = run(hull(2e3))
    total = result.energy.kinetic + result.energy.elastic
    # tolerance: that of the run, 1e-6 of what moves
    assert np.ptp(total) < 1e-5 * total[0]
    assert np.ptp(result.energy.elastic) > 2e-4 * total[0]
    for kept in (result.momentum.linear, result.momentum.angular):
        assert np.ptp(kept, axis=0).max() < 1e-4 * abs(kept).max()


def test_the_fluid_has_inertia_and_no_weight():
    body, gravity = hull(1e4), np.array([1.0, -2.0, 3.0])
    assert body.mass == pytest.approx(sum(MASSES), rel=1e-14)
    np.testing.assert_allclose(body.center_of_mass, np.array(MASSES) @ NODES / sum(MASSES), atol=1e-14)
    scene = kf.System(gravity=gravity)
    scene.add_flexible_body("hull", body, joint=kf.Free())
    model = scene.freeze()
    rates = model.rhs(0.0, model.initial_state)[-model.free_count :]
    turned = np.cross(rates[3:6], NODES)
    moved = (rates[:3] + turned).ravel() + body.basis @ rates[6:]
    # of the nodes: M and the fluid take part, and only M has weight
    directions = np.random.default_rng(3).standard_normal((4, 3))
    M = np.kron(np.diag(MASSES), np.eye(3))
    A = sp.block_diag([5.0 * np.outer(n, n) for n in directions]).toarray()
    np.testing.assert_allclose(moved, np.linalg.solve(M + A, M @ np.tile(gravity, 4)), rtol=1e-10, atol=1e-10)


def test_a_free_joint_has_no_reaction_in_motion():
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_flexible_body("hull", hull(1e4), joint=kf.Free(velocity=V, angular_velocity=W))
    model = scene.freeze()
    y = model.initial_state
    du = model.rhs(0.0, y)[-model.free_count :]
    # the balance of the whole body is another sum than Kane's equations; forces are of the order of 100 N
    assert np.abs(joint_reactions(State(model, 0.0, *model.parts(y)[:2]), du)).max() < 1e-10


def test_frequencies_are_those_with_the_fluid():
    body = hull(1e4, {"three": "clamped", "one": "node"})
    moments, k = body.moments, body.free_count
    np.testing.assert_array_equal(moments.leading(k).fluid, moments.fluid[: 6 + k, : 6 + k])
    K, A = body.stiffness[:k, :k], moments.fluid[6 : 6 + k, 6 : 6 + k]
    n = np.random.default_rng(3).standard_normal((4, 3))[3]
    np.testing.assert_allclose(np.linalg.eigvalsh(A), [0.0, 0.0, 5.0 * n @ n], atol=1e-12)
    squares = scipy.linalg.eigh(K, MASSES[3] * np.eye(3) + A, eigvals_only=True)
    np.testing.assert_allclose(body.frequencies, np.sqrt(squares) / (2.0 * np.pi), rtol=1e-12)


def test_a_body_in_a_fluid_is_saved_and_read(tmp_path):
    body = hull(1e4)
    body.save(tmp_path / "hull.npz")
    np.testing.assert_array_equal(kf.FlexibleBody.load(tmp_path / "hull.npz").moments.fluid, body.moments.fluid)


def test_the_nodal_form_has_no_added_mass():
    model = kf.model_from_matrices(
        np.diag([1.0, 2.0]), 50.0 * np.array([[1.0, -1.0], [-1.0, 1.0]]), [[0, 0, 0], [1, 0, 0]], components=("x",)
    )
    with pytest.raises(kf.ModelError, match=r"exact inertia.*Remedy"):
        kf.flexible_body(replace(model, mass_field=None, added_mass=sp.identity(2, format="csr")))


def test_what_has_no_place_for_the_fluid_says_so(tmp_path, monkeypatch):
    with pytest.raises(kf.ModelError, match=r"no place for an added mass.*Remedy"):
        kf.write_sid(hull(1e4), tmp_path / "hull.sid")
    monkeypatch.setattr("kanefe.reduction.build.LARGEST_DENSE", 5)
    with pytest.raises(kf.ModelError, match=r"cannot be kept whole.*Remedy"):
        hull(1e4)
