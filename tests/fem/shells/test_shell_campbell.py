"""The Campbell diagram of a spinning blade of sheet, by `kanefe.campbell`, against the whole matrices of its mesh."""

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

import kanefe as kf
from kanefe_fem import Material, shell_body, shell_model, surface_mesh

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
THICK, COUNT = 3e-3, 3


def blade_mesh():
    """Curved across, and set at an angle: bending, twist and stretch are coupled."""

    def place(s, r):
        angle, pitch = (r - 0.5) * 0.7, 0.1
        across, up = 0.15 * np.sin(angle), 0.15 * np.cos(angle) - 0.15
        turned = np.cos(pitch) * across - np.sin(pitch) * up, np.sin(pitch) * across + np.cos(pitch) * up
        return 0.08 + 0.3 * s, *turned

    return surface_mesh(place, (6, 3))


def whole_frequencies(model: kf.FiniteElementModel, speed: float) -> np.ndarray:
    """Of ``M q'' + 2 w G q' + (K + K_g - w^2 M_s) q = 0`` with the root held, spun about z, lowest first, Hz.

    ``M_s`` and G are the centrifugal and Coriolis terms of the points of mass, ``K_g`` is that of the static state; the
    quadratic problem is solved in the 30 lowest modes of the stiffened and softened body.
    """
    field, held = model.mass_field, 6 * model.groups["root"].nodes[:, None] + np.arange(6)
    free = np.setdiff1d(np.arange(model.size), held)
    N, across = field.interpolation, sp.diags([1.0, 1.0, 0.0])
    turning = sp.csr_matrix([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    pulled, coriolis = (sp.kron(field.mass, own).tocsr() for own in (across, turning))
    state = np.zeros(model.size)
    state[free] = spla.spsolve(
        model.stiffness[free][:, free].tocsc(), speed**2 * (N.T @ (pulled @ field.points.ravel()))[free]
    )
    K = model.stiffness + model.stress_stiffness(state) - speed**2 * (N.T @ pulled @ N)
    M, G = model.mass, 2.0 * speed * (N.T @ coriolis @ N)
    squares, modes = spla.eigsh(K[free][:, free].tocsc(), 30, M[free][:, free].tocsc(), sigma=0.0)
    small = modes.T @ (G[free][:, free] @ modes)
    none, one = np.zeros((30, 30)), np.eye(30)
    found = np.linalg.eigvals(np.block([[none, one], [-np.diag(squares), -small]])).imag
    return np.sort(found[found > 0.0])[:COUNT] / (2.0 * np.pi)


@pytest.mark.fenicsx
def test_a_campbell_diagram_is_that_of_the_whole_matrices():
    mesh = blade_mesh()
    statics = kf.CraigBampton(modes=8, loads=("centrifugal",))
    body = shell_body(mesh, STEEL, {"root": "clamped"}, THICK, statics, stiffening="inertial")
    model = shell_model(mesh, STEEL, THICK)

    def spinning(speed: float) -> kf.System:
        scene = kf.System()
        scene.add_flexible_body("blade", body, joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
        return scene

    diagram = kf.campbell(spinning, [0.0, 150.0, 300.0], modes=COUNT)
    exact = np.array([whole_frequencies(model, speed) for speed in diagram.speeds])
    assert exact[2, 0] > 1.15 * exact[0, 0]  # it stiffens by a fifth
    # eight modes beside the statics: 1e-5; the equilibrium of the scene is that of the deformed body: 1e-5
    np.testing.assert_allclose(diagram.frequencies, exact, rtol=3e-5)
    (crossing,) = diagram.critical_speeds(order=3.0)
    assert whole_frequencies(model, crossing.speed)[0] == pytest.approx(3.0 * crossing.speed / (2.0 * np.pi), rel=3e-5)
