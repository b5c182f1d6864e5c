"""Reading meshes: formats, orders of nodes, groups by name, conversion between orders."""

from __future__ import annotations

import sys
import threading
import warnings

import numpy as np
import pytest

from fem_meshes import KINDS, box, write_msh2
from kanefe.errors import MeshError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import MIDS, measures, quadrature, shape
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh_files import read_mesh
from repository import ARM


def volume(mesh):
    return measures(mesh.kind, mesh.nodes[mesh.connectivity])[0].sum()


def area(mesh, group):
    return sum(measures(b.kind, mesh.nodes[b.nodes])[0].sum() for b in mesh.facets[group])


def same_mesh(one, other, atol=0.0):
    """Assert that two meshes are the same up to the numbering of their nodes."""
    assert one.dimension == other.dimension
    assert set(one.cells) == set(other.cells)
    assert set(one.facets) == set(other.facets)
    for a, b in ((one.cells, other.cells), (one.facets, other.facets)):
        for name in a:
            assert [x.kind for x in a[name]] == [x.kind for x in b[name]]
            for x, y in zip(a[name], b[name], strict=True):
                np.testing.assert_allclose(one.nodes[x.nodes], other.nodes[y.nodes], rtol=0, atol=atol)


@pytest.mark.parametrize("kind", sorted(MIDS))
def test_shape_functions_are_one_at_their_node_and_their_gradients_are_those_of_differences(kind):
    element = shape(kind)
    np.testing.assert_allclose(element.values(element.nodes), np.eye(len(element.nodes)), atol=1e-13)
    points, weights = quadrature(kind, 2)
    # central differences of a quadratic are exact, save for round-off / h; those of a rational shape to h^2
    h, error = (1e-5, 1e-6) if kind.startswith("pyramid") else (1e-3, 1e-11)
    for axis in range(element.dimension):
        step = h * np.eye(element.dimension)[axis]
        difference = (element.values(points + step) - element.values(points - step)) / (2 * h)
        np.testing.assert_allclose(element.gradients(points)[:, :, axis], difference, atol=error)
    unit = {"triangle": 0.5, "tetra": 1 / 6, "wedge": 0.5, "pyramid": 4 / 3}.get(element.corner_kind, 1.0)
    assert weights.sum() == pytest.approx(unit, rel=1e-14)


@pytest.mark.parametrize("degree", range(8))
def test_quadrature_of_simplices_is_exact_to_its_degree(degree):
    from math import factorial

    for kind in ("triangle", "tetra"):
        points, weights = quadrature(kind, degree)
        d = points.shape[1]
        for powers in np.ndindex(*(degree + 1,) * d):
            if sum(powers) <= degree:
                exact = np.prod([factorial(p) for p in powers]) / factorial(sum(powers) + d)
                assert weights @ np.prod(points ** np.array(powers), axis=1) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_second_order_adds_each_side_once_and_goes_back(kind):
    mesh = box(kind, (3, 2, 2), (0.3, 0.1, 0.08))
    d = mesh.dimension
    quadratic = mesh.with_order(2)
    # nodes of order 2 are those of a grid twice as fine (in a Kuhn grid too: all diagonals have their middle on it)
    assert len(quadratic.nodes) == np.prod([2 * n + 1 for n in (3, 2, 2)[:d]])
    assert len(np.unique(quadratic.nodes.round(12), axis=0)) == len(quadratic.nodes)
    assert volume(quadratic) == pytest.approx(np.prod((0.3, 0.1, 0.08)[:d]), rel=1e-13)
    tip = np.unique(quadratic.facets["tip"][0].nodes)
    np.testing.assert_array_equal(tip, np.flatnonzero(np.isclose(quadratic.nodes[:, 0], 0.3)))
    same_mesh(quadratic.with_order(1), mesh)
    again = quadratic.with_order(2)
    np.testing.assert_array_equal(again.connectivity, quadratic.connectivity)
    for facets in quadratic.facets["tip"]:
        corners = facets.nodes[:, : shape(facets.kind).corners]
        for i, mid in enumerate(MIDS[facets.kind]):
            mean = quadratic.nodes[corners[:, list(mid)]].mean(axis=1)
            np.testing.assert_allclose(quadratic.nodes[facets.nodes[:, corners.shape[1] + i]], mean, atol=1e-15)


def test_orphan_nodes_facets_and_points_off_the_body_are_dropped():
    nodes = [[9, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [8, 8, 8]]
    body = {"body": (Cells("tetra", np.array([[1, 2, 3, 4]])),)}
    facets = {"on": (Cells("triangle", np.array([[1, 2, 3]])),), "off": (Cells("triangle", np.array([[0, 1, 2]])),)}
    mesh = Mesh(np.array(nodes, float), 3, body, facets, points={"p": np.array([0, 4])}).with_order(2)
    assert len(mesh.nodes) == 10
    assert len(mesh.facets["on"][0].nodes) == 1
    assert len(mesh.facets["off"][0].nodes) == 0
    np.testing.assert_array_equal(mesh.nodes[mesh.points["p"]], [[0, 0, 1]])


PLATE = """
def build(gmsh):
    occ, model = gmsh.model.occ, gmsh.model
    plate, hole = occ.addBox(0, 0, 0, 1, 1, 0.05), occ.addCylinder(0.5, 0.5, -1, 0, 0, 3, 0.4)
    occ.cut([(3, plate)], [(3, hole)])
    occ.synchronize()
    model.setPhysicalName(3, model.addPhysicalGroup(3, [1]), "plate")
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.5)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
"""
"""Cells too coarse for their hole: moved onto it, the nodes at the middle of sides fold cells over themselves."""


@pytest.mark.gmsh
class TestGmsh:
    def test_cells_that_fold_are_mended(self, tmp_path, monkeypatch):
        path = tmp_path / "plate.py"
        path.write_text(PLATE)
        # 2 % is what eight arcs of second order miss of a circle at the most
        assert volume(read_mesh(path, order=2)) == pytest.approx(0.05 * (1 - np.pi * 0.4**2), rel=0.02)
        monkeypatch.setattr("kanefe_fem._gmsh.unfolded", lambda mesh: mesh)
        monkeypatch.setattr("kanefe_fem._gmsh._unfold", lambda gmsh: None)
        with pytest.raises(MeshError, match="changes its sign"):
            read_mesh(path, order=2)

    def test_cells_that_gmsh_does_not_unfold_are_made_straight(self, tmp_path, monkeypatch):
        """Gmsh 4.13 of Debian 13 gave up on this one, and ended Python: its error came from a thread."""
        path = tmp_path / "plate.py"
        path.write_text(PLATE)
        monkeypatch.setattr("kanefe_fem._gmsh._unfold", lambda gmsh: None)
        with pytest.warns(MeshWarning, match="cells of plate.py would fold over .* sides are straight"):
            mesh = read_mesh(path, order=2)
        # between the hole with sides of second order and the one with straight sides, of eight corners
        straight = 0.5 * 8 * 0.4**2 * np.sin(np.pi / 4)
        assert 0.05 * (1 - np.pi * 0.4**2) * 0.98 < volume(mesh) < 0.05 * (1 - straight) * 1.02

    @pytest.mark.parametrize("hexes", [False, True])
    @pytest.mark.parametrize("order", [1, 2])
    def test_all_formats_of_msh_give_the_same_mesh(self, geo, gmsh_session, tmp_path, hexes, order):
        gmsh = gmsh_session
        gmsh.open(str(geo(hexes=hexes)))
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        meshes = []
        for version in (2.2, 4.1):
            for binary in (0, 1):
                gmsh.option.setNumber("Mesh.MshFileVersion", version)
                gmsh.option.setNumber("Mesh.Binary", binary)
                path = tmp_path / f"box-{version}-{binary}.msh"
                gmsh.write(str(path))
                meshes.append(read_mesh(path))
        assert (
            meshes[0].kind
            == {(0, 1): "tetra", (0, 2): "tetra10", (1, 1): "hexahedron", (1, 2): "hexahedron27"}[int(hexes), order]
        )
        assert volume(meshes[0]) == pytest.approx(0.3 * 0.1 * 0.08, rel=1e-12)
        assert area(meshes[0], "tip") == pytest.approx(0.1 * 0.08, rel=1e-12)
        for other in meshes[1:]:
            same_mesh(meshes[0], other, atol=1e-15)  # ascii has 16 digits

    @pytest.mark.parametrize("suffix", [".vtu", ".inp", ".xdmf"])
    @pytest.mark.parametrize("hexes", [False, True])
    def test_meshio_formats_give_the_mesh_of_gmsh(self, geo, tmp_path, suffix, hexes):
        import meshio

        if suffix == ".xdmf":
            pytest.importorskip("h5py")
        order = (
            2 if suffix == ".vtu" else 1
        )  # Abaqus has no hexahedra of 27 nodes; meshio's XDMF reader no mixed order 2
        ours = read_mesh(geo(hexes=hexes), order=order)
        numbers = {"bar": 1, "root": 2, "tip": 3}
        blocks = [(name, b) for groups in (ours.cells, ours.facets) for name, bs in groups.items() for b in bs]
        data = {"group": [np.full(len(b.nodes), numbers[name]) for name, b in blocks]}
        sets = {
            name: [np.arange(len(b.nodes)) if n == name else np.array([], int) for n, b in blocks] for name in numbers
        }
        path = tmp_path / f"box{suffix}"
        cells = [(b.kind, b.nodes) for _, b in blocks]
        if suffix == ".inp":
            meshio.Mesh(ours.nodes, cells, cell_sets=sets).write(path)
            theirs = read_mesh(path)
        else:
            meshio.Mesh(ours.nodes, cells, cell_data=data).write(path)
            theirs = read_mesh(path, names={v: k for k, v in numbers.items()})
            assert set(read_mesh(path).cells) == {"1"}
        same_mesh(ours, theirs, atol=1e-15)

    def test_a_source_of_curved_cells_is_meshed_at_the_order_asked_for(self, tmp_path):
        path = tmp_path / "rod.geo"
        path.write_text(
            'SetFactory("OpenCASCADE"); Cylinder(1) = {0, 0, 0, 0.2, 0, 0, 0.1}; Mesh.MeshSizeMax = 0.05;\n'
            'Physical Volume("rod") = {1}; Physical Surface("root") = {3};\n'
        )
        exact = np.pi * 0.1**2 * 0.2
        errors = [1 - volume(read_mesh(path, order=order)) / exact for order in (1, 2)]
        assert 1e-3 < errors[0] < 0.1
        assert abs(errors[1]) < 1e-3 < errors[0] / 10

    def test_a_python_source_is_called_with_gmsh(self, tmp_path):
        path = tmp_path / "cube.py"
        path.write_text(
            "def build(gmsh):\n"
            "    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)\n"
            "    gmsh.model.occ.synchronize()\n"
            "    gmsh.model.addPhysicalGroup(3, [1], 7)\n"
        )
        mesh = read_mesh(path, order=2)
        assert mesh.kind == "tetra10"
        assert list(mesh.cells) == ["7"], "a group without a name is called by its number"
        assert volume(mesh) == pytest.approx(1.0, rel=1e-12)
        assert "cube" not in sys.modules

    def test_a_plane_source_is_meshed_in_two_dimensions(self, tmp_path):
        path = tmp_path / "plate.geo"
        path.write_text(
            'SetFactory("OpenCASCADE"); Rectangle(1) = {0, 0, 0, 2, 1}; Physical Surface("plate") = {1};\n'
            'Physical Line("root") = {4}; Physical Point("corner") = {3};\n'
        )
        mesh = read_mesh(path)
        assert (mesh.dimension, mesh.kind, set(mesh.facets), set(mesh.lines)) == (2, "triangle", {"root"}, {"root"})
        np.testing.assert_allclose(mesh.nodes[mesh.points["corner"]], [[2, 1, 0]], atol=1e-14)
        assert volume(mesh) == pytest.approx(2.0, rel=1e-12)

    def test_line_elements_of_frames(self, tmp_path):
        path = tmp_path / "frame.geo"
        path.write_text(
            "Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(3) = {1, 0, 1}; Line(1) = {1, 2}; Line(2) = {2, 3};\n"
            "Transfinite Line{1, 2} = 4;\n"
            'Physical Line("boom") = {1}; Physical Line("mast") = {2}; Physical Point("foot") = {1};\n'
        )
        mesh = read_mesh(path)
        assert mesh.dimension == 1
        assert {name: blocks[0].nodes.shape for name, blocks in mesh.lines.items()} == {"boom": (3, 2), "mast": (3, 2)}
        np.testing.assert_array_equal(mesh.nodes[mesh.points["foot"]], [[0, 0, 0]])

    def test_a_facet_in_two_groups_is_lost_by_neither(self, geo):
        groups = GROUPS_SHARED
        mesh = read_mesh(geo(groups=groups))
        assert area(mesh, "tip") == pytest.approx(0.1 * 0.08, rel=1e-12)
        assert area(mesh, "ends") == pytest.approx(2 * 0.1 * 0.08, rel=1e-12)
        rows = {name: {tuple(sorted(row)) for b in bs for row in b.nodes.tolist()} for name, bs in mesh.facets.items()}
        assert rows["tip"] < rows["ends"]

    @pytest.mark.parametrize("version", [2.2, 4.1])
    def test_a_facet_in_two_groups_of_a_file(self, geo, gmsh_session, tmp_path, version):
        gmsh_session.open(str(geo(groups=GROUPS_SHARED)))
        gmsh_session.model.mesh.generate(3)
        gmsh_session.option.setNumber("Mesh.MshFileVersion", version)
        path = tmp_path / "shared.msh"
        gmsh_session.write(str(path))
        mesh = read_mesh(path)
        assert area(mesh, "tip") == pytest.approx(0.1 * 0.08, rel=1e-12)
        assert area(mesh, "ends") == pytest.approx(2 * 0.1 * 0.08, rel=1e-12)

    def test_node_numbers_with_gaps_are_renumbered(self, tmp_path):
        path = write_msh2(
            tmp_path / "gap.msh",
            [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
            [(4, 1, (1, 2, 3, 4)), (2, 2, (1, 2, 3))],
            [(3, 1, "bar"), (2, 2, "root")],
        )
        whole = read_mesh(path)
        far = {1: 17, 2: 5_000_000_001 % 2**31, 3: 4, 4: 900}
        text = path.read_text().splitlines()
        start, end = text.index("$Nodes") + 2, text.index("$EndNodes")
        for i in range(start, end):
            number, rest = text[i].split(" ", 1)
            text[i] = f"{far[int(number)]} {rest}"
        for i in range(text.index("$Elements") + 2, text.index("$EndElements")):
            words = text[i].split()
            text[i] = " ".join(words[:5] + [str(far[int(n)]) for n in words[5:]])
        gaps = tmp_path / "gaps.msh"
        gaps.write_text("\n".join(text) + "\n")
        same_mesh(whole, read_mesh(gaps))

    def test_a_session_of_the_user_is_left_as_it_was(self, geo, gmsh_session):
        gmsh = gmsh_session
        gmsh.model.add("mine")
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        before = gmsh.model.list()
        read_mesh(geo())
        assert gmsh.model.getCurrent() == "mine"
        assert gmsh.model.list() == before
        assert len(gmsh.model.getEntities(3)) == 1

    def test_reading_works_in_threads_and_leaves_gmsh_finalised(self, geo):
        path = geo()
        found = []
        threads = [threading.Thread(target=lambda: found.append(read_mesh(path))) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(found) == 3
        same_mesh(found[0], found[2])

    def test_nothing_is_printed(self, geo, capfd):
        read_mesh(geo())
        out, err = capfd.readouterr()
        assert (out, err) == ("", "")

    def test_cells_of_no_group_are_left_out_with_a_warning(self, geo):
        path = geo(
            groups=GEO_GROUPS_FIRST + "more[] = Extrude {0, 0, 0.08} { Surface{out[0]}; Layers{2}; };",
        )
        with pytest.warns(MeshWarning, match="belong to no physical group"):
            mesh = read_mesh(path)
        assert volume(mesh) == pytest.approx(0.3 * 0.1 * 0.08, rel=1e-12)

    @pytest.mark.parametrize(
        ("nodes", "column", "groups", "words"),
        [
            ("Nodes", "", (1, 2), ""),
            ("ParametricNodes", " 3 1", (1, 2), ""),  # of Mesh.SaveParametric
            ("Nodes", "", (0, 0), "names 'body', 'root', and no element is in them"),  # of Mesh.SaveAll
            ("Nodes", "", (1, 0), "names 'root', and no element is in it"),
        ],
    )
    def test_what_gmsh_writes_of_a_tetrahedron(self, nodes, column, groups, words, tmp_path):
        """Issues 1411 and 1388 of meshio have such files, of gmsh 4."""
        places = enumerate(("0 0 0", "1 0 0", "0 1 0", "0 0 1"), 1)
        rows = "".join(f"{number} {place}{column}\n" for number, place in places)
        path = tmp_path / "one.msh"
        path.write_text(
            '$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 "body"\n2 2 "root"\n$EndPhysicalNames\n'
            f"${nodes}\n4\n{rows}$End{nodes}\n"
            f"$Elements\n2\n1 2 2 {groups[1]} 1 1 2 3\n2 4 2 {groups[0]} 1 1 2 3 4\n$EndElements\n"
        )
        with pytest.warns(MeshWarning, match=words) if words else warnings.catch_warnings():
            mesh = read_mesh(path)
        assert volume(mesh) == pytest.approx(1.0 / 6.0)
        assert set(mesh.facets) == ({"root"} if groups[1] else set())

    def test_the_arm_that_comes_with_the_package(self):
        mesh = read_mesh(ARM)
        assert set(mesh.cells) == {"arm"}
        assert set(mesh.facets) == {"root", "tip"}
        exact = (0.5 * (0.08 + 0.05) - np.pi * (0.022**2 + 0.020**2 + 0.018**2 + 0.016**2)) * 0.04
        assert volume(mesh) == pytest.approx(exact, rel=2e-5)  # cells of order 2 on round holes
        assert area(mesh, "root") == pytest.approx(0.08 * 0.04, rel=1e-12)
        assert area(mesh, "tip") == pytest.approx(0.05 * 0.04, rel=1e-12)
        assert len(mesh.provenance["sha256"]) == 64


GEO_GROUPS_FIRST = 'Physical Volume("bar") = {out[1]};'
GROUPS_SHARED = (
    'Physical Volume("bar") = {out[1]}; Physical Surface("tip") = {out[3]}; '
    'Physical Surface("ends") = {out[3], out[5]};'
)
