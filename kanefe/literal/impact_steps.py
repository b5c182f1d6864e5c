"""A step of Moreau and Jean over whatever happens in it: impulses of rigid contacts in the place of forces and impacts.

    q_M = q_A + h/2 u_A,    M (u_E - u_A) = h F + W I,    q_E = q_M + h/2 u_E

with M, F and W at the midpoint, where also the contacts are found that are closed. Their impulses I solve the
complementarity of ``v_E + e v_A`` along the normal and v_E across it (Moreau, "Unilateral contact and dry friction in
finite freedom dynamics", 1988; Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257), and never make energy: see
`kanefe.kernels.impacts.step_impulses`. F is taken at the speeds of the middle of the step without impulses: between
impacts a step is of order 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.contact.rigid.rigid_contact import OPEN, REPORTED_CHANGES, SLIPPING, SLIPS, STICKS, TAKEN
from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import accelerations
from kanefe.kane.energy import dissipated_power, drive_power, load_power
from kanefe.kernels.impacts.tolerances import ROUND_OFF_OF_FORCES
from kanefe.literal.contact_forces import probe_jacobian
from kanefe.literal.impulses import unit_responses
from kanefe.literal.loop_closure import project_positions, project_speeds
from kanefe.states.constraints import meetings
from kanefe.states.state import State
from kanefe.tree.contact_steps import Stepped, struck
from kanefe.tree.model_data import QUADRATURES, ModelData
from kanefe.tree.rigid_points import points_of_contacts

if TYPE_CHECKING:
    from kanefe.contact.rigid.meeting import Meeting


def stepped(model: ModelData, t: float, y: Vector, h: float) -> Stepped:
    """Return the state after a step of h (s) from time t (s).

    Raises
    ------
    SimulationError
        If the impulses of contacts were not found.
    """
    q, u, z = (part.copy() for part in model.parts(y))
    for load in model.rigid_contacts:
        where = model.load_states[load]
        z[where.start + REPORTED_CHANGES : where.stop] = OPEN  # also from how deep a point left, and its slip: none
    z_open = z.copy()
    n, q_mid = model.free_count, model.advance(q, 0.5 * h * u)
    first = State(model, t + 0.5 * h, q_mid, u, z_open)
    state = State(model, t + 0.5 * h, q_mid, u + 0.5 * h * accelerations(first), z_open)
    du = accelerations(state)
    u_after, quadratures = u + h * du, h * _powers(state, du)
    keys = points_of_contacts(model)
    points = [p for p, (c, i) in enumerate(keys) if meetings(first)[c][i].gap <= 0.0]
    closed = [keys[p] for p in points]
    impulses, depth, residual, approach, bend, lowered = np.zeros(0), 0.0, 0.0, 0.0, 0.0, 0.0
    if closed:
        rows = np.vstack([probe_jacobian(first, c, i) for c, i in closed])
        J, met = rows[:, :n], [meetings(first)[c][i] for c, i in closed]
        before = np.concatenate([one.rates for one in met])
        freely = before + h * (J @ du)
        G = J @ unit_responses(first, J.T)
        found = struck(model, points, G, before, freely)
        if found is None:
            raise SimulationError(
                f"at t = {t:.6g} s the impulses of {len(closed)} contacts were not found. Remedy: a smaller step, less "
                "friction, or compliant contacts, kanefe.HuntCrossley(...)"
            )
        impulses, residual, lowered = found
        u_after = u_after + unit_responses(first, (J.T @ impulses)[:, None])[:, 0]
        after = freely + G @ impulses
        depth, approach = -min(one.gap for one in met), h * max(0.0, -float(before[::3].min()))
        bend = 0.5 * h * h * _largest_curve(first, met, rows)
        fastest = max(float(np.abs(before).max()), float(np.abs(freely).max()))
        _write(first, closed, impulses, 0.5 * (before + after), after, fastest, h, z, quadratures)
    q_end = model.advance(q_mid, 0.5 * h * u_after)
    if model.constraints:
        q_end = project_positions(model, t + h, q_end, None, z_open)
        u_after = project_speeds(model, t + h, q_end, u_after, None, z_open)
    y_end = np.concatenate((q_end, u_after, z, y[-QUADRATURES:] + quadratures))
    return Stepped(y_end, impulses, closed, depth, residual, approach, bend, int(lowered))


def _largest_curve(state: State, met: Sequence[Meeting], rows: Matrix) -> float:
    """Return the largest acceleration of contact points into their surfaces that comes from speeds and drives, m/s2."""
    own = np.array([one.remainder[0] for one in met])
    return float(np.abs(own + rows[::3, state.model.free_count :] @ state.driven_rates).max())


def _powers(state: State, du: Vector) -> Vector:
    """Return the power that dampers take and that loads and drives give, W."""
    return np.array((dissipated_power(state), load_power(state) + drive_power(state, du)))


def _write(
    state: State,
    closed: list[tuple[int, int]],
    impulses: Vector,
    mean: Vector,
    after: Vector,
    fastest: float,
    h: float,
    z: Vector,
    quadratures: Matrix,
) -> None:
    """Write what contacts did in a step to their states, and the energy that they took to the books.

    Impulses and speeds count from the residual on to which the problem is solved, of the largest; of speeds these are
    also those that impulses take, so that what rests is not told by round-off. With the mean of the speeds before and
    after the step, by which the coordinates move, the books balance: what forces have given to speeds that impulses
    take again is in both.
    """
    model, least = state.model, ROUND_OFF_OF_FORCES * float(np.abs(impulses).max())
    still = ROUND_OFF_OF_FORCES * fastest
    for k, (c, i) in enumerate(closed):
        rows = slice(3 * k, 3 * k + 3)
        push = impulses[rows]
        contact = model.rigid_contact(c)
        where, met = model.load_states[model.rigid_contacts[c]], meetings(state)[c][i]
        A = state.marker(contact.ends[0]).A_NF
        belt = met.axes[1:] @ (A @ contact.belt)
        quadratures[0] -= float(push @ mean[rows])
        quadratures[1] += float(push[1:] @ belt)
        if push[0] <= least:
            continue
        own = z[where]
        slip = float(np.linalg.norm(after[rows][1:]))
        own[1] -= float(push[1:] @ mean[rows][1:])
        own[TAKEN] -= float(push[0] * mean[rows][0])
        own[0] += contact.probes[i][1].share * slip * h
        if after[3 * k] > still:  # it has bounced
            continue
        if contact.friction is not None and slip <= still:
            contact.with_status(own, i, STICKS, met.place)
        else:
            along = SLIPPING.at_rest / slip * after[rows][1:] @ met.axes[1:] @ A if slip > 0.0 else np.zeros(3)
            contact.with_status(own, i, SLIPS, along)
