"""Finite elements of the user: a beam with its shape functions against kanefe's own, any numbering, and bad ones."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import ModelError
from kanefe_fem import Material, beam_body, recover, straight_beam
from kanefe_fem.beams.sections import Section

LENGTH, ELEMENTS = 1.0, 3
EA, EI, MASS = 1e5, 20.0, 0.6
"""Stiffness to stretch in N and to bending in N m2, and mass per length in kg/m."""


class Beam:
    """A plane beam of Hermite's elements, whose axis has mass."""

    components = ("x", "y", "rz")
    mass = None

    def __init__(self):
        n, h = ELEMENTS + 1, LENGTH / ELEMENTS
        self.nodes = np.column_stack((np.linspace(0.0, LENGTH, n), np.zeros((n, 2))))
        self.groups = {"root": 0, "tip": n - 1}
        self.cells = (kf.Cells("line", np.column_stack((np.arange(n - 1), np.arange(1, n)))),)
        self.stiffness, N = np.zeros((3 * n, 3 * n)), []
        points, weights = np.polynomial.legendre.leggauss(4)
        for e in range(ELEMENTS):
            rows = np.arange(3 * e, 3 * e + 6)
            for s, weight in zip(0.5 * (points + 1.0), 0.5 * h * weights, strict=True):
                stretch = np.array([-1.0, 0, 0, 1.0, 0, 0]) / h
                bend = np.array([0, 12 * s - 6, h * (6 * s - 4), 0, 6 - 12 * s, h * (6 * s - 2)]) / h**2
                local = EA * np.outer(stretch, stretch) + EI * np.outer(bend, bend)
                self.stiffness[np.ix_(rows, rows)] += weight * local
                moved = np.zeros((3, 3 * n))
                moved[0, rows[[0, 3]]] = 1 - s, s
                moved[1, rows[[1, 2, 4, 5]]] = self.hermite(s, h)
                N.append(moved)
        X = np.repeat(self.nodes[:-1], 4, axis=0)
        X[:, 0] += np.tile(0.5 * h * (points + 1.0), ELEMENTS)
        self.mass_field = kf.MassField(X, np.tile(0.5 * MASS * h * weights, ELEMENTS), sp.csr_matrix(np.vstack(N)))

    @staticmethod
    def hermite(s, h):
        return 1 - 3 * s**2 + 2 * s**3, h * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, h * (s**3 - s**2)


class Shuffled(Beam):
    """The same with its unknowns in another order."""

    def __init__(self):
        super().__init__()
        n = len(self.nodes)
        self.unknowns = np.random.default_rng(1).permutation(3 * n).reshape(n, 3)
        back = np.argsort(self.unknowns.ravel())
        self.stiffness = self.stiffness[np.ix_(back, back)]
        field = self.mass_field
        self.mass_field = kf.MassField(field.points, field.mass, field.interpolation[:, back])
        self.damping = 1e-3 * self.stiffness
        self.order = back

    def stresses(self, u):
        """Return EA u' of elements at their first nodes, as if it were a stress."""
        found = np.zeros((len(self.nodes), 6, u.shape[1]))
        x = u[self.unknowns[:, 0]]
        found[:-1, 0] = np.diff(x, axis=0) * EA * ELEMENTS / LENGTH
        return found


def reduced(elements):
    return kf.flexible_body(
        kf.model_from_elements(elements), {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=2)
    )


def test_shape_functions_give_the_inertia_of_a_beam_exactly():
    own = reduced(Beam())
    section = Section(A=MASS / 1000.0, I_y=1.0, I_z=EI * MASS / 1000.0 / EA, J=1.0)
    material = Material(E=EA * 1000.0 / MASS, nu=0.3, rho=1000.0)
    theirs = beam_body(
        straight_beam(
            LENGTH, section, material, elements=ELEMENTS, planar=True, rotary_inertia=False, theory="euler-bernoulli"
        ),
        {"root": "clamped", "tip": "rigid"},
        kf.CraigBampton(modes=2),
    )
    assert own.is_exact
    # both are integrals of polynomials; modes differ in sign
    np.testing.assert_allclose(own.frequencies, theirs.frequencies, rtol=1e-9)
    np.testing.assert_allclose(own.inertia, theirs.inertia, atol=1e-12)
    of = [abs(body.moments.leading(body.free_count).shape_product) for body in (own, theirs)]
    np.testing.assert_allclose(of[0], of[1], atol=1e-8)


def test_any_numbering_of_unknowns_is_the_same_body():
    for name in ("basis", "stiffness", "inertia_basis"):
        np.testing.assert_allclose(
            abs(getattr(reduced(Shuffled()), name)), abs(getattr(reduced(Beam()), name)), rtol=1e-7, atol=1e-7
        )
    assert reduced(Shuffled()).damping.any()


def test_stresses_of_the_elements_are_recovered_in_a_run():
    scene = kf.System()
    scene.add_force(scene.add_flexible_body("beam", reduced(Shuffled())).interface("tip"), (0.7, 0.0, 0.0))
    fields = recover(kf.equilibrium(scene), "beam")
    np.testing.assert_allclose(fields.stress_at_nodes()[0, :-1, 0], 0.7, rtol=1e-9)
    assert fields.envelope().peak == pytest.approx(0.7, rel=1e-9)
    with pytest.raises(ModelError, match="no strain at nodes"):
        fields.strain_at_nodes()


def test_stresses_are_in_the_file_of_a_result(tmp_path):
    scene = kf.System()
    scene.add_flexible_body("beam", reduced(Shuffled()), joint=kf.Revolute("z", speed=1.0))
    result = scene.simulate((0.0, 0.01), method="radau5")
    result.save(tmp_path / "run.h5")
    read = kf.load_result(tmp_path / "run.h5")
    np.testing.assert_array_equal(recover(read, "beam").stress_at_nodes(), recover(result, "beam").stress_at_nodes())


def square():
    """Return a plate of two linear triangles in the plane, of matrices only, with facets."""
    nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    cells = (kf.Cells("triangle", np.array([[0, 1, 2], [0, 2, 3]])),)
    K, M = np.zeros((8, 8)), np.zeros((4, 4))
    for t in cells[0].nodes:
        x, y = nodes[t, 0], nodes[t, 1]
        b, c = y[[1, 2, 0]] - y[[2, 0, 1]], x[[2, 0, 1]] - x[[1, 2, 0]]
        B = np.zeros((3, 6))
        B[0, ::2] = B[2, 1::2] = b
        B[1, 1::2] = B[2, ::2] = c
        rows = (2 * t[:, None] + [0, 1]).ravel()
        K[np.ix_(rows, rows)] += B.T @ np.diag([1e4, 1e4, 5e3]) @ B / 2.0
        M[np.ix_(t, t)] += (np.ones((3, 3)) + np.eye(3)) / 24.0
    return SimpleNamespace(
        nodes=nodes,
        stiffness=K,
        mass=np.kron(M, np.eye(2)),
        components=("x", "y"),
        cells=cells,
        groups={"left": [0, 3]},
    )


def test_a_group_of_whole_facets_has_their_measure():
    group = kf.model_from_elements(square()).groups["left"]
    assert group.measure is not None
    assert group.measure.sum() == pytest.approx(1.0)
    corner = square()
    corner.groups = {"corner": [0]}
    assert kf.model_from_elements(corner).groups["corner"].measure is None


def changed(elements, **fields):
    for name, value in fields.items():
        setattr(elements, name, value)
    return elements


def without(name):
    elements = square()
    delattr(elements, name)
    return elements


def field(**change):
    given = Beam().mass_field
    return kf.MassField(**{"points": given.points, "mass": given.mass, "interpolation": given.interpolation, **change})


FLIPPED = sp.diags([1, 1, -1] * 4)
NUMBERS = np.arange(12)[::-1].reshape(4, 3)
PAIRS = np.arange(8)[::-1].reshape(4, 2)
BAD = {
    "no stiffness": (lambda: without("stiffness"), "no attribute 'stiffness'"),
    "no mass": (lambda: changed(square(), mass=None), "neither a mass matrix nor a mass field"),
    "unknowns twice": (lambda: changed(square(), unknowns=[[0, 1], [2, 3], [4, 5], [6, 6]]),
        "numbers 0 to 7, each once"),
    "lumped mass beside a field": (
        lambda: changed(Beam(), mass=np.kron(np.diag([0.1, 0.2, 0.2, 0.1]), np.diag([1, 1, 0]))),
        "not that of the mass field.*by [0-9.]+",
    ),
    "slopes of the other sign": (
        lambda: changed(Beam(), mass_field=field(interpolation=Beam().mass_field.interpolation @ FLIPPED)),
        r"do not move its points with a rigid motion.*by 0.05 of a unit motion.*Remedy",
    ),
    "too few masses": (lambda: changed(Beam(), mass_field=field(mass=np.ones(2))), r"masses of \(2, 2\)"),
    "negative masses": (lambda: changed(Beam(), mass_field=field(mass=-np.ones(12))), "one is negative"),
    "no field": (lambda: changed(Beam(), mass_field=3.0), "kanefe.MassField"),
    "no field, and unknowns": (lambda: changed(Beam(), mass_field=3.0, unknowns=NUMBERS), "kanefe.MassField"),
    "inner unknowns": (lambda: changed(square(), unknowns=PAIRS, stiffness=np.eye(9)), r"9"),
    "geometric stiffness of another size": (
        lambda: changed(square(), stress_stiffness=lambda w, load: np.eye(3)), r"shape \(3, 3\)"),
    "geometric stiffness that is not symmetric": (
        lambda: changed(square(), stress_stiffness=lambda w, load: w[0] * np.triu(np.ones((8, 8)))), "not symmetric"),
    "geometric stiffness that is constant": (
        lambda: changed(square(), stress_stiffness=lambda w, load: np.eye(8)), "not linear"),
    "negative water": (lambda: changed(square(), added_mass=np.diag([1.0] * 7 + [-1.0])), "negative in a motion"),
    "stiffness that holds": (lambda: changed(square(), stiffness=square().stiffness + np.eye(8)), "resists the rigid"),
}  # fmt: skip


@pytest.mark.parametrize("fault", BAD)
def test_what_is_no_element_is_refused(fault):
    make, message = BAD[fault]
    with pytest.raises(ModelError, match=message):
        kf.model_from_elements(make())


BAD_STRESSES = {
    "another shape": (lambda u: np.zeros((4, 6)), "shape"),
    "constant": (lambda u: np.ones((4, 6, u.shape[1])), "not linear"),
    "of rigid motions": (lambda u: u.reshape(4, 2, -1)[:, [0] * 6], "zero in a rigid motion"),
}


@pytest.mark.parametrize("fault", BAD_STRESSES)
def test_stresses_that_are_none_are_refused(fault):
    stresses, message = BAD_STRESSES[fault]
    model = kf.model_from_elements(changed(square(), stresses=stresses))
    with pytest.raises(ModelError, match=message):
        kf.flexible_body(model, {"left": "clamped"})


def test_added_mass_is_in_the_file_of_matrices(tmp_path):
    wet = kf.model_from_elements(changed(square(), added_mass=np.diag([0.0, 1.0] * 4)))
    kf.write_matrices(wet, tmp_path / "wet.npz")
    np.testing.assert_array_equal(kf.read_matrices(tmp_path / "wet.npz").added_mass.toarray(), wet.added_mass.toarray())
