"""What axial forces would do to the stiffness of slender bodies that are made without stiffening.

A body is looked at in slices along its longest direction. The tension N of a slice is the sum of the forces on what is
beyond it: inertia and weight of its points, and forces at its interfaces, which its deformation tells. On the slopes w'
of the slices it does the work of the stiffness that the body lacks,

    dK = int N w'^T w' ds,

whose eigenvalues relative to K are the errors of the stiffness: P / P_cr of a compressed column, and of a blade that
spins about 1.2 (speed / first frequency)^2.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.errors import outside
from kanefe.frames import Matrix, Vector, cross
from kanefe.states.state import State
from kanefe.storage.scipy_later import scipy
from kanefe.tree.body_terms import FlexibleTerms
from kanefe.tree.model_data import ModelData
from kanefe.tree.stiffening_check import StiffeningWarning

SLICES = 24
"""Number of slices along a body, of equal length."""

SLENDER = 0.3
"""Largest width of a slender body relative to its length: plates and blocks are not looked at."""

BY_SPIN, BY_LOADS = 0.01, 0.1
"""Error of the stiffness, relative to it, from which it is told: that of a spin at a tenth of the first frequency, and
of an axial load of a tenth of the one that buckles the body."""

MAY_MATTER = 0.3
"""Part of these errors, found at once for all states of a run, from which one is evaluated."""

FEWEST = 4
"""Least number of slices with points of the body in them."""

STATES = 8
"""Number of times of a run, about, at which the speeds of drives are looked at."""


class Axial(NamedTuple):
    """The error of a body without stiffening: its name, the time (s), the error by spin and by loads, and the pull (N).

    An error is the stiffness that its axial force would add, relative to its own; of compression below zero.
    """

    body: str
    time: float
    by_spin: float
    by_loads: float
    pull: float

    @property
    def size(self) -> float:
        """How far it is beyond what is told."""
        return max(abs(self.by_spin) / BY_SPIN, abs(self.by_loads) / BY_LOADS)

    @property
    def remark(self) -> str:
        """Message with a remedy."""
        is_spin = abs(self.by_spin) / BY_SPIN >= abs(self.by_loads) / BY_LOADS
        share = self.by_spin if is_spin else self.by_loads
        per_cent = f"{100.0 * abs(share):.2g}" if abs(share) < 1.0 else f"{100.0 * abs(share):.0f}"
        what = "its spin" if is_spin else "an axial load"
        does = f"pulls it with {self.pull:.3g} N" if self.pull > 0.0 else f"presses on it with {-self.pull:.3g} N"
        return (
            f"flexible body {self.body!r} has no stiffening, but {what} {does} at t = {self.time:.6g} s, which would "
            f"make it {per_cent} % {'stiffer' if share > 0.0 else 'softer'} against bending: its "
            "deflections and the squares of its frequencies are off by about as much. Remedy: make the body with "
            "stiffening='full'"
        )


class _Slices(NamedTuple):
    """The slices of a slender body: places along it, its points in them, and the slopes of each, (slices, 2, k).

    `shares` are what its coordinates alone tell of axial loads, (k, interfaces), as changes of the stiffness relative
    to it; `frequency` is its lowest, rad/s.
    """

    along: Vector
    at: Vector
    step: float
    masses: Vector
    points: Matrix
    of_points: np.ndarray
    slopes: np.ndarray
    shares: Matrix
    frequency: float


_kept: WeakKeyDictionary[FlexibleBody, _Slices | None] = WeakKeyDictionary()


def warn_of_axial_forces(model: ModelData, times: Vector, coordinates: Matrix, speeds: Matrix, what: str = "") -> None:
    """Warn of the body without stiffening whose axial force matters the most, if it does.

    Parameters
    ----------
    model : ModelData
    times, coordinates, speeds : ndarray
        States (t, q, u). Those in which a body is pulled or turns the most are evaluated, if it may matter there.
    what : str
        Begins the message.
    """
    lacking = [i for i, body in enumerate(model.bodies) if body.flexible is not None and _lacks(body.flexible)]
    if not lacking or not len(times) or not (np.all(np.isfinite(coordinates)) and np.all(np.isfinite(speeds))):
        return
    looks: dict[int, list[int]] = {}
    turns = _turns(model, times, speeds)
    for number in lacking:
        terms = model.bodies[number].flexible
        slices = None if terms is None else _slices(terms.body)
        if terms is None or slices is None:
            continue
        shares = np.abs(coordinates[:, terms.eta] @ slices.shares).max(axis=1, initial=0.0)
        for of_rows, told in ((shares, BY_LOADS), ((turns / slices.frequency) ** 2, BY_SPIN)):
            row = int(of_rows.argmax())
            if of_rows[row] > MAY_MATTER * told:
                looks.setdefault(row, []).append(number)
    found = [
        axial
        for row, numbers in looks.items()
        for axial in axial_forces(State(model, float(times[row]), coordinates[row], speeds[row]), numbers)
    ]
    worst = max(found, key=lambda one: one.size, default=None)
    if worst is not None and worst.size > 1.0:
        warnings.warn(what + worst.remark, StiffeningWarning, stacklevel=outside())


def _turns(model: ModelData, times: Vector, speeds: Matrix) -> Vector:
    """Return what no body turns faster than in each state, but for what bodies bend, rad/s."""
    joints = np.ones(model.free_count, dtype=bool)
    for body in model.bodies:
        if body.flexible is not None:
            joints[body.flexible.speeds] = False
    turns = np.abs(speeds[:, joints]).sum(axis=1)
    if model.driven_count:
        driven = [np.abs(model.driven_speeds(float(t))[0]).sum() for t in times[:: max(1, len(times) // STATES)]]
        turns = turns + max(driven)
    return np.asarray(turns)


def axial_forces(state: State, numbers: Sequence[int]) -> list[Axial]:
    """Return what the axial forces of some bodies do, by their numbers."""
    found = []
    for number in numbers:
        body, terms = state.model.bodies[number], state.model.bodies[number].flexible
        assert terms is not None  # noqa: S101
        slices = _slices(terms.body)
        if slices is None:
            continue
        k, frame = terms.body.free_count, state.motions[number]
        gravity = frame.A_NF.T @ np.asarray(state.model.gravity)
        spin = frame.Z + cross(frame.w, cross(frame.w, slices.points))
        forces = slices.masses[:, None] * (gravity - spin)
        by_spin = _beyond(terms.body, slices, slices.of_points, -slices.masses * (spin @ slices.along))
        eta = state.q[terms.eta]
        K = terms.body.stiffness[:k, :k]
        basis = terms.body.inertia_basis.reshape(len(slices.points), -1, terms.body.count)[:, :3, :k]
        pulls = _pulls(terms.body, slices, K @ eta - np.einsum("px,pxk->k", forces, basis))
        by_loads = _beyond(terms.body, slices, np.array(_places(terms.body, slices), dtype=int), pulls)
        of_spin, of_loads = (_share(slices, tension, K) for tension in (by_spin, by_loads))
        worst = by_spin if abs(of_spin) / BY_SPIN >= abs(of_loads) / BY_LOADS else by_loads
        found.append(Axial(body.name, state.t, of_spin, of_loads, float(worst[np.abs(worst).argmax()])))
    return found


def _lacks(terms: FlexibleTerms) -> bool:
    """Return whether a body has modes but no stiffening."""
    return type(terms.body) is FlexibleBody and terms.body.free_count > 0 and terms.body.moments.quadratic_first is None


def _slices(body: FlexibleBody) -> _Slices | None:
    """Return the slices of a body, made once; None if it is not slender."""
    if body not in _kept:
        _kept[body] = _made(body)
    return _kept[body]


def _made(body: FlexibleBody) -> _Slices | None:
    points, k = body.inertia_points, body.free_count
    basis = body.inertia_basis.reshape(len(points), -1, body.count)[:, :3, :k]
    masses = np.asarray(body.inertia_mass.sum(axis=1)).ravel()
    if len(points) < SLICES // 4 or len(masses) != len(points) or masses.sum() <= 0.0:
        return None
    middle = np.average(points, axis=0, weights=np.maximum(masses, 0.0))
    _, sizes, axes = np.linalg.svd(points - middle, full_matrices=False)
    if sizes[1] > SLENDER * sizes[0]:
        return None
    along = axes[0] * (1.0 if axes[0] @ (middle - _root(body)) >= 0.0 else -1.0)
    s = points @ along
    step = np.ptp(s) / SLICES
    cuts = s.min() + step * np.arange(SLICES + 1)
    of_points = np.clip(np.searchsorted(cuts, s, side="right") - 1, 0, SLICES - 1)
    at = cuts[:-1] + 0.5 * step
    filled = [slice_ for slice_ in (np.flatnonzero(of_points == i) for i in range(SLICES)) if len(slice_)]
    if len(filled) < FEWEST:
        return None
    places = np.array([s[slice_].mean() for slice_ in filled])
    across = np.array([axes[1:3] @ basis[slice_].mean(axis=0) for slice_ in filled]).reshape(len(filled), -1)
    moved = np.array([np.interp(cuts, places, column) for column in across.T]).T.reshape(SLICES + 1, 2, k)
    slopes = np.diff(moved, axis=0) / step
    K = body.stiffness[:k, :k]
    lowest = scipy.linalg.eigvalsh(K, body.moments.elastic_mass[:k, :k], subset_by_index=(0, 0))[0]
    if lowest <= 0.0:
        return None
    made = _Slices(along, at, float(step), masses, points, of_points, slopes, np.zeros((k, 0)), float(np.sqrt(lowest)))
    pulls = np.array([_pulls(body, made, row) for row in K])
    each = [_share(made, _beyond(body, made, np.array([i]), np.ones(1)), K) for i in _places(body, made)]
    return made._replace(shares=pulls * each)


def _root(body: FlexibleBody) -> Vector:
    """Return where a body is held, or the origin of G."""
    held = [frame.position for frame in body.interfaces if frame.is_held]
    return np.mean(held, axis=0) if held else np.zeros(3)


def _beyond(body: FlexibleBody, slices: _Slices, of: np.ndarray, pulls: Vector) -> Vector:
    """Return the tension in each slice due to forces along the body in some slices, on the side that is not held."""
    sums = np.bincount(np.minimum(of, SLICES - 1), weights=pulls, minlength=SLICES)
    held = float(slices.along @ _root(body)) - slices.at[0]
    root = int(np.clip(round(held / slices.step), 0, SLICES - 1))
    tension = np.cumsum(sums[::-1])[::-1] - 0.5 * sums
    tension[:root] = -(np.cumsum(sums) - 0.5 * sums)[:root]
    return tension


def _free(body: FlexibleBody) -> list[InterfaceFrame]:
    return [frame for frame in body.interfaces if not frame.is_held]


def _places(body: FlexibleBody, slices: _Slices) -> list[int]:
    """Return the slice of each interface that is not held."""
    first = slices.at[0] - 0.5 * slices.step
    return [int(np.clip((frame.position @ slices.along - first) / slices.step, 0, SLICES - 1)) for frame in _free(body)]


def _pulls(body: FlexibleBody, slices: _Slices, left: Vector) -> Vector:
    """Return the forces along the body at these interfaces that balance generalised forces."""
    free = _free(body)
    if not free:
        return np.zeros(0)
    motions = np.hstack([frame.motion[:, : body.free_count].T for frame in free])
    found = np.linalg.lstsq(motions, left, rcond=1e-9)[0].reshape(-1, 6)[:, :3] @ slices.along
    return np.asarray(found)


def _share(slices: _Slices, tension: Vector, K: Matrix) -> float:
    """Return the largest change of the stiffness relative to it, with its sign."""
    added = np.einsum("s,sck,scl->kl", slices.step * tension, slices.slopes, slices.slopes)
    try:
        shares = scipy.linalg.eigvalsh(added, K)
    except np.linalg.LinAlgError:  # a body that is free in space
        return 0.0
    return float(shares[np.abs(shares).argmax()])
