"""Partitioned meshes of gmsh: a file with one of several parts is no body, and ghost cells are copies of cells."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from kanefe.errors import MeshError
from kanefe_fem.mesh.msh_file import has_parts, msh_version

SECTION = b"$PartitionedEntities"

READS_PARTS = (4, 12)
"""First version of gmsh that reads its own partitioned meshes of format 2.2: 4.8 ends the process on some."""


def refuse_parts_of_format_2(version: str, path: Path) -> None:
    """Refuse a partitioned mesh that a version of gmsh does not read.

    Raises
    ------
    MeshError
    """
    numbers = tuple(int(part) for part in version.split(".")[:2])
    if numbers < READS_PARTS and msh_version(path).startswith("2") and has_parts(path):
        raise MeshError(
            f"{path.name} is a partitioned mesh of format 2.2, which gmsh {version} cannot read. Remedy: write it in "
            "format 4.1 (Mesh.MshFileVersion = 4.1), or without parts (gmsh.model.mesh.unpartition)"
        )


def refuse_piece(gmsh: Any, dimension: int, path: Path) -> None:
    """Refuse a mesh of which the current model has only some parts.

    Format 4.1 says how many parts there are. In format 2.2 only the numbers of the parts that are there show it.

    Raises
    ------
    MeshError
        If parts are missing; the message says which there are.
    """
    parts = {
        int(part)
        for _, entity in own_entities(gmsh, dimension)
        for part in gmsh.model.getPartitions(dimension, entity)
        if len(gmsh.model.mesh.getElements(dimension, entity)[0])
    }
    if not parts:
        return
    stated, ghosts = _stated_parts(path), ghost_count(gmsh, dimension)
    count = max(stated, *parts)
    if len(parts) == count > 1:
        return
    listed, more = ", ".join(map(str, sorted(parts))), f" (and {ghosts} ghost cells of others)" if ghosts else ""
    raise MeshError(
        f"{path.name} has part {listed} of {stated or 'several'} of a partitioned mesh{more}, "
        "not the whole body. Remedy: write it as one file (Mesh.PartitionSplitMeshFiles = 0), or join them in gmsh: "
        "gmsh.merge each of them, then gmsh.model.mesh.unpartition() and gmsh.write"
    )


def _stated_parts(path: Path) -> int:
    """Return the number of parts that a file of format 4.1 says; 0 of others."""
    if path.suffix.lower() != ".msh" or not msh_version(path).startswith("4"):
        return 0
    content = path.read_bytes()
    at = content.find(SECTION)
    if at < 0:
        return 0
    head = content[at + len(SECTION) :].lstrip(b"\r\n")[:20]
    first = head.split()[0] if head.split() else b""
    if first.isdigit():
        return int(first)
    return min(int.from_bytes(head[:8], "little"), int.from_bytes(head[:8], "big"))


def own_entities(gmsh: Any, dimension: int) -> list[tuple[int, int]]:
    """Return the entities of a dimension without ghosts, whose cells are those of other parts once more."""
    entities = gmsh.model.getEntities(dimension)
    return [(d, int(tag)) for d, tag in entities if "ghost" not in gmsh.model.getType(d, tag).lower()]


def ghost_count(gmsh: Any, dimension: int) -> int:
    """Return how many ghost cells there are."""
    own = set(own_entities(gmsh, dimension))
    others = [(d, int(tag)) for d, tag in gmsh.model.getEntities(dimension) if (d, int(tag)) not in own]
    return sum(len(gmsh.model.mesh.getGhostElements(d, tag)[0]) for d, tag in others)
