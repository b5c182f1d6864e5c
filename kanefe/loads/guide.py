"""Guides: a trolley, wheel or pin that slides along a line of a body that may bend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Matrix, Vector, shaped_numbers
from kanefe.joints.quintic import quintic_spline
from kanefe.kernels.force_elements.guide import GuideNumbers, foot_of, guide, guide_tell, guide_watch, place_in, weight
from kanefe.kernels.force_elements.nearest_on_line import Line
from kanefe.kernels.links.polynomials import POWERS
from kanefe.kernels.values.filled import filled, filled_from
from kanefe.loads.action import NO_STATES, End, LoadKernel, Tangent
from kanefe.loads.base import Load, LoadEvent
from kanefe.loads.by_kernel import EventByKernel, numbers_of, written_by
from kanefe.loads.checks import check_number

NEAREST = 0.5
"""Largest distance of a runner from its line at the start, relative to the shortest gap between points of the line:
beyond, the guide is probably between the wrong frames."""


@checked("name")
@dataclass(frozen=True, eq=False)
class Guide(Load):
    """A runner, such as a trolley, a wheel or a pin, that is guided along a line and slides on it.

    The line is the spline of the fifth degree through frames, in their order, as they move: nodes or interfaces of a
    flexible body, of all segments of a segmented body or of an exact beam, frames beside them, such as on a rail, or
    frames of several bodies. The runner is held across the line by a stiffness k and a damping c, those of wheels and
    flanges, and is free along it: with the nearest point r of the line, where it has the tangent e, and the velocity v
    relative to the points of the line there,

        F = -k (p - r) - c (v - e e . v) - drag e e . v

    acts on the runner, and its opposite on the frames of the line, in the shares with which r depends on them, so that
    the force goes from frame to frame without jumps, and does the work that the line's bending takes (Eq. 11). Only
    places are used: the runner may turn as its joint allows.

    A run in which the runner comes to an end of the line fails there with a message. Elastic forces have no net moment;
    damping and drag act on both sides at a distance of ``|p - r|``.

    Parameters
    ----------
    name : str
        Unique among the loads between frames of a scene.
    ends : tuple of Frame
        The runner, then two or more frames of the line, in their order along it.
    stiffness : float
        k, N/m. The runner leaves the line by the force over k, so that large values make the guide nearly rigid, and
        the equations stiff: with a runner of mass m, a frequency of ``sqrt(k / m)``.
    damping : float
        c, across the line, N s/m.
    drag : float
        Along the line, N s/m, such as rolling resistance.
    stations : array_like, shape (frames of the line,), optional
        Arc lengths of the frames of the line, rising from zero, m; default: distances between them at the start, one
        after the other.

    Raises
    ------
    ModelError
        If an argument is not valid, or the runner starts off the line; the message names it.

    Examples
    --------
    A bead on a straight wire between two posts; it begins beside it, by its weight over the stiffness:

    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> start = kf.Translation(position=(0.1, 0.0, -9.81e-6), velocity=(1.0, 0.0, 0.0))
    >>> bead = scene.add_point("bead", 0.1, joint=start)
    >>> posts = [scene.ground.frame(at=(x, 0.0, 0.0)) for x in (0.0, 1.0)]
    >>> scene.add(kf.Guide("wire", (bead, *posts), stiffness=1e5))
    >>> result = scene.simulate((0.0, 0.5))
    >>> float(result.load("wire", "arc length")[-1].round(6))
    0.6
    """

    name: str
    ends: tuple[Any, ...]
    stiffness: float
    damping: float = 0.0
    drag: float = 0.0
    stations: Any = None

    kind = "guide"
    columns = ("arc length [m]", "distance [m]", "rate [m/s]", "force [N]")
    needs_rotation = False

    def __post_init__(self) -> None:
        label = f"guide {self.name!r}"
        if not isinstance(self.ends, (tuple, list)) or len(self.ends) < 3:
            raise ModelError(f"{label} needs three ends or more: the runner, and the frames of its line in order")
        object.__setattr__(self, "ends", tuple(self.ends))
        for what in ("stiffness", "damping", "drag"):
            check_number(getattr(self, what), f"{what} of {label}", may_be_zero=what != "stiffness")
        if self.stations is not None:
            found = shaped_numbers(self.stations, (len(self.ends) - 1,), f"stations of {label}, one for each frame,")
            if found[0] != 0.0 or np.any(np.diff(found) <= 0.0):
                raise ModelError(f"stations of {label} must rise from zero, m; they are {found.tolist()}")
            object.__setattr__(self, "stations", found)

    @property
    def exchanges_energy(self) -> bool:
        """Whether it dissipates energy."""
        return bool(self.damping or self.drag)

    @property
    def length(self) -> float:
        """Length of the line, m; known at the start of a scene."""
        return float(self._stations[-1])

    @property
    def _stations(self) -> Vector:
        return np.arange(len(self.ends) - 1.0) if self.stations is None else np.asarray(self.stations)

    @property
    def events(self) -> tuple[LoadEvent, ...]:
        """That the runner comes to the start or the end of the line, which ends the run."""
        start, end = (EventByKernel(self, guide_watch, i) for i in (0, 1))
        return (
            LoadEvent("leaves its start", start, -1, self._left_start),
            LoadEvent("leaves its end", end, -1, self._left_end),
        )

    def _left_start(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        raise SimulationError(self._left(t, "start, at an arc length of 0 m,"))

    def _left_end(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        raise SimulationError(self._left(t, f"end, at an arc length of {self.length:.6g} m,"))

    def _left(self, t: float, where: str) -> str:
        return (
            f"guide {self.name!r} ends under its runner: it comes to the {where} at t = {t:.6g} s. Remedy: a longer "
            "line, a stop before its end, or a shorter run"
        )

    def started(self, t: float, ends: Sequence[End]) -> Guide:
        """Return the guide with the arc lengths of its line, if the runner is on it."""
        places = np.array([end.p for end in ends])
        gaps = np.linalg.norm(np.diff(places[1:], axis=0), axis=1)
        if not gaps.all():
            i = int(np.argmin(gaps))
            raise ModelError(
                f"frames {i} and {i + 1} of the line of guide {self.name!r} coincide. Remedy: leave out one of them"
            )
        load = self if self.stations is not None else replace(self, stations=np.append(0.0, np.cumsum(gaps)))
        s, distance, _, _ = load.tell(t, ends, NO_STATES)
        if min(event.function(t, ends, NO_STATES) for event in load.events) < 0.0:
            raise ModelError(
                f"the runner of guide {self.name!r} starts at an arc length of {s:.6g} m, but its line goes from 0 to "
                f"{load.length:.6g} m. Remedy: a start on it"
            )
        if not distance <= NEAREST * gaps.min():
            raise ModelError(
                f"the runner of guide {self.name!r} starts {distance:.6g} m off its line, whose frames are "
                f"{gaps.min():.6g} m apart. Remedy: a start on the line, or frames where the runner is guided"
            )
        return load

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent:
        """Return stiffness across the line, damping and drag, without what turning of the line does under load."""
        line, count = GuideNumbers(self.kernel.numbers).line, len(ends)
        s, _, slope, _ = foot_of(line, numbers_of(ends))
        place = place_in(line, s)
        shares = np.array([1.0, *(-weight(line, i, place)[0] for i in range(count - 1))])
        directions = np.linalg.svd(np.array([(*slope,)]))[2]  # along the line, and two across
        rows = np.zeros((3, count, 6))
        rows[:, :, :3] = shares[:, None] * directions[:, None]
        return Tangent(
            rows.reshape(3, -1),
            self.stiffness * np.array((0.0, 1.0, 1.0)),
            np.array((self.drag, self.damping, self.damping)),
        )

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return arc length of the runner and distance from the line (m), rate (m/s), and the force across (N)."""
        return np.array(written_by(guide_tell, t, self.kernel.numbers, NO_STATES, numbers_of(ends), states, 4))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        starts, weights = _weights(self._stations)
        table = np.concatenate((self._stations, starts, weights.ravel()))
        line = filled(Line, points=len(self._stations), pieces=len(starts) - 1, table=table)
        given = filled_from(self, GuideNumbers, line=line)
        return LoadKernel(guide, given, guide, guide_watch, tell=guide_tell)


def _weights(stations: Vector) -> tuple[Vector, Matrix]:
    """Return where the pieces of the line start and the last ends, and of each its weights, (pieces, 6, points).

    They are of the powers 0 to 5 of the arc length from its start; powers that a line of few points lacks are zero.
    """
    spline = quintic_spline(stations, np.eye(len(stations)), closed=False)
    powers = spline.c[::-1].transpose(1, 0, 2)
    weights = np.zeros((len(powers), POWERS, len(stations)))
    weights[:, : powers.shape[1]] = powers
    return spline.x, weights
