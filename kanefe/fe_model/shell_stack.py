"""Directors, thickness and layers of a shell: what stresses, pictures and contacts need besides its mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kanefe.fe_model.shapes import row_numbers


class FacePlaces(NamedTuple):
    """Where the fields of a shell are continuous: one for each side of a node and each section there.

    Attributes
    ----------
    of_corners : ndarray of int, shape (q,)
        Number of the place of each node of each cell, cell by cell.
    node, section : ndarray of int, shape (P,)
    director : ndarray, shape (P, 3)
        Unit director.
    thickness : ndarray, shape (P,)
        m.
    """

    of_corners: np.ndarray
    node: np.ndarray
    section: np.ndarray
    director: np.ndarray
    thickness: np.ndarray


@dataclass(frozen=True, eq=False)
class ShellStack:
    """The thickness of the shells of a body: those of its cells that have areas, in their order, c with q nodes in all.

    Attributes
    ----------
    nodes : ndarray of int, shape (s,)
        Node of each director.
    directors : ndarray, shape (s, 3)
        Unit directors: one for each smooth side of a node.
    sides : ndarray of int, shape (q,)
        Number of the director of each node of each cell, cell by cell.
    cells : ndarray of int, shape (q,)
        Number of that cell among the c.
    thickness : ndarray, shape (q,)
        m.
    along : ndarray, shape (c, 3)
        Direction whose part in the surface is the first axis of the section.
    of_cell : ndarray of int, shape (c,)
        Number of the section.
    is_isotropic : ndarray of bool, shape (m,)
        Sections with the same moduli in all directions of the surface.
    first : ndarray of int, shape (m + 1,)
        First layer of each section, bottom to top, and the number of all layers.
    heights : ndarray, shape (l, 2)
        Bottom and top of the layers above the surface of the nodes, as fractions of the thickness.
    plane : ndarray, shape (l, 3, 3)
        Stresses 11, 22, 12 from strains in plane stress, in the axes of the section, Pa.
    shear : ndarray, shape (l, 2, 2)
        Stresses 13, 23 from strains, Pa.
    across : ndarray, shape (l, 3)
        Strain 33 from strains 11, 22, 12 in plane stress.
    angles : ndarray, shape (l,)
        From axis 1 of the section to that of the layer, rad.
    strengths : ndarray, shape (l, 6)
        In tension and compression along axis 1 and 2, in shear 12, in Pa, and Tsai and Wu's coefficient F12 over
        ``sqrt(F11 F22)``; NaN where they are not known.
    forces : ndarray, shape (m, 2, 2)
        Shear forces from transverse shear strains per thickness, Pa.
    """

    nodes: np.ndarray
    directors: np.ndarray
    sides: np.ndarray
    cells: np.ndarray
    thickness: np.ndarray
    along: np.ndarray
    of_cell: np.ndarray
    is_isotropic: np.ndarray
    first: np.ndarray
    heights: np.ndarray
    plane: np.ndarray
    shear: np.ndarray
    across: np.ndarray
    angles: np.ndarray
    strengths: np.ndarray
    forces: np.ndarray

    @cached_property
    def places(self) -> FacePlaces:
        """Where fields are continuous."""
        section = self.of_cell[self.cells]
        keys = row_numbers(np.column_stack((self.nodes[self.sides], self.sides, section)))
        _, first, place = np.unique(keys, return_index=True, return_inverse=True)
        side = self.sides[first]
        return FacePlaces(place.ravel(), self.nodes[side], section[first], self.directors[side], self.thickness[first])

    @cached_property
    def most_layers(self) -> int:
        """Largest number of layers of a section."""
        return int(np.diff(self.first).max())

    def heights_of(self, section: np.ndarray) -> np.ndarray:
        """Return the bottom and the top of the whole thickness of sections, shape (..., 2), as fractions of it."""
        return np.stack((self.heights[self.first[section], 0], self.heights[self.first[section + 1] - 1, 1]), axis=-1)

    def layers_of(self, section: int) -> range:
        """Return the layers of a section, bottom to top."""
        return range(int(self.first[section]), int(self.first[section + 1]))
