"""The modes of a scene at any speed, about the steady state there."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers
from kanefe.instants.instant import Instant
from kanefe.instants.missed_statics import warn_of_missed
from kanefe.linear.azimuth import CONSTANT
from kanefe.linear.equilibrium.equilibria import balanced
from kanefe.linear.imbalance import Imbalance
from kanefe.linear.linearisation import Linearisation, linearised
from kanefe.linear.modes.floquet_modes import FloquetModes, floquet
from kanefe.linear.modes.modes import Modes, modes_of
from kanefe.linear.over_speed.followed_modes import AnyModes
from kanefe.linear.over_speed.whirl import spin_axis
from kanefe.linear.state import model_of
from kanefe.linear.unsettled import warn_of_imbalance

if TYPE_CHECKING:
    from kanefe.linear.state import Freezable

NEAR = 1e-2
"""Stiffness over mass, relative to the square of the speed, below which the bow due to unbalance is left out because
it is unbounded: within 0.5 % of a critical speed in the frame of the shaft."""


class OverSpeed(NamedTuple):
    """A scene over its speed (rad/s).

    Attributes
    ----------
    modes, undamped : callable
        Speed -> modes, Floquet modes if the scene changes with the azimuth; and modes without damping.
    imbalances : dict of float to Imbalance
        The imbalance at speeds at which the scene was linearised about its start.
    """

    modes: Callable[[float], AnyModes]
    undamped: Callable[[float], Modes]
    imbalances: dict[float, Imbalance]

    def warn(self, what: str) -> None:
        """Warn of the largest imbalance, if it is significant."""
        worst = max(self.imbalances, key=lambda speed: self.imbalances[speed].ratio, default=None)
        if worst is not None:
            warn_of_imbalance(self.imbalances[worst], f"{what} at {worst:.6g} rad/s", "balance=True")


def modes_over_speed(build: Callable[[float], Freezable | Model], at: Vector, balance: bool) -> OverSpeed:
    """Return the modes of a scene over its speed; raise a ModelError if nothing rotates."""
    imbalances: dict[float, Imbalance] = {}

    def state(speed: float, steady: bool) -> Linearisation:
        model = model_of(build(speed), f"campbell at {speed:.6g} rad/s")
        if not balance:
            found = linearised(model, None, None, (), ())
            imbalances[speed] = found.imbalance
            return found
        found_at = balanced(model, start=model.initial_state, steady=steady, slack=NEAR * speed**2)
        return found_at.linearise(inputs=(), outputs=())

    @cache
    def of_periodic(speed: float) -> AnyModes:
        lin = state(speed, False)
        if speed == 0.0:
            still = modes_of(lin)
            none = np.zeros(1, dtype=int)
            return FloquetModes(lin.small, np.inf, still.eigenvalues, none, still.vectors[None], still.is_rigid)
        return floquet(lin.model, period=2.0 * np.pi / abs(speed), t=lin.time, start=lin.state)

    def refused(speed: float) -> Modes:
        raise ModelError(
            "undamped modes of a scene that changes with the azimuth are not available. Remedy: build it undamped"
        )

    fastest = float(at[np.abs(at).argmax()])
    lin = state(fastest, False)
    if spin_axis(lin.small) is None:
        raise ModelError(
            f"nothing rotates in the scene of campbell at {fastest:.6g} rad/s. Remedy: a shaft driven by "
            "kanefe.Motion.steady(speed), with the speed that build is given"
        )
    if balance:
        warn_of_missed(Instant(lin.model, lin.time, lin.state), f"campbell at {fastest:.6g} rad/s")
    if lin.change > CONSTANT:
        return OverSpeed(of_periodic, refused, imbalances)
    # steadiness is checked once, at the fastest speed
    steady = cache(lambda speed: state(speed, speed == fastest))
    of = cache(lambda speed: modes_of(steady(speed)))
    return OverSpeed(of, cache(lambda speed: modes_of(steady(speed).undamped())), imbalances)


def ascending_speeds(speeds: object, what: str) -> Vector:
    """Return the speeds of a diagram; raise a ModelError if they are not two or more that ascend."""
    at = numbers(speeds)
    if at.ndim != 1 or len(at) < 2 or not np.all(np.isfinite(at)) or np.any(np.diff(at) <= 0.0):
        raise ModelError(f"the speeds of {what} must be two or more that ascend, rad/s, not {speeds!r}")
    return at
