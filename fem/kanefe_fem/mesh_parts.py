"""Parts of a mesh: several bodies from one mesh, each of some of its groups of cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import ModelError
from kanefe.finite_element_model import Cells

if TYPE_CHECKING:
    from kanefe_fem.mesh import Blocks, Mesh


def part_of(mesh: Mesh, cells: str | Sequence[str] | None) -> Mesh:
    """Return the mesh of some groups of cells, with the facets, lines and points that are on them.

    The facets between two bodies are in the parts of both, each with nodes of its own: they are interfaces by which a
    scene joins the bodies.

    Parameters
    ----------
    mesh : Mesh
        Whose node numbers exist.
    cells : str, sequence of str, or None
        Names of groups of cells. None: the whole mesh.

    Raises
    ------
    ModelError
        If the mesh has no such group of cells.

    Examples
    --------
    >>> rotor = part_of(mesh, "rotor")                                   # doctest: +SKIP
    """
    if cells is None:
        return mesh
    names = [cells] if isinstance(cells, str) else list(cells)
    unknown = [name for name in names if name not in mesh.cells]
    if unknown or not names:
        raise ModelError(
            f"{mesh.source} has no group of cells called {unknown[0] if unknown else None!r}. Remedy: cells= some of "
            f"{', '.join(map(repr, mesh.cells)) or 'none'}"
        )
    kept = {name: mesh.cells[name] for name in mesh.cells if name in names}
    used = np.zeros(len(mesh.nodes), dtype=bool)
    for blocks in kept.values():
        for block in blocks:
            used[block.nodes] = True
    number = np.cumsum(used) - 1

    def inside(groups: Blocks) -> dict[str, tuple[Cells, ...]]:
        found = {
            name: tuple(Cells(b.kind, number[b.nodes[used[b.nodes].all(axis=1)]]) for b in blocks)
            for name, blocks in groups.items()
        }
        return {name: blocks for name, blocks in found.items() if any(len(block.nodes) for block in blocks)}

    points = {name: number[ids[used[ids]]] for name, ids in mesh.points.items() if used[ids].any()}
    return replace(
        mesh,
        nodes=mesh.nodes[used],
        cells=inside(kept),
        facets=inside(mesh.facets),
        lines=inside(mesh.lines),
        points=points,
        source=mesh.source if len(kept) == len(mesh.cells) else f"{mesh.source} ({', '.join(kept)})",
    )
