"""Anchors of a contact's friction: against sliding, spinning and rolling of each closed point."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from kanefe.contact.contact_data import ContactData
from kanefe.contact.contact_evaluation import InPython
from kanefe.contact.touching_point import along_surface
from kanefe.frames import Matrix, Vector, across, cross
from kanefe.loads.action import End
from kanefe.loads.anchors import Anchor


class _Placed(NamedTuple):
    """An anchor, and where its stretch is: `axes` (r, 3) in N lead from its directions to the state from `at` on."""

    anchor: Anchor
    at: int
    axes: Matrix
    marked: int | None = None


def anchors_of(contact: ContactData, ends: Sequence[End], states: Vector) -> list[Anchor]:
    """Return the anchors of the closed points: see `kanefe.loads.base.Load.anchors`."""
    return [placed.anchor for placed in _placed(contact, ends, states)]


def anchored(
    contact: ContactData, ends: Sequence[End], states: Vector, tangentials: Sequence[Vector], slips: Sequence[bool]
) -> Vector:
    """Return the internal states with which they give some friction: see `kanefe.loads.base.Load.anchored`."""
    after = states.copy()
    for (anchor, at, axes, marked), tangential, is_slipping in zip(
        _placed(contact, ends, states), tangentials, slips, strict=True
    ):
        stretch = anchor.stretch(tangential)
        if len(tangential) == 1:
            after[at] = stretch[0]
        else:
            after[at : at + 3] = ends[0].A.T @ (stretch @ axes)
        if marked is not None:
            after[marked] = float(not is_slipping)
    return after


def _placed(contact: ContactData, ends: Sequence[End], states: Vector) -> Iterator[_Placed]:
    law = contact.friction
    if law is None or not law.holds or contact.rest is not None:
        return
    for i, touch in enumerate(InPython(contact, ends, states).touches()):
        if touch.depth <= 0.0:
            continue
        n, probe, w = touch.normal, contact.probes[i][1], ends[touch.end].w - ends[0].w
        axes, shares = np.array(across(n)), np.ones(2)
        holds, slides = law.holding, law.coefficient(float(np.linalg.norm(touch.along)))
        if law.axis is not None:  # two coefficients are measured by each of them
            first = along_surface(ends[0].A @ law.axis, n)
            axes[0] = first / np.linalg.norm(first)
            axes[1], shares = cross(n, axes[0]), np.array(law.coefficients)
            holds = slides = 1.0
        k, c = law.anchor(touch.share, touch.normal_force)
        at, turning = contact.begins + contact.each * i, contact.turning(i).start
        rows = _slides(axes, touch.point, touch.end, ends)
        slip = axes @ touch.along
        yield _Placed(
            Anchor(rows, slip, shares, holds * touch.normal_force, slides * touch.normal_force, k, c),
            at,
            axes,
            at + 3 if law.has_memory else None,
        )
        for arm, most, along in (
            (law.torsional, law.sliding * law.torsional, n[None]),
            (probe.lever if law.rolling > 0.0 else 0.0, law.rolling, axes),
        ):
            if arm > 0.0:
                rows, held = _turns(along, touch.end, len(ends)), most * touch.normal_force
                anchor = Anchor(rows, along @ w, np.ones(len(along)), held, held, k * arm**2, c * arm**2)
                yield _Placed(anchor, turning, along)
                turning += 1


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
