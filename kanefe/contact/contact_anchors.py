"""Anchors of a contact's friction: against sliding, spinning and rolling of each probe that touches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from kanefe.contact.contact_events import Touching
from kanefe.contact.laws.friction_laws import Coulomb
from kanefe.contact.touching_point import along_surface
from kanefe.frames import Matrix, Vector, cross
from kanefe.loads.anchors import Anchor
from kanefe.loads.base import End

if TYPE_CHECKING:
    from kanefe.contact.geometry.shape import Probe
    from kanefe.contact.laws.bristles import LuGre
    from kanefe.contact.rest import Rest


class Anchored(Touching, Protocol):
    """What the anchors are asked of: a `kanefe.contact.contact.Contact`."""

    @property
    def rest(self) -> Rest | None:
        """Of a contact that is looked at about a rest."""
        ...

    def anchor(self, law: Coulomb | LuGre, probe: Probe) -> tuple[float, float]:
        """Stiffness and damping of the spring of an anchor."""
        ...

    def turning(self, i: int) -> slice:
        """Where the states are of what holds a probe against turning."""
        ...


class _Placed(NamedTuple):
    """An anchor, and where its stretch is: `axes` (r, 3) in N lead from its directions to the state from `at` on."""

    anchor: Anchor
    at: int
    axes: Matrix
    marked: int | None = None


def anchors_of(contact: Anchored, ends: Sequence[End], states: Vector) -> list[Anchor]:
    """Return the anchors of the probes that touch: see `kanefe.loads.base.Load.anchors`."""
    return [placed.anchor for placed in _placed(contact, ends, states)]


def anchored(
    contact: Anchored, ends: Sequence[End], states: Vector, drags: Sequence[Vector], slips: Sequence[bool]
) -> Vector:
    """Return the internal states with which they give some friction: see `kanefe.loads.base.Load.anchored`."""
    after = states.copy()
    for (anchor, at, axes, marked), drag, is_slipping in zip(_placed(contact, ends, states), drags, slips, strict=True):
        stretch = anchor.stretch(drag)
        if len(drag) == 1:
            after[at] = stretch[0]
        else:
            after[at : at + 3] = ends[0].A.T @ (stretch @ axes)
        if marked is not None:
            after[marked] = float(not is_slipping)
    return after


def _placed(contact: Anchored, ends: Sequence[End], states: Vector) -> Iterator[_Placed]:
    law = contact.friction
    if not isinstance(law, Coulomb) or contact.rest is not None:
        return
    surface = ends[0]
    for i, touch in enumerate(contact.touches(ends, states)):
        if touch.depth <= 0.0:
            continue
        n, probe, end = touch.normal, contact.probes[i][1], ends[touch.end]
        first = along_surface(surface.A @ law.axis, n)
        if np.linalg.norm(first) < 1e-6:  # where there is but one coefficient any direction will do
            first = cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
        first = first / np.linalg.norm(first)
        axes = np.array((first, cross(n, first)))
        along, across = law.coefficients
        # two coefficients are measured by each of them
        shares = np.array((1.0, 1.0) if along == across else (along, across))
        mu = along if along == across else 1.0
        k, c = contact.anchor(law, probe)
        at = contact.begins + contact.each * i
        w = end.w - surface.w
        turns = _turns(axes, touch.end, len(ends))
        slides = _slides(axes, touch.point, touch.end, ends)
        yield _Placed(
            Anchor(
                slides,
                axes @ touch.along,
                shares,
                mu * law.static_ratio * touch.press,
                mu * law.fallen(float(np.linalg.norm(touch.along))) * touch.press,
                k,
                c,
            ),
            at,
            axes,
            at + 3 if law.has_memory else None,
        )
        turning = contact.turning(i).start
        if law.torsional > 0.0:
            arm, most = law.torsional, law.sliding * law.torsional * touch.press
            row = _turns(n[None], touch.end, len(ends))
            anchor = Anchor(row, np.array((w @ n,)), np.ones(1), most, most, k * arm**2, c * arm**2)
            yield _Placed(anchor, turning, n[None])
        if law.rolling > 0.0:
            arm, most = probe.lever, law.rolling * touch.press
            anchor = Anchor(turns, axes @ w, np.ones(2), most, most, k * arm**2, c * arm**2)
            yield _Placed(anchor, turning + (law.torsional > 0.0), axes)


def _slides(axes: Matrix, point: Vector, number: int, ends: Sequence[End]) -> Matrix:
    """Return the rates of slip at a point by the motion of the ends."""
    rows = np.zeros((len(axes), len(ends), 6))
    for i, sign in ((number, 1.0), (0, -1.0)):
        rows[:, i, :3] += sign * axes
        rows[:, i, 3:] += sign * cross(point - ends[i].p, axes)
    return rows.reshape(len(axes), -1)


def _turns(axes: Matrix, number: int, count: int) -> Matrix:
    """Return the rates at which an end turns past the surface about some axes."""
    rows = np.zeros((len(axes), count, 6))
    rows[:, number, 3:] += axes
    rows[:, 0, 3:] -= axes
    return rows.reshape(len(axes), -1)
