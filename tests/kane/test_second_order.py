"""Inertia and interfaces of the second-order displacement: the engine's side of motion-induced stiffening.

The oracle moves every mass point by ``psi eta + 1/2 eta^T H eta`` and sums over them (Eq. 24-26, 38). The moments hold
all terms up to second order in (eta, deta), so that the two differ by third-order terms, and by second-order ones in
the rows of the coordinates, whose forces are derivatives.
"""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from bent_bodies import bent, second_order_field
from kanefe.frames import skew
from scenes import lattice_body, random_inertia, random_state

CB = kf.CraigBampton(modes=3)


def inertia_of_points(
    body: kf.FlexibleBody, field: tuple[np.ndarray, np.ndarray], eta: np.ndarray, deta: np.ndarray, w: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return mass and bias as `MassMoments.terms`, from the velocities and accelerations of all points."""
    k, points = len(eta), body.inertia_points
    A, B = (X[..., :k, :k] for X in field)
    H = A + np.einsum("pb,abij->paij", points, B)
    psi = body.inertia_basis[:, :k].reshape(len(points), 3, k)
    slope = psi + H @ eta
    r = points + psi @ eta + 0.5 * (H @ eta) @ eta
    dr, remainder = slope @ deta, (H @ deta) @ deta
    V = np.zeros((len(points), 3, 6 + k))
    V[:, :, :3] = np.eye(3)
    V[:, :, 3:6] = [-skew(x) for x in r]
    V[:, :, 6:] = slope
    W = skew(w)
    Z = r @ (W @ W).T + 2.0 * dr @ W.T + remainder
    weighted = np.einsum("pq,qac->pac", body.inertia_mass.toarray(), V)
    return np.einsum("pac,pad->cd", weighted, V), np.einsum("pac,pa->c", weighted, Z)


@pytest.mark.parametrize("seed", range(2))
def test_moments_agree_with_the_points_to_their_order(seed: int) -> None:
    body = lattice_body(seed, reduction=CB)
    field = second_order_field(body, 5)
    bent_body = bent(body, 5)
    k = body.free_count
    rng = np.random.default_rng(seed)
    eta, deta, w = rng.standard_normal(k), rng.standard_normal(k), rng.standard_normal(3)

    def gaps(size: float) -> np.ndarray:
        found = bent_body.moments.leading(k).terms(size * eta, size * deta, w)
        expected = inertia_of_points(body, field, size * eta, size * deta, w)
        M, bias = (abs(a - b) for a, b in zip(found, expected, strict=True))
        return np.array((M[:6, :6].max(), M[:6, 6:].max(), bias[:6].max(), bias[6:].max()))

    # of halved deformations: an eighth of third-order terms, a quarter of second-order ones
    ratios = gaps(1e-3) / gaps(5e-4)
    np.testing.assert_allclose(ratios, (8, 4, 8, 4), rtol=0.02)
    plain, _ = body.moments.leading(k).terms(1e-3 * eta, 1e-3 * deta, w)
    full, _ = inertia_of_points(body, field, 1e-3 * eta, 1e-3 * deta, w)
    assert abs(plain - full)[:6, 6:].max() > 100 * gaps(1e-3)[1]  # without the terms it is of first order


def test_an_interface_moves_by_its_second_order_motion() -> None:
    body = bent(lattice_body(1, reduction=CB), 3)
    frame, k = body.interface("tip"), body.free_count
    rng = np.random.default_rng(0)
    eta, deta = rng.standard_normal(k), rng.standard_normal(k)
    h = 1e-4

    def displacement(s: float) -> np.ndarray:
        return frame.moved(eta + s * deta)[0]

    assert frame.quadratic is not None
    # quadratic in s: central differences are exact but for round-off
    np.testing.assert_allclose(frame.moved(eta)[1] @ deta, (displacement(h) - displacement(-h)) / (2 * h), rtol=1e-9)
    second = (displacement(1.0) - 2 * displacement(0.0) + displacement(-1.0)) / 1.0
    np.testing.assert_allclose(frame.remainder(deta), second, rtol=1e-12)
    many = np.array([eta, deta, eta + deta])
    np.testing.assert_allclose(frame.displacements(many), [frame.moved(each)[0] for each in many], rtol=1e-12)


def test_the_jacobian_sees_the_second_order_terms() -> None:
    scene = kf.System(gravity=(0, 0, -9.81))
    body = bent(lattice_body(1, reduction=CB), 3, strength=0.1)
    arm = scene.add_flexible_body("arm", body, joint=kf.Revolute("y"))
    tip = scene.add_rigid_body(
        "tip", 0.5, random_inertia(np.random.default_rng(0)), parent=arm.interface("tip"), joint=kf.Revolute("x")
    )
    scene.add_force(tip, (1.0, 2.0, 3.0))
    model = scene.freeze()
    y = np.concatenate((*random_state(model, 1), np.zeros(2)))[: model.coordinate_count + model.free_count]
    J = model.jacobian(0.0, y)
    for direction in np.random.default_rng(1).standard_normal((3, len(y))):
        h = 1e-4
        steps = [model.rhs(0.0, y + s * h * direction) for s in (-2, -1, 1, 2)]
        difference = (steps[0] - 8 * steps[1] + 8 * steps[2] - steps[3]) / (12 * h)
        # fourth order: truncation h^4 = 1e-16 and round-off 1e-16 / h of accelerations of some hundred
        np.testing.assert_allclose(J @ direction, difference, atol=1e-9 * abs(difference).max())
