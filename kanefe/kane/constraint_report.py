"""Which constraints of a scene depend on each other: for good, or where the scene starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.frames import Vector
from kanefe.kane.assemble import all_speeds, constrained_solver, mass_matrix
from kanefe.kane.constraints import RANK_TOLERANCE, constraint_rates
from kanefe.kane.kinematics import sweep_outward
from kanefe.kane.loop_closure import closed_coordinates
from kanefe.tree.model_data import ModelData

STEPS = (0.1, 0.03, 0.01, 0.001)
"""How far from the start the rank is looked at again, in rad, m or units of a mode: the first that the loops allow."""


@dataclass(frozen=True)
class ConstraintReport:
    """Rows of the constraints that count, and those that do not. ``print(report)`` says it in words.

    Attributes
    ----------
    constraints, rows : int
        How many there are in the scene.
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
        Rows that depend on others at the start only: there the mechanism may go on in more than one way.
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
                "singular start, the mechanism may go on in more than one way: rows that depend on others there only: "
                + "; ".join(self.singular)
            )
        return "\n".join(lines)


def constraint_report(model: ModelData, t: float = 0.0) -> ConstraintReport:
    """Return which rows of the constraints of a model depend on others at its start, at time t (s), and beside it."""
    q, u = model.initial_coordinates, model.initial_speeds
    names = [f"{constraint.name}: {row.label}" for constraint in model.constraints for row in constraint.rows]
    at_start = _dependent_rows(model, t, q, u)
    beside = _dependent_rows(model, t, _coordinates_beside(model, t, q, u), u) & at_start
    rank = len(names) - len(beside)
    whole, number = [], 0
    for constraint in model.constraints:
        numbers = set(range(number, number + len(constraint.rows)))
        number += len(constraint.rows)
        if numbers <= beside:
            whole.append(constraint.name)
    return ConstraintReport(
        constraints=len(model.constraints),
        rows=len(names),
        rank=rank,
        degrees_of_freedom=model.free_count - rank,
        redundant=tuple(names[i] for i in sorted(beside)),
        redundant_constraints=tuple(whole),
        singular=tuple(names[i] for i in sorted(at_start - beside)),
    )


def _dependent_rows(model: ModelData, t: float, q: Vector, u: Vector) -> set[int]:
    """Return the numbers of the rows that depend on rows before them."""
    full = all_speeds(model, t, u)
    motions = sweep_outward(model, t, q, full)
    n = model.free_count
    rows = constraint_rates(model, motions, q, full).over(slice(n))
    directions = constrained_solver(model, mass_matrix(model, motions, q, full)[:n, :n], rows).scaled_rows
    kept: list[Vector] = []
    dependent = set()
    for i, direction in enumerate(directions):
        rest = direction
        for _ in range(2):  # twice is enough against round-off (Kahan, Parlett)
            for other in kept:
                rest = rest - (other @ rest) * other
        size = float(np.linalg.norm(rest))
        if size <= np.sqrt(RANK_TOLERANCE):
            dependent.add(i)
        else:
            kept.append(rest / size)
    return dependent


def _coordinates_beside(model: ModelData, t: float, q: Vector, u: Vector) -> Vector:
    """Return closed coordinates a little away from q, in no special direction; q itself if nothing can move."""
    full = all_speeds(model, t, u)
    motions = sweep_outward(model, t, q, full)
    n = model.free_count
    rows = constraint_rates(model, motions, q, full).over(slice(n))
    solver = constrained_solver(model, mass_matrix(model, motions, q, full)[:n, :n], rows)
    wish = np.random.default_rng(0).standard_normal(n)
    allowed = wish + solver.solve(np.zeros(n), rows.J @ wish)[0]
    size = float(np.abs(allowed).max(initial=0.0))
    if size <= 1e-9:
        return q
    for step in STEPS:
        closed = closed_coordinates(model, t, model.advance(q, step / size * allowed))
        if closed is not None:
            return closed
    return q
