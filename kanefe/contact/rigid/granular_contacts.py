"""Rigid contacts of many bodies among each other: balls and walls, which only time stepping takes at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeGuard

import numpy as np

from kanefe.contact.rigid.rigid import DISTRIBUTING, POISSON, Rigid
from kanefe.contact.rigid.rigid_contact import check_rigid
from kanefe.contact.shapes import Plane, Points, Sphere
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.loads.action import Action, End
from kanefe.loads.base import Load

if TYPE_CHECKING:
    from kanefe.contact.geometry.shape import SurfaceShape
    from kanefe.contact.surface import Surface
    from kanefe.kernels.contact.laws.friction_law import FrictionLaw

FEW = 12
"""Number of pairs of surfaces up to which each has its own contact, whose touches and slips are events."""


class Ball(NamedTuple):
    """A ball or point fixed in an end: centre from the end in its axes and radius, m."""

    end: int
    centre: Vector
    radius: float


@dataclass(frozen=True, eq=False)
class GranularContacts(Load):
    """Rigid contacts of balls among each other and with walls; what they do, steps of Moreau and Jean find.

    Its internal states tell of the last step: how many pairs touch, and over all steps the deepest of them, and what
    the impulses leave of their conditions.

    Attributes
    ----------
    name : str
    ends : tuple of Frame
        Of the surfaces.
    balls : tuple of Ball
    walls : tuple of (int, SurfaceShape)
        Each with the number of its end, which is fixed in the ground.
    law : Rigid
    friction : float
    left_out : ndarray of int
        Pairs ``ball * (balls + walls) + other`` that pass through each other, ascending.
    """

    name: str
    ends: tuple[Any, ...]
    balls: tuple[Ball, ...]
    walls: tuple[tuple[int, SurfaceShape], ...]
    law: Rigid
    friction: float
    left_out: np.ndarray

    kind = "rigid contacts"
    columns = "touching [1]", "residual [1]", "penetration [m]"

    @property
    def initial_states(self) -> Vector:
        """Nothing touches."""
        return np.zeros(3)

    @property
    def has_rates(self) -> bool:
        """They change from step to step, and not between."""
        return False

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return nothing: see `kanefe.kernels.contact.granular_contacts`."""
        return Action(np.zeros((len(ends), 6)), rates=np.zeros(len(states)))

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return its states."""
        return states


def is_granular(law: object, pairs: int) -> TypeGuard[Rigid]:
    """Return whether so many pairs with a law are one load, over whose impacts time stepping goes."""
    return isinstance(law, Rigid) and pairs > FEW


def granular_contacts_of(
    name: str,
    among: Sequence[Surface],
    law: Rigid,
    friction: FrictionLaw | None,
    ignore: Sequence[tuple[Surface, Surface]],
) -> GranularContacts:
    """Return rigid contacts of each surface with each other one.

    Raises
    ------
    ModelError
        If there are other surfaces than balls and walls, or laws that time stepping does not have.
    """
    if law.impact in (POISSON, DISTRIBUTING) or (
        friction is not None and (friction.has_memory or len(set(friction.coefficients)) > 1)
    ):
        raise ModelError(
            f"{name}: many rigid contacts have the impacts of time stepping and one coefficient of friction. Remedy: "
            "Rigid(restitution) without impact=, Coulomb(mu)"
        )
    if friction is not None:
        check_rigid(Plane("z"), (), friction, np.zeros(3), name)
    ends = tuple(surface.frame for surface in among)
    balls: list[Ball] = []
    walls: list[tuple[int, SurfaceShape]] = []
    numbers: dict[str, list[int]] = {}
    for end, surface in enumerate(among):
        shape, is_fixed = surface.shape, surface.frame.number < 0
        if is_fixed and not isinstance(shape, Points):
            walls.append((end, shape))
        elif isinstance(shape, (Sphere, Points)) and shape.probes() and not is_fixed:
            numbers[surface.name] = []
            for probe in shape.probes():
                numbers[surface.name].append(len(balls))
                balls.append(Ball(end, probe.point, probe.radius))
        else:
            what = f"{shape.title}{' of the ground' if is_fixed else ''}"
            raise ModelError(
                f"{name}: surface {surface.name!r} is a {what}; many rigid contacts take balls and points of bodies, "
                "and all surfaces of the ground but points. Remedy: add_contact for each pair that can meet"
            )
    for number, (end, _) in enumerate(walls):
        numbers[among[end].name] = [len(balls) + number]
    width = len(balls) + len(walls)
    out = set()
    for a, b in ignore:
        for i in numbers.get(a.name, ()):
            for j in numbers.get(b.name, ()):
                out.add(min(i, j) * width + max(i, j))
    mu = 0.0 if friction is None else max(friction.coefficients)
    return GranularContacts(name, ends, tuple(balls), tuple(walls), law, mu, np.array(sorted(out), dtype=np.int64))


def granular_contacts(loads: Sequence[Load]) -> GranularContacts | None:
    """Return the first granular contacts among loads; None: there are none."""
    return next((load for load in loads if isinstance(load, GranularContacts)), None)
