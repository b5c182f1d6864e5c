"""Beams along the lines of a shell: where their axes are, and what their sections are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.fe_model.shapes import shape

NODES = np.array([0.0, 1.0, 0.5])
"""Places of the three nodes of a line, relative to its length."""

CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float)
"""Corners of a section as a box, in halves of its sides along y and z."""


@dataclass(frozen=True, eq=False)
class Ribs:
    """The stiffeners of a shell: m lines of three nodes, the cells of its body of the shape "line3", in their order.

    Attributes
    ----------
    arms : ndarray, shape (m, 3, 3)
        From the nodes to the axis, m.
    upright : ndarray, shape (m, 3, 3)
        Direction of local z at the nodes.
    of_line : ndarray of int, shape (m,)
        Number of the stiffener of each line, among r.
    stiffness : ndarray, shape (r, 6, 6)
        Of the sections to stretch, shear along y and z, twist, and bending about y and z, in N and N m2.
    fibres : ndarray, shape (r, p, 3)
        Around the outline of each section: y and z (m) and Young's modulus (Pa); zeros where its shape is not known.
    """

    arms: np.ndarray
    upright: np.ndarray
    of_line: np.ndarray
    stiffness: np.ndarray
    fibres: np.ndarray

    @property
    def has_shape(self) -> np.ndarray:
        """Whether the outline of the section of each stiffener is known, shape (r,)."""
        return np.asarray((self.fibres[:, :, 2] > 0.0).any(axis=1))

    def axes(self, places: np.ndarray) -> np.ndarray:
        """Return the axes of the sections at the nodes, by these (m, 3, 3) in m, as rows: (m, 3, 3, 3)."""
        return np.stack([axes_along(places + self.arms, self.upright, xi)[0] for xi in NODES], axis=1)

    def outlines(self, places: np.ndarray) -> np.ndarray:
        """Return the points of the outlines of the sections relative to the nodes (m, 3, 3), shape (m, 3, p, 3), m."""
        size = float(np.linalg.norm(np.ptp(places.reshape(-1, 3), axis=0)))
        stiffness = np.diagonal(self.stiffness, axis1=1, axis2=2)
        across = outlines(stiffness, self.fibres, size)[self.of_line]
        return self.arms[:, :, None] + np.einsum("mpa,mnai->mnpi", across, self.axes(places)[:, :, 1:])


def axes_along(axis: np.ndarray, upright: np.ndarray, xi: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the axes of sections along lines, the lengths of these, and the sines of the angle to their local z.

    Parameters
    ----------
    axis : ndarray, shape (m, 3, 3)
        Three points of each, m.
    upright : ndarray, shape (m, 3, 3)
        Direction of local z there.
    xi : float
        Place along them, 0 to 1.

    Returns
    -------
    axes : ndarray, shape (m, 3, 3)
        Rows: along the line, local y, local z.
    length : ndarray, shape (m,)
        By unit of xi, m.
    sine : ndarray, shape (m,)
    """
    element, at = shape("line3"), np.array([[xi]])
    along = np.einsum("n,mni->mi", element.gradients(at)[0, :, 0], axis)
    length = np.linalg.norm(along, axis=1)
    e_x = along / length[:, None]
    e_y = np.cross(np.einsum("n,mni->mi", element.values(at)[0], upright), e_x)
    sine = np.linalg.norm(e_y, axis=1)
    e_y /= np.maximum(sine, 1e-300)[:, None]
    return np.stack((e_x, e_y, np.cross(e_x, e_y)), axis=1), length, sine


def equivalent_sides(stretch: np.ndarray, about_y: np.ndarray, about_z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the sides along y and z of rectangles with given axial (N) and bending stiffness (N m2).

    From ``EI_z = EA h_y^2 / 12`` and the same about y.

    Examples
    --------
    >>> [float(side.round(12)) for side in equivalent_sides(np.array(6.0), np.array(4.5), np.array(2.0))]
    [2.0, 3.0]
    """
    return np.sqrt(12.0 * about_z / stretch), np.sqrt(12.0 * about_y / stretch)


def outlines(stiffness: np.ndarray, fibres: np.ndarray | None, size: float, thin: float = 0.01) -> np.ndarray:
    """Return outlines of sections, y and z (c, p, 2) in m: those known, else boxes with the same stiffness.

    Parameters
    ----------
    stiffness : ndarray, shape (c, 6)
        To stretch, shear, twist and bending.
    fibres : ndarray, shape (c, p, 3), or None
    size : float
        Of the body, m, which no side exceeds.
    thin : float
        Side where stiffnesses give none, relative to that.
    """
    with np.errstate(all="ignore"):
        sides = 0.5 * np.column_stack(equivalent_sides(stiffness[:, 0], stiffness[:, 4], stiffness[:, 5]))
    is_known = np.isfinite(sides) & (sides > 0.0) & (sides < size)
    boxes = CORNERS * np.where(is_known, sides, 0.5 * thin * size)[:, None]
    if fibres is None:
        return boxes
    share = (4.0 / fibres.shape[1] * np.arange(fibres.shape[1]))[:, None]
    corner, rest = share.astype(int).ravel(), share - np.floor(share)
    boxes = (1.0 - rest) * boxes[:, corner % 4] + rest * boxes[:, (corner + 1) % 4]
    return np.where(fibres[:, :, 2:] > 0.0, fibres[:, :, :2], boxes)
