"""The nearest consistent state: coordinates at which every loop is closed, and speeds that keep it closed.

The change is least in the metric of the mass matrix. How a scene starts is in `kanefe.literal.consistent_start`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import mass_matrix
from kanefe.kernels.constraints.tolerances import CLOSING
from kanefe.states.constrained_solver import constrained_solver
from kanefe.states.constraints import constraint_rates, constraint_residuals, held_rows, place_rows
from kanefe.states.state import State
from kanefe.tree.model_data import ModelData
from kanefe.tree.row_rates import RANK_TOLERANCE
from kanefe.tree.scales import joint_scales, scene_length

CONTACT_TOLERANCE = 1e-15
"""Largest gap of a rigid contact that touches, relative to the scene's length, if no other loop is closed. It has no
singular positions that would magnify it."""


@dataclass(slots=True)
class Position:
    """Residuals of the rows that hold places, `rows`, in a state at rest, and what makes them large."""

    state: State
    rows: np.ndarray
    residuals: Vector
    scales: Vector

    @property
    def openings(self) -> Vector:
        """Residuals, of the scene's length or in rad."""
        return self.residuals / self.scales

    @property
    def worst(self) -> float:
        """The largest of them."""
        return float(np.abs(self.openings).max(initial=0.0))


StepOf = Callable[[Position, float], Vector]
"""Function of a position, and of the eigenvalue below which rows depend on others, relative to the largest: returns the
next displacement of all free speeds."""


def project_positions(
    model: ModelData, t: float, q: Vector, stiffness: Matrix | None = None, z: Vector | None = None
) -> Vector:
    """Return the coordinates nearest to q at which the loops are closed, to the last digit that Newton's method gives.

    Beside a singular position a small opening acts like one divided by the third power of the distance from it, so
    that less than the last digit would hold up the integration there.

    Parameters
    ----------
    model : ModelData
    t : float
        s.
    q : ndarray, shape (coordinates,)
    stiffness : ndarray, shape (free, free), optional
        Added to M in the metric. Stiff modes, which M alone would move, then stay where they are.
    z : ndarray, shape (states,), optional
        Internal states, of which the switches say which constraints hold; default: those of the start.

    Raises
    ------
    SimulationError
        If a loop stays open: a drive moves past the reach of the mechanism.
    """
    return _positioned(State(model, t, q, None, z), stiffness) if model.is_constrained else q


def _positioned(state: State, stiffness: Matrix | None) -> Vector:
    """Return the coordinates of `project_positions`; those of the state itself if they are closed."""
    model = state.model
    metric = np.zeros((model.free_count, model.free_count)) if stiffness is None else stiffness
    last_digit = 0.0 if model.constraints else CONTACT_TOLERANCE
    found = closed(_position(state), by_metric(np.arange(model.free_count), metric), last_digit)
    if found.worst > CLOSING.largest_opening:
        raise SimulationError(
            f"at t = {state.t:.6g} s the mechanism cannot continue: {open_constraints(found)}. "
            "Remedy: check that driven joints stay within its reach"
        )
    return found.state.q


def closed_coordinates(model: ModelData, t: float, q: Vector) -> Vector | None:
    """Return the coordinates near q at which the loops are closed at time t (s), switched as at the start; or None."""
    n = model.free_count
    found = closed(openings(model, t, q), by_metric(np.arange(n), np.zeros((n, n))))
    return found.state.q if found.worst <= CLOSING.tolerance else None


def project_speeds(
    model: ModelData, t: float, q: Vector, u: Vector, stiffness: Matrix | None = None, z: Vector | None = None
) -> Vector:
    """Return the speeds nearest to u that keep the loops closed and what rolls from slipping; arguments as above."""
    return _with_speeds(State(model, t, q, u, z), stiffness) if model.is_constrained and len(u) else u


def _with_speeds(state: State, stiffness: Matrix | None) -> Vector:
    model, u = state.model, state.u
    rows = constraint_rates(state)
    if not len(rows.J):
        return u
    n = model.free_count
    M = mass_matrix(state)[:n, :n]
    solver = constrained_solver(model, M if stiffness is None else M + stiffness, rows.over(slice(n)))
    return np.asarray(u + solver.solve(np.zeros(n), rows.open_rates(state.full))[0])


def project(state: State, stiffness: Matrix | None = None) -> State:
    """Return the nearest state at which loops are closed and stay closed: see `project_positions`, `project_speeds`.

    A state that is closed is swept once for both.
    """
    q = _positioned(state, stiffness)
    state = state if q is state.q else State(state.model, state.t, q, state.u, state.z)
    u = _with_speeds(state, stiffness) if len(state.u) else state.u
    return state if u is state.u else State(state.model, state.t, q, u, state.z)


def openings(
    model: ModelData, t: float, q: Vector, z: Vector | None = None, rows: np.ndarray | None = None
) -> Position:
    """Return how far the constraints that hold are open at time t (s), all rows of places or some of them."""
    return _position(State(model, t, q, None, z), rows)


def _position(state: State, rows: np.ndarray | None = None) -> Position:
    from kanefe.constraints.rows import METRE

    rows = place_rows(state) if rows is None else rows
    # far from N's origin round-off is that of the distance
    length = max(scene_length(state.model), *(float(np.abs(motion.p_NoFo_N).max()) for motion in state.motions))
    scales = np.array([length if held_rows(state)[i][1].unit == METRE else 1.0 for i in rows])
    return Position(state, rows, constraint_residuals(state)[rows], scales)


def by_metric(columns: np.ndarray, stiffness: Matrix) -> StepOf:
    """Return the step of some of the free speeds that closes the loops and is least in the metric of M + stiffness."""

    def step(position: Position, least: float) -> Vector:
        state = position.state
        n = state.model.free_count
        full = np.zeros(n)
        if len(columns):
            rows = constraint_rates(state).over(columns, position.rows)
            metric = (mass_matrix(state)[:n, :n] + stiffness)[np.ix_(columns, columns)]
            solver = constrained_solver(state.model, metric, rows)
            full[columns] = solver.solve(np.zeros(len(columns)), position.residuals, least)[0]
        return full

    return step


def closed(position: Position, step_of: StepOf, tolerance: float = CLOSING.tolerance) -> Position:
    """Return the position after Newton's iteration by steps of the free speeds."""
    model = position.state.model
    limits = CLOSING.largest_step * joint_scales(model, scene_length(model))
    for _ in range(CLOSING.largest_iterations):
        if position.worst <= tolerance:
            break
        # what seems to depend on others, and stays open where these are closed, does not
        for least in (min(CLOSING.unknown * position.worst**2, CLOSING.largest_unknown), RANK_TOLERANCE):
            step = step_of(position, least)
            step *= min(1.0, 1.0 / max(float(np.max(np.abs(step) / limits, initial=0.0)), 1e-300))
            better = _shortened(step, position)
            if better is not None or least <= RANK_TOLERANCE:
                break
        if better is None:
            break
        # closed but for round-off, which gets less by chance: Newton's method would have taken away nearly all
        has_settled = better.worst <= CLOSING.tolerance and better.worst > 0.5 * position.worst
        position = better
        if has_settled:
            break
    return position


def _shortened(step: Vector, position: Position) -> Position | None:
    """Return the position after the step, halved until the loops open less than before; None if no step does that."""
    state, before = position.state, float(position.openings @ position.openings)
    # what is closed but for round-off gets better by a whole step or not at all
    for _ in range(CLOSING.most_halvings if position.worst > CLOSING.tolerance else 1):
        found = openings(state.model, state.t, state.model.advance(state.q, step), state.z, position.rows)
        if float(found.openings @ found.openings) < before:
            return found
        step = 0.5 * step
    return None


def open_constraints(position: Position) -> str:
    """Return the names of open constraints and by how much they are, the worst first."""
    worst: dict[str, tuple[float, str]] = {}
    rows = (held_rows(position.state)[i] for i in position.rows)
    for (constraint, row), size, g in zip(rows, np.abs(position.openings), position.residuals, strict=True):
        if size > max(CLOSING.tolerance, worst.get(constraint.name, (0.0, ""))[0]):
            text = f"{constraint.title} stays open by {abs(g):.3g} {row.unit} ({row.label})"
            worst[constraint.name] = float(size), text
    found = sorted(worst.values(), reverse=True)
    more = f" and {len(found) - 3} more" if len(found) > 3 else ""
    return "; ".join(text for _, text in found[:3]) + more
