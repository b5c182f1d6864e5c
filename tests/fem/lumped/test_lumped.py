"""Lumped masses and springs: against rigid bodies, closed forms, and the equations of a moving body."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
import scipy.sparse

from fem_meshes import STEEL, box, shown
from kanefe.errors import ModelError
from kanefe.fe_model.model import TRANSLATIONS, FiniteElementModel, MassField, NodeGroup, rigid_motion
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle, SolidCircle
from kanefe_fem.lumped import mean_motion as mean_motion_module
from kanefe_fem.lumped.mean_motion import mean_motion
from kanefe_fem.lumped.parts import LumpedMass, LumpedSpring, attach
from kanefe_fem.solids.model import solid_model

J = np.array([[3.0, 0.4, -0.2], [0.4, 2.5, 0.1], [-0.2, 0.1, 1.5]]) * 1e-3
PLACE = (0.35, 0.12, 0.09)


def cube(n=4, components=TRANSLATIONS):
    """Nodes on a grid with unit masses and no stiffness, for what hangs on them."""
    grid = np.linspace(0.0, 0.3, n)
    nodes = np.stack(np.meshgrid(grid, grid, grid, indexing="ij"), axis=-1).reshape(-1, 3)
    size = len(nodes) * len(components)
    mass = scipy.sparse.identity(len(nodes), format="csr")
    N = scipy.sparse.kron(scipy.sparse.identity(len(nodes)), np.eye(3)[:, : len(components)], format="csr")
    tip = np.flatnonzero(np.isclose(nodes[:, 0], 0.3))
    line = tip[np.isclose(nodes[tip, 2], 0.0)]
    root = np.flatnonzero(nodes[:, 0] == 0.0)
    groups = {n: NodeGroup(g, nodes[g].mean(axis=0)) for n, g in (("tip", tip), ("line", line), ("root", root))}
    zero = scipy.sparse.csr_matrix((size, size))
    return FiniteElementModel(nodes, components, zero, N.T @ N, MassField(nodes, mass, N), groups=groups)


def rigid_mass(mass, inertia, place):
    """Mass matrix about the origin of a rigid body."""
    R = rigid_motion(np.array([place]), (0, 0, 0), ("x", "y", "z", "rx", "ry", "rz"))
    full = scipy.linalg.block_diag(mass * np.eye(3), inertia)
    return R.T @ full @ R


class TestMasses:
    @pytest.mark.parametrize("at", ["tip", 17])
    def test_a_rigid_motion_of_a_beam_carries_its_inertia(self, at):
        beam = straight_beam(0.4, Rectangle(0.02, 0.03), STEEL, elements=20)
        heavy = attach(beam, [LumpedMass(at, 1.5, J, PLACE)])
        R = beam.rigid_modes()
        added = R.T @ ((heavy.mass - beam.mass) @ R)
        np.testing.assert_allclose(added, rigid_mass(1.5, J, PLACE), rtol=0, atol=1e-13)
        # the mass field says the same
        np.testing.assert_allclose((heavy.mass_field.mass_matrix() - heavy.mass).toarray(), 0, atol=1e-11)
        assert heavy.mass_field.mass.sum() == pytest.approx(beam.mass_field.mass.sum() + 1.5, rel=1e-13)

    @pytest.mark.parametrize("size", [1e-3, 1.0])
    def test_inertia_without_mass(self, size):
        """A flywheel whose mass is in the mesh: the inertia alone is added, wherever it hangs."""
        beam = straight_beam(0.4 * size, Rectangle(0.02 * size, 0.03 * size), STEEL, elements=20)
        heavy = attach(beam, [LumpedMass("tip", inertia=J * size**5)])
        R = beam.rigid_modes()
        added = R.T @ ((heavy.mass - beam.mass) @ R)
        scale = size ** np.repeat((3.0, 4.0), 3)  # of round-off: kg, kg m
        expected = scipy.linalg.block_diag(np.zeros((3, 3)), J * size**5)
        assert np.abs((added - expected) / np.sqrt(np.outer(scale, scale))).max() < 1e-12
        assert heavy.mass_field.mass.sum() == pytest.approx(beam.mass_field.mass.sum(), rel=1e-12)
        np.testing.assert_allclose((heavy.mass_field.mass_matrix() - heavy.mass).toarray(), 0, atol=1e-11)

    def test_inertia_about_z_is_enough_in_a_plane(self):
        """The same matrices as of a body that has its other moments too; and without mass."""
        beam = straight_beam(1.0, Rectangle(0.01, 0.01), STEEL, elements=4, planar=True)
        heavy = attach(beam, [LumpedMass("tip", 1e3, (0.0, 0.0, 50.0))])
        full = attach(beam, [LumpedMass("tip", 1e3, (30.0, 30.0, 50.0))])
        np.testing.assert_allclose(heavy.mass.toarray(), full.mass.toarray(), rtol=0, atol=1e-9)
        alone = attach(beam, [LumpedMass("tip", inertia=(0.0, 0.0, 50.0))])
        assert (alone.mass - beam.mass)[-1, -1] == pytest.approx(50.0, rel=1e-12)
        assert abs((alone.mass - beam.mass)[-3:-1]).max() < 1e-12

    def test_and_of_a_patch_without_rotations(self):
        model = cube()
        heavy = attach(model, [LumpedMass("tip", 1.5, J, PLACE), LumpedMass(0, 2.0)])
        R = model.rigid_modes()
        added = R.T @ ((heavy.mass - model.mass) @ R)
        # node 0 is the origin
        np.testing.assert_allclose(added, rigid_mass(1.5, J, PLACE) + rigid_mass(2.0, 0 * J, (0, 0, 0)), atol=1e-12)
        np.testing.assert_allclose((heavy.mass_field.mass_matrix() - heavy.mass).toarray(), 0, atol=1e-12)

    def test_the_patch_stays_soft(self):
        # what deforms the patch without its mean motion does not move the mass
        model = cube()
        T, blind = mean_motion(model, "tip", np.array(PLACE))
        u = np.random.default_rng(1).standard_normal(model.size)
        R = model.rigid_modes(PLACE)
        tip = (3 * model.groups["tip"].nodes[:, None] + np.arange(3)).ravel()
        q = np.linalg.lstsq(R[tip], u[tip], rcond=None)[0]
        np.testing.assert_allclose(T @ u, q, rtol=1e-10)
        assert blind.shape == (6, 0)

    def test_a_large_patch_is_followed_by_some_of_its_nodes(self, monkeypatch):
        monkeypatch.setattr(mean_motion_module, "LARGEST_PATCH", 40)
        model = cube(10)
        heavy = attach(model, [LumpedMass("tip", 1.5, J, PLACE)])
        R = model.rigid_modes()
        np.testing.assert_allclose(R.T @ ((heavy.mass - model.mass) @ R), rigid_mass(1.5, J, PLACE), atol=1e-12)
        assert (heavy.mass - model.mass).nnz <= (40 * 3) ** 2
        # the motion stays the mean one: a smooth field of second order is told nearly as by all nodes
        u = np.zeros((len(model.nodes), 3))
        u[:, 0] = model.nodes[:, 1] ** 2
        some = (mean_motion(model, "tip", np.array(PLACE))[0] @ u.ravel())[0]
        monkeypatch.setattr(mean_motion_module, "LARGEST_PATCH", 1000)
        every = (mean_motion(model, "tip", np.array(PLACE))[0] @ u.ravel())[0]
        assert some == pytest.approx(every, rel=0.1)

    def test_a_cantilever_with_a_tip_mass(self):
        # Rayleigh's textbook case with the exact equation: 1 + cos k cosh k = r k (sin k cosh k - cos k sinh k)
        section, length = SolidCircle(0.01), 1.0
        bar = straight_beam(length, section, STEEL, elements=20, theory="euler-bernoulli", planar=True)
        mass = 2.0
        line = STEEL.rho * section.A
        r = mass / (line * length)

        def equation(k):
            return 1 + np.cos(k) * np.cosh(k) - r * k * (np.sin(k) * np.cosh(k) - np.cos(k) * np.sinh(k))

        k = scipy.optimize.brentq(equation, 0.5, 1.8)
        exact = k**2 * np.sqrt(STEEL.E * section.I_z / (line * length**4))
        heavy = attach(bar, [LumpedMass("tip", mass)])
        free = np.arange(3, heavy.size)
        K, M = heavy.stiffness.toarray()[np.ix_(free, free)], heavy.mass.toarray()[np.ix_(free, free)]
        found = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[0])
        # 20 elements: (k h)^4 / 1440 is 1e-9; the rotary inertia of the sections takes some 1e-5
        assert found == pytest.approx(exact, rel=1e-4)

    def test_a_plane_body(self):
        model = straight_beam(0.4, Rectangle(0.02, 0.03), STEEL, elements=4, planar=True)
        heavy = attach(model, [LumpedMass("tip", 1.5, (1e-3, 2e-3, 1e-3), (0.45, 0.1, 0.0))])
        R = model.rigid_modes()[:, [0, 1, 5]]
        expected = rigid_mass(1.5, np.diag((1e-3, 2e-3, 1e-3)), (0.45, 0.1, 0.0))[np.ix_([0, 1, 5], [0, 1, 5])]
        np.testing.assert_allclose(R.T @ ((heavy.mass - model.mass) @ R), expected, atol=1e-14)

    @pytest.mark.fenicsx
    def test_a_solid_body_with_one(self):
        from kanefe.reduction import flexible_body

        mesh = box("hexahedron", (4, 1, 1), (0.4, 0.1, 0.1))
        part = LumpedMass("tip", 1.5, J, (0.45, 0.0, 0.2))
        model = solid_model(mesh, STEEL, lumped=[part])
        body = flexible_body(model, {"root": "clamped", "tip": "rigid"}, reduction=None)
        box_mass = 7850 * 0.004
        assert body.mass == pytest.approx(box_mass + 1.5, rel=1e-12)
        centre = (box_mass * np.array([0.2, 0.05, 0.05]) + 1.5 * np.array([0.45, 0.0, 0.2])) / (box_mass + 1.5)
        np.testing.assert_allclose(body.center_of_mass, centre, rtol=1e-12)
        own = flexible_body(solid_model(mesh, STEEL), {"root": "clamped", "tip": "rigid"}, reduction=None)
        np.testing.assert_allclose(body.inertia - own.inertia, rigid_mass(1.5, J, (0.45, 0.0, 0.2))[3:, 3:], atol=1e-11)
        # a rigid interface carries it as a rigid body
        tip = body.interface("tip").motion
        at_mass = rigid_motion(np.array([[0.45, 0.0, 0.2]]), body.interface("tip").position) @ tip
        full = rigid_motion(np.zeros((1, 3)), (0, 0, 0), ("x", "y", "z", "rx", "ry", "rz"))
        assert full.shape == (6, 6)
        expected = 1.5 * at_mass.T @ at_mass + tip[3:].T @ J @ tip[3:]
        found = body.moments.elastic_mass - own.moments.elastic_mass
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


class TestSprings:
    def test_a_spring_to_ground(self):
        model = cube()
        S = np.diag([1e5, 2e5, 3e5, 10.0, 20.0, 30.0])
        sprung = attach(model, [LumpedSpring("tip", np.diag(S), position=PLACE)])
        R = model.rigid_modes(PLACE)
        np.testing.assert_allclose(R.T @ (sprung.stiffness @ R), S, atol=1e-9)

    def test_a_spring_between_groups_feels_no_rigid_motion(self):
        model = cube()
        spring = LumpedSpring("tip", (1e5, 2e5, 3e5, 10.0, 20.0, 30.0), to="root")
        sprung = attach(model, [spring])
        assert abs(sprung.stiffness @ model.rigid_modes()).max() < 1e-9
        pull = np.zeros((len(model.nodes), 3))
        pull[model.groups["tip"].nodes, 0] = 1e-3
        assert pull.ravel() @ (sprung.stiffness @ pull.ravel()) == pytest.approx(1e5 * 1e-6, rel=1e-10)

    def test_a_damper_of_nothing_changes_nothing(self):
        model = cube()
        stiffness = (1e5, 2e5, 3e5, 10.0, 20.0, 30.0)
        plain, damped = (
            attach(model, [LumpedSpring("tip", stiffness, damping=damping)]) for damping in (None, (0.0,) * 6)
        )
        assert abs(plain.stiffness - damped.stiffness).max() == 0.0
        with pytest.raises(ModelError, match="cannot follow"):
            attach(model, [LumpedSpring(5, stiffness, damping=(0.0,) * 6)])

    def test_on_a_single_node(self):
        model = cube()
        sprung = attach(model, [LumpedSpring(5, (1.0, 2.0, 3.0))])
        np.testing.assert_allclose(sprung.stiffness.diagonal()[15:18], [1, 2, 3], rtol=1e-12)
        assert sprung.stiffness.count_nonzero() == 3


class TestBadInput:
    @pytest.mark.parametrize(
        ("make", "word"),
        [
            (lambda: LumpedMass("tip", 0.0), "neither mass nor inertia"),
            (lambda: LumpedMass("tip", -1.0), "mass = -1"),
            (lambda: LumpedMass("tip", inertia=(0.0, 0.0, 0.0)), "is zero"),
            (lambda: attach(cube(), [LumpedMass("tip", inertia=(0.0, 0.0, 1.0))]), "(0, 0, I) is for planar models"),
            (lambda: LumpedMass("tip", "heavy"), "mass is 'heavy'"),
            (lambda: LumpedMass("tip", 1.0, (1.0, 1.0, 3.0)), "no body has the inertia"),
            (lambda: LumpedMass("tip", 1.0, (1.0, 1.0)), "inertia=(1.0, 1.0)"),
            (lambda: LumpedMass("tip", 1.0, position=(0, np.nan, 0)), "not a point"),
            (lambda: LumpedSpring("tip", (1.0, -1.0, 1.0)), "negative in a direction"),
            (lambda: LumpedSpring("tip", (0.0, 0.0, 0.0)), "zero"),
            (lambda: LumpedSpring("tip", 7.0), "stiffness=7.0"),
            (lambda: LumpedSpring("tip", (1.0, 1.0, 1.0), to="tip"), "both ends"),
            (lambda: attach(cube(), [LumpedMass("top", 1.0)]), "'top'"),
            (lambda: attach(cube(), [LumpedMass(64, 1.0)]), "64 is not a place"),
            (lambda: attach(cube(), LumpedMass("tip", 1.0)), "a list of"),
            (lambda: attach(cube(), [LumpedMass(3, 1.0, J)]), "one node without rotations"),
            (lambda: attach(cube(), [LumpedMass(3, 1.0, position=(0, 0, 0.5))]), "one node without rotations"),
            (lambda: attach(cube(), [LumpedMass("line", 1.0, J)]), "lie on a line"),
            (lambda: attach(cube(), [LumpedSpring("line", (0, 0, 0, 1.0, 1.0, 1.0))]), "'line' cannot follow"),
            (lambda: attach(cube(), [LumpedSpring(3, (1.0, 1.0, 1.0), to=9)]), "cannot follow a rotation"),
        ],
    )
    def test_it_is_refused(self, make, word):
        with pytest.raises(ModelError) as error:
            make()
        shown(error, word)

    def test_a_mass_on_a_line_of_nodes_needs_no_rotation_about_it(self):
        heavy = attach(cube(), [LumpedMass("line", 1.0)])
        assert (heavy.mass - cube().mass).sum() == pytest.approx(3.0, rel=1e-12)

    @pytest.mark.fenicsx
    @pytest.mark.usefixtures("no_assembly")
    def test_groups_are_looked_up_before_the_assembly(self):
        with pytest.raises(ModelError) as error:
            solid_model(box("tetra", (1, 1, 1), (1, 1, 1)), STEEL, lumped=[LumpedSpring("tip", (1, 1, 1), to="top")])
        shown(error, "'top'")
