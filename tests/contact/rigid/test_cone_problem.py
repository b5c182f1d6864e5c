"""The complementarity problem of contacts: its solutions are solutions, and known ones are found."""

import numpy as np
import pytest

from contact_conditions import ConeProblem, left_of, solved


def problem(seed: int, contacts: int, speeds: int) -> ConeProblem:
    """Return contacts of a random mechanism; more of them than speeds: their rows depend on each other."""
    rng = np.random.default_rng(seed)
    J = rng.standard_normal((3 * contacts, speeds))
    b = J @ rng.standard_normal(speeds)
    mu = rng.uniform(0.0, 1.0, contacts)
    return ConeProblem(J @ J.T, b, mu, np.zeros(contacts), np.full((contacts, 2), np.nan))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("contacts", "speeds"), [(1, 6), (3, 12), (4, 6)])
def test_solutions_fulfil_the_conditions(seed, contacts, speeds):
    cones = problem(seed, contacts, speeds)
    x = solved(cones)
    assert x is not None
    size = np.abs(cones.b).max()
    assert left_of(cones, x) < 1e-9 * size
    y = cones.G @ x + cones.b
    for i in range(contacts):
        normal, friction, slip = x[3 * i], x[3 * i + 1 : 3 * i + 3], y[3 * i + 1 : 3 * i + 3]
        assert normal >= -1e-12 * size
        assert y[3 * i] >= -1e-8 * size
        assert normal * y[3 * i] == pytest.approx(0.0, abs=1e-8 * size**2)
        assert np.linalg.norm(friction) <= cones.mu[i] * normal * (1 + 1e-9) + 1e-12
        if np.linalg.norm(slip) > 1e-7 * size and normal > 0.0:
            np.testing.assert_allclose(friction, -cones.mu[i] * normal * slip / np.linalg.norm(slip), atol=1e-7 * size)


def test_what_slips_in_a_known_direction_and_least_forces():
    cones = ConeProblem(
        np.diag((2.0, 1.0, 1.0)), np.array((-4.0, 1.0, 0.0)), np.array((0.5,)), np.zeros(1), np.array([[0.6, 0.8]])
    )
    np.testing.assert_allclose(solved(cones), (2.0, -0.6, -0.8))
    np.testing.assert_allclose(solved(cones._replace(least=np.array((3.0,)))), (3.0, -0.9, -1.2))
    assert solved(cones._replace(G=np.diag((-2.0, 1.0, 1.0)))) is None
    assert len(solved(ConeProblem(np.zeros((0, 0)), np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((0, 2))))) == 0
