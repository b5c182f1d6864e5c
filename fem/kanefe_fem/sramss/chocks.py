"""Chocks around the skids: blocks on the deck that stop them. All numbers are assumed."""

from __future__ import annotations

import math

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.contact import HuntCrossley
from kanefe.contact.shapes import Box
from kanefe.errors import ModelError
from kanefe.fe_model.node_shares import NodeShares
from kanefe.scene.scene import FlexibleMember
from kanefe.system import System
from kanefe_fem.sramss.aircraft_loads import deck_of

LENGTH, BREADTH, HEIGHT = 0.30, 0.30, 0.10
"""Size of a chock along the face towards the skid, away from this face, and above the deck, m."""

STIFFNESS, DAMPING = 2e6, 0.3
"""Stiffness k (N/m) and damping lambda (s/m) of one wooden chock in N = k d max(0, 1 + lambda d')."""

SAME = 1e-6
"""Distance below which two positions are the same, m."""

SIDES = {"starboard": -1.0, "port": 1.0}


def add_chocks(
    scene: System,
    *,
    gap: float = 0.005,
    at: tuple[float, float] = (0.0, 0.0),
    stiffness: float = STIFFNESS,
) -> tuple[str, ...]:
    """Add chocks at the ends of the skids: unilateral stops in the plane of the deck.

    Each skid has four: in front of it, behind it, and outboard of its foremost and its aftmost shoe. They are
    frictionless contacts between a point of the shoe and a block fixed to the deck, with forces and events like any
    contact. A shoe that lifts off the deck by more than the height of a block, 0.1 m, passes over it. The chocks do not
    break.

    Parameters
    ----------
    scene : System
        Scene of `spatial_scene`, with the gear as its body "gear"; the deck is a body "deck" or the ground.
    gap : float
        Gap between each chock and the undeformed skid, m; zero if they touch.
    at : (float, float)
        x and y on the deck of the aircraft, as for the scene, m.
    stiffness : float
        Stiffness of one chock, N/m.

    Returns
    -------
    tuple of str
        Names of the contacts: "port chock forward", "port chock aft", "port chock outboard forward", ...

    Raises
    ------
    ModelError
        If the gap or the stiffness is out of range, or the gear has no shoes.

    Examples
    --------
    >>> scene = spatial_scene(gear, motion, mu=0.1)            # doctest: +SKIP
    >>> names = add_chocks(scene)                              # doctest: +SKIP
    >>> scene.simulate((0.0, 60.0)).contact(names[0]).normal   # doctest: +SKIP
    """
    if not (math.isfinite(gap) and gap >= 0.0):
        raise ModelError(f"gap of chocks must be zero m or above, not {gap!r}")
    if not (math.isfinite(stiffness) and stiffness > 0.0):
        raise ModelError(f"stiffness of chocks must be above zero N/m, not {stiffness!r}")
    member, deck, names = scene.body("gear"), deck_of(scene), []
    if not isinstance(member, FlexibleMember):
        raise ModelError("chocks stop a flexible gear, and the body 'gear' is rigid. Remedy: spatial_scene")
    normal = HuntCrossley(stiffness, DAMPING)
    for side, sign in SIDES.items():
        aft, forward = _ends(member.body, side)
        for where, shoe, way in (
            ("aft", aft, (-1.0, 0.0)),
            ("forward", forward, (1.0, 0.0)),
            ("outboard aft", aft, (0.0, sign)),
            ("outboard forward", forward, (0.0, sign)),
        ):
            node = _outermost(member.body, shoe, np.array(way))
            centre = np.array(at) + member.body.nodes[node, :2] + (gap + 0.5 * BREADTH) * np.array(way)
            size = (BREADTH, LENGTH) if way[0] else (LENGTH, BREADTH)
            name = f"{side} chock {where}"
            # it extends below the deck by its height, so that the face is closest to a shoe on the deck
            block = scene.add_surface(name, deck, Box((*size, 2.0 * HEIGHT)), at=(*centre, 0.0))
            scene.add_contact(name, member.node(node), block, normal=normal)
            names.append(name)
    return tuple(names)


def _ends(gear: FlexibleBody, side: str) -> tuple[NodeShares, NodeShares]:
    """Return the aftmost and the foremost shoe of a skid."""
    shoes = [group for group in gear.groups if group.name.startswith(f"{side} shoe")]
    if not shoes:
        raise ModelError(
            f"the gear has no group {f'{side} shoe 1'!r} for chocks. Remedy: the mesh meshes/skid_gear.py or "
            "meshes/skid_gear_solid.py"
        )
    shoes.sort(key=lambda shoe: float(gear.nodes[shoe.nodes, 0].mean()))
    return shoes[0], shoes[-1]


def _outermost(gear: FlexibleBody, shoe: NodeShares, way: np.ndarray) -> int:
    """Return the node of a shoe that is furthest in a direction along the deck, the middle one of several."""
    places = gear.nodes[shoe.nodes, :2]
    along = places @ way
    first = np.flatnonzero(along > along.max() - SAME)
    off = np.linalg.norm(places[first] - places[first].mean(axis=0), axis=1)
    return int(shoe.nodes[first[np.argmin(off)]])
