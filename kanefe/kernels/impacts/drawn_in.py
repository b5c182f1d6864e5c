"""Impacts without collision: friction draws what slips into its surface, where no force can hold it out.

In Painleve's paradox, ``A = G_NN - mu G_NT s <= 0`` of a closed contact that slips along s, a normal force presses the
contact in. If it is pressed in without force too, ``b_N < 0``, there is no force, and contacts of any stiffness go the
same way: they are pressed in until friction has stopped the slip, the faster the stiffer they are (F. Genot & B.
Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653-677; A. Champneys & P. Varkonyi, IMA J. Appl. Math. 81 (2016) 538-588).
That is an impact by Stronge's law which begins without approach. Where ``b_N >= 0`` the contact may as well open, and
what happens depends on how it came there.

Where several contacts are closed and no forces of all together let the slips go on, they have Poisson's impact, as
several always do: that to which the impulses of ever shorter times come, ``v + h b + G p`` in complementarity with p as
h goes to zero (D. E. Stewart, Arch. Ration. Mech. Anal. 145 (1998) 215-260), and the second part that it leads to.
"""

import numpy as np

from kanefe.kernels.contact.falling import steady_coefficient
from kanefe.kernels.contact.rigid_points import GivenPoints, given_points
from kanefe.kernels.impacts.cones import Cones, largest_of, let_choose
from kanefe.kernels.impacts.decision import (
    Asking,
    Decision,
    Look,
    block,
    is_at_rest,
    look,
    points_of,
    put_problem,
    solve,
)
from kanefe.kernels.impacts.impulses import move_by_forces, press, put_groups, strike_alone
from kanefe.kernels.impacts.tolerances import ROUND_OFF_OF_FORCES, STICKING, STRIKING
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.language import ZERO, Vector, inlined, kernel

BEYOND = 100.0
"""Change of rates in that time, relative to what accelerations without contacts make, from which it is an impact."""


@kernel
def draw_in(
    asking: Asking, decision: Decision, taking: np.ndarray, t: float, u: np.ndarray, z: np.ndarray
) -> tuple[bool, bool]:
    """Stop what slips, alone in its group, and is pressed in by its friction.

    Returns
    -------
    is_known : bool
        Whether the scene says what it is asked.
    is_any : bool
        Whether speeds have changed.
    """
    points, rigid, is_any = points_of(decision), given_points(asking.points), False
    put_groups(decision.now.G, points, taking, STRIKING.apart)
    for p in taking:
        if not _is_jammed(rigid, decision, taking, p):
            continue
        if not is_any and not look(asking, decision, Look.POINTS, t, taking):
            return False, False
        if not decision.now.b[3 * p] < -ROUND_OFF_OF_FORCES * largest_acceleration(decision, taking):
            continue
        put_three(decision.rates, 0, Vector(0.0, points[p].rates.y, points[p].rates.z))
        if strike_alone(rigid[p], decision, p, STRIKING.closely) and decision.pressed[0] > 0.0:
            for q in taking:
                points[q].force = ZERO
            points[p].force = three(decision.pressed, 0)
            move_by_forces(rigid, decision, taking, u, z)
            is_any = True
            if not look(asking, decision, Look.POINTS, t, taking):
                return False, False
    return True, is_any


@inlined
def largest_acceleration(decision: Decision, taking: np.ndarray) -> float:
    """Return the largest acceleration of a point without contacts."""
    largest = 0.0
    for q in taking:
        largest = max(largest, largest_of(decision.now.b[3 * q :], 3))
    return largest


@kernel
def _is_jammed(rigid: GivenPoints, decision: Decision, taking: np.ndarray, p: int) -> bool:
    """Return whether a point slips, alone of its group, and a force would press it in."""
    points, point = points_of(decision), points_of(decision)[p]
    if not point.is_closed or not rigid[p].rubs or is_at_rest(point):
        return False
    for q in taking:
        if q != p and points[q].group == point.group and points[q].is_closed:
            return False
    A, speed = block(decision.now.G, p, p).T.x, np.hypot(point.rates.y, point.rates.z)
    mu = steady_coefficient(rigid[p].friction, speed)
    return A.x - mu * (A.y * point.rates.y + A.z * point.rates.z) / speed <= STICKING.not_determined * A.x


@kernel
def draw_in_together(asking: Asking, decision: Decision, taking: np.ndarray, u: np.ndarray, z: np.ndarray) -> bool:
    """Stop several contacts that friction draws in, with the speeds that there are now; return whether there are."""
    points, problem, rigid, k = points_of(decision), decision.problem, given_points(asking.points), len(taking)
    largest = largest_acceleration(decision, taking)
    if largest == 0.0:
        return False
    put_problem(decision.now.G, taking, problem)
    for a in range(k):
        put_three(decision.rates, 3 * a, points[taking[a]].rates)
    least = STRIKING.shortest * largest_of(decision.rates, 3 * k)
    for a in range(k):
        cone = Cones(problem.each)[a]
        cone.mu, cone.least = rigid[taking[a]].friction.holding, 0.0
        let_choose(cone)
        for i in range(3):
            at = 3 * a + i
            problem.b[at] = decision.rates[at] + least / largest * decision.now.b[3 * taking[a] + i]
    is_found = solve(asking.solving, problem, k, False)
    if not is_found or _largest_change(decision, k, problem.x) <= BEYOND * least:
        return False  # what forces do in that time, which need no impact
    for a in range(k):
        points[taking[a]].force = three(problem.x, 3 * a)
    is_pressed = press(asking, decision, taking, True, True)
    if is_pressed and _largest_change(decision, k, decision.pressed) > least:
        for a in range(k):
            points[taking[a]].force = three(decision.pressed, 3 * a)
    move_by_forces(rigid, decision, taking, u, z)
    return True


@kernel
def _largest_change(decision: Decision, k: int, impulses: np.ndarray) -> float:
    """Return the largest change of the rates of k points of a problem."""
    largest = 0.0
    for i in range(3 * k):
        change = 0.0
        for j in range(3 * k):
            change += decision.problem.G[i, j] * impulses[j]
        largest = max(largest, abs(change))
    return largest
