"""How many nodes a mesh will have, and what memory and time it takes, before it is made.

The counts follow from volumes and areas by what cells of gmsh are like on average, measured on a cube, a plate with a
hole, a thin plate, a bar and a ball with gmsh 4.8 and 4.15: within 15 % where the cells are smaller than the details.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kanefe.errors import MeshError
from kanefe_fem.machine.memory import SHARE, free_memory, rough_size

TRIANGLES = 2.5
"""Number of triangles on an area of the square of the size."""

SIDE = 0.96
"""Side of equal triangles that cover an area, relative to the size."""

INNER_NODES = 0.68
"""Number of corners of cells in a volume of the cube of the side, with half of those on the surface."""

CELLS_OF_INNER, CELLS_OF_OUTER = 6.2, 2.94
"""Numbers of cells per corner inside and on the surface."""

BYTES = {1: 350.0, 2: 700.0}
"""Memory of gmsh and of the arrays per cell of the order, bytes."""

SECONDS_OF_TRIANGLE, SECONDS_OF_CELL = 1.5e-5, {1: 6e-6, 2: 2e-5}
"""Time of the mesher per triangle, and per cell of the order, on a processor of 2023, s."""


@dataclass(frozen=True)
class Estimate:
    """The size of a mesh to be made.

    Attributes
    ----------
    nodes, cells : int
    memory : float
        Of the mesher, bytes.
    seconds : float
        Of the mesher.
    factor : float
        Memory of a factorisation of the stiffness of the body, at most, bytes.
    """

    nodes: int
    cells: int
    memory: float
    seconds: float
    factor: float

    def __str__(self) -> str:
        """Return the estimate in words."""
        return (
            f"about {_rounded(self.nodes)} nodes and {_rounded(self.cells)} cells, {1e-6 * self.memory:.2g} MB and "
            f"{self.seconds:.2g} s to mesh; up to {1e-9 * self.factor:.2g} GB to factor its stiffness"
        )


def _rounded(count: int) -> str:
    return f"{float(f'{count:.2g}'):,.0f}"


def estimate(volumes: Sequence[float], areas: Sequence[float], sizes: Sequence[float], order: int) -> Estimate:
    """Return what a mesh of solids takes with a size for each.

    Parameters
    ----------
    volumes, areas, sizes : sequence of float, one for each solid
        m^3, m^2, m.
    order : {1, 2}
    """
    triangles = [TRIANGLES * area / size**2 for area, size in zip(areas, sizes, strict=True)]
    return from_triangles(volumes, triangles, [SIDE * size for size in sizes], order)


def of_surface(area: float, size: float, order: int) -> Estimate:
    """Return what a mesh of a surface takes, of an area in m^2 and a size in m; rows of six components a node."""
    cells = TRIANGLES * area / size**2
    nodes = cells / 2.0 if order == 1 else 2.0 * cells  # Euler's formula: half as many corners as triangles, 3/2 sides
    return Estimate(
        int(nodes), int(cells), BYTES[order] * cells, SECONDS_OF_TRIANGLE * cells, rough_size(int(6 * nodes))
    )


def from_triangles(
    volumes: Sequence[float], triangles: Sequence[float], sides: Sequence[float], order: int
) -> Estimate:
    """Return what a mesh of solids takes whose surfaces have so many triangles of these sides."""
    nodes = cells = 0.0
    for volume, count, side in zip(volumes, triangles, sides, strict=True):
        outer = count / 2.0
        inner = max(0.0, INNER_NODES * volume / side**3 - outer / 2.0)
        own = CELLS_OF_INNER * inner + CELLS_OF_OUTER * outer
        cells += own
        # Euler's formula gives the sides of the cells, which are the further nodes of order 2
        nodes += outer + inner if order == 1 else 2.0 * (outer + inner) + own + outer
    seconds = SECONDS_OF_TRIANGLE * sum(triangles) + SECONDS_OF_CELL[order] * cells
    return Estimate(int(nodes), int(cells), BYTES[order] * cells, seconds, rough_size(int(3 * nodes)))


def refuse_if_too_large(found: Estimate, sizes: Sequence[float], what: str) -> None:
    """Raise a MeshError if the mesher needs more memory than is free; the message names the size that would fit."""
    free = free_memory()
    if free is None or found.memory <= SHARE * free:
        return
    enlarged = (found.memory / (0.5 * free)) ** (1.0 / 3.0)
    raise MeshError(
        f"{what}: {found}, but only {1e-6 * free:.3g} MB are free. Remedy: a larger size, such as "
        f"{min(sizes) * enlarged:.2g} m, or only some of the parts, by cells="
    )
