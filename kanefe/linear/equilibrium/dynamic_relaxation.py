"""How a scene with contacts comes to rest: it moves, and is stopped whenever it moves fastest.

Kinetic damping (Cundall, "Explicit finite-difference methods in geomechanics", 1976): a motion from rest has lost most
of the potential energy it can lose where its kinetic energy is largest. Begun anew from there, again and again, it ends
near a stable balance, which a search then finds to the last digit.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.integrate.run import integrate
from kanefe.tree.scales import displacement_scales

Found = TypeVar("Found")

MOST_STOPS = 400
"""Largest number of motions between stops."""

STILL = 1e-3
"""Remaining acceleration, relative to the initial one, at which a scene is near its equilibrium."""

LOOKS = 40
"""Number of times in a motion at which its kinetic energy is evaluated."""

FALLING = 300.0
"""Duration of a motion without a stop, in multiples of the time in which a scene moves some distance from its start,
after which the body is lost."""

TOLERANCE = 1e-4
"""Relative tolerance of the motions, which only need to lead towards an equilibrium."""


class NoRest(SimulationError):
    """There is no rest, wherever a search begins."""


def found_or_fallen(
    search: Callable[[Vector], Found], led: Vector, falling: Callable[[], Model], t: float, q: Vector, u: Vector
) -> Found:
    """Return what a search finds from coordinates that it was led to, or else from those to which the scene falls.

    Parameters
    ----------
    search : callable
        Finds a rest from coordinates.
    led : ndarray, shape (coordinates,)
    falling : callable
        Gives the scene to be let move from q, where its speeds u are zero and nothing drives it.

    Raises
    ------
    SimulationError
        Of the first search, if neither finds a rest.
    """
    try:
        return search(led)
    except NoRest:
        raise
    except SimulationError as error:
        model = falling()
        if model.drives or model.controllers or u.any():
            raise
        try:
            return search(come_to_rest(model, t, q))
        except SimulationError:
            raise error from None


def come_to_rest(model: Model, t: float, q: Vector) -> Vector:
    """Return coordinates near a rest of a scene, from a state in which it does not move.

    Parameters
    ----------
    model : Model
        With contacts that yield, not as about a rest.
    t : float
        s.
    q : ndarray, shape (coordinates,)

    Raises
    ------
    SimulationError
        If it does not come to rest.
    """
    y = np.concatenate((q, np.zeros(model.free_count), model.initial_states))
    first = pace = _pace(model, t, y)
    length = some_way = 0.3 / math.sqrt(first) if first > 0.0 else 0.0  # s
    for _ in range(MOST_STOPS):
        if pace <= STILL * first:
            return model.parts(y)[0]
        y, length = _stopped(model, t, y, length, FALLING * some_way)
        pace = _pace(model, t, y)
    raise SimulationError(f"the scene does not come to rest within {MOST_STOPS} stops")


def _stopped(model: Model, t: float, y: Vector, length: float, longest: float) -> tuple[Vector, float]:
    """Return the state of rest where a motion from y is first fastest, and the duration of the next observation, s."""
    n = model.coordinate_count
    while length <= longest:
        q, u, z = model.parts(y)
        moving = replace(model, initial_coordinates=q, initial_speeds=u, initial_states=z)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its end is looked at here
            run = integrate(moving, (t, t + length), output_step=length / LOOKS, rtol=TOLERANCE, progress=False)
        states = np.hstack((run.coordinates, run.speeds, run.internal))
        energies = [model.energy(t, state).kinetic for state in states]
        falls = np.flatnonzero(np.diff(energies) < 0.0)
        if len(falls):
            found = states[falls[0]]
            found[n : n + model.free_count] = 0.0
            return found, 2.0 * max(float(run.times[falls[0]]) - t, length / LOOKS)
        if len(run.times) <= LOOKS:
            break  # it failed
        y, length = states[-1], 2.0 * length
    raise SimulationError("nothing stops the motion")


def _pace(model: Model, t: float, y: Vector) -> float:
    """Return the largest acceleration, of large displacements, 1/s2."""
    rates = model.parts(model.rhs(t, y))[1]
    return float(np.abs(rates / displacement_scales(model)).max(initial=0.0))
