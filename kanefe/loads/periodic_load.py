"""Periodic loads of a rotor: thrust and torque of its hub, and their harmonics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers, shaped_numbers
from kanefe.kernels.force_elements.periodic_load import PeriodicLoadNumbers, own_at, periodic_load
from kanefe.kernels.values.filled import filled_from
from kanefe.loads.action import End, LoadKernel
from kanefe.loads.base import Load
from kanefe.loads.screened import ScreenedLoad

ALWAYS = np.array((0.0, 1.0)), np.array((1.0, 1.0))
"""A table with the value one at all times."""


def checked_history(given: object, what: str) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values of a table over time; a ModelError names `what` if it is not a table."""
    is_list = isinstance(given, (tuple, list)) or (isinstance(given, np.ndarray) and given.ndim > 0)
    pair: Any = given if is_list and len(given) == 2 else ((), ())  # type: ignore[arg-type]
    times, values = numbers(pair[0]), numbers(pair[1])
    is_table = times.ndim == 1 and times.shape == values.shape and len(times) >= 2
    if not is_table or not np.all(np.isfinite((times, values))) or np.any(np.diff(times) <= 0.0):
        raise ModelError(f"{what} must be a table (times, values), two or more of each, times rising; not {given!r}")
    return times, values


@checked("name")
@dataclass(frozen=True, eq=False)
class PeriodicLoad(Load):
    """Force and moment on a frame, along its axes, with the period of a rotor: the loads of its hub.

        (F, M) = share(t) (mean + sum over n of (c_n cos(n psi) + s_n sin(n psi))),  psi = azimuth + rate t

    A rotor of b equal blades has harmonics of b, 2b, ... per turn; differences between blades excite 1 per turn.

    Parameters
    ----------
    name : str
        Unique among the loads between frames of a scene.
    on : Frame
        The hub; its axes rotate with the body.
    rate : float
        Speed of the rotor, rad/s.
    mean : array_like, shape (6,)
        Force (N) and moment (N m) along the frame's axes.
    harmonics : mapping of int to ((6,), (6,))
        By the number n per turn: cosine and sine parts, N and N m.
    azimuth : float
        Azimuth at t = 0, rad.
    share : (times, values), optional
        Factor of the load over time, linear between times (s) and constant before and after, such as the decrease of
        lift after touch-down. None: 1.

    Raises
    ------
    ModelError
        If an argument is not valid; the message names it.

    Examples
    --------
    Four blades with a lift of half of the weight of a block on a spring:

    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> spring = kf.CoordinateForce(stiffness=1e6, damping=1e3)
    >>> block = scene.add_point("block", 100.0, joint=kf.Prismatic("z", forces=spring))
    >>> lift = (0, 0, 50 * 9.81, 0, 0, 0)
    >>> shakes = {4: ((0, 0, 40.0, 0, 0, 0), (0, 0, 0, 0, 0, 0))}
    >>> scene.add(kf.PeriodicLoad("rotor", block, 30.0, lift, shakes))
    >>> result = scene.simulate((0.0, 0.2))
    >>> float(result.load("rotor")[0, 2].round(1))  # N: the mean and the first peak
    530.5
    """

    name: str
    on: Any
    rate: float
    mean: Any
    harmonics: Mapping[int, tuple[Any, Any]] = field(default_factory=dict)
    azimuth: float = field(default=0.0, kw_only=True)
    share: Any = field(default=None, kw_only=True)
    ends: tuple[Any, ...] = field(init=False)
    rows: np.ndarray = field(init=False, repr=False)

    kind = "periodic load"
    columns = (
        "force along x [N]",
        "force along y [N]",
        "force along z [N]",
        "moment about x [N m]",
        "moment about y [N m]",
        "moment about z [N m]",
    )

    def __post_init__(self) -> None:
        label = f"periodic load {self.name!r}"
        for what in ("rate", "azimuth"):
            shaped_numbers(getattr(self, what), (), f"{what} of {label}")
        object.__setattr__(self, "mean", shaped_numbers(self.mean, (6,), f"mean of {label}"))
        if not isinstance(self.harmonics, Mapping):
            raise ModelError(f"harmonics of {label} must be a mapping from n per turn, not {self.harmonics!r}")
        rows = np.zeros((len(self.harmonics), 13))
        for row, (n, parts) in zip(rows, self.harmonics.items(), strict=True):
            if not isinstance(n, (int, np.integer)) or isinstance(n, bool) or n < 1:
                raise ModelError(f"harmonics of {label} must be by whole numbers per turn, 1 or above, not {n!r}")
            row[0], row[1:] = n, shaped_numbers(parts, (2, 6), f"harmonic {n} of {label}").ravel()
        object.__setattr__(self, "rows", rows)
        if self.share is not None:
            object.__setattr__(self, "share", checked_history(self.share, f"share of {label}"))
        object.__setattr__(self, "ends", (self.on,))

    @property
    def screened(self) -> ScreenedLoad:  # type: ignore[override]
        """The frequency of the highest harmonic that is not zero."""
        highest = float(self.rows[self.rows[:, 1:].any(axis=1), 0].max(initial=0.0))
        return ScreenedLoad(forcing=highest * abs(self.rate))

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> None:
        """Return None: it depends only on the axes of its frame."""

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return force and moment along the frame's axes."""
        force, moment = own_at(t, PeriodicLoadNumbers(self.kernel.numbers))
        return np.array((*force, *moment))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        times, shares = self.share or ALWAYS
        rest = np.concatenate((self.rows.ravel(), times, shares))
        counts = {"harmonic_count": len(self.rows), "table_size": len(times)}
        given = filled_from(self, PeriodicLoadNumbers, harmonics=rest, **counts)
        return LoadKernel(periodic_load, given, periodic_load)
