"""A consistent start: coordinates at which every loop is closed, and speeds that keep it closed.

What is given is kept. What is not given follows with the least motion: joints first, in the metric of the mass matrix;
elastic coordinates only by what joints cannot do, with the least strain energy, as in statics. Where joints that are
not given cannot close the loops, given ones move too, as little as they can, before anything is strained:
`kanefe.equations.start_report` says by how much. A start that is consistent already is left as it is, to the bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import mass_matrix
from kanefe.kernels.constraints.tolerances import CLOSING
from kanefe.literal.loop_closure import Position, StepOf, by_metric, closed, open_constraints, openings
from kanefe.states.constrained_solver import constrained_solver
from kanefe.states.constraints import constraint_rates, held_rows
from kanefe.states.state import State
from kanefe.tree.model_data import ModelData
from kanefe.tree.row_rates import RANK_TOLERANCE, ROUND_OFF, Rates
from kanefe.tree.scales import displacement_scales, modal_frequencies
from kanefe.tree.tangents import elastic_stiffness

HELD_RATE = 100 * CLOSING.tolerance
"""Largest rate of a row that counts as held, relative to what it could be at speeds of such size."""

OPEN_RATE = 1e-6
"""Rate of a row, relative to the same, above which no speeds are consistent. At a singular position coordinates, and
with them the directions of rows, are known to the root of round-off only, 1e-8."""

REFINEMENTS = 3
"""Largest number of solutions for speeds, each of what the one before leaves by round-off or next to a singular
position."""

STIFF = 1e4
"""Stiffness at the lowest frequency over inertia, in the metric in which loops are closed: joints do nearly all.
Afterwards elastic coordinates become those of statics."""

RELAXED = 1e-10
"""Share of the strain energy below which a decrease of it does not count: coordinates are then known to 1e-5."""

SOFT = 1e-8
"""Share of the inertia, as the stiffness at the lowest frequency, that is added to the stiffness of elastic
coordinates: too little to matter, and enough for a coordinate without stiffness."""


Groups = Sequence[np.ndarray]
"""Numbers of free speeds, group by group."""


def consistent_start(model: ModelData, t: float) -> tuple[Vector, Vector]:
    """Return q and u at the start, consistent at time t (s).

    Raises
    ------
    ModelError
        If loops do not close, or no speeds keep them closed; the message names rows and joints.
    """
    q, u = model.initial_coordinates, model.initial_speeds
    if not model.constraints:
        return q, u
    q = _consistent_coordinates(model, t, q)
    _check_facing(model, t, q)
    return q, _consistent_speeds(model, t, q, u)


def _consistent_coordinates(model: ModelData, t: float, q: Vector) -> Vector:
    start = openings(model, t, q)
    if start.worst <= CLOSING.tolerance:
        return q
    stiffness = STIFF / (_lowest_square(model, np.arange(model.free_count)) or 1.0) * elastic_stiffness(model)
    best = start
    for groups in _movable(model, speeds=False):
        # always from the start: where an attempt gave up, joints may have turned far
        step = by_metric(np.concatenate(groups), stiffness)
        found = closed(start, step)
        if found.worst <= CLOSING.tolerance:
            return _relaxed(found, step, groups).state.q
        best = min(best, found, key=lambda position: position.worst)
    raise ModelError(f"the scene cannot be assembled: {_why_open(best)}")


def _lowest_square(model: ModelData, own: np.ndarray) -> float:
    """Return the square of the lowest frequency of modes among some free speeds, 1/s2; 0: there are none."""
    squares = modal_frequencies(model)[own] ** 2
    return float(squares[squares > 0.0].min(initial=np.inf)) if np.any(squares > 0.0) else 0.0


def _relaxed(position: Position, step: StepOf, groups: Groups) -> Position:
    """Return the closed position nearby in which elastic coordinates are as in statics: of the least strain energy."""
    model, n = position.state.model, position.state.model.free_count
    K, bend = elastic_stiffness(model), _bend(position.state)
    for _ in range(CLOSING.largest_iterations):
        energy = float(bend @ K @ bend)
        if energy == 0.0:
            break
        rows = constraint_rates(position.state).over(slice(n), position.rows)
        back = _least_step(position.state, rows, position.residuals, groups, K @ bend)
        found = closed(openings(model, position.state.t, model.advance(position.state.q, back)), step)
        bend = _bend(found.state)
        if found.worst > CLOSING.tolerance or not float(bend @ K @ bend) < (1.0 - RELAXED) * energy:
            break
        position = found
    return position


def _consistent_speeds(model: ModelData, t: float, q: Vector, u: Vector) -> Vector:
    state = State(model, t, q, u)
    rows = constraint_rates(state)
    own = rows.over(slice(model.free_count))
    if _are_held(model, rows, state.full, HELD_RATE):
        return u
    nearly = [u]
    for groups in _movable(model, speeds=True):
        # in tall towers of loops, inertia differs so much that rows are lost in round-off of its metric
        for metric in (_metric, _size):
            found = u
            for _ in range(REFINEMENTS):
                opened = rows.open_rates(model.all_speeds(t, found))
                found = found + _least_step(state, own, opened, groups, metric=metric)
                if _are_held(model, rows, model.all_speeds(t, found), HELD_RATE):
                    return found
            nearly.append(found)
    for found in nearly:
        if _are_held(model, rows, model.all_speeds(t, found), OPEN_RATE):
            return found
    raise ModelError(_why_moving(state, rows, nearly[-1]))


def _are_held(model: ModelData, rows: Rates, full: Vector, tolerance: float) -> bool:
    """Return whether all rows are held at speeds, relative to what they could be at speeds of such size."""
    n, scales = model.free_count, displacement_scales(model)
    fastest = max(1.0, float(np.max(np.abs(full[:n]) / scales, initial=0.0)))
    rest = np.zeros(rows.J.shape[1])
    rest[:n] = n * ROUND_OFF * fastest * scales  # a solution for all speeds leaves round-off of each in every other
    allowed = tolerance * rows.sizes(full[: rows.J.shape[1]]) + rows.sizes(rest)
    return bool(np.all(np.abs(rows.open_rates(full)) <= allowed))


def _movable(model: ModelData, *, speeds: bool) -> Iterator[Groups]:
    """Yield which free speeds may change in each attempt, in groups of which a later one moves less readily.

    Joints that are not given; all joints; then both with elastic coordinates.
    """
    joints: dict[bool, list[int]] = {False: [], True: []}
    elastic: dict[bool, list[int]] = {False: [], True: []}
    for body in model.bodies:
        for at, is_given in zip(body.speeds.tolist(), body.joint.given_start()[speeds], strict=True):
            if at < model.free_count:
                joints[is_given].append(at)
        if body.flexible is not None:
            start = body.flexible.given_deta if speeds else body.flexible.given_eta
            elastic[start is not None] += range(body.flexible.speeds.start, body.flexible.speeds.stop)
    rest, given = joints[False], joints[True]
    bent, kept = elastic[False], elastic[True]
    tried: list[list[list[int]]] = [[]]
    for attempt in ([rest], [rest, given], [rest, bent], [rest, given, bent, kept]):
        groups = [group for group in attempt if group]
        if groups not in tried:  # the same groups twice would fail twice
            tried.append(groups)
            yield [np.array(group) for group in groups]


def _bend(state: State) -> Vector:
    """Return the elastic coordinates from what is given of them, over the free speeds."""
    found = np.zeros(state.model.free_count)
    for body in state.model.bodies:
        if (terms := body.flexible) is not None:
            found[terms.speeds] = state.q[terms.eta] - (0.0 if terms.given_eta is None else terms.given_eta)
    return found


def _least_step(
    state: State,
    rows: Rates,
    opened: Vector,
    groups: Groups,
    strain: Vector | None = None,
    metric: Callable[[State, np.ndarray], Matrix] | None = None,
) -> Vector:
    """Return the displacement of the free speeds, or the change of them, that takes away what is open.

    Each group takes what those before it cannot: joints with the least kinetic energy, elastic coordinates with the
    least strain energy.

    Parameters
    ----------
    state : State
    rows : Rates
        Over the free speeds.
    opened : ndarray, shape (rows,)
    groups : sequence of ndarray of int
        Which of the free speeds may change; what moves most readily is first.
    strain : ndarray, shape (free,), optional
        Elastic forces before: the energy of all strain after the step is then the least, and not that of the step.
    metric : function (state, columns) -> ndarray, optional
        What displacements cost instead.
    """
    model, n = state.model, state.model.free_count
    cost = metric or _metric
    strain = np.zeros(n) if strain is None else strain
    sizes, step = displacement_scales(model), np.zeros(n)
    columns = np.concatenate(groups)
    reach = rows.reach[:, columns] @ sizes[columns] ** 2
    scale = np.divide(1.0, np.sqrt(reach), out=np.zeros_like(reach), where=reach > 0.0)
    for i in reversed(range(1, len(groups))):
        own = groups[i]
        left = _unreached(scale[:, None] * rows.J * sizes, groups[:i])
        theirs = Rates(
            left.T @ (scale[:, None] * rows.J[:, own]),
            np.zeros(left.shape[1]),
            (left**2).T @ (scale[:, None] ** 2 * rows.reach[:, own]),
            np.zeros(left.shape[1]),
        )
        solver = constrained_solver(model, cost(state, own), theirs)
        step[own] = solver.solve(-strain[own], left.T @ (scale * (opened + rows.J @ step)))[0]
    first = groups[0]
    solver = constrained_solver(model, cost(state, first), rows.over(first))
    step[first] = solver.solve(-strain[first], opened + rows.J @ step)[0]
    return step


def _unreached(J: Matrix, groups: Groups) -> Matrix:
    """Return combinations of rows that no displacement in the groups changes, as columns: (rows, combinations)."""
    vectors, lengths, _ = np.linalg.svd(J[:, np.concatenate(groups)])
    least = RANK_TOLERANCE * max(lengths.max(initial=0.0) ** 2, ROUND_OFF)
    return np.asarray(vectors[:, int(np.count_nonzero(lengths**2 > least)) :])


def _metric(state: State, own: np.ndarray) -> Matrix:
    """Return what a displacement of some free speeds costs: inertia, or stiffness of elastic coordinates."""
    model, block = state.model, np.ix_(own, own)
    M = mass_matrix(state)[block]
    lowest = _lowest_square(model, own)
    return elastic_stiffness(model)[block] + SOFT * lowest * M if lowest else M


def _size(state: State, own: np.ndarray) -> Matrix:
    """Return the metric of the sizes of displacements."""
    return np.diag(displacement_scales(state.model)[own] ** -2.0)


def _why_moving(state: State, rows: Rates, u: Vector) -> str:
    """Return which rows no speeds hold, and which driven joints move them."""
    model, full = state.model, state.model.all_speeds(state.t, u)
    open_rates, sizes = np.abs(rows.open_rates(full)), rows.sizes(full[: rows.J.shape[1]])
    worst = int(np.divide(open_rates, sizes, out=np.zeros_like(sizes), where=sizes > 0.0).argmax())
    constraint, row = held_rows(state)[worst]
    moving = [
        body.name
        for body in model.bodies
        if body.is_driven and np.any(rows.J[worst, body.speeds[list(body.driven)]] != 0.0)
    ]
    drives = f" driven joint of {', '.join(map(repr, moving))}" if moving else " given speeds"
    return (
        f"no speeds at the start keep the loops closed: {constraint.title} opens at {open_rates[worst]:.3g} "
        f"{row.unit}/s ({row.label}) by the{drives}. Remedy: a motion that the mechanism can follow from there, or "
        "another position at the start"
    )


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
    step = by_metric(np.arange(model.free_count), elastic_stiffness(model))
    for name in dict.fromkeys(names[turning].tolist()):
        kept = position.rows[~(turning & (names == name))]
        found = closed(openings(model, state.t, start, state.z, kept), step)
        if found.worst <= CLOSING.tolerance:
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
