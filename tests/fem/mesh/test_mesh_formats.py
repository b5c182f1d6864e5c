"""Meshes of other programs: groups of cells, facets and nodes reach the model by their names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fem_meshes import box
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh_files import read_mesh

meshio = pytest.importorskip("meshio")
BAR = box("hexahedron", (4, 1, 1), (1.0, 0.1, 0.1))
CELLS = BAR.cells["bar"][0].nodes
ROOT, TIP = (BAR.facets[name][0].nodes for name in ("root", "tip"))


def assert_same(mesh: Mesh) -> None:
    assert mesh.nodes == pytest.approx(BAR.nodes)
    assert sorted(map(sorted, mesh.cells["bar"][0].nodes.tolist())) == sorted(map(sorted, CELLS.tolist()))
    for name, facet in (("root", ROOT), ("tip", TIP)):
        assert sorted(mesh.facets[name][0].nodes.ravel().tolist()) == sorted(facet.ravel().tolist())


def test_nastran_properties(tmp_path: Path) -> None:
    blocks: list[Any] = [("hexahedron", CELLS), ("quad", ROOT), ("quad", TIP)]
    numbers = [np.full(4, 1), np.full(1, 2), np.full(1, 3)]
    path = tmp_path / "bar.bdf"
    meshio.Mesh(BAR.nodes, blocks, cell_data={"nastran:ref": numbers}).write(path)
    assert_same(read_mesh(path, names={1: "bar", 2: "root", 3: "tip"}))
    assert set(read_mesh(path).facets) == {"2", "3"}


def test_med_families(tmp_path: Path) -> None:
    pytest.importorskip("h5py")
    path = tmp_path / "bar.med"
    blocks: list[Any] = [("hexahedron", CELLS), ("quad", np.vstack((ROOT, TIP)))]
    tags = [np.full(4, -1), np.array([-2, -3])]
    at_end = np.where(np.isin(np.arange(len(BAR.nodes)), TIP), 1, 0)
    mesh = meshio.Mesh(BAR.nodes, blocks, cell_data={"cell_tags": tags}, point_data={"point_tags": at_end})
    mesh.cell_tags = {-1: ["bar"], -2: ["root", "ends"], -3: ["tip", "ends"]}  # a family is in several groups
    mesh.point_tags = {1: ["end nodes"]}
    mesh.write(path)
    read = read_mesh(path)
    assert_same(read)
    assert len(read.facets["ends"][0].nodes) == 2
    assert sorted(read.points["end nodes"].tolist()) == sorted(TIP.ravel().tolist())


def test_abaqus_sets_of_elements_and_nodes(tmp_path: Path) -> None:
    path = tmp_path / "bar.inp"
    sets = {"root": np.unique(ROOT), "tip": np.unique(TIP)}
    meshio.Mesh(BAR.nodes, [("hexahedron", CELLS)], point_sets=sets, cell_sets={"bar": [np.arange(4)]}).write(path)
    read = read_mesh(path)
    assert list(read.cells) == ["bar"]
    assert {name: read.points[name].tolist() for name in sets} == {name: ids.tolist() for name, ids in sets.items()}


@pytest.mark.fenicsx
def test_sets_of_nodes_are_interfaces(tmp_path: Path) -> None:
    import kanefe as kf
    from fem_meshes import STEEL
    from kanefe_fem.solids.model import solid_model

    path = tmp_path / "bar.inp"
    sets = {"root": np.unique(ROOT), "tip": np.unique(TIP)}
    meshio.Mesh(BAR.nodes, [("hexahedron", CELLS)], point_sets=sets, cell_sets={"bar": [np.arange(4)]}).write(path)
    of_nodes, of_facets = (
        kf.flexible_body(
            solid_model(mesh, STEEL, order=1), {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=2)
        )
        for mesh in (read_mesh(path), BAR)
    )
    assert of_nodes.frequencies == pytest.approx(of_facets.frequencies, rel=1e-9)
