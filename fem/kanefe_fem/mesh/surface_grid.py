"""Meshes of surfaces without a mesh generator: a grid of nine-node quadrangles on a map of the unit square."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.frames import numbers
from kanefe_fem.machine.memory import check_size
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.simple import merged

Place = Callable[[np.ndarray, np.ndarray], Sequence[np.ndarray]]
"""Function of coordinates s and r, arrays from 0 to 1, that returns x, y and z in m."""

_ORDER = ((0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0), (1, 1))


@checked
def surface_mesh(place: Place, counts: tuple[int, int]) -> Mesh:
    """Return a mesh of a surface in space, for a shell.

    Parameters
    ----------
    place : callable
        Function of arrays s and r, from 0 to 1, that returns x, y and z in m. The normal is that of the tangents along
        s and along r.
    counts : (int, int)
        Numbers of quadrangles along s and along r.

    Returns
    -------
    Mesh
        Of order 2 with the group of cells "body" and the lines "root" and "tip" (s = 0 and 1), "bottom" and "top" (r =
        0 and 1).

    Raises
    ------
    ModelError
        If a number is not valid, or the function does not return three arrays of the right shape.

    Examples
    --------
    A gutter, half a pipe of 0.1 m radius along x:

    >>> gutter = surface_mesh(lambda s, r: (s, 0.1 * np.cos(np.pi * r), -0.1 * np.sin(np.pi * r)), (8, 6))
    >>> sorted(gutter.facets)
    ['bottom', 'root', 'tip', 'top']
    """
    if numbers(counts).shape != (2,) or not all(isinstance(n, (int, np.integer)) and n >= 1 for n in counts):
        raise ModelError(f"surface_mesh: counts={counts!r}. Remedy: two whole numbers of at least 1")
    check_size(int(np.prod([2 * n + 1 for n in counts])), f"surface_mesh: counts={counts!r}")
    r, s = np.meshgrid(*(np.linspace(0.0, 1.0, 2 * n + 1) for n in counts[::-1]), indexing="ij")
    given = place(s.ravel(), r.ravel())
    found = [numbers(x) for x in given] if isinstance(given, tuple | list | np.ndarray) else []
    if len(found) != 3 or any(x.shape not in ((), s.ravel().shape) for x in found):
        raise ModelError("surface_mesh: the function does not return x, y and z for each point. Remedy: three arrays")
    nodes = np.stack([np.broadcast_to(x, s.ravel().shape) for x in found], axis=1)
    number = np.arange(s.size).reshape(s.shape)
    rows, columns = number.shape
    cells = np.stack(
        [number[i : rows - 2 + i : 2, j : columns - 2 + j : 2].ravel() for i, j in _ORDER],
        axis=1,
    )
    sides = {"root": number[:, 0], "tip": number[:, -1], "bottom": number[0], "top": number[-1]}
    lines = {
        name: (Cells("line3", np.stack((side[:-2:2], side[2::2], side[1:-1:2]), axis=1)),)
        for name, side in sides.items()
    }
    return Mesh(nodes, 2, {"body": (Cells("quad9", cells),)}, facets=lines, source="a surface")


def joined_surfaces(meshes: Sequence[Mesh]) -> Mesh:
    """Return surfaces as one mesh, with the nodes that lie on each other made one; lines keep no names.

    Parameters
    ----------
    meshes : sequence of Mesh
        As of `surface_mesh`.
    """
    starts = np.cumsum([0, *(len(mesh.nodes) for mesh in meshes)])
    table = np.concatenate([mesh.connectivity + start for mesh, start in zip(meshes, starts[:-1], strict=True)])
    nodes, cells = merged(np.concatenate([mesh.nodes for mesh in meshes]), table)
    return Mesh(nodes, 2, {"body": (Cells("quad9", cells),)}, source="surfaces")
