"""Door to mapdl-archive: nodes and components of Ansys archives. The only file that imports mapdl_archive."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import FileError, MissingDependency
from kanefe.imports.node_table import NodeTable
from kanefe.storage.files import regular_file


def nodes(path: Path) -> NodeTable:
    """Return the nodes of an archive (.cdb) with its node components as sets."""
    mapdl_archive = _import_mapdl_archive()
    path = regular_file(path, "for the nodes")
    try:
        archive = mapdl_archive.Archive(str(path), parse_vtk=False)
        labels = np.asarray(archive.nnum, dtype=np.int64)
        points = np.asarray(archive.nodes, dtype=float)[:, :3]
        angles = np.asarray(archive.node_angles, dtype=float)
        sets = {name: np.asarray(members, dtype=np.int64) for name, members in archive.node_components.items()}
    except (OSError, ValueError, KeyError, IndexError, TypeError, RuntimeError, AttributeError) as error:
        raise FileError(f"cannot read the nodes of {path}: {error}. Remedy: write it again with CDWRITE,DB") from error
    if not len(labels):
        raise FileError(f"{path} has no nodes (NBLOCK). Remedy: write it again with CDWRITE,DB")
    table = NodeTable.of_rows(np.column_stack((labels, points)), str(path), sets)
    if not np.any(angles):
        return table
    order = np.argsort(labels)
    return NodeTable(table.labels, table.points, table.sets, _axes(np.radians(angles[order])))


def _axes(angles: np.ndarray) -> np.ndarray:
    """Return A_Gd of nodes turned by THXY about z, then THYZ about the new x, then THZX about the new y, (n, 3, 3)."""
    c, s = np.cos(angles), np.sin(angles)
    zero, one = np.zeros(len(angles)), np.ones(len(angles))

    def matrix(rows: list[list[np.ndarray]]) -> np.ndarray:
        return np.array(rows).transpose(2, 0, 1)

    about_z = matrix([[c[:, 0], -s[:, 0], zero], [s[:, 0], c[:, 0], zero], [zero, zero, one]])
    about_x = matrix([[one, zero, zero], [zero, c[:, 1], -s[:, 1]], [zero, s[:, 1], c[:, 1]]])
    about_y = matrix([[c[:, 2], zero, s[:, 2]], [zero, one, zero], [-s[:, 2], zero, c[:, 2]]])
    return about_z @ about_x @ about_y


def _import_mapdl_archive() -> Any:
    try:
        import mapdl_archive
    except ImportError as problem:
        raise MissingDependency(
            "mapdl-archive", "read_ansys of an archive (.cdb)", "pip install 'kanefe[ansys]'"
        ) from problem
    return mapdl_archive
