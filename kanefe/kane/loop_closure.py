"""A consistent state: coordinates at which every loop is closed, and speeds that keep it closed.

Both are the nearest ones: the change is least in the metric of the mass matrix. A start that is consistent already is
left as it is, to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import constrained_solver, mass_matrix
from kanefe.kane.constraints import constraint_rates, constraint_residuals, held_rows, place_rows
from kanefe.kane.state import State
from kanefe.kane.tangents import elastic_stiffness
from kanefe.kernels.constraints.tolerances import (
    LARGEST_ITERATIONS,
    LARGEST_OPENING,
    LARGEST_STEP,
    MOST_HALVINGS,
    TOLERANCE,
)
from kanefe.tree.model_data import ModelData
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


def consistent_start(model: ModelData, t: float) -> tuple[Vector, Vector]:
    """Return q and u at the start, consistent at time t (s): see `kanefe.equations.start.model_at_start`."""
    q, u = model.initial_coordinates, model.initial_speeds
    if not model.constraints:
        return q, u
    best = openings(model, t, q)
    if best.worst > TOLERANCE:
        for columns in _movable(model):
            # K times 1 s2: elastic coordinates move as in statics
            found = _closed(openings(model, t, q), columns, elastic_stiffness(model))
            if found.worst <= TOLERANCE:
                q = found.state.q
                break
            best = min(best, found, key=lambda position: position.worst)
        else:
            raise ModelError(f"the scene cannot be assembled: {_why_open(best)}")
    _check_facing(model, t, q)
    return q, _consistent_speeds(model, t, q, u)


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
    found = _closed(_position(state), np.arange(model.free_count), metric, last_digit)
    if found.worst > LARGEST_OPENING:
        raise SimulationError(
            f"at t = {state.t:.6g} s the mechanism cannot continue: {open_constraints(found)}. "
            "Remedy: check that driven joints stay within its reach"
        )
    return found.state.q


def closed_coordinates(model: ModelData, t: float, q: Vector) -> Vector | None:
    """Return the coordinates near q at which the loops are closed at time t (s), switched as at the start; or None."""
    n = model.free_count
    found = _closed(openings(model, t, q), np.arange(n), np.zeros((n, n)))
    return found.state.q if found.worst <= TOLERANCE else None


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


def _closed(position: Position, columns: np.ndarray, stiffness: Matrix, tolerance: float = TOLERANCE) -> Position:
    """Return the position after Newton's iteration over some of the free speeds."""
    model = position.state.model
    n = model.free_count
    if not len(columns):
        return position
    length = scene_length(model)
    limits = LARGEST_STEP * joint_scales(model, length)[columns]
    for _ in range(LARGEST_ITERATIONS):
        if position.worst <= tolerance:
            break
        rows = constraint_rates(position.state).over(columns, position.rows)
        metric = (mass_matrix(position.state)[:n, :n] + stiffness)[np.ix_(columns, columns)]
        step, _ = constrained_solver(model, metric, rows).solve(np.zeros(len(columns)), position.residuals)
        step *= min(1.0, 1.0 / max(float(np.max(np.abs(step) / limits)), 1e-300))
        better = _shortened(columns, step, position)
        if better is None:
            break
        # closed but for round-off, which gets less by chance: Newton's method would have taken away nearly all
        has_settled = better.worst <= TOLERANCE and better.worst > 0.5 * position.worst
        position = better
        if has_settled:
            break
    return position


def _shortened(columns: np.ndarray, step: Vector, position: Position) -> Position | None:
    """Return the position after the step, halved until the loops open less than before; None if no step does that."""
    state, before = position.state, float(position.openings @ position.openings)
    full = np.zeros(state.model.free_count)
    # what is closed but for round-off gets better by a whole step or not at all
    for _ in range(MOST_HALVINGS if position.worst > TOLERANCE else 1):
        full[columns] = step
        found = openings(state.model, state.t, state.model.advance(state.q, full), state.z, position.rows)
        if float(found.openings @ found.openings) < before:
            return found
        step = 0.5 * step
    return None


def _movable(model: ModelData) -> list[np.ndarray]:
    """Return the free speeds that may move in each attempt: joints without a given start, joints, everything."""
    joints = [body.speeds[body.speeds < model.free_count] for body in model.bodies]
    starts = [np.array_equal(body.joint.initial_coordinates(), body.joint.home()) for body in model.bodies]
    unset = [columns for columns, is_unset in zip(joints, starts, strict=True) if is_unset]
    stages = [np.concatenate([*unset, np.zeros(0, dtype=int)]), np.concatenate(joints), np.arange(model.free_count)]
    # the same set twice would fail twice
    return [stage for i, stage in enumerate(stages) if len(stage) and (i == 0 or len(stage) > len(stages[i - 1]))]


def _consistent_speeds(model: ModelData, t: float, q: Vector, u: Vector) -> Vector:
    """Return consistent speeds: those that are given (not zero) stay, and elastic ones, if the others can follow."""
    state = State(model, t, q, u)
    full, rows = state.full, constraint_rates(state)
    sizes = rows.sizes(full[: rows.J.shape[1]])
    open_rates = rows.J @ full[: rows.J.shape[1]]
    if np.all(np.abs(open_rates) <= 100 * TOLERANCE * sizes):
        return u
    joints = np.concatenate([body.speeds[body.speeds < model.free_count] for body in model.bodies])
    M = mass_matrix(state)
    for columns in (joints[u[joints] == 0.0], joints):
        followed = u.copy()
        solver = constrained_solver(model, M[np.ix_(columns, columns)], rows.over(columns))
        followed[columns] += solver.solve(np.zeros(len(columns)), open_rates)[0]
        if np.all(np.abs(rows.J @ model.all_speeds(t, followed)[: rows.J.shape[1]]) <= 1e-9 * sizes):
            return followed
    return project_speeds(model, t, q, u)


def _check_facing(model: ModelData, t: float, q: Vector) -> None:
    state = State(model, t, q)
    for constraint in model.constraints:
        if constraint.a is None or constraint.b is None or not constraint.holds(state.z):
            continue
        A_ab = state.marker(constraint.a).A_NF.T @ state.marker(constraint.b).A_NF
        if any(axis @ A_ab @ axis < 0.0 for axis in constraint.facing):
            raise ModelError(
                f"{constraint.title} closes with the axes of its ends opposite to each other. "
                "Remedy: turn one end by half a turn, frame(orientation=...), or start nearer to the closed position"
            )


def _why_open(position: Position) -> str:
    """Return why the scene cannot be closed from where the search for it ended, and a remedy.

    Where Newton's method gives up, an axis that cannot hold has torn the ends apart: what closes once the directions of
    one constraint are let go is not a matter of lengths.
    """
    from kanefe.constraints.rows import METRE

    state = position.state
    model, start = state.model, state.model.initial_coordinates
    held = held_rows(state)
    turning = np.array([held[i][1].unit != METRE for i in position.rows], dtype=bool)
    names = np.array([held[i][0].name for i in position.rows])
    stiffness, everything = elastic_stiffness(model), np.arange(model.free_count)
    for name in dict.fromkeys(names[turning].tolist()):
        kept = position.rows[~(turning & (names == name))]
        found = _closed(openings(model, state.t, start, state.z, kept), everything, stiffness)
        if found.worst <= TOLERANCE:
            left = openings(model, state.t, found.state.q, state.z)
            worst = int(np.abs(left.openings).argmax())
            constraint, row = held[left.rows[worst]]
            return (
                f"{constraint.title} closes but for its axis, which is off by {abs(left.residuals[worst]):.3g} "
                f"{row.unit} ({row.label}) where all else is closed. Remedy: another axis of the joint, ends turned by "
                "frame(orientation=...), or a joint that leaves that direction free"
            )
    return (
        f"{open_constraints(position)}. "
        "Remedy: start nearer to the closed position, or check lengths, axes and where the ends are"
    )


def open_constraints(position: Position) -> str:
    """Return the names of open constraints and by how much they are, the worst first."""
    worst: dict[str, tuple[float, str]] = {}
    rows = (held_rows(position.state)[i] for i in position.rows)
    for (constraint, row), size, g in zip(rows, np.abs(position.openings), position.residuals, strict=True):
        if size > max(TOLERANCE, worst.get(constraint.name, (0.0, ""))[0]):
            text = f"{constraint.title} stays open by {abs(g):.3g} {row.unit} ({row.label})"
            worst[constraint.name] = float(size), text
    found = sorted(worst.values(), reverse=True)
    more = f" and {len(found) - 3} more" if len(found) > 3 else ""
    return "; ".join(text for _, text in found[:3]) + more
