"""The text of `print(mesh)`."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import measures, shape

SHOWN = 12
"""Largest number of listed groups of one kind."""

_UNITS = ("m", "m2", "m3")


def summary(
    source: str,
    nodes: np.ndarray,
    groups: Mapping[str, Mapping[str, tuple[Cells, ...]]],
    points: Mapping[str, int],
) -> str:
    """Return a text of several lines with nodes, cells by shape, extent, and the groups with their sizes.

    Parameters
    ----------
    source : str
        Origin of the mesh.
    nodes : ndarray, shape (n, 3)
        Coordinates in m.
    groups : dict of "cells", "facets" and "lines" to groups by name
    points : dict of str to int
        Number of points of each group.
    """
    bodies = (groups["cells"] or groups["lines"]).values()
    body = nodes[np.unique(np.concatenate([block.nodes.ravel() for blocks in bodies for block in blocks]))]
    low, size = np.min(body, axis=0), np.ptp(body, axis=0)
    apart = f" ({len(nodes) - len(body)} more in no cell)" if len(body) < len(nodes) else ""
    counts: dict[str, int] = {}
    for blocks in groups["cells"].values():
        for block in blocks:
            counts[block.kind] = counts.get(block.kind, 0) + len(block.nodes)
    cells = ", ".join(f"{count} {kind}" for kind, count in counts.items()) or "no cells"
    lines = [
        f"mesh {source}: {len(body)} nodes{apart}, {cells}",
        f"  extent  {' x '.join(f'{x:.4g}' for x in size)} m, from ({', '.join(f'{x:.4g}' for x in low)})",
    ]
    for word, named in groups.items():
        lines += _listed(word, [f"{name or 'all'} ({_size(nodes, blocks)})" for name, blocks in named.items()])
    return "\n".join(lines + _listed("points", [f"{name} ({count})" for name, count in points.items()]))


def _listed(word: str, shown: list[str]) -> list[str]:
    if not shown:
        return []
    more = f", and {len(shown) - SHOWN} more" if len(shown) > SHOWN else ""
    return [f"  {word:<7} {', '.join(shown[:SHOWN])}{more}"]


def _size(nodes: np.ndarray, blocks: tuple[Cells, ...]) -> str:
    """Return the number of cells of a group and their length, area or volume."""
    filled = [block for block in blocks if len(block.nodes)]
    if not filled:
        return "empty"
    total = sum(float(measures(block.kind, nodes[block.nodes])[0].sum()) for block in filled)
    unit = _UNITS[shape(filled[0].kind).dimension - 1]
    return f"{sum(len(block.nodes) for block in filled)}, {total:.4g} {unit}"
