"""Checks of the mesh of a shell beside those of `kanefe_fem.mesh.checks`: nothing here is wrong, but told."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from kanefe.errors import outside
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import shape
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.shells.directors import corner_normals

TURN = np.radians(60.0)
"""Largest turn of the normal within a cell, rad, above which it is told."""

SHARP = np.radians(3.0)
"""Least angle at the corner of a cell, rad; below it, or as near to 180 degrees, the cell is a sliver."""

SAME = 1e-6
"""Distance of the middles of two cells, relative to their size, below which one lies on the other."""

NARROW = 1e-3
"""Area of a cell, relative to the square of its longest side, below which it is a sliver."""


def check_surface(mesh: Mesh, *, is_whole: bool) -> Mesh:
    """Return the mesh of a shell with each line once in a group; warn of what is hardly intended.

    Parameters
    ----------
    mesh : Mesh
    is_whole : bool
        Whether no other cells use its nodes.

    Warns
    -----
    MeshWarning
        Of nodes in no cell, cells on others, lines that are there twice, cells that are warped and slivers.
    """
    free = len(mesh.nodes) - len(mesh.body_nodes)
    if free and is_whole:
        first = int(np.setdiff1d(np.arange(len(mesh.nodes)), mesh.body_nodes)[0])
        _tell(
            f"{mesh.source}: {free} nodes are in no cell of the shell, first node {first} at "
            f"{mesh.nodes[first].round(6).tolist()} m, and are left out. Remedy: none, if they are construction points"
        )
    _tell_of_twins(mesh)
    for name, block in _blocks(mesh):
        _tell_of_warp(mesh, name, block)
        _tell_of_slivers(mesh, name, block)
    facets = {name: tuple(_once(mesh, name, blocks)) for name, blocks in mesh.facets.items()}
    lines = {name: facets.get(name, blocks) for name, blocks in mesh.lines.items()}
    return replace(mesh, facets=facets, lines=lines)


def tell_of_turned(source: str, turned: int, what: Sequence[str]) -> None:
    """Warn of cells that were turned to the side of most others, where something goes by the normals."""
    if turned and what:
        _tell(
            f"{source}: {turned} cells have their normal on the other side of their neighbours', and are turned as "
            f"most are. {', '.join(what)} {'goes' if len(what) == 1 else 'go'} by the normals of most. Remedy: turn "
            "them in the mesh, if that is the wrong side"
        )


def _blocks(mesh: Mesh) -> Iterator[tuple[str, Cells]]:
    for name, blocks in mesh.cells.items():
        for block in blocks:
            yield name, block


def turn_within(nodes: np.ndarray, block: Cells) -> np.ndarray:
    """Return the largest angle between the normals at the corners of each cell, rad: of warp, or of a curve."""
    normals = corner_normals(nodes, block)[:, : shape(block.kind).corners]
    cosine = np.einsum("mpi,mqi->mpq", normals, normals).min(axis=(1, 2))
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _tell_of_twins(mesh: Mesh) -> None:
    """Warn of cells that lie on others and have nodes of their own."""
    blocks = [block for _, block in _blocks(mesh)]
    corners = [mesh.nodes[block.nodes[:, : shape(block.kind).corners]] for block in blocks]
    middles = np.concatenate([x.mean(axis=1) for x in corners])
    sizes = np.concatenate([np.linalg.norm(np.ptp(x, axis=1), axis=1) for x in corners])
    twins = cKDTree(middles).query_pairs(SAME * sizes.max(), output_type="ndarray")
    near = np.linalg.norm(middles[twins[:, 0]] - middles[twins[:, 1]], axis=1) < SAME * sizes[twins].min(axis=1)
    if near.any():
        at = middles[twins[near][0, 0]].round(6).tolist()
        _tell(
            f"{mesh.source}: {near.sum()} cells lie on another one, the first at {at} m, and are not joined to it over "
            "their area: each bends by itself. Remedy: one surface with the thickness of both, or a gap between them"
        )


def _tell_of_warp(mesh: Mesh, name: str, block: Cells) -> None:
    """Warn of cells whose normals at the corners differ much."""
    turn = turn_within(mesh.nodes, block)
    wrong = np.flatnonzero(turn > TURN)
    if len(wrong):
        worst = int(turn.argmax())
        _tell(
            f"{mesh.source}: {len(wrong)} cells of group {name!r} are warped, or too large for their curve: the normal "
            f"turns by up to {np.degrees(turn[worst]):.0f} degrees within one, at {_place(mesh, block, worst)} m. "
            "Remedy: smaller cells there, or triangles"
        )


def _tell_of_slivers(mesh: Mesh, name: str, block: Cells) -> None:
    """Warn of cells that are next to a line."""
    corners = mesh.nodes[block.nodes[:, : shape(block.kind).corners]]
    ahead = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(ahead, axis=2)
    behind = -np.roll(ahead, 1, axis=1)
    cosine = np.einsum("mci,mci->mc", ahead, behind) / (lengths * np.roll(lengths, 1, axis=1))
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    sharpest = np.minimum(angle, np.pi - angle).min(axis=1)
    spread = corners[:, 2:] - corners[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], spread[:, 0]), axis=1) * (corners.shape[1] - 2)
    slim = area / lengths.max(axis=1) ** 2
    wrong = np.flatnonzero((sharpest < SHARP) | (slim < NARROW))
    if len(wrong):
        worst = int(wrong[slim[wrong].argmin()])
        _tell(
            f"{mesh.source}: {len(wrong)} cells of group {name!r} are slivers, the narrowest at "
            f"{_place(mesh, block, worst)} m: area over longest side squared {slim[worst]:.2g}, sharpest angle "
            f"{np.degrees(sharpest[worst]):.2g} degrees. Remedy: heal the geometry (short edges), or mesh more evenly"
        )


def _once(mesh: Mesh, name: str, blocks: tuple[Cells, ...]) -> Iterator[Cells]:
    """Yield blocks of lines with each line once."""
    for kind in dict.fromkeys(block.kind for block in blocks):
        nodes = np.concatenate([block.nodes for block in blocks if block.kind == kind])
        _, first = np.unique(np.sort(nodes, axis=1), axis=0, return_index=True)
        if len(first) < len(nodes):
            _tell(
                f"{mesh.source}: {len(nodes) - len(first)} lines of group {name!r} are there twice, and count "
                "once. Remedy: remove the duplicate curve (Coherence in a .geo)"
            )
        yield Cells(kind, nodes[np.sort(first)])


def _place(mesh: Mesh, block: Cells, number: int) -> list[float]:
    return [float(x) for x in mesh.nodes[block.nodes[number]].mean(axis=0).round(6)]


def _tell(text: str) -> None:
    warnings.warn(text, MeshWarning, stacklevel=outside())
