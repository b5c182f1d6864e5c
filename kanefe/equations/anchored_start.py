"""Anchors of dry friction at the start of a run: stretched by what friction holds there, or by what it slips with.

Of the points that are at rest, the frictions x are those of least accelerations (Gauss's principle),

    min 1/2 x^T G x - b^T x,    |x_i| <= what the i-th holds,    G = D M^-1 D^T

with D the partial rates of their slips and b the accelerations of these without x. Where several do the same, as where
a box stands on four feet, x is the one of least energy in the anchors' springs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.literal.bearing_loads import with_consistent_loads
from kanefe.literal.route import LiteralRoute
from kanefe.loads.anchors import Anchor
from kanefe.states.interactions import slip_rows
from kanefe.states.state import State
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import displacement_scales

ROUNDS = 30
"""Largest number of iterations between frictions and the joint loads that they cause, and of the search for slipping
points."""

SETTLED = 1e-12
"""Change of the states in an iteration, relative to the largest, below which it has converged."""

DEPENDENT = 1e-10
"""Eigenvalue of G, relative to the largest, below which frictions have the same effect."""

BALANCED = 1e-9
"""Remaining acceleration, relative to the largest without friction, below which a body at rest stays at rest."""

MOST_SWEEPS = 2000
"""Largest number of sweeps in the search for frictions at their limits."""

MOMENT = 1e-6
"""Time over which slip rates are compared, relative to the time in which the scene moves by its size, or in s."""

BEYOND = 1.0 + 1e-9
"""Factor on the kinetic friction beyond which a point slips from the start. A holding point stays as far below its
limit."""


def with_balanced_anchors(model: ModelData, t: float, q: Vector, u: Vector, z: Vector) -> Vector:
    """Return internal states in which friction is in balance where it can hold; loads of joints follow it.

    Parameters
    ----------
    model : ModelData
        Without bodies that keep all degrees of freedom.
    t : float
        s.
    q, u, z : ndarray
        State at the start.
    """
    for _ in range(ROUNDS):
        after = _balanced(model, t, q, u, z)
        if after is None:
            return with_consistent_loads(model, t, q, u, z)
        after = with_consistent_loads(model, t, q, u, after)
        change, z = float(np.abs(after - z).max()), after
        if not model.bearings or not change > SETTLED * float(np.abs(after).max()):
            break
    return z


class _Group(NamedTuple):
    number: int
    anchor: Anchor
    where: slice


def _balanced(model: ModelData, t: float, q: Vector, u: Vector, z: Vector) -> Vector | None:
    """Return the states with the anchors in balance under the loads that joints have in z; None: there are none."""
    state, groups, count = State(model, t, q, u, z), [], 0
    for number, load in enumerate(model.loads):
        for anchor in load.anchors(state.load_ends(number), state.load_states(number)):
            groups.append(_Group(number, anchor, slice(count, count + len(anchor.slip))))
            count += len(anchor.slip)
    if not groups:
        return None
    x = np.zeros(count)
    for _, anchor, where in groups:
        x[where] = anchor.steady if anchor.moves else 0.0
    slips = np.array([group.anchor.moves for group in groups])
    resting = np.flatnonzero(~slips)
    if len(resting):
        x = _held(State(model, t, q, u, _stretched(state, groups, x, slips)), groups, resting, x, slips)
    return _stretched(state, groups, x, slips)


def _stretched(state: State, groups: list[_Group], x: Vector, slips: np.ndarray) -> Vector:
    z = state.z.copy()
    for number in {group.number for group in groups}:
        own = [i for i, group in enumerate(groups) if group.number == number]
        tangentials = [x[groups[i].where] for i in own]
        where = state.model.load_states[number]
        load, ends = state.model.loads[number], state.load_ends(number)
        z[where] = load.anchored(ends, z[where], tangentials, slips[own].tolist())
    return z


def _held(free: State, groups: list[_Group], resting: np.ndarray, x: Vector, slips: np.ndarray) -> Vector:
    """Return the frictions with those of what rests, and mark what slips among it; `free` is without these."""
    chosen = np.concatenate([np.arange(groups[i].where.start, groups[i].where.stop) for i in resting])
    D, n = np.vstack([slip_rows(free, groups[i].number, groups[i].anchor) for i in resting]), free.model.free_count
    shares = np.concatenate([groups[i].anchor.shares for i in resting])
    D, b = shares[:, None] * D, shares * _slip_accelerations(free, groups)[chosen]
    G = D[:, :n] @ LiteralRoute(free.model).responses(free, D[:, :n].T)
    # in the roots of the springs' energies
    root = np.concatenate([np.full(len(groups[i].anchor.slip), np.sqrt(groups[i].anchor.stiffness)) for i in resting])
    stops = np.cumsum([len(groups[i].anchor.slip) for i in resting])
    parts = [slice(stop - len(groups[i].anchor.slip), stop) for i, stop in zip(resting, stops, strict=True)]
    G, b = 0.5 * (G + G.T) * np.outer(root, root), b * root
    size, y = float(np.abs(b).max()), np.zeros(len(b))
    for _ in range(ROUNDS):
        most = np.array([a.slides if slips[i] else a.holds for i in resting for a in (groups[i].anchor,)])
        most = most * np.where(slips[resting], BEYOND, 2.0 - BEYOND) / root[[part.start for part in parts]]
        y = _least(G, b, parts, most, size)
        left = b - G @ y
        new = np.array([np.linalg.norm(left[part]) > BALANCED * size for part in parts], dtype=bool) & ~slips[resting]
        if not new.any():
            break
        slips[resting[new]] = True
    found = x.copy()
    found[chosen] = y * root
    return found


def _slip_accelerations(state: State, groups: list[_Group]) -> Vector:
    """Return the rates of all slips: where something rolls, it touches at other and other points.

    By differences of order 2 from states that follow. What does not touch there counts as at constant rates.
    """
    model, du, found = state.model, LiteralRoute(state.model).accelerations_at(state), np.zeros(groups[-1].where.stop)
    moment = MOMENT / max(1.0, float(np.abs(state.u / displacement_scales(model)).max(initial=0.0)))
    slips = []
    for later in (moment, 2.0 * moment):
        q = model.advance(state.q, later * state.u + 0.5 * later**2 * du)
        moved = State(model, state.t + later, q, state.u + later * du, state.z)
        slips.append({i: load.anchors(moved.load_ends(i), moved.load_states(i)) for i, load in enumerate(model.loads)})
    for number in {group.number for group in groups}:
        own = [group for group in groups if group.number == number]
        if len(own) == len(slips[0][number]) == len(slips[1][number]):
            for group, soon, late in zip(own, slips[0][number], slips[1][number], strict=True):
                found[group.where] = (4.0 * soon.slip - late.slip - 3.0 * group.anchor.slip) / (2.0 * moment)
    return found


def _least(G: Matrix, b: Vector, parts: list[slice], most: Vector, size: float) -> Vector:
    """Return the y of the least ``1/2 y^T G y - b^T y`` whose parts are no larger than `most`; `size` is that of b."""
    values, vectors = np.linalg.eigh(G)
    kept = values > DEPENDENT * float(values[-1])
    y = vectors[:, kept] @ ((vectors[:, kept].T @ b) / values[kept])
    if np.abs(G @ y - b).max() > BALANCED * size or any(
        np.linalg.norm(y[part]) > limit for part, limit in zip(parts, most, strict=True)
    ):
        steps = [max(float(np.linalg.norm(G[part, part], 2)), 1e-300) for part in parts]
        for _ in range(MOST_SWEEPS):  # Gauss and Seidel's iteration, each part onto its ball
            before = y.copy()
            for part, limit, slope in zip(parts, most, steps, strict=True):
                with np.errstate(over="ignore"):  # a drive gives way to no friction
                    new = y[part] + np.clip((b[part] - G[part] @ y) / slope, -1e150, 1e150)
                length = float(np.linalg.norm(new))
                y[part] = new if length <= limit else limit / length * new
            if np.abs(y - before).max() <= SETTLED * float(most.max()):
                break
    return np.asarray(y)
