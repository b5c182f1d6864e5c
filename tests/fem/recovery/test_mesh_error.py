"""The estimate of the error of the mesh in a stress, against fields whose error is known."""

from __future__ import annotations

import numpy as np
import pytest

from fem_meshes import box
from kanefe_fem import Material, shell_model
from kanefe_fem.recovery.envelope import envelope_of
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.shell_points import ShellStrains
from recovered_boxes import G, fields_of, recovered
from shell_meshes import grid

ONE = np.ones((1, 1))


def stretched(kind, order, cells, power):
    """Return the envelope of a box with u_x = 1e-3 x^power: von Mises' stress is 2 G u_x'."""
    mesh = box(kind, (cells, 2, 2), (1.0, 0.3, 0.3)).with_order(order)
    u = np.zeros((len(mesh.nodes), 3, 1))
    u[:, 0, 0] = 1e-3 * mesh.nodes[:, 0] ** power
    return recovered(fields_of(mesh, u), ONE).envelope()


@pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
def test_a_stress_that_cells_have_has_no_error(kind):
    found = stretched(kind, 2, 3, 2)
    assert found.peak == pytest.approx(2.0 * G * 2e-3, rel=1e-9)
    assert found.mesh_error < 1e-9


@pytest.mark.parametrize("cells", [4, 8])
def test_bricks_of_a_cubic_displacement_know_their_error(cells):
    """Their best points have the exact strain, which is quadratic: the fit is exact."""
    found = stretched("hexahedron", 2, cells, 3)
    true = abs(2.0 * G * 3e-3 / found.peak - 1.0)
    assert true == pytest.approx(1.0 / (6.0 * cells**2), rel=0.05)  # f'' h^2 / 12 of f = 3 x^2 at its end
    assert found.mesh_error == pytest.approx(true, rel=1e-6)


@pytest.mark.parametrize(("kind", "order", "power"), [("tetra", 2, 3), ("hexahedron", 1, 2), ("tetra", 1, 2)])
def test_other_cells_know_theirs_within_a_factor(kind, order, power):
    """Their best points are not exact."""
    found = stretched(kind, order, 8, power)
    true = abs(2.0 * G * power * 1e-3 / found.peak - 1.0)
    assert 0.5 * true < found.mesh_error < 2.0 * true


@pytest.mark.fenicsx
@pytest.mark.parametrize(("kind", "low", "high"), [("quad9", 0.99, 1.01), ("triangle6", 0.3, 3.0)])
def test_shells_know_the_error_of_their_bending(kind, low, high):
    """A plate with w = x^4 / 12: its curvature x^2 is exact at the best points of quadrangles."""
    t = 0.01
    model = shell_model(grid("plate", 6, 3, kind=kind), Material(E=1.0, nu=0.0, rho=1.0), t)
    x = np.asarray(model.nodes)[:, 0]
    moved = np.zeros((len(x), 6))
    moved[:, 2], moved[:, 4] = -(x**4) / 12.0, x**3 / 3.0  # theta_y = -w'
    fields = ShellStrainFields(
        ShellStrains(np.asarray(model.nodes), moved.reshape(-1, 1), model.cells, model.elasticity.shell), "b", "top"
    )
    found = envelope_of(fields, ONE, np.zeros(1), "max_principal", "nodes", None)
    true = abs(0.5 * t * x.max() ** 2 / found.peak - 1.0)
    assert true > 1e-3
    assert low * true < found.mesh_error < high * true
    assert "error of the mesh about" in str(found)


def test_what_is_not_known_is_told():
    mesh = box("tetra", (1, 1, 1), (1.0, 1.0, 1.0))
    u = np.zeros((len(mesh.nodes), 3, 1))
    u[:, 0, 0] = mesh.nodes[:, 0]
    few = recovered(fields_of(mesh, u), ONE)
    assert np.isnan(few.envelope(at="cells").mesh_error)
    assert "error of the mesh not known" in str(few.envelope(at="cells"))
