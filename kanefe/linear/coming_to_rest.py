"""How a scene with contacts comes to rest: it moves, and is stopped whenever it moves fastest.

Kinetic damping (Cundall, "Explicit finite-difference methods in geomechanics", 1976): a motion from rest has lost most
of the potential energy it can lose where its kinetic energy is largest. Begun anew from there, again and again, it ends
near a stable balance, which a search then finds to the last digit.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.integrate.run import integrate
from kanefe.tree.scales import displacement_scales

MOST_STOPS = 400
"""Motions at most from one stop to the next."""

STILL = 1e-3
"""Of the acceleration at the start: what is left where a scene is near its rest."""

LOOKS = 40
"""Instants of a motion at which its kinetic energy is asked for."""

FALLING = 300.0
"""Times that in which a scene goes some way from its start: what moves on for as long in one go is lost."""

TOLERANCE = 1e-4
"""Of the motions, which need be no better than to lead somewhere."""


def may_move(model: Model, u: Vector) -> bool:
    """Return whether a scene can be let move from a state: nothing drives it, and its speeds u are zero."""
    return not (model.drives or model.controllers or u.any())


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
    """Return the state of rest where a motion from y is fastest first, and how long the next should be looked at, s."""
    n = model.coordinate_count
    while length <= longest:
        q, u, z = model.parts(y)
        moving = replace(model, initial_coordinates=q, initial_speeds=u, initial_states=z)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its end is looked at here
            run = integrate(moving, (t, t + length), output_step=length / LOOKS, rtol=TOLERANCE, progress=False)
        states = np.hstack((run.coordinates, run.speeds, run.internal))
        energies = [_kinetic(model, t, state) for state in states]
        falls = np.flatnonzero(np.diff(energies) < 0.0)
        if len(falls):
            found = states[falls[0]]
            found[n : n + model.free_count] = 0.0
            return found, 2.0 * max(float(run.times[falls[0]]) - t, length / LOOKS)
        if len(run.times) <= LOOKS:
            break  # it failed
        y, length = states[-1], 2.0 * length
    raise SimulationError("nothing stops what moves")


def _kinetic(model: Model, t: float, y: Vector) -> float:
    """Return twice the kinetic energy, J."""
    u = model.parts(y)[1]
    return float(u @ model.mass_matrix(t, y) @ u)


def _pace(model: Model, t: float, y: Vector) -> float:
    """Return the largest acceleration, of large displacements, 1/s2."""
    rates = model.parts(model.rhs(t, y))[1]
    return float(np.abs(rates / displacement_scales(model)).max(initial=0.0))
