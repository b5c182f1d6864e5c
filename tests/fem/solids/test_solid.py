"""Matrices of solids: exact inertia, rigid modes, an independent assembly, materials without recompiling, MUMPS."""

from __future__ import annotations

import logging
import warnings
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
import skfem
from skfem.helpers import ddot, sym_grad, trace

from fem_meshes import KINDS, STEEL, box, deformed
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import kind_of_order, quadrature, shape
from kanefe_fem import _fenicsx
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.checks import is_straight
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh_files import read_mesh
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.forms import mass_degree, stiffness_degree
from kanefe_fem.solids.model import solid_model
from repository import ARM

pytestmark = [pytest.mark.fenicsx, pytest.mark.gmsh]

SIZE = (0.3, 0.1, 0.08)


def plane_options(mesh, plane="stress"):
    return {"plane": plane, "thickness": 0.02} if mesh.dimension == 2 else {}


def box_of(kind, geometry_order=1, divisions=(3, 2, 2)):
    return box(kind, divisions, SIZE).with_order(geometry_order)


def bent(x):
    """Bend, twist and stretch a box into a body whose sides are curved and whose Jacobian is not constant."""
    y = x.copy()
    y[:, 0] += 0.9 * x[:, 0] ** 2
    y[:, 1] += 0.6 * x[:, 0] ** 2 + 1.5 * x[:, 0] * x[:, 1]
    y[:, 2] += 0.8 * x[:, 0] * x[:, 1]
    return y


def inertia_matrix(model):
    """Return the 6x6 inertia about the origin, by the mass field."""
    from kanefe.fe_model.model import rigid_motion

    motion = rigid_motion(model.mass_field.points, (0.0, 0.0, 0.0))
    return motion.T @ (sp.kron(model.mass_field.mass, sp.identity(3)) @ motion)


def inertia_by_quadrature(mesh, density, thickness=1.0):
    """Return the same from the geometry alone, exact for its polynomials."""
    element = shape(mesh.kind)
    points, weights = quadrature(mesh.kind, 12)
    x = mesh.nodes[mesh.connectivity]
    total = np.zeros((6, 6))
    for value, gradient, weight in zip(element.values(points), element.gradients(points), weights, strict=True):
        jacobian = np.abs(np.linalg.det(np.swapaxes(x[:, :, : mesh.dimension], 1, 2) @ gradient))
        r = np.einsum("mnx,n->mx", x, value)
        block = np.zeros((len(r), 3, 6))
        block[:, range(3), range(3)] = 1.0
        block[:, 0, 4], block[:, 0, 5] = r[:, 2], -r[:, 1]
        block[:, 1, 3], block[:, 1, 5] = -r[:, 2], r[:, 0]
        block[:, 2, 3], block[:, 2, 4] = r[:, 1], -r[:, 0]
        total += np.einsum("m,mxa,mxb->ab", density * thickness * weight * jacobian, block, block)
    return total


class TestInertia:
    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("geometry_order", [1, 2])
    @pytest.mark.parametrize("order", [1, 2])
    def test_a_box_has_the_mass_centre_and_inertia_of_the_formulas(self, kind, geometry_order, order):
        mesh = box_of(kind, geometry_order)
        model = solid_model(mesh, STEEL, order=order, **plane_options(mesh))
        a, b, c = SIZE if mesh.dimension == 3 else (*SIZE[:2], 0.0)
        thickness = 1.0 if mesh.dimension == 3 else 0.02
        m = STEEL.rho * a * b * (c or thickness)
        expected = np.zeros((6, 6))
        expected[:3, :3] = m * np.eye(3)
        x, y, z = np.array([a, b, c]) / 2
        cross = m * np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
        expected[:3, 3:], expected[3:, :3] = cross, cross.T
        expected[3:, 3:] = -m / 4 * np.outer((a, b, c), (a, b, c))
        expected[range(3, 6), range(3, 6)] = m / 3 * np.array([b**2 + c**2, a**2 + c**2, a**2 + b**2])
        scale = np.abs(expected).max()
        np.testing.assert_allclose(inertia_matrix(model), expected, rtol=0, atol=1e-12 * scale)

    @pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
    @pytest.mark.parametrize("geometry_order", [1, 2])
    @pytest.mark.parametrize("order", [1, 2])
    def test_a_bent_body_has_the_inertia_of_its_geometry(self, kind, geometry_order, order):
        mesh = deformed(box_of(kind, geometry_order), bent)
        model = solid_model(mesh, STEEL, order=order)
        expected = inertia_by_quadrature(mesh.with_order(min(order, geometry_order)), STEEL.rho)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(inertia_matrix(model), expected, rtol=0, atol=1e-12 * scale)
        if geometry_order == order == 2:
            straight = inertia_by_quadrature(mesh.with_order(1), STEEL.rho)
            assert np.abs(straight - expected).max() > 1e-6 * scale, "the curvature must matter in this test"

    @pytest.mark.gmsh
    def test_a_curved_cylinder_converges_to_the_round_one(self, tmp_path):
        path = tmp_path / "rod.geo"
        errors = []
        for size in (0.08, 0.04):
            path.write_text(
                'SetFactory("OpenCASCADE"); Cylinder(1) = {0, 0, 0, 0.2, 0, 0, 0.1}; Physical Volume("rod") = {1};\n'
                f"Mesh.MeshSizeMax = {size}; Mesh.MeshSizeMin = {size};\n"
            )
            inertia = inertia_matrix(solid_model(read_mesh(path, order=2), STEEL))
            mass = STEEL.rho * np.pi * 0.1**2 * 0.2
            errors.append([abs(inertia[0, 0] / mass - 1), abs(inertia[3, 3] / (mass * 0.1**2 / 2) - 1)])
        # the error of a quadratic arc falls with h^4: 16 times for half the size; meshes are not nested, so 8 at least
        assert np.all(np.array(errors[1]) < np.array(errors[0]) / 8)
        assert np.all(np.array(errors[1]) < 1e-4)

    def test_the_mass_matrix_is_that_of_the_mass_field(self):
        for kind in KINDS:
            mesh = box_of(kind)
            model = solid_model(mesh, STEEL, **plane_options(mesh))
            assert abs(model.mass - model.mass_field.mass_matrix()).max() == 0.0
            assert model.components == ("x", "y", "z")[: mesh.dimension]
            assert model.stiffness.shape == model.mass.shape == (model.size, model.size)


class TestStiffness:
    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("geometry_order", [1, 2])
    @pytest.mark.parametrize("order", [1, 2])
    def test_rigid_motions_cost_no_energy_and_the_matrix_is_symmetric(self, kind, geometry_order, order):
        mesh = box_of(kind, geometry_order)
        if mesh.dimension == 3:
            mesh = deformed(mesh, bent)
        model = solid_model(mesh, STEEL, order=order, **plane_options(mesh))
        K, R = model.stiffness, model.rigid_modes()
        size = abs(K).max()
        assert abs(K @ R).max() < 1e-12 * size
        assert abs(K - K.T).max() < 1e-13 * size
        # no other motion is free: hourglass modes would be
        values = np.linalg.eigvalsh(K.toarray())
        rigid = 6 if mesh.dimension == 3 else 3
        assert values[rigid - 1] < 1e-11 * values[-1] < 1e-9 * values[-1] < values[rigid]

    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("order", [1, 2])
    def test_uniform_strain_gives_hookes_energy(self, kind, order):
        rng = np.random.default_rng(3)
        for plane in ("stress", "strain"):
            mesh = box_of(kind)
            d = mesh.dimension
            model = solid_model(mesh, STEEL, order=order, **plane_options(mesh, plane))
            gradient = 1e-3 * rng.standard_normal((d, d))
            strain = np.zeros((3, 3))
            strain[:d, :d] = (gradient + gradient.T) / 2
            E, nu = STEEL.E, STEEL.nu
            if d == 2 and plane == "stress":
                strain[2, 2] = -nu / (1 - nu) * (strain[0, 0] + strain[1, 1])
            stress = E / (1 + nu) * (strain + nu / (1 - 2 * nu) * np.trace(strain) * np.eye(3))
            volume = np.prod(SIZE[:d]) * (1.0 if d == 3 else 0.02)
            u = (model.nodes[:, :d] @ gradient.T).reshape(-1)
            assert u @ (model.stiffness @ u) == pytest.approx(np.sum(stress * strain) * volume, rel=1e-12)

    @pytest.mark.parametrize("kind", KINDS)
    # order 1 on a geometry of order 2 drops the mid-side nodes: the same as geometry of order 1
    @pytest.mark.parametrize(("geometry_order", "order"), [(1, 1), (1, 2), (2, 2)])
    def test_the_matrices_are_those_of_an_independent_assembly(self, kind, geometry_order, order):
        mesh = box_of(kind, geometry_order)
        if mesh.dimension == 3:
            mesh = deformed(mesh, bent)
        else:
            mesh = deformed(mesh, lambda x: bent(x) * [1, 1, 0])
        model = solid_model(mesh, STEEL, order=order, **plane_options(mesh))
        stiffness, mass, points = scikit_fem_matrices(mesh.with_order(order), geometry_order, order)
        # both number the nodes as they like: match the points
        ours, theirs = [np.lexsort(np.round(x[:, : mesh.dimension], 10).T) for x in (model.nodes, points)]
        np.testing.assert_allclose(model.nodes[ours][:, : mesh.dimension], points[theirs], atol=1e-12)
        M = model.mass_field.mass
        assert abs(M[ours][:, ours] - mass[theirs][:, theirs]).max() < 1e-10 * abs(M).max()
        d = mesh.dimension
        ours, theirs = ((d * nodes[:, None] + np.arange(d)).reshape(-1) for nodes in (ours, theirs))
        K = model.stiffness
        assert abs(K[ours][:, ours] - stiffness[theirs][:, theirs]).max() < 1e-10 * abs(K).max()


def scikit_fem_matrices(mesh, geometry_order, order):
    """Return (K, Ms, points of the degrees of freedom) by scikit-fem, node-major, with the same quadrature."""
    element, geometry = shape(mesh.kind), shape(kind_of_order(mesh.kind, geometry_order))
    known = {
        "tetra": (skfem.MeshTet, skfem.ElementTetP1),
        "tetra10": (skfem.MeshTet2, skfem.ElementTetP2),
        "hexahedron": (skfem.MeshHex, skfem.ElementHex1),
        "hexahedron27": (skfem.MeshHex2, skfem.ElementHex2),
        "triangle": (skfem.MeshTri, skfem.ElementTriP1),
        "triangle6": (skfem.MeshTri2, skfem.ElementTriP2),
        "quad": (skfem.MeshQuad, skfem.ElementQuad1),
        "quad9": (skfem.MeshQuad2, skfem.ElementQuad2),
    }
    theirs = their_mesh(known[geometry.kind][0], known[geometry.kind][1](), mesh, geometry)
    scalar = known[mesh.kind][1]()
    lame = STEEL.lame if mesh.dimension == 3 else STEEL.plane_stress_lame
    thickness = 1.0 if mesh.dimension == 3 else 0.02

    def rule(degree):
        import basix  # dolfinx's own points: on curved cells the stiffness is no polynomial

        names = {"tetra": "tetrahedron", "hexahedron": "hexahedron", "triangle": "triangle", "quad": "quadrilateral"}
        points, weights = basix.make_quadrature(getattr(basix.CellType, names[element.corner_kind]), degree)
        return points.T, weights

    vector = skfem.Basis(theirs, skfem.ElementVector(scalar), quadrature=rule(stiffness_degree(element, geometry)))
    basis = skfem.Basis(theirs, scalar, quadrature=rule(mass_degree(element, geometry)))

    @skfem.BilinearForm
    def energy(u, v, _):
        eu, ev = sym_grad(u), sym_grad(v)
        return thickness * (lame * trace(eu) * trace(ev) + 2 * STEEL.shear_modulus * ddot(eu, ev))

    @skfem.BilinearForm
    def inertia(u, v, _):
        return thickness * STEEL.rho * u * v

    stiffness, mass = energy.assemble(vector), inertia.assemble(basis)
    # vector degrees of freedom in the order of the scalar ones: same point, then component
    places, components = vector.doflocs, np.empty(vector.N, int)
    for table in (
        vector.nodal_dofs,
        vector.edge_dofs if mesh.dimension == 3 else None,
        vector.facet_dofs,
        vector.interior_dofs,
    ):
        if table is not None and table.size:
            components[table] = np.arange(len(table))[:, None] % mesh.dimension
    order_of = np.lexsort([components, *np.round(places, 10)])
    scalar_order = np.lexsort([*np.round(basis.doflocs, 10)])
    stiffness = stiffness[order_of][:, order_of]
    mass = mass[scalar_order][:, scalar_order]
    return stiffness.tocsr(), mass.tocsr(), basis.doflocs.T[scalar_order]


def their_mesh(make, element, mesh, geometry):
    """Return scikit-fem's mesh of the same cells: corners by numbers, further nodes by its own degrees of freedom."""
    corners = mesh.connectivity[:, : geometry.corners]
    used, cells = np.unique(corners, return_inverse=True)
    cells = cells.reshape(corners.shape)
    linear = {"tetra": skfem.MeshTet, "hexahedron": skfem.MeshHex, "triangle": skfem.MeshTri, "quad": skfem.MeshQuad}[
        geometry.corner_kind
    ]
    # where scikit-fem's reference corners lie among ours
    reference = linear.init_refdom() if hasattr(linear, "init_refdom") else linear.elem.refdom
    permutation = shape(geometry.corner_kind).match(np.asarray(reference.p).T)
    x = mesh.nodes[used][:, : mesh.dimension].T
    plain = linear(np.ascontiguousarray(x), np.ascontiguousarray(cells[:, permutation].T), sort_t=False)
    if geometry.order == 1:
        return plain
    basis = skfem.Basis(plain, element, intorder=1)
    doflocs = np.empty((mesh.dimension, basis.N))
    # their element's reference points, matched to ours, say which of our nodes each local degree of freedom is
    local = geometry.match(np.asarray(element.doflocs))
    doflocs[:, basis.element_dofs] = np.moveaxis(
        mesh.nodes[mesh.connectivity[:, local]][:, :, : mesh.dimension], (0, 1, 2), (2, 1, 0)
    )
    return make(doflocs, plain.t, sort_t=False)


class TestModel:
    @pytest.mark.parametrize("geometry_order", [1, 2])
    def test_groups_hold_mid_side_nodes_and_the_centre_of_area(self, geometry_order):
        for kind in KINDS:
            mesh = box_of(kind, geometry_order)
            for order in (1, 2):
                model = solid_model(mesh, STEEL, order=order, **plane_options(mesh))
                for name, x in (("root", 0.0), ("tip", SIZE[0])):
                    group = model.groups[name]
                    np.testing.assert_array_equal(group.nodes, np.flatnonzero(np.isclose(model.nodes[:, 0], x)))
                    centre = [x, *(np.array(SIZE[1:]) / 2)] if mesh.dimension == 3 else [x, SIZE[1] / 2, 0]
                    np.testing.assert_allclose(group.position, centre, atol=1e-14)
                cells = model.cells[0]
                assert cells.kind == kind_of_order(kind, order)
                mids = shape(cells.kind).nodes
                corners = model.nodes[cells.nodes[:, : shape(cells.kind).corners]]
                mapped = np.einsum("pn,mnx->mpx", shape(kind).values(mids), corners)
                np.testing.assert_allclose(model.nodes[cells.nodes], mapped, atol=1e-14)

    def test_the_centre_of_an_uneven_group_is_weighted_by_area(self):
        mesh = box("tetra", (2, 4, 4), (1.0, 1.0, 1.0))
        nodes = np.array(mesh.nodes)
        nodes[:, 1] **= 3  # small facets on one side
        model = solid_model(replace(mesh, nodes=nodes), STEEL)
        np.testing.assert_allclose(model.groups["tip"].position, [1, 0.5, 0.5], atol=1e-13)
        assert abs(model.nodes[model.groups["tip"].nodes].mean(axis=0)[1] - 0.5) > 0.05

    @pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
    def test_a_material_for_each_group_is_where_it_belongs(self, kind):
        mesh = box(kind, (10, 2, 2), (1.0, 0.1, 0.1))
        cells = np.random.default_rng(5).permutation(mesh.connectivity)  # dolfinx reorders them again
        left = mesh.nodes[cells].mean(axis=1)[:, 0] < 0.3
        two = replace(mesh, cells={"soft": (Cells(kind, cells[~left]),), "hard": (Cells(kind, cells[left]),)})
        soft, hard = Material(E=1e9, nu=0.0, rho=1000.0), Material(E=4e9, nu=0.0, rho=3000.0)
        model = solid_model(two, {"hard": hard, "soft": soft})
        area, border = 0.01, 0.3
        x = model.nodes[:, 0]
        M = model.mass_field.mass
        assert M.sum() == pytest.approx(area * (3000 * border + 1000 * (1 - border)), rel=1e-13)
        first_moment = area * (3000 * border**2 + 1000 * (1 - border**2)) / 2
        assert x @ (M @ np.ones(len(x))) == pytest.approx(first_moment, rel=1e-13)
        # u_x = x^2 lies in the space; its energy is the integral of E (2 x)^2
        u = np.zeros(model.size)
        u[::3] = x**2
        energy = area * 4 / 3 * (4e9 * border**3 + 1e9 * (1 - border**3))
        assert u @ (model.stiffness @ u) == pytest.approx(energy, rel=1e-11)

    def test_new_values_compile_nothing(self):
        cache = _fenicsx.load().cache
        mesh = box("tetra", (2, 1, 1), (1.0, 0.1, 0.1))
        solid_model(mesh, STEEL)
        before = {path.name for path in cache.iterdir()}
        solid_model(mesh, Material(E=71.3e9, nu=0.311, rho=2713.0))
        bigger = box("tetra", (3, 1, 1), (1.0, 0.1, 0.1))
        halves = {"a": (Cells("tetra", bigger.connectivity[:9]),), "b": (Cells("tetra", bigger.connectivity[9:]),)}
        solid_model(replace(bigger, cells=halves), {"a": STEEL, "b": Material(E=1.5e9, nu=0.4, rho=1100.0)})
        assert {path.name for path in cache.iterdir()} == before

    def test_straight_cells_of_order_two_are_assembled_as_straight(self):
        mesh = box_of("tetra", 2)
        assert is_straight(mesh)
        assert not is_straight(deformed(mesh, bent))
        one, two = solid_model(mesh, STEEL), solid_model(mesh.with_order(1), STEEL)
        assert one.stiffness.nnz == two.stiffness.nnz
        assert np.abs(np.sort(one.stiffness.diagonal()) / np.sort(two.stiffness.diagonal()) - 1).max() < 1e-12

    def test_a_curved_geometry_matters(self):
        mesh = deformed(box_of("tetra", 2), bent)
        curved, straight = solid_model(mesh, STEEL), solid_model(mesh.with_order(1), STEEL)
        # bending keeps the volume, but not where it is
        assert inertia_matrix(curved)[5, 5] != pytest.approx(inertia_matrix(straight)[5, 5], rel=1e-6)

    def test_provenance(self):
        import json

        model = solid_model(ARM, Material(E=70e9, nu=0.33, rho=2700.0))
        kept = json.loads(json.dumps(model.provenance))
        assert kept["file"] == "arm.msh"
        assert len(kept["sha256"]) == 64
        assert kept["dofs"] == model.size == 3 * kept["nodes"]
        assert set(kept["versions"]) == {"dolfinx", "PETSc"}
        assert kept["materials"]["arm"]["E"] == 70e9
        assert all(seconds >= 0 for seconds in kept["seconds"].values())

    def test_nothing_is_logged_or_printed(self, caplog, capfd):
        with caplog.at_level(logging.DEBUG):
            solid_model(box_of("tetra"), STEEL)
        assert [r for r in caplog.records if r.levelno < logging.WARNING] == []
        out, err = capfd.readouterr()
        assert (out, err) == ("", "")

    def test_an_unknown_version_is_warned_of(self, monkeypatch):
        import dolfinx

        monkeypatch.setattr(dolfinx, "__version__", dolfinx.__version__)
        monkeypatch.setattr(_fenicsx, "NEWEST", (0, 4))
        with pytest.warns(UserWarning, match="outside the tested range"):
            solid_model(box_of("tetra"), STEEL)

    def test_a_numbering_that_is_not_understood_is_refused(self, monkeypatch):
        correct = _fenicsx.node_of_dof
        monkeypatch.setattr(_fenicsx, "node_of_dof", lambda *args: np.roll(correct(*args), 1))
        with pytest.raises(ValueError, match="ordered in an unknown way"):
            solid_model(box_of("tetra"), STEEL)


class TestBody:
    def test_a_reduced_body_of_the_arm(self):
        from kanefe.reduction import CraigBampton

        aluminium = Material(E=70e9, nu=0.33, rho=2700.0)
        body = solid_body(ARM, aluminium, {"root": "clamped", "tip": "rigid"}, reduction=CraigBampton(modes=6))
        assert body.free_count == 12  # six of the tip's frame, six modes
        exact = 2700.0 * (0.5 * (0.08 + 0.05) - np.pi * (0.022**2 + 0.020**2 + 0.018**2 + 0.016**2)) * 0.04
        assert body.mass == pytest.approx(exact, rel=2e-5)  # quadratic arcs around the holes


def test_no_warning_from_the_assembly():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solid_model(box_of("hexahedron"), STEEL)


def test_a_mesh_of_arrays_takes_two_coordinates():
    mesh = Mesh(np.array([[0, 0], [1, 0], [0, 1]], float), 2, {"p": (Cells("triangle", np.array([[0, 1, 2]])),)})
    model = solid_model(mesh, STEEL, plane="strain", thickness=0.5)
    assert model.mass_field.mass.sum() == pytest.approx(STEEL.rho * 0.25, rel=1e-14)
