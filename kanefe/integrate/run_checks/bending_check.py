"""How far flexible bodies are bent at the steps of a run, not only where its states are stored."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kanefe.bodies.inner_rotations import InnerRotations, inner_rotations
from kanefe.frames import Vector
from kanefe.kernels.evaluation.bending import BentBody
from kanefe.tree.bending import Bent
from kanefe.tree.model_data import ModelData

AT_ONCE = 32
"""Number of steps that are evaluated together."""

WatchedBodies = list[tuple[str, slice, InnerRotations]]


def watched_bodies(model: ModelData) -> WatchedBodies:
    """Return name, coordinates and inner rotations of each body that can bend."""
    flexible = [(body.name, body.flexible) for body in model.bodies if body.flexible is not None]
    found = [(name, terms.eta, inner_rotations(terms.body)) for name, terms in flexible]
    return [(name, eta, inner) for name, eta, inner in found if inner is not None]


def bends_in_kernels(bodies: WatchedBodies, base: int) -> tuple[np.ndarray, Vector]:
    """Return what kernels watch: rows of integers, and reals that are to lie from the place `base` on.

    See `kanefe.kernels.evaluation.bending`.
    """
    integers, reals = [], []
    for _, eta, inner in bodies:
        integers += [eta.start, eta.stop - eta.start, 3 * len(inner.chosen), base]
        reals += [np.zeros(2), *inner.watched]
        base += sum(map(len, reals[-4:]))
    return np.array(integers, dtype=np.int64), np.concatenate([np.zeros(0), *reals])


def bends_of_kernels(bodies: WatchedBodies, integers: np.ndarray, reals: Vector) -> list[Bent]:
    """Return what kernels have seen."""
    found = []
    for (name, *_), row in zip(bodies, integers.reshape(-1, BentBody.integer_count), strict=True):
        body = BentBody(row, reals)
        if body.largest > 0.0:
            found.append(Bent(name, float(body.when), body.bent.copy()))
    return found


class Bends:
    """Largest bending in steppers in Python so far; states are evaluated in batches, in a fifth of the time."""

    def __init__(self, model: ModelData) -> None:
        self._bodies = watched_bodies(model)
        self._largest = dict.fromkeys((name for name, *_ in self._bodies), 0.0)
        self._seen: dict[str, Bent] = {}
        self._times: list[float] = []
        self._states: list[Vector] = []

    def __bool__(self) -> bool:
        return bool(self._bodies)

    @property
    def seen(self) -> list[Bent]:
        """Where each body was bent the most."""
        self._look()
        return list(self._seen.values())

    def keep(self, t: float, y: Vector) -> None:
        """Keep a state at time t (s) for evaluation; it must not change."""
        self._times.append(t)
        self._states.append(y)
        if len(self._times) == AT_ONCE:
            self._look()

    def _look(self) -> None:
        if not self._times:
            return
        states = np.array(self._states)
        for name, at, inner in self._bodies:
            row = inner.worst_row(states[:, at])
            size = inner.size(states[row, at])
            if size > self._largest[name]:
                self._largest[name] = size
                self._seen[name] = Bent(name, self._times[row], states[row, at].copy())
        self._times.clear()
        self._states.clear()

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return what has been seen as arrays."""
        self._look()
        kept = [(i, self._seen[name]) for i, (name, *_) in enumerate(self._bodies) if name in self._seen]
        return {f"bent {i}": np.append(one.time, one.eta) for i, one in kept}

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot."""
        self._times.clear()
        self._states.clear()
        self._seen.clear()
        for i, (name, _, inner) in enumerate(self._bodies):
            kept = np.array(snapshot.get(f"bent {i}", np.zeros(0)))
            self._largest[name] = 0.0
            if len(kept):
                self._seen[name] = Bent(name, float(kept[0]), kept[1:])
                self._largest[name] = inner.size(kept[1:])
