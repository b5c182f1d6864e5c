"""The masses on both sides of contacts, for the damping of the anchors of their friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Vector
from kanefe.loads.anchors import default_damping
from kanefe.loads.base import Load
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.contact.contact import Contact


def with_contact_masses(model: ModelData, loads: Sequence[Load]) -> tuple[Load, ...]:
    """Return loads with the masses at contacts, and with damping of their anchors if none is given."""
    if not loads:
        return ()
    from kanefe.contact.contact import compliant_contacts

    completed = list(loads)
    if contacts := list(compliant_contacts(loads)):
        trees, masses = _trees(model)
        for i, contact in contacts:
            completed[i] = _completed(contact, trees, masses)
    return tuple(completed)


def _completed(contact: Contact, trees: Sequence[int], masses: Vector) -> Contact:
    surface, *touching = ({trees[end.body]} if end.body >= 0 else {-1} for end in contact.ends)
    sides = surface, set().union(*touching)
    inverse = sum(1.0 / mass for side in sides if (mass := sum(masses[tree] for tree in side)) > 0.0)
    mass = 1.0 / inverse if inverse > 0.0 else 1.0
    friction = contact.friction
    if friction is not None and friction.lacks_damping:
        friction = friction.with_damping(default_damping(friction.spring, mass))
    return replace(contact, mass=mass, friction=friction)


def _trees(model: ModelData) -> tuple[list[int], Vector]:
    """Return for each body the number of the tree that moves with it, and the masses of these trees, kg.

    The last tree, of driven bodies and the ground, has an infinite mass.
    """
    trees: list[int] = []
    masses: list[float] = []
    for body in model.bodies:
        parent = trees[body.parent] if body.parent >= 0 else -1
        is_free = body.flexible is not None or bool(np.any(body.speeds < model.free_count))
        if parent < 0 and is_free:
            parent = len(masses)
            masses.append(0.0)
        trees.append(parent)
        if parent >= 0:
            masses[parent] += float(body.rigid.mass) if body.rigid is not None else 0.0
            masses[parent] += float(body.flexible.body.mass) if body.flexible is not None else 0.0
    return trees, np.array([*masses, inf])
