"""The largest rotations within flexible bodies, and whether they are in the valid range of their kinematics.

Linear: points move along straight lines, so that a part rotated by theta is too long by theta^2 / 2, and forces have
the lever arms of the straight body. Stiffened: displacements are correct to the second order and their inertia to the
first; beyond some rotation, smaller with more modes, a motion loses its inertia.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.bodies.inner_rotations import InnerRotations, inner_rotations
from kanefe.frames import Matrix, Vector
from kanefe.storage.scipy_later import scipy
from kanefe.tree.body_terms import is_unreduced
from kanefe.tree.model_data import ModelData

FARTHEST = 0.2
"""Rotation at which a part of a body is 2 % too long, and a cantilever under a tip force 1.4 % too soft, rad."""

LEAST = 0.1
"""Smallest inertia along a motion relative to that at rest: below it the equations are invalid."""

MOST_LOST = 0.02
"""Part of the inertia of a body that turns and bends on in its shape from which its own error is told, as much as a
part is too long at `FARTHEST`."""


class Bent(NamedTuple):
    """A deformed state of a body: its name, the time in s, and its free coordinates (k,)."""

    body: str
    time: float
    eta: Vector


class Bending(NamedTuple):
    """The largest rotation within a body, relative to its mesh frame.

    Attributes
    ----------
    body : str
    rotation : float
        rad; with `of_displacements`, the largest displacement over the length of the body.
    reach : float
        Largest rotation or displacement in the valid range of its kinematics.
    place : str
        Place in the body.
    time : float
        s.
    displacement : float
        Largest displacement in the body at that time, m.
    of_displacements : bool
        Whether displacements are used because rotations in the body are not known.
    """

    body: str
    rotation: float
    reach: float
    place: str
    time: float
    displacement: float
    of_displacements: bool

    @property
    def is_too_far(self) -> bool:
        """Whether the body is bent beyond its reach."""
        return self.rotation > self.reach

    def __str__(self) -> str:
        size = f"{self.rotation:.3g} of its length" if self.of_displacements else f"{self.rotation:.3g} rad"
        return f"{self.body!r} by {size} at {self.place}, t = {self.time:.6g} s, and {self.displacement:.3g} m at most"

    @property
    def remark(self) -> str:
        """Message for a body that is bent too far, with a remedy."""
        unit = "of its length" if self.of_displacements else "rad"
        return (
            f"a flexible body is bent beyond its valid range, {self}; its kinematics hold to about {self.reach:.2g} "
            f"{unit}. Remedy: check what drives it; if it really is this soft, kanefe_fem.segmented, which cuts it "
            "into a chain of bodies that bend less"
        )


def bendings(model: ModelData, times: Vector, coordinates: Matrix, between: Sequence[Bent] = ()) -> list[Bending]:
    """Return the largest rotation within each flexible body that is deformed.

    Parameters
    ----------
    model : ModelData
    times : ndarray, shape (T,)
    coordinates : ndarray, shape (T, coordinates)
        States q.
    between : sequence of Bent
        Deformed states of bodies at other times.
    """
    found = []
    for body in model.bodies:
        inner = inner_rotations(body.flexible.body) if body.flexible is not None else None
        if body.flexible is None or inner is None:
            continue
        etas, flexible = coordinates[:, body.flexible.eta], body.flexible.body
        row = inner.worst_row(etas)
        stored = Bent(body.name, float(times[row]), etas[row])
        seen = [one for one in between if one.body == body.name]
        most = max(stored, *seen, key=lambda one: inner.size(one.eta)) if seen else stored
        place, turned = inner.largest(most.eta)
        rotation = float(np.linalg.norm(turned))
        if rotation > 0.0 and np.isfinite(rotation):
            moved = float(np.linalg.norm(flexible.node_displacements(most.eta), axis=1).max())
            reach = _reach(flexible, most.eta, turned, inner)
            found.append(Bending(body.name, rotation, reach, place, most.time, moved, inner.of_displacements))
    return found


def worst_bending(model: ModelData, times: Vector, coordinates: Matrix, between: Sequence[Bent] = ()) -> Bending | None:
    """Return the bending that is largest relative to its reach: see `bendings`."""
    return max(bendings(model, times, coordinates, between), key=lambda one: one.rotation / one.reach, default=None)


def _reach(body: FlexibleBody, eta: Vector, turned: Vector, inner: InnerRotations) -> float:
    """Return the largest rotation for which the kinematics of a body are valid, bent in this shape.

    Stiffened: on a hinge at the origin of G it turns about the axis of the rotation, and bends on in this shape, with
    all but `MOST_LOST` of its inertia. Other motions, of high modes, may lose more: see `kanefe.tree.bent`.

    The inertia of curved and pretwisted bodies also changes with the sign of the bending, in proportion to it. This is
    no error, since inertia is kept to first order: it is left out by the mean of both signs, and what is lost then is
    the missing square.
    """
    if is_unreduced(body) or body.moments.quadratic_first is None or inner.of_displacements:
        return FARTHEST
    rotation = float(np.linalg.norm(turned))
    moments, none = body.moments.leading(body.free_count), np.zeros(body.free_count)
    hinged = np.zeros((6 + body.free_count, 2))
    hinged[3:6, 0] = turned / rotation
    hinged[6:, 1] = eta / np.linalg.norm(eta)
    bent, other, straight = (hinged.T @ moments.terms(x, none, np.zeros(3))[0] @ hinged for x in (eta, -eta, none))
    try:
        lost = 1.0 - float(scipy.linalg.eigvalsh(0.5 * (bent + other), straight)[0])
    except np.linalg.LinAlgError:  # no inertia about this axis
        return FARTHEST
    # the loss of inertia grows with the square of the rotation
    return min(FARTHEST, rotation * float(np.sqrt(MOST_LOST / max(lost, 1e-300))))
