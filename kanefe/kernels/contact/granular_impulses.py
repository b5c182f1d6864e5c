"""Impulses among many loose bodies in a step over impacts: Gauss and Seidel's iteration over their contacts.

Each contact goes on from the speeds that the others have left. The law is that of
`kanefe.kane.rigid_contacts.step_impulses`: where the impulses among bodies that touch each other would make energy, the
restitution among them is lowered, or the mean of the rates before and after the step obeys the law. Bodies that touch
are known by a tree each (R. E. Tarjan, J. ACM 22 (1975) 215-225).
"""

from __future__ import annotations

import math

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, dot, minus, plus, put_three, three, times
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.impacts.tolerances import HALVINGS, ROUND_OFF_OF_FORCES

NORMAL, ARMS, OTHER_ARMS, SPINS, OTHER_SPINS, LIGHTNESS, IMPULSE, BESIDE = 0, 9, 18, 27, 36, 45, 47, 50
INVERSE_NORMAL, INVERSE_ALONG, BEFORE, SPEED, CONTACT_SIZE = 53, 54, 55, 58, 59
"""Columns of contacts: normal and two tangential directions in N; the moments of unit forces along these about the body
and about the other body, in their axes, and the angular velocities that unit impulses add; inverses of both masses;
impulses; what the law adds to the rates at the end of the step, of those at its start; inverses of the effective
inertias; rates at the start of the step; the largest of these and of those without impulses. Of a wall what would move
is zero.
"""

FIRST, SECOND, KEY, GROUP, PAIR_SIZE = range(5)
"""Columns of pairs: the body of the ball, the other body (-1: a wall), a number of the pair, and the root of its group.
"""

STEPS, TOUCHING, SWEEPS, MOST_SWEEPS, TOUCHED, LOWERED, COUNTS = range(7)
"""Indices of counts: remaining steps, contacts of the last step, sweeps in total, most sweeps in a step, contacts of
all steps, and in all of them how many groups of bodies have had their restitution lowered."""

STEP, GRAVITY, RESTITUTION, FRICTION, ENOUGH, DEEPEST, RESIDUAL, TAKEN, CONTROL_SIZE = 0, 1, 4, 5, 6, 7, 8, 9, 10
"""Indices of control values: s, m/s2, dimensionless fractions, and the change of speeds in a sweep, relative to the
largest, that counts as none; deepest penetration (m), largest relative change of speeds at the end of sweeps, and
energy taken (J)."""

ROOT, STAGE = 0, 1
"""Columns of groups: of each body the next one towards the root of its group, and of a root what is done to its group.
"""

SOLVED, TRIED, WITHOUT, IN_MEAN, HALVED, LOWEST = range(6)
"""Stages: impulses that make no energy; with the whole restitution, without any, by the mean of the rates, with a share
of it, and with the lowest share."""

WORK, SIZE, FASTEST, LOW, HIGH = range(5)
"""Columns of sums of roots: work of impulses (J), their size (N s), the largest rate (m/s), and between which shares of
the restitution they begin to make energy."""

SUMS = 5

CLOSE_SHARES = 0.5**HALVINGS
"""Length of an interval of shares that is not halved any more, relative to the whole one."""

Speeds = tuple[Numbers, Numbers, Numbers, Numbers]
"""Velocity and angular velocity of a body and of another one."""


@inlined
def speeds(u: np.ndarray, body: int, other: int) -> Speeds:
    """Return velocity and angular velocity of the body of a contact and of the other one; zero of a wall."""
    v, w = three(u[body], 0), three(u[body], 3)
    if other < 0:
        return v, w, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    return v, w, three(u[other], 0), three(u[other], 3)


@inlined
def put_speeds(u: np.ndarray, body: int, other: int, both: Speeds) -> None:
    """Write the same."""
    put_three(u[body], 0, both[0])
    put_three(u[body], 3, both[1])
    if other >= 0:
        put_three(u[other], 0, both[2])
        put_three(u[other], 3, both[3])


@inlined
def rate(row: np.ndarray, k: int, both: Speeds) -> float:
    """Return the rate of a contact along one of its directions, m/s."""
    v, w, other_v, other_w = both
    turning = dot(three(row, ARMS + 3 * k), w) - dot(three(row, OTHER_ARMS + 3 * k), other_w)
    return dot(three(row, 3 * k), minus(v, other_v)) + turning


@inlined
def answer(row: np.ndarray, j: int, k: int) -> float:
    """Return by what a unit impulse along one direction changes the rate along another, 1/kg."""
    along = dot(three(row, 3 * j), three(row, 3 * k)) * (row[LIGHTNESS] + row[LIGHTNESS + 1])
    turning = dot(three(row, ARMS + 3 * j), three(row, SPINS + 3 * k))
    return along + turning + dot(three(row, OTHER_ARMS + 3 * j), three(row, OTHER_SPINS + 3 * k))


@inlined
def pushed(row: np.ndarray, k: int, both: Speeds, impulse: float) -> Speeds:
    """Return the speeds after an impulse along one of the directions of a contact."""
    v, w, other_v, other_w = both
    e = three(row, 3 * k)
    return (
        plus(v, times(impulse * row[LIGHTNESS], e)),
        plus(w, times(impulse, three(row, SPINS + 3 * k))),
        minus(other_v, times(impulse * row[LIGHTNESS + 1], e)),
        minus(other_w, times(impulse, three(row, OTHER_SPINS + 3 * k))),
    )


@kernel
def solve(
    found: int,
    counts: np.ndarray,
    control: np.ndarray,
    u: np.ndarray,
    contacts: np.ndarray,
    pairs: np.ndarray,
    groups: np.ndarray,
    sums: np.ndarray,
) -> None:
    """Write impulses, and the speeds that they lead to.

    Parameters
    ----------
    groups : ndarray of int, shape (bodies, 2)
        Workspace.
    sums : ndarray, shape (bodies, SUMS)
        Workspace.
    """
    e, largest = control[RESTITUTION], 0.0
    for c in range(found):
        row = contacts[c]
        both = speeds(u, pairs[c, FIRST], pairs[c, SECOND])
        largest = max(largest, abs(rate(row, 0, both) + e * row[BEFORE]))
        row[SPEED] = 0.0
        _put_law(row, e, 0.0)
        for k in range(3):
            row[SPEED] = max(row[SPEED], max(abs(row[BEFORE + k]), abs(rate(row, k, both))))
    for c in range(found):  # from the impulses of the step before
        row = contacts[c]
        if row[IMPULSE] != 0.0:
            both = speeds(u, pairs[c, FIRST], pairs[c, SECOND])
            for k in range(3):
                both = pushed(row, k, both, row[IMPULSE + k])
            put_speeds(u, pairs[c, FIRST], pairs[c, SECOND], both)
    _put_groups(found, pairs, groups)
    is_first = True
    while True:
        counts[SWEEPS] += _sweep(found, counts[MOST_SWEEPS], is_first, largest, control, u, contacts, pairs, groups)
        is_first = False
        _put_sums(found, u, contacts, pairs, groups, sums)
        if not _go_on(counts, control, groups, sums):
            return
        for c in range(found):
            root = pairs[c, GROUP]
            stage, share = groups[root, STAGE], 0.0
            if stage == HALVED:
                share = 0.5 * (sums[root, LOW] + sums[root, HIGH])
            elif stage == LOWEST:
                share = sums[root, LOW]
            if stage != SOLVED:
                _put_law(contacts[c], share * e, 1.0 if stage == IN_MEAN else 0.0)


@inlined
def _put_law(row: np.ndarray, share: float, of_all: float) -> None:
    """Write what the law adds to rates: a share of those before along the normal, and one in all directions."""
    row[BESIDE] = (share + of_all) * row[BEFORE]
    row[BESIDE + 1], row[BESIDE + 2] = of_all * row[BEFORE + 1], of_all * row[BEFORE + 2]


@kernel
def _sweep(
    found: int,
    most: int,
    is_first: bool,
    largest: float,
    control: np.ndarray,
    u: np.ndarray,
    contacts: np.ndarray,
    pairs: np.ndarray,
    groups: np.ndarray,
) -> int:
    """Improve the impulses of groups that are not solved until their rates stay; return the number of sweeps."""
    change, sweeps, mu = 0.0, 0, control[FRICTION]
    for _ in range(most):
        change, sweeps = 0.0, sweeps + 1
        for c in range(found):
            if is_first or groups[pairs[c, GROUP], STAGE] != SOLVED:
                change = max(change, _improve(mu, u, contacts[c], pairs[c, FIRST], pairs[c, SECOND]))
        if change <= control[ENOUGH] * largest:
            break
    control[RESIDUAL] = max(control[RESIDUAL], change / largest if largest > 0.0 else 0.0)
    return sweeps


@inlined
def _root(groups: np.ndarray, i: int) -> int:
    """Return the root of the group of a body, with a shorter way to it from then on."""
    while groups[i, ROOT] != i:
        groups[i, ROOT] = groups[groups[i, ROOT], ROOT]
        i = groups[i, ROOT]
    return i


@kernel
def _put_groups(found: int, pairs: np.ndarray, groups: np.ndarray) -> None:
    """Write which bodies touch each other, none of them solved; bodies that touch the same wall alone do not."""
    for i in range(len(groups)):
        groups[i, ROOT], groups[i, STAGE] = i, SOLVED
    for c in range(found):
        if pairs[c, SECOND] >= 0:
            groups[_root(groups, pairs[c, FIRST]), ROOT] = _root(groups, pairs[c, SECOND])
    for c in range(found):
        pairs[c, GROUP] = _root(groups, pairs[c, FIRST])
        groups[pairs[c, GROUP], STAGE] = TRIED


@kernel
def _put_sums(
    found: int, u: np.ndarray, contacts: np.ndarray, pairs: np.ndarray, groups: np.ndarray, sums: np.ndarray
) -> None:
    """Write the work of the impulses in each group that is not solved, their size, and the largest rate."""
    for i in range(len(groups)):
        sums[i, WORK] = sums[i, SIZE] = sums[i, FASTEST] = 0.0
    for c in range(found):
        row, root = contacts[c], pairs[c, GROUP]
        if groups[root, STAGE] != SOLVED:
            both = speeds(u, pairs[c, FIRST], pairs[c, SECOND])
            for k in range(3):
                sums[root, WORK] += row[IMPULSE + k] * 0.5 * (row[BEFORE + k] + rate(row, k, both))
                sums[root, SIZE] += abs(row[IMPULSE + k])
            sums[root, FASTEST] = max(sums[root, FASTEST], row[SPEED])


@kernel
def _go_on(counts: np.ndarray, control: np.ndarray, groups: np.ndarray, sums: np.ndarray) -> bool:
    """Write the next stage of each group; return whether any of them is not solved."""
    is_any, round_off = False, max(ROUND_OFF_OF_FORCES, control[ENOUGH])
    for i in range(len(groups)):
        stage = groups[i, STAGE]
        if stage == SOLVED:
            continue
        makes_energy = sums[i, WORK] > round_off * sums[i, FASTEST] * sums[i, SIZE]
        if stage == TRIED:
            stage = WITHOUT if makes_energy else SOLVED
        elif stage == WITHOUT:
            stage = IN_MEAN if makes_energy else HALVED
            sums[i, LOW], sums[i, HIGH] = 0.0, 1.0
            counts[LOWERED] += 0 if makes_energy else 1
        elif stage == HALVED:
            share = 0.5 * (sums[i, LOW] + sums[i, HIGH])
            if makes_energy:
                sums[i, HIGH] = share
            else:
                sums[i, LOW] = share
            stage = HALVED if sums[i, HIGH] - sums[i, LOW] > CLOSE_SHARES else LOWEST
        else:
            stage = SOLVED
        groups[i, STAGE] = stage
        is_any = is_any or stage != SOLVED
    return is_any


@inlined
def _improve(mu: float, u: np.ndarray, row: np.ndarray, body: int, other: int) -> float:
    """Set the impulses of a contact by the speeds that the others leave; return by how much rates change, m/s."""
    both = speeds(u, body, other)
    normal = max(0.0, row[IMPULSE] - row[INVERSE_NORMAL] * (rate(row, 0, both) + row[BESIDE]))
    more = normal - row[IMPULSE]
    if normal == 0.0 and more == 0.0:
        return 0.0  # open, and friction has ended with it
    both = pushed(row, 0, both, more)
    row[IMPULSE] = normal
    change = abs(more) / row[INVERSE_NORMAL]
    if mu > 0.0:
        s = row[IMPULSE + 1] - row[INVERSE_ALONG] * (rate(row, 1, both) + row[BESIDE + 1])
        t = row[IMPULSE + 2] - row[INVERSE_ALONG] * (rate(row, 2, both) + row[BESIDE + 2])
        size = math.sqrt(s * s + t * t)
        if size > mu * normal:
            s, t = mu * normal / size * s, mu * normal / size * t
        more_s, more_t = s - row[IMPULSE + 1], t - row[IMPULSE + 2]
        both = pushed(row, 2, pushed(row, 1, both, more_s), more_t)
        row[IMPULSE + 1], row[IMPULSE + 2] = s, t
        change = max(change, max(abs(more_s), abs(more_t)) / row[INVERSE_ALONG])
    put_speeds(u, body, other, both)
    return change


@kernel
def account(found: int, control: np.ndarray, u: np.ndarray, contacts: np.ndarray, pairs: np.ndarray) -> None:
    """Add the energy that contacts took in a step: impulses times the mean of the rates before and after it."""
    for c in range(found):
        row = contacts[c]
        both = speeds(u, pairs[c, FIRST], pairs[c, SECOND])
        for k in range(3):
            control[TAKEN] -= row[IMPULSE + k] * 0.5 * (row[BEFORE + k] + rate(row, k, both))
