"""Universal files of I-DEAS: the meshes that gmsh writes both ways, node by node, and what is refused by its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kanefe.errors import FileError
from kanefe_fem import Mesh, read_mesh
from kanefe_fem.mesh.checks import MeshWarning

TETRA = """    -1
  2411
         1         1         1        11
   0.0D+00   0.0D+00   0.0D+00
         2         1         1        11
   1.0D+00   0.0D+00   0.0D+00
         3         1         1        11
   0.0D+00   1.0D+00   0.0D+00
        14         1         1        11
   0.0D+00   0.0D+00   1.0D+00
    -1
    -1
  2412
         7       111         2         1         7         4
         1         2         3        14
    -1
    -1
  2467
         1         0         0         0         0         0         0         0
nothing

         2         0         0         0         0         0         0         3
TIP
         7        14         0         0         7         2         0         0
         7         3         0         0
         3         0         0         0         0         0         0         1
ALL OF IT
         8         7         0         0
    -1
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "a.unv"
    path.write_text(text)
    return path


def corners(mesh: Mesh) -> dict[str, np.ndarray]:
    """Places of the nodes of each cell and facet, by kind and group, cells in the order of their centres."""
    found = {}
    for blocks in (mesh.cells, mesh.facets):
        for name, some in blocks.items():
            for block in some:
                places = mesh.nodes[block.nodes]
                centres = places.mean(axis=1).round(9)
                found[f"{name} {block.kind}"] = places[np.lexsort(centres.T)]
    return found


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("shape", ["tetra", "hexahedron", "wedge"])
def test_the_same_mesh_both_ways(shape: str, order: int, tmp_path: Path) -> None:
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
        gmsh.option.setNumber("Mesh.MeshSizeMin", 0.5)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
        if shape == "tetra":
            volume = gmsh.model.occ.addBox(0, 0, 0, 1, 1, 0.5)
        else:
            face = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
            made = gmsh.model.occ.extrude([(2, face)], 0, 0, 0.5, [2], recombine=True)
            volume = made[1][1]
            if shape == "hexahedron":
                gmsh.model.occ.synchronize()
                gmsh.model.mesh.setTransfiniteSurface(face)
                gmsh.model.mesh.setRecombine(2, face)
        gmsh.model.occ.synchronize()
        for dimension, tag, name in ((3, volume, "body"), (2, 1, "root")):
            gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, [tag]), name)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        for suffix in (".unv", ".msh"):
            gmsh.write(str(tmp_path / f"a{suffix}"))
    finally:
        gmsh.finalize()
    ours, theirs = (corners(read_mesh(tmp_path / f"a{suffix}")) for suffix in (".unv", ".msh"))
    assert ours.keys() == theirs.keys()
    assert any(shape in name for name in ours)
    for name, places in ours.items():
        np.testing.assert_allclose(places, theirs[name], rtol=0, atol=1e-12)  # digits of both files


def test_groups_of_nodes_and_elements(tmp_path: Path) -> None:
    with pytest.warns(MeshWarning, match=r"a\.unv: groups without members: nothing"):
        mesh = read_mesh(written(tmp_path, TETRA))
    assert list(mesh.cells) == ["ALL OF IT"]
    assert sorted(mesh.points) == ["TIP"]
    assert mesh.nodes[mesh.points["TIP"]].tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]


def test_members_of_other_kinds_are_told(tmp_path: Path) -> None:
    node, other = "         7         3         0         0\n", "        14         5         0         0\n"
    with pytest.warns(MeshWarning, match="1 member"):
        mesh = read_mesh(written(tmp_path, TETRA.replace(node, other)))
    assert len(mesh.points["TIP"]) == 2


def test_lengths_by_the_units_of_the_file(tmp_path: Path) -> None:
    units = (
        "    -1\n   164\n         5  MM: mm (milli-newton)        2\n 1.0D+03 1.0D+03 1.0D+00\n 2.7315D+02\n    -1\n"
    )
    with pytest.warns(MeshWarning, match=r"in units of 1/1000 m \(data set 164\), and converted"):
        mesh = read_mesh(written(tmp_path, units + TETRA))
    assert mesh.nodes.max() == pytest.approx(1e-3)


SYSTEM = "    -1\n  2420\n   1\nmesh\n   1   1   0\ncylinder\n 1 0 0\n 0 1 0\n 0 0 1\n 0 0 0\n    -1\n"


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("111         2", "117         2", r"\(line 14\) an element of kind 117 with 4 nodes, which is not read"),
        ("         7         4\n", "         7         5\n", r"an element of kind 111 with 5 nodes"),
        ("        14\n    -1", "        15\n    -1", r"has no node 15, which element 7 has \(line 14\)"),
        ("         2         3        14", "         2         3", r"\(line 15\) and element 7 ends with 3 nodes of 4"),
        ("        14         1         1", "         3         1         1", r"\(line 9\) which is a node again"),
        ("   0.0D+00   1.0D+00   0.0D+00", "   0.0D+00   x   0.0D+00", r"\(line 8\) where numbers should be"),
        (
            "         0         3\nTIP",
            "         0         4\nTIP",
            r"\(line 26\) with more members of group 'TIP'",
        ),
        ("  2411\n", "   781\n", r"\(line 2\) which are nodes of an old kind"),
        ("    -1\n  2411\n", SYSTEM + "    -1\n  2411\n", r"nodes in the coordinate system 1 \(line 14\)"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(old: str, new: str, match: str, tmp_path: Path) -> None:
    assert old in TETRA
    with pytest.raises(FileError, match=match):
        read_mesh(written(tmp_path, TETRA.replace(old, new, 1)))


def test_a_file_that_ends_early(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"ends within a data set \(line 15\)"):
        read_mesh(written(tmp_path, "\n".join(TETRA.split("\n")[:15])))
