"""Sections of shells: stiffness, shear correction and mass of layers."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe_fem import Laminate, Material, Orthotropic, Ply
from kanefe_fem.shells.sections import section

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
CARBON = Orthotropic(E1=25.0, E2=1.0, E3=1.0, nu12=0.25, nu13=0.25, nu23=0.25, G12=0.5, G13=0.5, G23=0.2, rho=1.0)


def test_one_layer_is_that_of_plates():
    one = section(STEEL)
    D = STEEL.E / 12.0 / (1.0 - STEEL.nu**2)
    assert one.stiffness(2)[0, 0] == pytest.approx(D, rel=1e-14)
    assert np.abs(one.stiffness(1)).max() < 1e-14 * STEEL.E
    np.testing.assert_allclose(one.shear, 5.0 / 6.0 * STEEL.shear_modulus * np.eye(2), rtol=1e-13, atol=1e-3)


def bent(one, side):
    """Return 100 w E2 h^3 / (q a^4) in the middle of a simply supported square of unit thickness (Navier's series)."""
    a = np.pi / side
    A, B, D = (one.stiffness(power) for power in range(3))
    # unknowns u, v, w, b1, b2: cos sin, sin cos, sin sin, cos sin, sin cos
    strain = np.array([[-a, 0.0], [0.0, -a], [a, a]])
    whole = np.block([[A, B], [B, D]])
    gradient = np.zeros((6, 5))
    gradient[:3, :2], gradient[3:, 3:] = strain, strain
    shear = np.array([[0.0, 0.0, a, 1.0, 0.0], [0.0, 0.0, a, 0.0, 1.0]])
    K = gradient.T @ whole @ gradient + shear.T @ one.shear @ shear
    return 100.0 * np.linalg.solve(K, (0.0, 0.0, 1.0, 0.0, 0.0))[2] / side**4


@pytest.mark.parametrize(
    ("side", "first_order", "exact", "share"),
    [(4, 1.70951, 1.93672, 0.7), (10, 0.66271, 0.73698, 0.3), (20, 0.49117, 0.51295, 0.3)],
)
def test_the_shear_correction_of_a_cross_ply_is_that_of_its_stack(side, first_order, exact, share):
    """0/90/90/0 under a sine load: first-order theory with 5/6, and Pagano's solution in space."""
    plies = Laminate([Ply(CARBON, 0.25, np.radians(angle)) for angle in (0, 90, 90, 0)])
    assert bent(section(plies, shear_factor=5.0 / 6.0), side) == pytest.approx(first_order, rel=1e-5)
    of_stack = bent(section(plies), side)
    assert abs(of_stack / exact - 1.0) < share * abs(first_order / exact - 1.0)


def test_a_split_layer_is_whole():
    """Layers of one material are the material."""
    thirds = Laminate([Ply(STEEL, 0.001), Ply(STEEL, 0.0005), Ply(STEEL, 0.0015)])
    one, other = section(STEEL, 0.25), section(thirds, 0.25)
    for power in range(3):
        np.testing.assert_allclose(other.stiffness(power), one.stiffness(power), rtol=1e-12, atol=1e-3)
    np.testing.assert_allclose(other.shear, one.shear, rtol=1e-12, atol=1e-2)
    for a, b in zip(one.points, other.points, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-15)


def test_three_points_have_the_moments_of_the_layers():
    stack = section(Laminate([Ply(STEEL, 0.001), Ply(CARBON, 0.004), Ply(STEEL, 0.002)]), -0.3)
    heights, shares = stack.points
    for power in range(6):
        exact = sum(
            layer.rho * (layer.top ** (power + 1) - layer.bottom ** (power + 1)) / (power + 1) for layer in stack.layers
        )
        assert stack.mass(0) * shares @ heights**power == pytest.approx(exact, rel=1e-12)
