"""Closed loops of scenes with unreduced bodies: at the start, and after each step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.constraints.rows import METRE
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Vector
from kanefe.kernels.constraints.tolerances import CLOSING
from kanefe.literal.consistent_start import consistent_start
from kanefe.states.constraints import constraint_rates, constraint_residuals, held_rows
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import scene_length
from kanefe.unreduced.condensed import Condensed, FrozenMoments
from kanefe.unreduced.demand import some_inertia

if TYPE_CHECKING:
    from kanefe.unreduced.bordered import Bordered

LARGEST_ITERATIONS = 8


def closed_start(model: ModelData, t: float) -> tuple[Vector, Vector]:
    """Return q and u at the start, consistent with the loops at time t (s); unreduced bodies keep their shape.

    Raises
    ------
    ModelError
        If a loop cannot be closed by the joints and the other bodies alone.
    """
    condensed = Condensed(model, is_complete=True)
    q, u = model.initial_coordinates, model.initial_speeds
    moments = []
    for substructure in condensed.substructures:
        metric = some_inertia(substructure, q[substructure.eta])
        moments.append(FrozenMoments(metric, np.zeros(len(metric))))
    twin = condensed.with_moments(moments)
    q_s, u_s = consistent_start(twin, t)
    for substructure in condensed.substructures:
        d, rates = substructure.d, substructure.rates
        if np.any(q_s[d] != twin.initial_coordinates[d]) or np.any(u_s[rates] != twin.initial_speeds[rates]):
            raise ModelError(
                f"the loops of the scene close only if the unreduced body {model.bodies[substructure.number].name!r} "
                "is deformed at the start. Remedy: start nearer to the closed position, or "
                "reduction=CraigBampton()"
            )
    if q_s is twin.initial_coordinates and u_s is twin.initial_speeds:
        return q, u
    q, u = q.copy(), u.copy()
    q[condensed.plain_coordinates] = q_s[condensed.plain_places]
    u[condensed.plain_speeds] = u_s[condensed.plain_rates]
    return q, u


def closed_state(condensed: Condensed, t: float, q: Vector, u: Vector, bordered: Bordered) -> tuple[Vector, Vector]:
    """Return the state near (q, u) with its loops closed, the nearest in the metric of the iteration.

    Raises
    ------
    SimulationError
        If a loop stays open.
    """
    small, model = condensed.small, condensed.model
    length = scene_length(model)
    last = np.inf
    for _ in range(LARGEST_ITERATIONS):
        state = condensed.state(t, q, u)
        g = constraint_residuals(state)
        scales = np.array([length if row.unit == METRE else 1.0 for _, row in held_rows(state)])
        worst = float(np.abs(g / scales).max(initial=0.0))
        if worst <= CLOSING.tolerance or worst >= last:
            break
        last = worst
        step = bordered.solve(np.zeros(small.free_count), None, g)
        q = model.advance(q, condensed.joined(step.z, step.parts))
    if worst > CLOSING.largest_opening:
        raise SimulationError(
            f"at t = {t:.6g} s the mechanism cannot continue: a loop stays open by {worst:.3g} of its size. "
            "Remedy: check that driven joints stay within its reach"
        )
    for _ in range(LARGEST_ITERATIONS):
        state = condensed.state(t, q, u)
        rows = constraint_rates(state)
        open_rates = rows.J @ state.full[: rows.J.shape[1]]
        sizes = rows.sizes(state.full[: rows.J.shape[1]])
        if np.all(np.abs(open_rates) <= 100 * CLOSING.tolerance * sizes):
            break
        step = bordered.solve(np.zeros(small.free_count), None, open_rates)
        u = u + condensed.joined(step.z, step.parts)
    return q, u
