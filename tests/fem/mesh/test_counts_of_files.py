"""Counts that a file states are those of what is read of it; what meshio leaves out is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fem_meshes import box
from kanefe.errors import FileError
from kanefe_fem import read_mesh
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.claimed_counts import check_all_read

meshio = pytest.importorskip("meshio")
BAR = box("hexahedron", (4, 1, 1), (1.0, 0.1, 0.1))
NODES = len(BAR.nodes)
TETRA = "NDIME= 3\nNELEM= 1\n10 0 1 2 3 0\nNPOIN= {}\n0 0 0 0\n1 0 0 1\n0 1 0 2\n0 0 1 3\n{}"


def written(folder: Path, name: str, **options: object) -> Path:
    """The bar as meshio writes it; triangles in formats of surfaces, tetrahedra in formats of those."""
    kind, cells = "hexahedron", BAR.cells["bar"][0].nodes
    if name.endswith((".stl", ".ply", ".off")):
        kind, cells = "triangle", cells[:, :3]
    elif name.endswith((".node", ".xml")):
        kind, cells = "tetra", cells[:, [0, 1, 3, 4]]
    meshio.Mesh(BAR.nodes, [(kind, cells)]).write(folder / name, **options)
    return folder / name


@pytest.mark.filterwarnings("ignore:VTU requires:UserWarning")
@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("a.vtu", {"binary": False}),
        ("a.vtu", {"binary": True}),
        ("a.vtk", {"binary": False}),
        ("a.vtk", {"binary": True}),
        ("a.vtk", {"file_format": "vtk42"}),
        ("a.xdmf", {"data_format": "XML"}),
        ("a.su2", {}),
        ("a.mesh", {}),
        ("a.ply", {"binary": True}),
        ("a.stl", {"binary": True}),
        ("a.stl", {"binary": False}),
        ("a.off", {}),
        ("a.xml", {}),
        ("a.node", {}),
        ("a.msh", {"file_format": "gmsh", "binary": True}),
        ("a.msh", {"file_format": "gmsh22", "binary": False}),
    ],
)
def test_other_counts_are_refused_or_told(name: str, options: dict[str, object], tmp_path: Path) -> None:
    path = written(tmp_path, name, **options)
    check_all_read(path, NODES, 4)
    with pytest.raises(FileError, match=rf"{name} states 4 cells, and 3 were read: .* Remedy"):
        check_all_read(path, NODES, 3)
    if name not in ("a.stl", "a.xdmf"):  # which do not state them
        with pytest.warns(MeshWarning, match=rf"{name} states {NODES} nodes, and 5 were read\. Remedy"):
            check_all_read(path, 5, 4)


def test_a_binary_stl_with_fewer_triangles_than_it_states_is_refused(tmp_path: Path) -> None:
    """As gmsh 4.15 writes it of quadrilaterals of second order; meshio takes it for a text."""
    path = written(tmp_path, "a.stl", binary=True)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(FileError, match=r"a\.stl claims 4 of triangles, and has 2 at most"):
        read_mesh(path)


def test_formats_without_counts_are_as_they_are_read(tmp_path: Path) -> None:
    check_all_read(written(tmp_path, "a.bdf"), 1, 1)


@pytest.mark.gmsh
def test_nodes_that_gmsh_leaves_out_are_told(tmp_path: Path) -> None:
    path = written(tmp_path, "a.msh", file_format="gmsh22", binary=False)
    text = path.read_text().replace(f"$Nodes\n{NODES}\n", f"$Nodes\n{NODES + 1}\n99 7 7 7\n")
    path.write_text(text)
    with pytest.warns(MeshWarning, match=rf"a\.msh states {NODES + 1} nodes, and {NODES} were read"):
        assert read_mesh(path).cell_count == 4


def test_what_meshio_tells_on_the_terminal_only_is_a_warning(tmp_path: Path) -> None:
    (tmp_path / "a.su2").write_text(TETRA.format(4, "NPERIODIC 3\n"))
    with pytest.warns(
        MeshWarning, match=r"a\.su2: meshio says: meshio could not parse line NPERIODIC 3 skipping\. Rem"
    ):
        assert read_mesh(tmp_path / "a.su2").cell_count == 1


def test_an_unknown_shape_is_called_so(tmp_path: Path) -> None:
    (tmp_path / "a.su2").write_text(TETRA.format(4, "").replace("\n10 ", "\n24 "))
    with pytest.raises(FileError, match=r"meshio cannot read a\.su2: it does not know 24"):
        read_mesh(tmp_path / "a.su2")


@pytest.mark.parametrize(("name", "is_group"), [("group", True), ("tetgen:ref", True), ("domain", False)])
def test_whole_numbers_of_cells_are_groups_or_told(name: str, is_group: bool, tmp_path: Path) -> None:
    cells, numbers = BAR.cells["bar"][0].nodes, np.array((3, 3, 4, 4))
    path = tmp_path / "a.vtu"
    meshio.Mesh(BAR.nodes, [("hexahedron", cells)], cell_data={name: [numbers]}).write(path)
    if is_group:
        assert list(read_mesh(path).cells) == ["3", "4"]
        return
    with pytest.warns(MeshWarning, match=r"a\.vtu has whole numbers 'domain' of its cells, which are not taken for gr"):
        assert list(read_mesh(path).cells) == ["body"]
