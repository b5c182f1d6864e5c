"""Impulses of an impact of rigid contacts, each group of coupled ones by itself, and what is to be told of them.

One contact has Stronge's impulse, or by its law Newton's or Poisson's with Coulomb's friction of the impulses. Several
at once have Poisson's: pressed together until none approaches,

    v_C = v + G p_C,    0 <= p_C,N  _|_  v_C,N >= 0,    p_C,T in Coulomb's cone against v_C,T

and let go by ``p_E,N >= e p_C,N`` (Ch. Glocker & F. Pfeiffer, Nonlinear Dyn. 7 (1995) 471-497). The first part takes
energy, ``p_C . (v + v_C) / 2 = p_C . v_C - p_C G p_C / 2 <= 0``; of the second the largest share is taken with which
the whole gives none. With any share of it impulses are in their cones and nothing approaches: both are convex.
"""

import numpy as np

from kanefe.kernels.contact.rigid_points import GivenPoints, ImpactLaw, RigidPoint, RigidStates, given_points
from kanefe.kernels.impacts.cones import Cones, largest_of, let_choose, solve_least_norm
from kanefe.kernels.impacts.decision import (
    Asking,
    Decision,
    Points,
    block,
    is_at_rest,
    points_of,
    put_problem,
    sizes,
    solve,
    taken_by,
)
from kanefe.kernels.impacts.distributing import distribute
from kanefe.kernels.impacts.stronge import Blow, strike_one
from kanefe.kernels.impacts.tolerances import SOLVING, STRIKING
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.language import ZERO, Symmetric, Vector, copy, dot, inlined, kernel, largest_in


@kernel
def strike(asking: Asking, decision: Decision, taking: np.ndarray, u: np.ndarray, z: np.ndarray) -> tuple[bool, float]:
    """Change free speeds, rates and energies of contacts by the impulses of an impact.

    Returns
    -------
    is_found : bool
        Whether there are impulses.
    gained : float
        Energy that they make, J.
    """
    points, gained = points_of(decision), 0.0
    for p in taking:
        points[p].force, points[p].gains = ZERO, False
    put_groups(decision.now.G, points, taking, STRIKING.apart)
    for p in taking:
        if points[p].group == p:
            active = decision.active[: put_members(decision, taking, p)]
            is_found, made = _strike_group(asking, decision, active)
            if not is_found:
                return False, 0.0
            gained += made
    move_by_forces(given_points(asking.points), decision, taking, u, z)
    largest = 0.0
    for p in taking:
        largest = max(largest, largest_in(points[p].force))
    for p in taking:
        points[p].is_struck = points[p].force.x > SOLVING.close * largest
    return True, gained


@kernel
def move_by_forces(rigid: GivenPoints, decision: Decision, taking: np.ndarray, u: np.ndarray, z: np.ndarray) -> None:
    """Change free speeds, rates of points and energies of contacts by the impulses that were found."""
    points, G = points_of(decision), decision.now.G
    for p in taking:
        respond(decision, p, points[p].force, u)
    for p in taking:
        point, size = points[p], 0.0
        for q in taking:
            size += dot(sizes(block(G, p, q).T.x), sizes(points[q].force))
        before = point.rates
        point.rates = before + moved_by(decision, taking, p)
        point.not_moving = max(point.not_moving, STRIKING.struck * size)
        RigidStates(z, rigid[p].first_state).taken += taken_by(point.force, before, point.rates)


@inlined
def respond(decision: Decision, p: int, force: Vector, y: np.ndarray) -> None:
    """Add to free speeds what a force at a point does."""
    responses = decision.now.responses
    for c in range(len(y)):
        y[c] += force.x * responses[3 * p, c] + force.y * responses[3 * p + 1, c] + force.z * responses[3 * p + 2, c]


@kernel
def moved_by(decision: Decision, by: np.ndarray, p: int) -> Vector:
    """Return what the impulses of some points do to the rates of one."""
    points, moved = points_of(decision), ZERO
    for q in by:
        moved += block(decision.now.G, p, q) @ points[q].force
    return moved


@kernel
def put_groups(G: np.ndarray, points: Points, taking: np.ndarray, apart: float) -> None:
    """Write of each point the least one whose impulses move it by more than a share of what they do by themselves."""
    for p in taking:
        points[p].group, points[p].is_poisson, points[p].depends = p, False, False
    is_done = False
    while not is_done:
        is_done = True
        for a in range(len(taking)):
            for b in range(a):
                one, other = points[taking[a]], points[taking[b]]
                if one.group == other.group:
                    continue
                own = np.sqrt(_coupling(G, taking[a], taking[a]) * _coupling(G, taking[b], taking[b]))
                if _coupling(G, taking[a], taking[b]) > apart * own:
                    one.group = other.group = min(one.group, other.group)
                    is_done = False


@inlined
def _coupling(G: np.ndarray, p: int, q: int) -> float:
    """Return the largest response of a point to impulses at another."""
    found = 0.0
    for i in range(3 * p, 3 * p + 3):
        found = max(found, largest_of(G[i, 3 * q :], 3))
    return found


@kernel
def put_members(decision: Decision, taking: np.ndarray, group: int) -> int:
    """Write the points of a group to the active ones; return how many these are."""
    points, k = points_of(decision), 0
    for p in taking:
        if points[p].group == group:
            decision.active[k] = p
            k += 1
    return k


@kernel
def _strike_group(asking: Asking, decision: Decision, active: np.ndarray) -> tuple[bool, float]:
    """Write the impulses of a group, if it is struck; return whether there are some, and the energy that they make."""
    points, strikes = points_of(decision), False
    for a in range(len(active)):
        point = points[active[a]]
        put_three(decision.rates, 3 * a, point.rates)
        strikes = strikes or point.rates.x < -point.not_moving
    if not strikes:
        return True, 0.0
    is_found, is_poisson = _press_together(asking, decision, active, STRIKING.closely)
    if not is_found:
        return False, 0.0
    made = exchanged = 0.0
    for a in range(len(active)):
        points[active[a]].force = three(decision.pressed, 3 * a)
    for p in active:
        point = points[p]
        after = point.rates + moved_by(decision, active, p)
        made -= taken_by(point.force, point.rates, after)
        exchanged += 0.5 * dot(sizes(point.force), sizes(point.rates) + sizes(after))
    is_alone = len(active) == 1 or _shares(given_points(asking.points), active)
    depends = not is_alone and _depends_on_order(asking, decision, active)
    gains = made > STRIKING.added * exchanged
    for p in active:
        points[p].is_poisson, points[p].depends, points[p].gains = is_poisson, depends, gains
    return True, made if gains else 0.0


@kernel
def _shares(points: GivenPoints, active: np.ndarray) -> bool:
    """Return whether any of some points distributes its impacts."""
    found = False
    for p in active:
        found = found or points[p].law == ImpactLaw.DISTRIBUTING
    return found


@kernel
def _depends_on_order(asking: Asking, decision: Decision, active: np.ndarray) -> bool:
    """Return whether points that struck one after the other, the first or the last first, would part otherwise.

    So they do if gaps that nobody can measure are between them.
    """
    points, size = points_of(decision), 0.0
    for p in active:
        size = max(size, largest_in(points[p].rates))
    for is_last_first in (False, True):
        if not _strike_in_turn(asking, decision, active, is_last_first, STRIKING.still_in_turn * size):
            continue
        for p in active:
            point = points[p]
            if largest_in(point.acceleration - point.rates - moved_by(decision, active, p)) > STRIKING.jumps * size:
                return True
    return False


@kernel
def _strike_in_turn(asking: Asking, decision: Decision, active: np.ndarray, is_last_first: bool, still: float) -> bool:
    """Write to accelerations the rates after impacts of one point after the other; return whether none approaches."""
    points, one, k = points_of(decision), decision.alone, len(active)
    for p in active:
        points[p].acceleration = points[p].rates
    for _ in range(STRIKING.in_turn):
        one[0] = -1
        for a in range(k):
            p = active[k - 1 - a if is_last_first else a]
            if one[0] < 0 and points[p].acceleration.x < -still:
                one[0] = p
        if one[0] < 0:
            return True
        put_three(decision.rates, 0, points[one[0]].acceleration)
        is_found, _ = _press_together(asking, decision, one, STRIKING.roughly)
        if not is_found:
            return False
        for p in active:
            points[p].acceleration += block(decision.now.G, p, one[0]) @ three(decision.pressed, 0)
    return False


@kernel
def _press_together(asking: Asking, decision: Decision, active: np.ndarray, closely: float) -> tuple[bool, bool]:
    """Write the impulses of some points; return whether there are some, and are Poisson's where Newton's are not.

    Where what is between several surfaces cannot part from all that it meets as Newton's law has it, that is Poisson's.
    """
    rigid, p = given_points(asking.points), active[0]
    if len(active) == 1 and (rigid[p].law == ImpactLaw.STRONGE or rigid[p].law == ImpactLaw.DISTRIBUTING):
        return strike_alone(rigid[p], decision, p, closely), False
    put_problem(decision.now.G, active, decision.problem)
    if _shares(rigid, active):
        return distribute(rigid, active, decision.rates, decision.problem, decision.pressed), False
    if press(asking, decision, active, False, False):
        return True, False
    return press(asking, decision, active, True, False), True


@kernel
def strike_alone(given: RigidPoint, decision: Decision, p: int, closely: float) -> bool:
    """Write Stronge's impulse of the first active point, p; return whether there is one."""
    blow, A = Blow(decision.blow, decision.of_blow), block(decision.now.G, p, p)
    blow.G = Symmetric(A.x.x, A.y.x, A.z.x, A.y.y, A.z.y, A.z.z)
    blow.first, blow.closely = three(decision.rates, 0), closely
    is_found = strike_one(blow, given, decision.turned)
    put_three(decision.pressed, 0, blow.p)
    return is_found


@kernel
def press(asking: Asking, decision: Decision, active: np.ndarray, all_poisson: bool, is_warm: bool) -> bool:
    """Write the impulses of some points, by their laws or by Poisson's; return whether there are some.

    Of Poisson's impact the second part follows, as much of it as gives no energy; contacts by Newton's law keep what
    they have come to. `is_warm`: whether the forces of the problem are a guess of those of the first part.
    """
    k, problem, pressed, rigid = len(active), decision.problem, decision.pressed, given_points(asking.points)
    if not _press_part(asking, decision, active, all_poisson, False, is_warm):
        return False
    copy(problem.x[: 3 * k], pressed)
    any_least = any_newton = False
    for a in range(k):
        is_poisson = all_poisson or rigid[active[a]].law != ImpactLaw.NEWTON
        any_newton = any_newton or not is_poisson
        lets_go = is_poisson and rigid[active[a]].restitution * pressed[3 * a] != 0.0
        any_least = any_least or lets_go
    if not any_least:
        return True
    if not _press_part(asking, decision, active, all_poisson, True, False):
        return False
    share = 1.0 if any_newton else _share(decision, k)
    for i in range(3 * k):
        pressed[i] += share * problem.x[i]
    return True


@kernel
def _press_part(
    asking: Asking, decision: Decision, active: np.ndarray, all_poisson: bool, lets_go: bool, is_warm: bool
) -> bool:
    """Solve for the first part of an impact, or for the second one, that lets go; return whether there are impulses."""
    k, problem, rigid, cones = len(active), decision.problem, given_points(asking.points), Cones(decision.problem.each)
    for i in range(3 * k):
        problem.b[i] = decision.rates[i]
        if lets_go:
            for j in range(3 * k):
                problem.b[i] += problem.G[i, j] * decision.pressed[j]
    for a in range(k):
        cone, given, e = cones[a], rigid[active[a]], rigid[active[a]].restitution
        is_poisson = all_poisson or given.law != ImpactLaw.NEWTON
        cone.mu, cone.least = given.friction.holding, 0.0
        let_choose(cone)
        if not is_poisson:
            problem.b[3 * a] += e * min(decision.rates[3 * a], 0.0)
        elif lets_go:
            cone.least = e * decision.pressed[3 * a]
    return solve(asking.solving, problem, k, is_warm)


@kernel
def _share(decision: Decision, k: int) -> float:
    """Return the largest share of the second part of impulses with which the whole gives no energy."""
    problem, pressed, more = decision.problem, decision.pressed, decision.problem.x
    gone = linear = squared = exchanged = 0.0
    for i in range(3 * k):
        before, first, second = decision.rates[i], 0.0, 0.0
        for j in range(3 * k):
            first += problem.G[i, j] * pressed[j]
            second += problem.G[i, j] * more[j]
        gone += pressed[i] * (before + 0.5 * first)
        linear += more[i] * (before + first)
        squared += 0.5 * more[i] * second
        exchanged += abs(more[i]) * abs(before)
    if gone + linear + squared <= STRIKING.added * exchanged or squared <= 0.0:
        return 1.0
    gone = min(gone, 0.0)
    return min(1.0, -2.0 * gone / (linear + np.sqrt(linear * linear - 4.0 * squared * gone)))


@kernel
def stop(asking: Asking, decision: Decision, taking: np.ndarray, u: np.ndarray) -> bool:
    """Take the round-off from the speeds of what is closed, and of what does not slip; return whether there was any."""
    points, problem, held, n, is_any = points_of(decision), decision.problem, decision.rates, 0, False
    for p in taking:
        point = points[p]
        sticks = given_points(asking.points)[p].rubs and is_at_rest(point)
        put_three(decision.pressed, 3 * p, ZERO)
        put_three(problem.tried, 3 * p, point.rates)
        for i in range(3):
            if point.is_closed and (i == 0 or sticks):
                held[n] = 3 * p + i
                is_any = is_any or problem.tried[3 * p + i] != 0.0
                n += 1
    if not is_any:
        return False
    for a in range(n):
        i = int(held[a])
        problem.value[a] = -problem.tried[i]
        for b in range(n):
            problem.slopes[a, b] = decision.now.G[i, int(held[b])]
    solve_least_norm(problem, n)
    for a in range(n):
        decision.pressed[int(held[a])] = problem.value[a]
    for p in taking:
        points[p].force = three(decision.pressed, 3 * p)
        respond(decision, p, points[p].force, u)
    for p in taking:
        put_three(problem.tried, 3 * p, points[p].rates + moved_by(decision, taking, p))
    for a in range(n):
        problem.tried[int(held[a])] = 0.0
    for p in taking:
        points[p].rates = three(problem.tried, 3 * p)
    return True
