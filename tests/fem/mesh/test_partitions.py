"""Partitioned meshes: whole ones are read, with ghosts once; a piece is refused."""

from __future__ import annotations

import contextlib
import warnings
from pathlib import Path

import pytest

from kanefe.errors import MeshError
from kanefe.fe_model.shapes import measures
from kanefe_fem import read_mesh
from kanefe_fem.mesh.msh_file import has_parts

pytestmark = pytest.mark.gmsh


def partitioned(
    folder: Path,
    *,
    parts: int = 3,
    ghosts: bool = False,
    split: bool = False,
    named: bool = True,
    binary: bool = False,
    version: float = 4.1,
) -> Path:
    """A box of 2 x 1 x 1 m in parts."""
    import gmsh

    gmsh.initialize(["test"], False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addBox(0, 0, 0, 2, 1, 1)
        gmsh.model.occ.synchronize()
        if named:
            for dimension, name in ((3, "body"), (2, "held")):
                gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, [1]), name)
        gmsh.option.setNumber("Mesh.CharacteristicLengthMax", 0.5)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.PartitionSplitMeshFiles", split)
        gmsh.option.setNumber("Mesh.PartitionCreateGhostCells", ghosts)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.partition(parts)
        gmsh.write(str(folder / "p.msh"))
    finally:
        gmsh.option.setNumber("Mesh.Binary", 0)
        gmsh.option.setNumber("Mesh.PartitionSplitMeshFiles", 0)
        gmsh.option.setNumber("Mesh.PartitionCreateGhostCells", 0)
        gmsh.finalize()
    return folder / "p.msh"


@pytest.mark.parametrize("named", [True, False])
@pytest.mark.parametrize("ghosts", [True, False])
def test_a_whole_partitioned_mesh_is_read_once(ghosts: bool, named: bool, tmp_path: Path) -> None:
    path = partitioned(tmp_path, ghosts=ghosts, named=named)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = read_mesh(path)
    volume = sum(measures(block.kind, mesh.nodes[block.nodes])[0].sum() for block in mesh.cell_blocks)
    assert volume == pytest.approx(2.0, rel=1e-12)
    assert ("ghost cells left out" in mesh.provenance) == ghosts


@pytest.mark.parametrize("binary", [True, False])
def test_a_piece_is_refused(binary: bool, tmp_path: Path) -> None:
    partitioned(tmp_path, split=True, binary=binary)
    for part in (1, 2, 3):
        with pytest.raises(MeshError, match=rf"p_{part}.msh has part {part} of 3 of a partitioned mesh, .* Remedy"):
            read_mesh(tmp_path / f"p_{part}.msh")
    partitioned(tmp_path, split=True, ghosts=True)
    with pytest.raises(
        MeshError, match=r"part 1 of 3 of a partitioned mesh \(and \d+ ghost cells of others\), not the"
    ):
        read_mesh(tmp_path / "p_1.msh")


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("split", [True, False])
def test_parts_in_format_2_are_refused_or_read_as_far_as_gmsh_can(binary: bool, split: bool, tmp_path: Path) -> None:
    """Version 4.8 of gmsh reads none, and ends the process on some."""
    partitioned(tmp_path, split=split, binary=binary, version=2.2)
    path = tmp_path / ("p_3.msh" if split else "p.msh")
    assert has_parts(path)
    if split:
        with pytest.raises(
            MeshError, match=r"which gmsh 4\.8\.\d cannot read|has part 3 of several of a partitioned mesh"
        ):
            read_mesh(path)
        return
    with contextlib.suppress(MeshError):
        mesh = read_mesh(path)
        volume = sum(measures(block.kind, mesh.nodes[block.nodes])[0].sum() for block in mesh.cell_blocks)
        assert volume == pytest.approx(2.0, rel=1e-12)
