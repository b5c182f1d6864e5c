"""A solve on each route: its duration, and whether it agrees with another one."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Generator, Iterator
from dataclasses import dataclass

import numpy as np

from kanefe.doctor.trial_scenes import arm, double_pendulum
from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.system import System

STEPS, STEP = 50, 1e-3  # of the fixed steps
SAME = 1e-10
"""Largest difference relative to the largest number: the same steps on two routes differ by round-off, accumulated over
200 evaluations."""

NEEDED = {"engine", "explicit"}
"""Libraries of kernels that the solves need."""

RTOL = 1e-7
ALIKE = 1e-5
"""Largest difference relative to the displacement of the tip: both runs have errors of about 100 times their tolerance
per step."""


@dataclass(frozen=True)
class Solve:
    """Outcome of a solve on a route.

    Attributes
    ----------
    route : str
    scene : str
    seconds : float
        Including the time to freeze the model.
    difference, limit : float
        From the solve that it is compared with, relative; NaN for the first.
    against : str
    trouble : str
        The error, if there is no result.
    """

    route: str
    scene: str
    seconds: float
    difference: float = float("nan")
    limit: float = float("nan")
    against: str = ""
    trouble: str = ""

    @property
    def is_fault(self) -> bool:
        """Whether it failed, or disagrees."""
        return bool(self.trouble) or bool(self.against and not self.difference <= self.limit)


def solves(missing: Collection[str] = ()) -> Iterator[Solve]:
    """Yield a solve on each route as it is done; none if a library of kernels that they need is in `missing`."""
    if not NEEDED.isdisjoint(missing):
        return
    for name, scene, route in (
        ("double pendulum", double_pendulum, "compiled, in the plane"),
        ("arm, hub and tip in space", lambda: arm(is_reduced=True), "compiled, order n"),
    ):
        plain = yield from _tried("literal", name, lambda scene=scene: _by_literal_steps(scene().freeze()))  # type: ignore[misc]
        yield from _tried(route, name, lambda scene=scene: _by_compiled_steps(scene()), plain, "literal", SAME)  # type: ignore[misc]
    reduced = yield from _tried("compiled, all modes", "arm, free steps", lambda: _tip_of(arm(is_reduced=True)))
    unreduced = "unreduced, sparse matrices"
    yield from _tried(unreduced, "arm, free steps", lambda: _tip_of(arm(is_reduced=False)), reduced, "all modes", ALIKE)


def _tried(
    route: str,
    scene: str,
    solve: Callable[[], Vector],
    other: Vector | None = None,
    against: str = "",
    limit: float = float("nan"),
) -> Generator[Solve, None, Vector | None]:
    began = time.perf_counter()
    try:
        found = solve()
    except Exception as error:  # noqa: BLE001  (any error is reported)
        yield Solve(route, scene, time.perf_counter() - began, trouble=f"{type(error).__name__}: {error}")
        return None
    seconds = time.perf_counter() - began
    if other is None:
        yield Solve(route, scene, seconds)
    else:
        yield Solve(route, scene, seconds, float(abs(found - other).max() / abs(other).max()), limit, against)
    return found


def _by_literal_steps(model: Model) -> Vector:
    """Return the state after fixed steps of Runge and Kutta through the paper's dense matrices."""
    y, h = model.initial_state.copy(), STEP

    def rates(t: float, y: Vector) -> Vector:
        return model.literal.evaluate(t, y).rates[: len(y)]  # without the energy quadratures

    for number in range(STEPS):
        t = number * h
        a = rates(t, y)
        b = rates(t + 0.5 * h, y + 0.5 * h * a)
        c = rates(t + 0.5 * h, y + 0.5 * h * b)
        d = rates(t + h, y + h * c)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return y


def _by_compiled_steps(scene: System) -> Vector:
    """Return the state after the same steps in compiled code."""
    result = scene.simulate((0.0, STEPS * STEP), method="rk4", step=STEP, progress=False)
    result.raise_for_status()
    return np.asarray(result.at(STEPS * STEP).state)


def _tip_of(scene: System) -> Vector:
    """Return the displacement of the tip after 50 ms, by the method that is chosen for the scene."""
    result = scene.simulate((0.0, STEPS * STEP), rtol=RTOL, progress=False)
    result.raise_for_status()
    places = result.position("tip")
    return np.asarray(places[-1] - places[0])
