"""Groups of MED files: families that are of no group, as medcoupling writes them, are those of what is in none."""

from __future__ import annotations

import zipfile
from pathlib import Path

from kanefe_fem import read_mesh

CUBE = Path(__file__).with_name("medcoupling_9_15_0.zip")
"""A cube of 8 hexahedra with groups of cells, faces and nodes: medcoupling 9.15.0."""


def test_groups_beside_families_of_none(tmp_path: Path) -> None:
    with zipfile.ZipFile(CUBE) as archive:
        archive.extractall(tmp_path)
    mesh = read_mesh(tmp_path / "c.med")
    assert {name: sum(len(block.nodes) for block in blocks) for name, blocks in mesh.cells.items()} == {"ALL": 8}
    assert {name: sum(len(block.nodes) for block in blocks) for name, blocks in mesh.facets.items()} == {
        "ROOT": 4,
        "TIP": 4,
    }
    assert (mesh.nodes[mesh.facets["ROOT"][0].nodes][..., 0] == 0.0).all()
    assert (mesh.nodes[mesh.points["BOTTOM"]][:, 2] == 0.0).all()
    assert len(mesh.points["BOTTOM"]) == 9
