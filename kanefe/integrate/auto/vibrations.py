"""Vibrations of a scene: how large they are at a state, and which of them nothing damps."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.locked_speeds import has_locked_speeds
from kanefe.kernels.steppers.step_commands import VECTOR
from kanefe.storage.scipy_later import scipy
from kanefe.tree.scales import coordinate_moves, displacement_scales, modal_frequencies, state_scales
from kanefe.tree.tangents import constant_tangents

FIRST_SHARE = 0.05
"""First step if nothing vibrates, relative to the span."""

FIRST_PERIODS = 20.0
"""Radians of the lowest mode over which the trial step brings vibrations to rest."""

UNSEEN, UNSEEN_UNDAMPED = 20.0, 5.0
"""Vibrations that are stepped over, in multiples of the absolute tolerance, which by default is a tenth of the relative
one: damped and undamped."""

LEAST_DAMPING = 0.005
"""Damping ratio from which a vibration does not grow with any number of columns of the extrapolation."""

GROWTH, MOST_RADIANS = 0.05, 0.5
"""Largest growth of a vibration in a step of the extrapolation, relative to the fourth power of its radians in the
step, and the radians up to which this holds. It follows from the stability functions of one to eight columns on the
imaginary axis, of which that of three grows most."""

CALM = 10.0
"""Radians of a vibration in a step of the extrapolation with all columns from which it does not grow, however small its
damping; with fewer columns in proportion. It is a quarter more than stability requires, because frequencies change as
bodies move."""

MOST_CHANGES = 64
"""Largest number of jumps of functions of time whose vibrations are computed."""

ALLOWED_AT_REST = 0.1
"""Default absolute tolerance as a fraction of the permitted error of a large quantity."""

OFTEN = 0.3
"""Size of a vibration, relative to the largest one, from which it counts as excited again."""

MOST_DENSE = 600
"""Largest number of speeds of scenes whose vibrations are computed from matrices of the whole scene."""


def are_seen(dynamics: Dynamics, t: float, y: Vector, longest: float, rtol: float, atol: Vector) -> bool:
    """Return whether modes of bodies vibrate by more than the tolerances from a state on.

    A linearly implicit trial step over some periods of the lowest mode, but no longer than `longest` s, brings the
    modes close to where they would come to rest. What that takes from a deflection, and from a speed over the frequency
    of the mode, is its vibration, whether it begins as the one or as the other.

    Parameters
    ----------
    dynamics : Dynamics
        Of a scene in order n.
    t, longest : float
        s.
    y : ndarray
        State.
    rtol : float
        Relative to the deflection.
    atol : ndarray
        Absolute, for each component of the state.
    """
    model = dynamics.model
    rates = modal_frequencies(model)
    if not np.any(rates > 0.0):
        return False
    h = min(longest, FIRST_PERIODS / float(rates[rates > 0.0].min()))
    n, m = model.coordinate_count, model.free_count
    vectors = np.zeros((VECTOR.stiffness_direction + 1, len(y)))
    vectors[VECTOR.at] = y
    vectors[VECTOR.stiffness_direction, n : n + m] = -h * y[n : n + m]
    dynamics.implicit_rate(t, vectors, h, h * h)
    for turns, at, speed in coordinate_moves(model):
        if not turns and rates[speed] > 0.0:
            change = h * vectors[VECTOR.slope, n + speed]
            size = math.hypot(h * (y[n + speed] + change), change / rates[speed])
            if size > UNSEEN * atol[at] + rtol * abs(y[at]):
                return True
    return False


class Vibrations(NamedTuple):
    """Vibrations of a scene about where it starts, each (k,).

    Attributes
    ----------
    frequencies : ndarray
        rad/s.
    ratios : ndarray
        Of damping.
    sizes : ndarray
        How large each is at the start, of what is large along the coordinate that it moves the most.
    momenta : ndarray, shape (k, free)
        Of each, for speeds: its own speed, in the units of its shape.
    reach : ndarray
        How far each goes at a size of one in those units, of what is large.
    haste : ndarray
        How much larger the speeds of each are than its displacements, of what is large, at least one. Those of joints
        count against a radian a second, and not against the frequency; the less, the faster a joint will move.
    begins : ndarray
        How often each begins in a run.
    """

    frequencies: Vector
    ratios: Vector
    sizes: Vector
    momenta: Matrix
    reach: Vector
    haste: Vector
    begins: Vector


def vibrations(dynamics: Dynamics, start: float, span: float) -> Vibrations:
    """Return the vibrations of a scene at the start (s), but for those that take longer than the span (s) for a period.

    Of modes, and of springs and dampers in joints, with the mass of the whole scene; of very large scenes and of what
    has no inertia but through loops, those of bodies alone. A vibration is as large as the speeds that it starts with
    over its frequency, and its acceleration over the square of that: so far it is from where it would rest.
    """
    model = dynamics.model
    n, m = model.coordinate_count, model.free_count
    K, C = constant_tangents(model)
    alone = modal_frequencies(model)
    where = np.flatnonzero(alone)
    M = np.diag(np.divide(np.diag(K), alone**2, out=np.ones(m), where=alone > 0.0))
    squares, shapes = alone[where] ** 2, np.eye(m)[:, where] / np.sqrt(np.diag(M)[where])
    if m <= MOST_DENSE:
        K, C = model.literal.tangents(model.literal.at(start, model.initial_coordinates, model.initial_speeds))
        with suppress(np.linalg.LinAlgError):
            whole = model.literal.mass_at_start(start)
            squares, shapes = scipy.linalg.eigh(K, whole)
            M = whole
    is_vibration = squares * span**2 > 4.0 * math.pi**2
    frequencies, shapes = np.sqrt(squares[is_vibration]), shapes[:, is_vibration]
    y = dynamics.initial_state(start)
    moving, pushed = y[n : n + m], dynamics.rate(start, y)[n : n + m]
    displacements, speeds = displacement_scales(model), state_scales(model)[n : n + m]
    momenta = shapes.T @ M
    falls = np.abs(pushed - shapes @ (momenta @ pushed))  # without vibrations
    fallen = np.minimum(span * falls, np.sqrt(2.0 * displacements * falls))
    allowed = 1.0 + (np.abs(moving) + fallen) / speeds / ALLOWED_AT_REST
    reach = np.abs(shapes / displacements[:, None]).max(axis=0, initial=0.0)
    counts = alone > 0.0 if has_locked_speeds(model) and not model.controllers else np.ones(m, dtype=bool)
    speed = np.abs(shapes / (speeds * allowed)[:, None])[counts].max(axis=0, initial=0.0)
    return Vibrations(
        frequencies,
        0.5 * np.sum(shapes * (C @ shapes), axis=0) / frequencies,
        reach * np.hypot(momenta @ moving / frequencies, momenta @ pushed / frequencies**2),
        momenta,
        reach,
        np.maximum(frequencies * speed / reach, 1.0),
        np.ones(len(reach)),
    )


def begun_by(changes: Vector, sample: float, dynamics: Dynamics, found: Vibrations) -> tuple[Vibrations, float]:
    """Return vibrations as large as changes of functions of the time begin them, and when the largest begins, s.

    A change at once moves the rest of a vibration by what it pushes over the square of its frequency; one that takes
    long beside a radian of it by less, in proportion. All are seen from the start of the scene.

    Parameters
    ----------
    changes : ndarray
        The sides of those of `kanefe.integrate.breakpoints.changes_of`, s.
    sample : float
        Between two looks at the functions, s: what takes no longer counts as at once.
    dynamics : Dynamics
    found : Vibrations
        At the start.
    """
    n, m, y = dynamics.model.coordinate_count, dynamics.model.free_count, dynamics.initial_state(changes[0])
    begun = np.zeros((1, len(found.frequencies)))
    with suppress(Exception):  # of the user: the run tells of it, if it comes there
        directions = np.array([dynamics.rate(t, y)[n : n + m] for t in changes[:MOST_CHANGES].tolist()])
        radians = found.frequencies * np.maximum(np.diff(changes[:MOST_CHANGES]) - sample, 0.0)[:, None]
        begun = np.abs(np.diff(directions, axis=0) @ found.momenta.T) / np.maximum(0.5 * radians, 1.0)
        begun *= found.reach / found.frequencies**2
    sizes = np.maximum(found.sizes, begun.max(axis=0))
    often = np.maximum((begun > OFTEN * sizes).sum(axis=0), 1)
    when = changes[1 + np.argmax(begun.max(axis=1, initial=0.0))]
    return found._replace(sizes=sizes, begins=often), float(when)


def least_damping(radians: Vector) -> Vector:
    """Return the ratios from which on no vibration grows in steps of the extrapolation of so many radians of it.

    Damping takes the ratio times the radians away in a step, and the step adds what `GROWTH` says.
    """
    return np.where(radians < MOST_RADIANS, np.minimum(GROWTH * radians**3, LEAST_DAMPING), LEAST_DAMPING)


def all_damped(model: Model) -> bool:
    """Return whether all vibrations are damped, by the bodies alone.

    True only where flexible bodies carry nothing, and no joint has a spring. Free of its frame a mode is faster, and
    damped more; with masses attached it is slower, and damped less.
    """
    carries = any(body.parent >= 0 and model.bodies[body.parent].flexible is not None for body in model.bodies)
    if carries or model.constraints:
        return False
    K, C = (np.diag(X) for X in constant_tangents(model))
    alone = modal_frequencies(model)
    least = 2.0 * LEAST_DAMPING * np.divide(K, alone, out=np.zeros_like(K), where=alone > 0.0)
    return bool(np.all(C >= least) and not np.any(K[alone == 0.0]))
