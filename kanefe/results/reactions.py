"""Joint reactions of all states of a run at once, for scenes with joints, inertia and gravity only.

The balance of each body is that of `kanefe.kane.reactions`, which serves all other scenes: an inward sweep over the
Newton-Euler equations, with time as the first axis of every array.
"""

from __future__ import annotations

import numpy as np

from kanefe.bodies.mass_moments import MassMoments
from kanefe.frames import Matrix, cross
from kanefe.tree.body_terms import BodyTerms
from kanefe.tree.model_data import ModelData
from kanefe.tree.route import FrameMotions, RunSweeps

NUMBERS_AT_ONCE = 4_000_000
"""Number of values computed at once in the products of moments with coordinates: some tens of megabytes."""


def are_alone(model: ModelData) -> bool:
    """Return whether only joints, inertia and gravity act on the bodies, as the sweep over all states requires."""
    if model.constraints or model.loads or any(body.loads or body.field_loads for body in model.bodies):
        return False
    return all(b.flexible is None or isinstance(b.flexible.free_moments, MassMoments) for b in model.bodies)


def reactions_of_states(model: ModelData, sweeps: RunSweeps, states: Matrix) -> list[Matrix]:
    """Return for each body the wrenches (T, 6) that its joint exerts on it: see `kanefe.kane.reactions`.

    Parameters
    ----------
    model : ModelData
        One for which `are_alone` is true.
    sweeps : RunSweeps
    states : ndarray, shape (T, state)
    """
    frames = [sweeps.frame(number, None, is_accelerated=True) for number in range(len(model.bodies))]
    rates = sweeps.rates[:, model.coordinate_count : model.coordinate_count + model.free_count]
    pairs = zip(model.bodies, frames, strict=True)
    wrenches = [_demand(model, body, frame, states, rates) for body, frame in pairs]
    for number in reversed(range(len(model.bodies))):
        parent = model.bodies[number].parent
        if parent >= 0:
            wrenches[parent] = wrenches[parent] + moved_wrenches(wrenches[number], frames[number], frames[parent])
    return wrenches


def moved_wrenches(wrenches: Matrix, source: FrameMotions, target: FrameMotions) -> Matrix:
    """Convert wrenches (T, 6) about `source` in its axes to wrenches about `target` in its axes."""
    back = target.axes.transpose(0, 2, 1)
    A = back @ source.axes
    force = _times(A, wrenches[:, :3])
    r = _times(back, source.position - target.position)
    return np.hstack((force, _times(A, wrenches[:, 3:]) + cross(r, force)))


def _demand(model: ModelData, body: BodyTerms, frame: FrameMotions, states: Matrix, rates: Matrix) -> Matrix:
    """Return the wrench (T, 6) that a body requires in addition to gravity."""
    if frame.acceleration is None or frame.angular_acceleration is None:
        raise TypeError("the accelerations of the frames are needed")
    back = frame.axes.transpose(0, 2, 1)
    gravity = np.asarray(model.gravity) if body.has_gravity else np.zeros(3)
    a = _times(back, frame.acceleration - gravity)
    alpha, w = _times(back, frame.angular_acceleration), _times(back, frame.angular_velocity)
    if body.rigid is not None:
        c = np.broadcast_to(body.rigid.com, a.shape)
        force = body.rigid.mass * (a + cross(alpha, c) + cross(w, cross(w, c)))
        spun = w @ body.rigid.inertia.T + body.rigid.rotor
        return np.hstack((force, alpha @ body.rigid.inertia.T + cross(w, spun) + cross(c, force)))
    if body.flexible is None:
        return np.zeros((len(a), 6))
    terms, start = body.flexible, model.coordinate_count
    eta, speeds = states[:, terms.eta], slice(start + terms.speeds.start, start + terms.speeds.stop)
    given = (eta, states[:, speeds], rates[:, terms.speeds], w, a, alpha)
    moments = terms.free_moments
    if not isinstance(moments, MassMoments):
        raise TypeError("the moments of a mass field are needed")
    at_once = max(1, NUMBERS_AT_ONCE // max(1, 9 * eta.shape[1]))
    pieces = [[x[i : i + at_once] for x in given] for i in range(0, len(eta), at_once)]
    return np.concatenate([moments.wrenches(*piece) for piece in pieces])


def _times(A: np.ndarray, x: Matrix) -> Matrix:
    """Return matrices (T, 3, 3) times vectors (T, 3)."""
    return np.asarray((A @ x[:, :, None])[:, :, 0])
