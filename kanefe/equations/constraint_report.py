"""Which constraints of a scene depend on each other: for good, or where the scene starts."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.equations.dependent_rows import dependent_rows
from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.literal.loop_closure import closed_coordinates
from kanefe.states.constrained_solver import ConstrainedSolver, constrained_solver
from kanefe.states.constraints import constraint_rates, held_rows
from kanefe.states.state import State
from kanefe.tree.model_data import ModelData
from kanefe.tree.route import Route
from kanefe.tree.scales import displacement_scales, modal_frequencies

STEPS = (0.1, 0.03, 0.01, 0.001)
"""Distances from the start at which the rank is computed again, in rad or scene lengths: the first that the loops
permit."""


@dataclass(frozen=True)
class ConstraintReport:
    """Rows of the constraints that count, and those that do not. ``print(report)`` says it in words.

    Attributes
    ----------
    constraints, rows : int
        How many hold at the start.
    rank : int
        Rows that do not depend on others, near the start.
    degrees_of_freedom : int
        Free speeds that are left.
    redundant : tuple of str
        Rows that say what earlier rows say, each as ``constraint: row``. They do no harm; forces are shared among
        dependent rows with least norm.
    redundant_constraints : tuple of str
        Constraints all of whose rows are redundant.
    singular : tuple of str
        Rows that depend on others at the start only: there the mechanism may continue in more than one way.
    """

    constraints: int
    rows: int
    rank: int
    degrees_of_freedom: int
    redundant: tuple[str, ...]
    redundant_constraints: tuple[str, ...]
    singular: tuple[str, ...]

    @property
    def is_singular(self) -> bool:
        """Whether the rank drops at the start."""
        return len(self.singular) > 0

    def __str__(self) -> str:
        lines = [
            f"constraints: {self.constraints}, rows: {self.rows}, rank: {self.rank}, "
            f"degrees of freedom left: {self.degrees_of_freedom}"
        ]
        if self.redundant:
            lines.append(f"redundant rows, {len(self.redundant)}: " + "; ".join(self.redundant))
        if self.redundant_constraints:
            lines.append("wholly redundant: " + ", ".join(self.redundant_constraints))
        if self.singular:
            lines.append(
                "singular start, the mechanism may continue in more than one way: rows that depend on others there "
                "only: " + "; ".join(self.singular)
            )
        return "\n".join(lines)


def constraint_report(route: Route, t: float = 0.0) -> ConstraintReport:
    """Return which rows of the constraints of a model depend on others at its start, at time t (s), and beside it."""
    model = route.model
    start = State(model, t, model.initial_coordinates, model.initial_speeds)
    names = _names(start)
    held = [constraint for constraint in model.constraints if constraint.holds(start.z)]
    solver = _solver(start, route)
    at_start = _dependent_rows(start, solver)
    beside = at_start
    if at_start:  # what depends on nothing here does not do so beside it either
        there = State(model, t, _coordinates_beside(start, solver, route), start.u)
        beside = _dependent_rows(there, _solver(there, route)) & at_start
    rank = len(names) - len(beside)
    whole, number = [], 0
    for constraint in held:
        numbers = set(range(number, number + len(constraint.rows)))
        number += len(constraint.rows)
        if numbers <= beside:
            whole.append(constraint.name)
    return ConstraintReport(
        constraints=len(held),
        rows=len(names),
        rank=rank,
        degrees_of_freedom=model.free_count - rank,
        redundant=tuple(names[i] for i in sorted(beside)),
        redundant_constraints=tuple(whole),
        singular=tuple(names[i] for i in sorted(at_start - beside)),
    )


_redundant: WeakKeyDictionary[ModelData, tuple[bytes, set[int]]] = WeakKeyDictionary()


def singular_rows(state: State, route: Route) -> tuple[str, ...]:
    """Return the rows that depend on others in a state, but not beside it, each as ``constraint: row``.

    The mass matrix comes from the route.

    Which rows are redundant is found beside the first state of a scene that is asked about, and kept for others with
    the same internal states: wherever a mechanism moves from there, its rank is the same but at singular positions.
    """
    model, switches = state.model, state.z.tobytes()
    solver = _solver(state, route)
    here = _dependent_rows(state, solver)
    before = _redundant.get(model)
    if not here or (before is not None and before[0] == switches and here <= before[1]):
        return ()
    q = _coordinates_beside(state, solver, route)
    if q is state.q:  # nothing is known of a mechanism that cannot move
        return ()
    there = State(model, state.t, q, state.u)
    beside = _dependent_rows(there, _solver(there, route))
    _redundant[model] = switches, beside
    return tuple(_names(state)[i] for i in sorted(here - beside))


def _names(state: State) -> list[str]:
    return [f"{constraint.name}: {row.label}" for constraint, row in held_rows(state)]


def _solver(state: State, route: Route) -> ConstrainedSolver:
    n = state.model.free_count
    M = route.mass_matrix(state.t, np.concatenate((state.q, state.u, state.z)))[:n, :n]
    return constrained_solver(state.model, M, constraint_rates(state).over(slice(n)))


def _dependent_rows(state: State, solver: ConstrainedSolver) -> set[int]:
    """Return the numbers of the rows that depend on rows before them."""
    return dependent_rows(solver.scaled_rows, constraint_rates(state).J[:, : state.model.free_count])


def _sizes(model: ModelData) -> Vector:
    """Return a large displacement along every free speed; of modes the less, the more they bend for it."""
    frequencies = modal_frequencies(model)
    modes = frequencies[frequencies > 0.0]
    return np.asarray(displacement_scales(model) / np.clip(frequencies / modes.min(initial=np.inf), 1.0, 1e6))


def _coordinates_beside(state: State, solver: ConstrainedSolver, route: Route) -> Vector:
    """Return closed coordinates a little away from those of a state, in no special direction; the same if stuck."""
    model, q, n = state.model, state.q, state.model.free_count
    rows = constraint_rates(state).over(slice(n))
    scales = _sizes(model)
    wish = scales * np.random.default_rng(0).standard_normal(n)
    allowed = wish + solver.solve(np.zeros(n), rows.J @ wish)[0]
    size = float(np.abs(allowed / scales).max(initial=0.0))
    if size <= 1e-9:
        return q
    for step in STEPS:
        closed = _closed(state, model.advance(q, step / size * allowed), route)
        if closed is not None:
            return closed
    return q


def _closed(state: State, q: Vector, route: Route) -> Vector | None:
    """Return the coordinates near q at which the loops are closed, or None."""
    model, t = state.model, state.t
    if model.rigid_contacts:  # the compiled route closes loops alone
        return closed_coordinates(model, t, q)
    try:
        return model.parts(route.projected(t, np.concatenate((q, state.u, state.z))))[0]
    except SimulationError:
        return None
