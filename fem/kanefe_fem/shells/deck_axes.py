"""Axes of the materials of shells in decks.

Nastran: the side G1-G2 of an element turned by THETA about its normal, or the first axis of a coordinate system (MCID)
along the surface. Abaqus: x along the surface, or the first axis of an ORIENTATION whose third is across, turned by its
angle about the normal.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.imports.abaqus_input import Keyword
from kanefe.imports.abaqus_sets import key_of
from kanefe.imports.card import Card
from kanefe.imports.coordinate_systems import right_handed
from kanefe.imports.grid_points import GridPoints, coordinate_system
from kanefe.imports.node_table import rows_of
from kanefe_fem.materials.laminate import Laminate, Ply
from kanefe_fem.materials.oriented import Oriented, SolidMaterial

PARALLEL = 1e-3
"""Sine of the angle between the first axes of elements and one direction, up to which they follow it."""


def axes_of_elements(
    elements: Sequence[Card], places: Sequence[int], grids: GridPoints, cards: Sequence[Card]
) -> np.ndarray:
    """Return the axes (3, 3) whose part in the surface is the first axis of all elements of a property of Nastran.

    Parameters
    ----------
    elements : sequence of Card
    places : sequence of int
        Their fields of THETA or MCID: a whole number is MCID.
    grids : GridPoints
    cards : sequence of Card
        All of the deck.

    Raises
    ------
    FileError
        If the axes of elements are not along one direction, or by a system that is not rectangular.
    """
    systems = [_mcid(card, place) for card, place in zip(elements, places, strict=True)]
    if systems[0] is not None and all(one == systems[0] for one in systems):
        system = coordinate_system(cards, systems[0], elements[0])
        if system.kind != "R":
            raise elements[0].refused(
                f"has axes by the coordinate system {systems[0]}, which is not rectangular. Remedy: materials= with "
                "Oriented(..., cylindrical_axes(...))"
            )
        return system.axes
    for card, number in zip(elements, systems, strict=True):
        if number is not None:
            raise card.refused(
                f"has axes by MCID {number}, and other elements of its property have not. Remedy: a property for each"
            )
    return _by_sides(elements, places, grids)


def _mcid(card: Card, place: int) -> int | None:
    """Return the number of the coordinate system of an element, None if it has an angle."""
    return card.whole(place) if card.field(place).lstrip("+-").isdigit() else None


def _by_sides(elements: Sequence[Card], places: Sequence[int], grids: GridPoints) -> np.ndarray:
    corners = np.array([[card.whole(4 + i) for i in range(3)] for card in elements])
    x = grids.points[rows_of(corners, grids.labels)]
    sides = np.stack((x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
    normals = np.cross(sides[:, 0], sides[:, 1])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    first = sides[:, 0] / np.linalg.norm(sides[:, 0], axis=1)[:, None]
    angle = np.radians([card.number(place) for card, place in zip(elements, places, strict=True)])[:, None]
    first = np.cos(angle) * first + np.sin(angle) * np.cross(normals, first)
    mean = first.mean(axis=0)
    mean /= np.linalg.norm(mean) or 1.0
    off = np.abs(np.cross(normals, first) @ mean)
    if off.max() > PARALLEL:
        raise elements[int(off.argmax())].refused(
            "has an axis of its material that is not along those of the other elements of its property. Remedy: "
            "MCID, materials= with Oriented(...), or THETA by which they are"
        )
    third = normals[0] - (normals[0] @ mean) * mean
    third /= np.linalg.norm(third)
    return np.column_stack((mean, np.cross(third, mean), third))


def oriented_by(
    section: Keyword, blocks: Sequence[Keyword], material: SolidMaterial, thickness: float
) -> SolidMaterial:
    """Return the material of a section of Abaqus in the axes of its ORIENTATION.

    Raises
    ------
    FileError
        If it is not there, or of a kind that is not read; the message has its line.
    """
    name = section.option("ORIENTATION")
    found = [one for one in blocks if one.name == "ORIENTATION" and key_of(one.option("NAME")) == key_of(name)]
    if not found:
        raise section.refused(f"has the ORIENTATION {name!r}, which is not there. Remedy: write the whole deck")
    block, remedy = found[-1], "Remedy: materials= with Oriented(...)"
    kinds = (block.options.get(one, "").strip().upper() for one in ("SYSTEM", "DEFINITION"))
    if not all(
        kind in usual for kind, usual in zip(kinds, (("", "R", "RECTANGULAR"), ("", "COORDINATES")), strict=True)
    ):
        raise block.refused(f"is not of a rectangular system by coordinates, and not read. {remedy}")
    rows = [[block.number(text, at) for text in fields] for at, fields in block.rows()]
    if not rows or len(rows[0]) not in (6, 9):
        raise block.refused("has no two points of its axes, or three. Remedy: check that its lines are complete")
    points = np.reshape(rows[0], (-1, 3))
    origin = points[2] if len(points) == 3 else np.zeros(3)
    axes = right_handed(points[0] - origin, points[1] - origin)
    if axes is None:
        raise block.refused("has its points on one line. Remedy: a point beside its first axis")
    across, angle = (*rows[1], 0.0, 0.0)[:2] if len(rows) > 1 else (1.0, 0.0)
    if across != 3.0:
        raise block.refused(
            f"has its axis {across:g} across the shell, by which Abaqus and CalculiX take different axes. Remedy: a "
            'second line "3, 0." with the third axis across; or materials= with Oriented(...)'
        )
    if angle:
        plies = material.plies if isinstance(material, Laminate) else (Ply(material, thickness),)
        material = Laminate([Ply(ply.material, ply.thickness, ply.angle + np.radians(angle)) for ply in plies])
    return Oriented(material, axes)
