"""Impulses among many loose bodies in a step over impacts: Gauss and Seidel's iteration over their contacts.

Each contact goes on from the speeds that the others have left. The law is that of
`kanefe.kernels.impacts.step_impulses`: where the impulses among bodies that touch each other would make energy, the
restitution among them is lowered, or the mean of the rates before and after the step obeys the law. Bodies that touch
are known by a tree each (R. E. Tarjan, J. ACM 22 (1975) 215-225).
"""

import math
from collections import namedtuple

from kanefe.kernels.contact.granular_scene import BodyStates, Contact, Contacts, Control, Groups, Stage, Steps
from kanefe.kernels.impacts.tolerances import HALVINGS, ROUND_OFF_OF_FORCES
from kanefe.kernels.language import ZERO, Vector, dot, inlined, kernel, largest_in

CLOSE_SHARES = 0.5**HALVINGS
"""Length of an interval of shares that is not halved any more, relative to the whole one."""

Speeds = namedtuple("Speeds", "v w other_v other_w")
"""Velocity and angular velocity of a body and of another one; zero of a wall."""


@inlined
def speeds(contact: Contact, states: BodyStates) -> Speeds:
    """Return the speeds of both sides of a contact."""
    body = states[contact.body]
    if contact.other < 0:
        return Speeds(body.v, body.w, ZERO, ZERO)
    other = states[contact.other]
    return Speeds(body.v, body.w, other.v, other.w)


@inlined
def put_speeds(contact: Contact, states: BodyStates, both: Speeds) -> None:
    """Write the same."""
    body = states[contact.body]
    body.v, body.w = both.v, both.w
    if contact.other >= 0:
        other = states[contact.other]
        other.v, other.w = both.other_v, both.other_w


@inlined
def rates(contact: Contact, both: Speeds) -> Vector:
    """Return the rates of a contact along its directions, m/s."""
    turning = contact.arms @ both.w - contact.other_arms @ both.other_w
    return contact.axes @ (both.v - both.other_v) + turning


@inlined
def pair_rates(contact: Contact, states: BodyStates) -> Vector:
    """Return the same at the present speeds."""
    return rates(contact, speeds(contact, states))


@inlined
def pushed(contact: Contact, both: Speeds, impulse: Vector) -> Speeds:
    """Return the speeds after an impulse along the directions of a contact."""
    push = contact.axes.T @ impulse
    return Speeds(
        both.v + contact.lightness * push,
        both.w + contact.spins.T @ impulse,
        both.other_v - contact.other_lightness * push,
        both.other_w - contact.other_spins.T @ impulse,
    )


@inlined
def work_of(contact: Contact, states: BodyStates) -> float:
    """Return the work of the impulses of a contact, J: by the mean of the rates before and after the step."""
    return 0.5 * dot(contact.impulse, contact.before + pair_rates(contact, states))  # type: ignore[no-any-return]


@kernel
def solve(found: int, steps: Steps) -> None:
    """Write the impulses of so many contacts, and the speeds that they lead to."""
    control, contacts = Control(steps.counts, steps.control), Contacts(steps.pairs, steps.contacts)
    states = BodyStates(steps.u)
    groups, e, largest = Groups(steps.groups, steps.sums), control.restitution, 0.0
    for c in range(found):
        contact = contacts[c]
        now = pair_rates(contact, states)
        largest = max(largest, abs(now.x + e * contact.before.x))
        contact.speed = max(largest_in(contact.before), largest_in(now))
        _put_law(contact, e, 0.0)
    for c in range(found):  # from the impulses of the step before
        contact = contacts[c]
        impulse = contact.impulse
        if impulse.x != 0.0:
            put_speeds(contact, states, pushed(contact, speeds(contact, states), impulse))
    _put_groups(found, contacts, groups)
    is_first = True
    while True:
        _sweep(found, is_first, largest, steps)
        is_first = False
        _put_sums(found, contacts, groups, states)
        if not _go_on(control, groups):
            return
        for c in range(found):
            group = groups[contacts[c].group]
            stage, share = group.stage, 0.0
            if stage == Stage.HALVED:
                share = 0.5 * (group.low + group.high)
            elif stage == Stage.LOWEST:
                share = group.low
            if stage != Stage.SOLVED:
                _put_law(contacts[c], share * e, 1.0 if stage == Stage.IN_MEAN else 0.0)


@inlined
def _put_law(contact: Contact, share: float, of_all: float) -> None:
    """Write what the law adds to rates: a share of those before along the normal, and one in all directions."""
    before = contact.before
    contact.beside = Vector((share + of_all) * before.x, of_all * before.y, of_all * before.z)


@kernel
def _sweep(found: int, is_first: bool, largest: float, steps: Steps) -> None:
    """Improve the impulses of groups that are not solved until their rates stay."""
    control, contacts = Control(steps.counts, steps.control), Contacts(steps.pairs, steps.contacts)
    states = BodyStates(steps.u)
    groups, mu, change = Groups(steps.groups, steps.sums), control.friction, 0.0
    for _ in range(control.most_sweeps):
        change = 0.0
        control.sweeps += 1
        for c in range(found):
            if is_first or groups[contacts[c].group].stage != Stage.SOLVED:
                change = max(change, _improve(mu, contacts[c], states))
        if change <= control.enough * largest:
            break
    control.residual = max(control.residual, change / largest if largest > 0.0 else 0.0)


@inlined
def _root(groups: Groups, i: int) -> int:
    """Return the root of the group of a body, with a shorter way to it from then on."""
    while groups[i].root != i:
        groups[i].root = groups[groups[i].root].root
        i = groups[i].root
    return i


@kernel
def _put_groups(found: int, contacts: Contacts, groups: Groups) -> None:
    """Write which bodies touch each other, none of them solved; bodies that touch the same wall alone do not."""
    for i in range(len(groups)):
        groups[i].root, groups[i].stage = i, Stage.SOLVED
    for c in range(found):
        if contacts[c].other >= 0:
            groups[_root(groups, contacts[c].body)].root = _root(groups, contacts[c].other)
    for c in range(found):
        contacts[c].group = _root(groups, contacts[c].body)
        groups[contacts[c].group].stage = Stage.TRIED


@kernel
def _put_sums(found: int, contacts: Contacts, groups: Groups, states: BodyStates) -> None:
    """Write the work of the impulses in each group that is not solved, their size, and the largest rate."""
    for i in range(len(groups)):
        groups[i].work = groups[i].size = groups[i].fastest = 0.0
    for c in range(found):
        contact, group = contacts[c], groups[contacts[c].group]
        if group.stage != Stage.SOLVED:
            impulse = contact.impulse
            group.work += work_of(contact, states)
            group.size += abs(impulse.x) + abs(impulse.y) + abs(impulse.z)
            group.fastest = max(group.fastest, contact.speed)


@kernel
def _go_on(control: Control, groups: Groups) -> bool:
    """Write the next stage of each group; return whether any of them is not solved."""
    is_any, round_off = False, max(ROUND_OFF_OF_FORCES, control.enough)
    for i in range(len(groups)):
        group = groups[i]
        stage = group.stage
        if stage == Stage.SOLVED:
            continue
        makes_energy = group.work > round_off * group.fastest * group.size
        if stage == Stage.TRIED:
            stage = Stage.WITHOUT if makes_energy else Stage.SOLVED
        elif stage == Stage.WITHOUT:
            stage = Stage.IN_MEAN if makes_energy else Stage.HALVED
            group.low, group.high = 0.0, 1.0
            control.lowered += 0 if makes_energy else 1
        elif stage == Stage.HALVED:
            share = 0.5 * (group.low + group.high)
            if makes_energy:
                group.high = share
            else:
                group.low = share
            stage = Stage.HALVED if group.high - group.low > CLOSE_SHARES else Stage.LOWEST
        else:
            stage = Stage.SOLVED
        group.stage = stage
        is_any = is_any or stage != Stage.SOLVED
    return is_any


@inlined
def _improve(mu: float, contact: Contact, states: BodyStates) -> float:
    """Set the impulses of a contact by the speeds that the others leave; return by how much rates change, m/s."""
    both, before = speeds(contact, states), contact.impulse
    rate = rates(contact, both) + contact.beside
    normal = max(0.0, before.x - contact.inverse_normal * rate.x)
    if normal == 0.0 and before.x == 0.0:
        return 0.0  # open, and friction has ended with it
    change, s, t = abs(normal - before.x) / contact.inverse_normal, before.y, before.z
    if mu > 0.0:
        rate += (normal - before.x) * contact.by_normal
        s -= contact.inverse_along * rate.y
        t -= contact.inverse_along * rate.z
        size = math.sqrt(s * s + t * t)
        if size > mu * normal:
            s, t = mu * normal / size * s, mu * normal / size * t
        change = max(change, max(abs(s - before.y), abs(t - before.z)) / contact.inverse_along)
    contact.impulse = Vector(normal, s, t)
    put_speeds(contact, states, pushed(contact, both, contact.impulse - before))
    return change


@kernel
def account(found: int, steps: Steps) -> None:
    """Add the energy that contacts took in a step."""
    control, contacts = Control(steps.counts, steps.control), Contacts(steps.pairs, steps.contacts)
    states = BodyStates(steps.u)
    for c in range(found):
        control.taken -= work_of(contacts[c], states)
