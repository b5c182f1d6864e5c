"""Dynamic relaxation of a scene with contacts: it moves, and is stopped whenever its kinetic energy has a maximum.

Kinetic damping (Cundall, "Explicit finite-difference methods in geomechanics", 1976): at the maximum of its kinetic
energy, a motion from rest has lost most of the potential energy that it can lose. Restarted from rest again and again,
it ends near a stable balance, from which a search finds the balance exactly.
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
from kanefe.tree.scales import displacement_scales

Found = TypeVar("Found")

MOST_STOPS = 400
"""Largest number of stops."""

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
    """There is no rest, wherever a search starts."""


def found_or_fallen(
    search: Callable[[Vector], Found], led: Vector, falling: Callable[[], Model], t: float, q: Vector, u: Vector
) -> Found:
    """Return the result of a search from given coordinates, or else from those found by dynamic relaxation.

    Parameters
    ----------
    search : callable
        Finds a rest from coordinates.
    led : ndarray, shape (coordinates,)
        Coordinates from which it starts first.
    falling : callable
        Returns the model for the relaxation from q, which is only tried without speeds u and drives.

    Raises
    ------
    SimulationError
        The error of the first search, if neither finds a rest.
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
    """Return coordinates near a rest of a scene, by dynamic relaxation from q with zero speeds.

    Parameters
    ----------
    model : Model
        With compliant contacts, in their form for runs.
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
    """Return the state at the first maximum of kinetic energy with zero speeds, and the next time of observation, s."""
    from kanefe.integrate.run import integrate

    n = model.coordinate_count
    while length <= longest:
        q, u, z = model.parts(y)
        moving = replace(model, initial_coordinates=q, initial_speeds=u, initial_states=z)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its status is evaluated here
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
    """Return the largest acceleration relative to the scale of displacements, 1/s2."""
    rates = model.parts(model.rhs(t, y))[1]
    return float(np.abs(rates / displacement_scales(model)).max(initial=0.0))
