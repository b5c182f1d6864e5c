"""Bad meshes, materials and calls: each is refused with its name, its place and a remedy, before dolfinx sees it."""

from __future__ import annotations

import os
import signal
import struct
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fem_meshes import KINDS, STEEL, box, shown, write_msh2
from kanefe.errors import FileError, MeshError, MissingDependency, ModelError
from kanefe.fe_model.model import Cells
from kanefe_fem import _gmsh
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.mesh.checks import MeshWarning, check_mesh, oriented
from kanefe_fem.mesh.groups import check_interfaces
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.mesh_files import read_mesh
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.model import solid_model

TETRA = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]


def one_block(kind, nodes, cells, dimension=3):
    return Mesh(np.array(nodes, float), dimension, {"bar": (Cells(kind, np.array(cells)),)}, source="test")


@pytest.mark.usefixtures("no_assembly")
class TestMesh:
    def test_no_group_of_cells(self):
        with pytest.raises(MeshError) as error:
            solid_model(replace(box("tetra", (2, 1, 1), (1, 1, 1)), cells={}), STEEL)
        shown(error, "no cell belongs to a physical volume")

    @pytest.mark.parametrize("where", [np.nan, np.inf])
    def test_coordinates_that_are_not_finite(self, where):
        mesh = box("tetra", (2, 1, 1), (1, 1, 1))
        nodes = np.array(mesh.nodes)
        nodes[5, 1] = where
        with pytest.raises(MeshError) as error:
            solid_model(replace(mesh, nodes=nodes), STEEL)
        shown(error, "node 5", "finite")

    def test_node_numbers_that_do_not_exist(self):
        with pytest.raises(MeshError) as error:
            solid_model(one_block("tetra", TETRA, [[0, 1, 2, 4]]), STEEL)
        shown(error, "node 4", "only 4 nodes")

    @pytest.mark.parametrize(
        ("kind", "count", "word"),
        [
            ("pyramid14", 14, "Mesh.ElementOrder"),
            ("tetra20", 20, "Mesh.ElementOrder"),
        ],
    )
    def test_shapes_that_are_not_supported(self, kind, count, word):
        nodes = np.random.default_rng(1).random((count, 3))
        with pytest.raises(MeshError) as error:
            solid_model(one_block(kind, nodes, [range(count)]), STEEL)
        shown(error, kind, "'bar'", word)

    def test_mixed_shapes(self):
        tets, hexes = box("tetra", (1, 1, 1), (1, 1, 1)), box("hexahedron", (1, 1, 1), (1, 1, 1))
        mesh = replace(tets, cells={"a": tets.cell_blocks, "b": hexes.cell_blocks})
        with pytest.raises(MeshError) as error:
            solid_model(mesh, {"a": STEEL, "b": STEEL})
        shown(error, "mixes shapes", "triangular side", "pyramids between")

    def test_a_cell_in_two_groups(self):
        mesh = box("tetra", (2, 1, 1), (1, 1, 1))
        block = mesh.cell_blocks[0]
        both = replace(mesh, cells={"a": (block,), "b": (Cells("tetra", block.nodes[3:5]),)})
        with pytest.raises(MeshError) as error:
            solid_model(both, {"a": STEEL, "b": STEEL})
        shown(error, "'a' and 'b'", "two groups")

    def test_a_cell_twice(self):
        with pytest.raises(MeshError) as error:
            solid_model(one_block("tetra", TETRA, [[0, 1, 2, 3], [1, 2, 0, 3]]), STEEL)
        shown(error, "there 2 times", "(0.25, 0.25, 0.25)")

    def test_a_flat_cell(self):
        nodes = [*TETRA, [1, 1, 0], [1, 0.5, 0]]
        with pytest.raises(MeshError) as error:
            solid_model(one_block("tetra", nodes, [[0, 1, 2, 3], [1, 2, 4, 5]]), STEEL)
        shown(error, "vanishes in cell 1", "'bar'", "(0.75, 0.625, 0)")

    def test_a_cell_turned_partly_inside_out(self):
        mesh = box("hexahedron", (2, 1, 1), (2, 1, 1))
        cells = mesh.connectivity.copy()
        cells[1, [0, 1]] = cells[1, [1, 0]]
        with pytest.raises(MeshError) as error:
            solid_model(one_block("hexahedron", mesh.nodes, cells), STEEL)
        shown(error, "changes its sign inside cell 1", "(1.5, 0.5, 0.5)")

    def test_a_curved_cell_that_folds(self):
        mesh = box("tetra", (1, 1, 1), (1, 1, 1)).with_order(2)
        nodes = np.array(mesh.nodes)
        nodes[mesh.connectivity[0, 4]] += 0.4  # a mid-side node past the corner
        with pytest.raises(MeshError) as error:
            solid_model(replace(mesh, nodes=nodes), STEEL)
        shown(error, "Jacobian", "HighOrderOptimize")

    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("order", [1, 2])
    def test_cells_that_are_merely_inside_out_are_turned(self, kind, order):
        mesh = check_mesh(box(kind, (2, 1, 2), (1, 1, 1)).with_order(order))
        nodes = np.array(mesh.nodes)
        nodes[:, 0] *= -1.0
        mirrored = oriented(replace(mesh, nodes=nodes))
        again = oriented(mirrored)
        assert not np.array_equal(mirrored.connectivity, mesh.connectivity)
        np.testing.assert_array_equal(again.connectivity, mirrored.connectivity)
        np.testing.assert_array_equal(np.sort(mirrored.connectivity), np.sort(mesh.connectivity))

    def test_parts_that_are_not_connected(self):
        one = box("tetra", (2, 1, 1), (1, 1, 1))
        far = one.nodes + np.array([5.0, 0, 0])
        cells = np.vstack([one.connectivity, one.connectivity[:3] + len(one.nodes)])
        with pytest.raises(MeshError) as error:
            solid_model(one_block("tetra", np.vstack([one.nodes, far]), cells), STEEL)
        shown(error, "2 parts", "12 cells around (0.5", "3 cells around (5.")

    def test_coincident_nodes_that_were_not_merged(self):
        one = box("hexahedron", (2, 1, 1), (1, 1, 1))
        nodes = np.vstack([one.nodes, one.nodes + np.array([1.0, 0, 0])])
        cells = np.vstack([one.connectivity, one.connectivity + len(one.nodes)])
        with pytest.raises(MeshError) as error:
            solid_model(one_block("hexahedron", nodes, cells), STEEL)
        shown(error, "2 parts", "4 nodes lie on another one", "merge them")

    def test_a_crack_is_only_warned_of(self):
        one = box("hexahedron", (2, 2, 1), (1, 1, 1))
        nodes, cells = np.array(one.nodes), one.connectivity.copy()
        split = np.flatnonzero(np.isclose(nodes[:, 0], 0.5) & np.isclose(nodes[:, 1], 1.0))
        for i, old in enumerate(split):
            cells[-1][cells[-1] == old] = len(nodes) + i
        mesh = one_block("hexahedron", np.vstack([nodes, nodes[split]]), cells)
        with pytest.warns(MeshWarning, match="2 nodes lie on another one"):
            check_mesh(mesh)

    def test_a_surface_that_is_not_plane(self):
        nodes = np.array(box("quad", (2, 2), (1, 1)).nodes)
        nodes[:, 2] = nodes[:, 0] ** 2
        mesh = replace(box("quad", (2, 2), (1, 1)), nodes=nodes)
        with pytest.raises(MeshError) as error:
            solid_model(mesh, STEEL, plane="stress", thickness=0.1)
        shown(error, "plane z = constant", "shell_body")

    def test_a_mesh_of_lines(self):
        mesh = Mesh(np.array(TETRA, float), 1, {}, lines={"boom": (Cells("line", np.array([[0, 1]])),)})
        with pytest.raises(MeshError) as error:
            solid_model(mesh, STEEL)
        shown(error, "only lines", "beam")


@pytest.mark.usefixtures("no_assembly")
class TestCall:
    mesh = box("tetra", (2, 1, 1), (1.0, 0.1, 0.1))

    def test_an_unknown_interface(self):
        with pytest.raises(ModelError) as error:
            solid_body(self.mesh, STEEL, {"root": "clamped", "tipp": "rigid"})
        shown(error, "'tipp'", "root, tip")

    def test_a_group_of_cells_as_an_interface(self):
        with pytest.raises(ModelError) as error:
            check_interfaces(self.mesh, {"bar": "clamped"})
        shown(error, "'bar' is a group of cells")

    def test_an_interface_without_facets(self):
        mesh = replace(self.mesh, facets={"root": (), "tip": self.mesh.facets["tip"]})
        with pytest.raises(MeshError) as error:
            solid_body(mesh, STEEL, {"root": "clamped"})
        shown(error, "'root' has no facets")

    def test_an_interface_off_the_body(self):
        nodes = np.vstack([self.mesh.nodes, np.array(TETRA, float) + 3.0])
        n = len(self.mesh.nodes)
        mesh = replace(self.mesh, nodes=nodes, facets={"root": (Cells("triangle", np.array([[n, n + 1, n + 2]])),)})
        with pytest.raises(MeshError) as error:
            solid_body(mesh, STEEL, {"root": "clamped"})
        shown(error, "'root'", "not on the body")

    def test_materials_and_groups_that_do_not_match(self):
        two = replace(self.mesh, cells={"a": self.mesh.cell_blocks, "b": ()})
        two = replace(
            two,
            cells={
                "a": (Cells("tetra", self.mesh.connectivity[:6]),),
                "b": (Cells("tetra", self.mesh.connectivity[6:]),),
            },
        )
        for materials, words in (
            ({}, ("group 'bar' has no material",)),
            ({"bar": STEEL, "bat": STEEL}, ("'bat'", "no such group", "'bar'")),
            ({"bar": 210e9}, ("'bar'", "210")),
        ):
            with pytest.raises(ModelError) as error:
                solid_model(self.mesh, materials)
            shown(error, *words)
        for materials, words in ((STEEL, ("one material", "'a', 'b'")), ({"a": STEEL}, ("'b' has no material",))):
            with pytest.raises(ModelError) as error:
                solid_model(two, materials)
            shown(error, *words)

    def test_plane_and_thickness_where_they_do_not_belong(self):
        plate = box("quad", (2, 2), (1, 1))
        for mesh, options, words in (
            (self.mesh, {"plane": "stress"}, ("has volumes",)),
            (self.mesh, {"thickness": 0.1}, ("has volumes",)),
            (plate, {}, ("plane=None",)),
            (plate, {"plane": "flat", "thickness": 1.0}, ("plane='flat'",)),
            (plate, {"plane": "stress"}, ("thickness=None",)),
            (plate, {"plane": "stress", "thickness": -1.0}, ("thickness=-1.0",)),
            (self.mesh, {"order": 3}, ("order=3",)),
        ):
            with pytest.raises(ModelError) as error:
                solid_model(mesh, STEEL, **options)
            shown(error, *words)


class TestFiles:
    def test_a_file_that_is_not_there(self, tmp_path):
        for name in ("no.msh", "no.vtu"):
            with pytest.raises(FileError) as error:
                read_mesh(tmp_path / name)
            shown(error, name)

    @pytest.mark.parametrize("suffix", [".vtu", ".inp", ".xdmf", ".vtk", ".fem", ".f3grid", ".foo"])
    @pytest.mark.parametrize("content", [b"", b"\x00\x01garbage\n\n", b"<VTKFile"])
    def test_garbage_through_meshio(self, tmp_path, suffix, content):
        path = tmp_path / f"bad{suffix}"
        path.write_bytes(content)
        with pytest.raises((FileError, MeshError)) as error:
            read_mesh(path)
        shown(error, path.name)

    def test_a_truncated_vtu(self, tmp_path):
        import meshio

        mesh = box("tetra", (2, 1, 1), (1, 1, 1))
        path = tmp_path / "bar.vtu"
        meshio.Mesh(mesh.nodes, [("tetra", mesh.connectivity)]).write(path)
        whole = path.read_bytes()
        for part in (0.3, 0.6, 0.95):
            path.write_bytes(whole[: int(part * len(whole))])
            with pytest.raises(FileError) as error:
                read_mesh(path)
            shown(error, "bar.vtu")

    def test_order_of_the_geometry(self, tmp_path):
        with pytest.raises(MeshError) as error:
            read_mesh(tmp_path / "any.msh", order=3)
        shown(error, "order 3")


@pytest.mark.gmsh
class TestGmshFiles:
    @pytest.mark.parametrize("version", [2.2, 4.1])
    @pytest.mark.parametrize("binary", [0, 1])
    def test_a_truncated_msh_is_an_error_and_never_a_crash(self, geo, gmsh_session, tmp_path, version, binary):
        gmsh = gmsh_session
        gmsh.open(str(geo()))
        gmsh.model.mesh.generate(3)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        path = tmp_path / "bar.msh"
        gmsh.write(str(path))
        whole = path.read_bytes()
        for size in {0, 5, 30, *np.linspace(40, len(whole) - 6, 25).astype(int)}:
            path.write_bytes(whole[:size])
            with pytest.raises(FileError) as error:
                read_mesh(path)
            shown(error, "bar.msh")

    def test_lines_missing_inside_an_ascii_file(self, geo, gmsh_session, tmp_path):
        # in a process of its own: should gmsh crash, the test says so
        gmsh_session.open(str(geo()))
        gmsh_session.model.mesh.generate(3)
        path = tmp_path / "bar.msh"
        gmsh_session.write(str(path))
        lines = path.read_text().splitlines()
        start = lines.index("$Elements")
        path.write_text("\n".join(lines[: start + 20] + lines[start + 40 :]) + "\n")
        script = (
            "import sys\nfrom kanefe.errors import KanefeError\nfrom kanefe_fem.mesh_files import read_mesh\n"
            "try:\n    read_mesh(sys.argv[1])\nexcept KanefeError as error:\n    print(type(error).__name__)\n"
        )
        done = subprocess.run(
            [sys.executable, "-c", script, str(path)],
            capture_output=True,
            text=True,
            check=False,
            cwd=Path.cwd(),
            env={**os.environ, "PYTHONPATH": ":".join(filter(None, sys.path))},
        )
        assert done.returncode == 0, done.stderr
        assert done.stdout.strip() in ("FileError", "MeshError")

    def test_not_a_mesh_and_an_old_format(self, tmp_path):
        path = tmp_path / "x.msh"
        for text, word in (("hello\n", "$MeshFormat"), ("$MeshFormat\n1.0 0 8\n$EndMeshFormat\n", "1.0")):
            path.write_text(text)
            with pytest.raises(FileError) as error:
                read_mesh(path)
            shown(error, "x.msh", word)

    def test_a_volume_in_two_groups(self, geo):
        with pytest.raises(MeshError) as error:
            read_mesh(geo(groups='Physical Volume("a") = {out[1]}; Physical Volume("b") = {out[1]};'))
        shown(error, "volume 1", "'a' and 'b'")

    @pytest.mark.parametrize("version", [2.2, 4.1])
    def test_a_volume_in_two_groups_of_a_file(self, geo, gmsh_session, tmp_path, version):
        gmsh_session.open(str(geo(groups='Physical Volume("a") = {out[1]}; Physical Volume("b") = {out[1]};')))
        gmsh_session.model.mesh.generate(3)
        gmsh_session.option.setNumber("Mesh.MshFileVersion", version)
        path = tmp_path / "two.msh"
        gmsh_session.write(str(path))
        with pytest.raises(MeshError) as error:
            read_mesh(path)
        shown(error, "two.msh", "'a' and 'b'")

    def test_groups_that_gmsh_cannot_keep_apart(self, tmp_path):
        elements = [(4, 1, (1, 2, 3, 4)), (2, 2, (1, 2, 3)), (2, 3, (1, 2, 4))]
        names = [(3, 1, "bar"), (2, 2, "root"), (2, 3, "tip")]
        path = write_msh2(tmp_path / "same.msh", TETRA, elements, names)
        assert set(read_mesh(path).facets) == {"root", "tip"}
        path.write_text(path.read_text().replace("2 2 3 3", "2 2 3 2"))  # "tip" on the entity of "root"
        with pytest.raises(MeshError) as error:
            read_mesh(path)
        shown(error, "same.msh", "'root', 'tip'", "entit")

    def test_third_order(self, geo):
        with pytest.raises(MeshError) as error:
            read_mesh(geo(options="Mesh.ElementOrder = 3;"))
        shown(error, "Mesh.ElementOrder = 1 or 2")

    def test_a_source_with_an_error(self, tmp_path):
        path = tmp_path / "bad.geo"
        path.write_text("Point(1) = {0, 0, 0;\nVolume(1) = {7};\n")
        with pytest.raises(FileError) as error:
            read_mesh(path)
        shown(error, "bad.geo")

    @pytest.mark.parametrize(("text", "word"), [("x = 1\n", "build(gmsh)"), ("def build(:\n", "not a Python source")])
    def test_python_sources(self, tmp_path, text, word):
        path = tmp_path / "source.py"
        path.write_text(text)
        with pytest.raises(FileError, match=r"source\.py") as error:
            read_mesh(path)
        assert word in str(error.value)

    def test_a_fault_of_the_users_own_source_comes_through(self, tmp_path):
        path = tmp_path / "source.py"
        path.write_text("def build(gmsh):\n    1 / 0\n")
        with pytest.raises(ZeroDivisionError):
            read_mesh(path)
        path.write_text("def build(gmsh):\n    gmsh.model.occ.addBox(0, 0, 0, 0, 0, 0)\n")
        with pytest.raises(FileError, match=r"source\.py"):
            read_mesh(path)


class TestMissing:
    @pytest.mark.parametrize(("name", "remedy"), [("gmsh", "python3-gmsh"), ("meshio", "pip install meshio")])
    def test_readers(self, tmp_path, monkeypatch, name, remedy):
        path = tmp_path / {"gmsh": "a.msh", "meshio": "a.vtu"}[name]
        path.write_text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n0\n$EndNodes\n$Elements\n0\n$EndElements\n")
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(MissingDependency) as error:
            read_mesh(path)
        shown(error, name, remedy)

    def test_dolfinx(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "dolfinx", None)
        with pytest.raises(MissingDependency) as error:
            solid_model(box("tetra", (2, 1, 1), (1, 1, 1)), STEEL)
        shown(error, "python3-dolfinx", "kanefe[fenicsx]", "/usr/bin/python3")


@pytest.mark.parametrize("suffix", [".iges", ".SLDPRT"])
def test_a_geometry_that_is_not_read_is_told(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"part{suffix}"
    path.write_text("?")
    with pytest.raises(FileError, match=r"is a geometry of another program\. Remedy: export it as STEP"):
        read_mesh(path)


def msh4(damage: tuple[str, str] = ("", "")) -> bytes:
    text = (
        '$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 "v"\n$EndPhysicalNames\n$Entities\n0 0 0 1\n'
        "1 0 0 0 1 1 1 1 1 0\n$EndEntities\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
        "$EndNodes\n$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n"
    )
    assert damage[0] in text
    return text.replace(*damage).encode()


DAMAGE = {
    "node of an element": ("1 1 2 3 4\n", "1 1 2 3 1000000000000\n"),
    "negative": ("1 1 2 3 4\n", "1 -1 2 3 4\n"),
    "nodes of a block": ("3 1 0 4\n", "3 1 0 18446744073709551615\n"),
    "elements of a block": ("3 1 4 1\n", "3 1 4 18446744073709551615\n"),
    "blocks": ("1 4 1 4\n", "-1 0 1 4\n"),
    "number of a node": ("4\n1\n2\n", "4\n1\n9223372036854775807\n"),
    "dimension of a name": ('3 1 "v"', '18446744073709551615 1 "v"'),
}


@pytest.mark.gmsh
@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_file_is_refused_before_gmsh_takes_its_numbers_for_places(
    tmp_path: Path, damage: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Gmsh ended Python by most of these."""
    path = tmp_path / "part.msh"
    path.write_bytes(msh4())
    assert len(read_mesh(path).nodes) == 4
    path.write_bytes(msh4(damage))
    monkeypatch.setattr(_gmsh, "session", None)
    with pytest.raises(
        FileError, match=r"part\.msh.* (is damaged|line of \$PhysicalNames).*Remedy: write the file again"
    ):
        read_mesh(path)


@pytest.mark.gmsh
def test_numbers_of_a_binary_file_are_compared_too(tmp_path: Path) -> None:
    path = tmp_path / "part.msh"
    write = tmp_path / "write.py"
    write.write_text(
        "def build(gmsh):\n    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)\n    gmsh.model.occ.synchronize()\n"
        "    gmsh.model.addPhysicalGroup(3, [1])\n    gmsh.model.mesh.generate(3)\n"
        f"    gmsh.option.setNumber('Mesh.Binary', 1)\n    gmsh.write({str(path)!r})\n"
        "    gmsh.option.setNumber('Mesh.Binary', 0)\n"
    )
    mesh, whole = read_mesh(write), path.read_bytes()
    assert len(read_mesh(path).nodes) == len(mesh.nodes)
    for place in (whole.index(b"$Nodes") + 14, whole.index(b"$EndElements") - 9):
        content = bytearray(whole)
        content[place] ^= 0xFF
        path.write_bytes(content)
        with pytest.raises(FileError, match=r"is damaged: the count or the numbers of its (nodes|elements)"):
            read_mesh(path)


@pytest.mark.gmsh
@pytest.mark.parametrize("binary", [0, 1])
@pytest.mark.parametrize("damage", ["number of a node", "node of an element"])
def test_numbers_of_format_2_are_compared(tmp_path: Path, binary: int, damage: str) -> None:
    """Gmsh ended Python by a last node 0, and by an element that names the node after the last."""
    path = tmp_path / "part.msh"
    head = f"$MeshFormat\n2.2 {binary} 8\n".encode() + b"\1\0\0\0\n" * binary + b"$EndMeshFormat\n"

    def content(last: int, named: int) -> bytes:
        nodes = [(n, float(n == 2), float(n == 3), float(n > 3 or n < 1)) for n in (1, 2, 3, last)]
        if binary:
            rows = b"".join(struct.pack("<i3d", *node) for node in nodes) + b"\n"
            cells = struct.pack("<10i", 4, 1, 2, 1, 1, 1, 1, 2, 3, named) + b"\n"
        else:
            rows = "".join("{} {} {} {}\n".format(*node) for node in nodes).encode()
            cells = f"1 4 2 1 1 1 2 3 {named}\n".encode()
        return head + b"$Nodes\n4\n" + rows + b"$EndNodes\n$Elements\n1\n" + cells + b"$EndElements\n"

    path.write_bytes(content(4, 4))
    assert len(read_mesh(path).nodes) == 4
    path.write_bytes(content(0, 4) if "number" in damage else content(4, 5))
    with pytest.raises(FileError, match=r"is damaged: the count or the numbers of its (nodes|elements)"):
        read_mesh(path)


ENDS = {
    ".ply": "ply\nformat ascii 1.0\nelement vertex 3\n",
    ".off": "OFF\n",
    ".tec": 'TITLE = "a"\nVARIABLES = "X", "Y", "Z"\n'
    "ZONE NODES=5, ELEMENTS=2, DATAPACKING=BLOCK, ZONETYPE=FETETRAHEDRON\n0.0\n",
    ".mdpa": "Begin Nodes\n 1 0.0 0.0 0.0\n",
    ".node": "# nodes\n",
    ".wkt": "TIN (" + "((0.0 0.0 0.0, 1.0 0.0 0.0, 0.0 1.0 0.0, 0.0 0.0 0.0)), " * 5,
}


@pytest.mark.skipif(os.name != "posix", reason="by a signal")
@pytest.mark.parametrize("suffix", ENDS)
def test_a_file_that_ends_early_ends_its_reader(tmp_path: Path, suffix: str) -> None:
    """These readers of meshio looked for more lines for ever."""
    path = tmp_path / f"part{suffix}"
    path.write_text(ENDS[suffix])

    def end(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(10)
    try:
        with pytest.raises(FileError, match=r"part\..*it ends where more should follow|\.wkt are not read"):
            read_mesh(path)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


CLAIMS = {
    ".ply": "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face {}\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    ".xml": '<dolfin><mesh celltype="triangle" dim="2"><vertices size="3"><vertex index="0" x="0" y="0"/>'
    '<vertex index="1" x="1" y="0"/><vertex index="2" x="0" y="1"/></vertices>'
    '<cells size="{}"><triangle index="0" v0="0" v1="1" v2="2"/></cells></mesh></dolfin>',
}


@pytest.mark.parametrize("suffix", CLAIMS)
def test_a_file_that_claims_more_than_it_has_is_refused(tmp_path: Path, suffix: str) -> None:
    """Room was made for a hundred million cells, and took what was there for some."""
    path = tmp_path / f"part{suffix}"
    path.write_text(CLAIMS[suffix].format(1))
    assert len(read_mesh(path).nodes) == 3
    path.write_text(CLAIMS[suffix].format(99999999))
    with pytest.raises(FileError, match=r"part\.\w+ claims 99999999 of \w+, and has \d+ at most.*Remedy"):
        read_mesh(path)


@pytest.mark.parametrize(
    "make",
    [
        lambda: box_mesh((1, 1, 1), (10**5,) * 3),
        lambda: straight_beam(1.0, Rectangle(1.0, 1.0), STEEL, elements=10**11),
    ],
)
def test_a_mesh_larger_than_memory_is_refused(make):
    with pytest.raises(ModelError, match=r"takes .* GiB, but only"):
        make()
