"""Equilibrium: rest under loads, and steady motion at given speeds."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.given_state import knows_states
from kanefe.equations.model import Model
from kanefe.equations.unstiffened import warn_of_axial_forces
from kanefe.errors import AccuracyWarning, ModelError, SimulationError, SimulationWarning, outside
from kanefe.frames import Vector, numbers
from kanefe.instants.missed_statics import warn_of_missed
from kanefe.linear.azimuth import moved_on, times_ahead
from kanefe.linear.equilibrium.balance import BalanceSearch
from kanefe.linear.equilibrium.overflow import check_loads
from kanefe.linear.equilibrium.rest import Equilibrium
from kanefe.linear.imbalance import BALANCED
from kanefe.linear.state import at_rest, rested_states, rubbing, started_model
from kanefe.tree.bending import worst_bending

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.linear.equilibrium.rigid_rest import Found
    from kanefe.linear.state import Freezable

MOST_ROUNDS, SAME_LOADS = 30, 1e-10
"""Largest number of searches, each under the joint loads of the previous one, and the relative change of these loads at
which they end."""

Settle: TypeAlias = Callable[[BalanceSearch], tuple[Vector, Vector]]
"""Function that returns q and u in balance by a search."""

LOST = 1e-6
"""Imbalance at a later time above which the equilibrium is lost; rotating coordinates have more round-off."""


@checked("t", "start", "speeds", "find", "steady")
def equilibrium(
    scene: Freezable | Model,
    *,
    t: float | None = None,
    start: Start = None,
    speeds: Mapping[str, Any] | None = None,
    find: Sequence[str] = (),
    steady: bool = True,
) -> Equilibrium:
    """Find a state without accelerations: at rest, or in steady motion.

    Driven joints follow their motions; a blade on a shaft at a steady rate is balanced in the rotating frame. Loops
    stay closed. The search leads to the stable rest to which the scene would creep from the start under strong damping
    (Newton's method with a stiffness that is shifted to be positive definite); if there is none, to the nearest
    unstable one. Where that fails, the loads are raised from zero, as `equilibrium_path` does, if the scene is at rest,
    without contacts and friction. A start that is in balance is kept, even if it is unstable: see
    ``equilibrium(...).linearise().modes()``. A rotor above a critical speed has no statically stable rest: it is
    balanced near the start, where gyroscopic forces stabilise it.

    On rigid contacts no normal force is in tension and no surface is penetrated. Sticking points stay where they touch,
    as far as friction holds them; ``carrying`` has the normal forces.

    Parameters
    ----------
    scene : System or Model
    t : float, optional
        Time at which loads and drives are evaluated, s; default: that of the start, or zero.
    start : state, optional
        Where the search begins, as `kanefe.System.simulate` takes it; its speeds are ignored. Default: the start of
        the scene.
    speeds : mapping of str to float or sequence, optional
        Constant speeds of free joints, by body, rad/s and m/s, such as of a rotor that is neither driven nor braked.
        All other speeds are zero.
    find : sequence of str, optional
        Bodies whose joint speeds are unknowns (trim), with initial values in `speeds`, while their coordinates and
        those of bodies with given speeds are fixed: the precession of a top at a given lean.
    steady : bool
        Whether the balance must also hold later, when drives have turned and loads have changed; False: only at t.

    Raises
    ------
    ModelError
        If a name or a number is not valid.
    SimulationError
        If no balance is found: the message names the remaining force and its coordinate, or the contact that slips, and
        the remedy.

    Warns
    -----
    AccuracyWarning
        If the modes of a body miss much of its deformation by gravity, spin or tractions, if it is bent beyond the
        limit of its kinematics, or if the last functions of an exact beam and its quadratures move it by more than
        1 % of its length.
    OtherRestWarning
        If contacts that touched at the start have lifted, or the rest is close to tipping off the least loaded ones.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> spring = kf.CoordinateForce(stiffness=100.0)
    >>> ball = scene.add_rigid_body("ball", 2.0, joint=kf.Prismatic("z", forces=spring))
    >>> round(float(kf.equilibrium(scene).joint_coordinates("ball")[0]), 6)
    -0.1962
    """
    found = balanced(scene, t=t, start=start, speeds=speeds, find=find, steady=steady)
    warn_of_missed(found, "equilibrium")
    if found.other_rest is not None:
        from kanefe.linear.equilibrium.other_rest import OtherRestWarning

        warnings.warn(f"equilibrium: {found.other_rest}", OtherRestWarning, stacklevel=outside())
    if (bending := found.bending) is not None and bending.is_too_far:
        warnings.warn(f"equilibrium: {bending.remark}", AccuracyWarning, stacklevel=outside())
    if (resolution := found.resolution) is not None and resolution.is_coarse:
        warnings.warn(f"equilibrium: {resolution.remark}", AccuracyWarning, stacklevel=outside())
    warn_of_axial_forces(found.model, np.array([found.time]), found.q[None], found.u[None], "equilibrium: ")
    return found


def balanced(
    scene: Freezable | Model,
    *,
    t: float | None = None,
    start: Start = None,
    speeds: Mapping[str, Any] | None = None,
    find: Sequence[str] = (),
    steady: bool = True,
    slack: float = 0.0,
) -> Equilibrium:
    """Return the result of `equilibrium` without its warnings, for analyses that need many.

    `slack` (1/s2): stiffness over mass of directions that are left unchanged, see `BalanceSearch`.
    """
    falling, time, y = _begun(scene, t, start)
    model, q = at_rest(falling, time, y), falling.parts(y)[0]
    begun = replace(model, initial_coordinates=q)
    if model.constraints and start is None:
        q, _ = model.literal.closed(time, q, np.zeros(0))
    check_loads(model, model.literal.at(time, q))
    u, found = _given_speeds(model, speeds or {}, find)
    if len(found) and model.is_constrained:
        raise ModelError(
            "equilibrium: speeds to be found and rigid contacts or loops at once are not supported. Remedy: give the "
            "speeds, and try several"
        )
    held = tuple(speeds or {}) if len(found) else ()
    may_part = any(load.may_part for load in model.loads) and _has_initial_load_states(model)
    settle = BalanceSearch.run if may_part or model.rigid_contacts else _beside_or_settled

    def search_from(model: Model, q: Vector, settle: Settle = settle) -> Found:
        return _under_its_loads(model, time, q, u, found, held, slack, settle)

    if model.rigid_contacts:
        from kanefe.linear.equilibrium.contact_continuation import continued
        from kanefe.linear.equilibrium.rigid_rest import rest_on_contacts

        stiff = model

        def approach(q: Vector, yielding: Callable[[float], Model]) -> Vector:
            return continued(stiff, time, q, u, found, held, yielding)

        model, search, state = rest_on_contacts(model, time, q, u, search_from, approach, not may_part)
    else:
        if may_part:
            from kanefe.linear.equilibrium.contact_continuation import continued

            led = continued(model, time, q, u, found, held)
            model, search, state = _on_contacts(falling, time, q, u, search_from, led)
        else:
            model, search, state = _found_or_raised(model, time, q, u, search_from)
    q, u = state
    if steady:
        _check_steady(model, time, *state)
    z = rested_states(model, time, np.concatenate((*state, model.initial_states)))
    y = np.concatenate((*state, z))
    return Equilibrium(
        at_rest(model, time, y), time, y, search.imbalance(q, u), search.iterations, begun, search.small(q, u)
    )


def _begun(scene: Freezable | Model, t: float | None, start: Start) -> tuple[Model, float, Vector]:
    """Return the model, time and state from which an equilibrium is searched for."""
    with warnings.catch_warnings():  # contacts may begin deep: the search moves them
        warnings.filterwarnings("ignore", "contact .* begins .* deep", SimulationWarning)
        model, time, y = started_model(scene, t, start, "equilibrium")
        if start is None or not knows_states(model, start):
            model, y = _slack_unless_balanced(model, time, y)
    return model, time, y


def _has_initial_load_states(model: Model) -> bool:
    """Return whether loads have their initial states, not those of a run; rigid contacts are not checked."""
    states = enumerate(zip(model.loads, model.load_states, strict=True))
    return all(
        i in model.rigid_contacts or np.array_equal(model.initial_states[where], load.initial_states)
        for i, (load, where) in states
    )


def _slack_unless_balanced(model: Model, t: float, y: Vector) -> tuple[Model, Vector]:
    """Return a model and its state with relaxed anchors of friction, unless the given ones are in balance.

    Otherwise tensioned anchors would remain as preloads in the rest that is found.
    """
    scene, (q, u, z) = model.route.state(t, y), model.parts(y.copy())
    if not any(load.anchors(scene.load_ends(i), scene.load_states(i)) for i, load in enumerate(model.loads)):
        return model, y
    if BalanceSearch(at_rest(model, t, y), t, q, u, np.zeros(0, dtype=int), ()).imbalance(q, u).ratio <= BALANCED:
        return model, y
    for i, load in enumerate(model.loads):
        own = scene.load_ends(i), scene.load_states(i)
        if anchors := load.anchors(*own):
            slack = [np.zeros(len(anchor.slip)) for anchor in anchors]
            z[model.load_states[i]] = load.anchored(*own, slack, [False] * len(anchors))
    return replace(model, initial_states=z), np.concatenate((q, u, z))


def _on_contacts(
    model: Model, t: float, q: Vector, u: Vector, search: Callable[[Model, Vector], Found], led: Vector
) -> Found:
    """Return a balance on compliant contacts, from the coordinates of contact continuation or by relaxation."""
    from kanefe.linear.equilibrium.dynamic_relaxation import found_or_fallen

    def resting(q: Vector) -> Model:
        return at_rest(model, t, np.concatenate((q, u, model.initial_states)))

    return found_or_fallen(lambda q: search(resting(q), q), led, lambda: model, t, q, u)


def _found_or_raised(model: Model, t: float, q: Vector, u: Vector, search: Callable[..., Found]) -> Found:
    """Return a balance from coordinates, or else the one to which the loads lead that are raised from zero."""
    try:
        return search(model, q)
    except SimulationError:
        is_driven = model.driven_count and model.driven_speeds(t)[0].any()
        if u.any() or is_driven or rubbing(model) is not None:
            raise
        from kanefe.linear.equilibrium.load_continuation import raised_to

        led = raised_to(model, t, q)
        if led is None:
            raise
        return search(model, led, BalanceSearch.polished)


def _under_its_loads(
    model: Model,
    t: float,
    q: Vector,
    u: Vector,
    found: np.ndarray,
    held: tuple[str, ...],
    slack: float,
    settle: Settle,
) -> tuple[Model, BalanceSearch, tuple[Vector, Vector]]:
    """Return an equilibrium with consistent joint loads for friction, and the search that found it."""
    for _ in range(MOST_ROUNDS):
        search = BalanceSearch(model, t, q, u, found, held, slack=slack)
        q, u = state = settle(search)
        z = model.literal.with_consistent_loads(t, q, u)
        if np.allclose(z, model.initial_states, rtol=SAME_LOADS, atol=0.0):
            return model, search, state
        model = replace(model, initial_states=z)
    raise SimulationError(
        "no equilibrium of the scene was found: friction that follows the loads of joints changes these again "
        "and again. Remedy: a run to rest, or CoordinateForce(friction=...), which is given"
    )


def _beside_or_settled(search: BalanceSearch) -> tuple[Vector, Vector]:
    """Return the balance to which a scene settles; above a critical speed, that which gyroscopic forces stabilise.

    Above a critical speed a rotor is statically unstable in the rotating frame. A balance near the start is accepted
    there if no motion diverges about it (a whirl may grow, which leads to no other balance), or if the statically
    stable balance is beyond the limit of the bodies.
    """
    if (unbowed := search.unbowed()) is not None:
        return unbowed
    beside = search.beside()
    if beside is None:
        return search.run()
    if not _diverges(search, beside):
        return beside
    try:
        settled = search.run()
    except SimulationError:
        return beside
    bending = worst_bending(search.model, np.array([search.t]), settled[0][None])
    return beside if bending is not None and bending.is_too_far else settled


def _diverges(search: BalanceSearch, state: tuple[Vector, Vector]) -> bool:
    """Return whether a small motion about a balance grows without oscillation."""
    from kanefe.linear.linearisation import linearisation_of
    from kanefe.linear.modes.modes import modes_of

    modes = modes_of(linearisation_of(search.small(*state), (), ()))
    return bool(np.any(modes.grows & (modes.eigenvalues.imag == 0.0)))


def _given_speeds(model: Model, speeds: Mapping[str, Any], find: Sequence[str]) -> tuple[Vector, np.ndarray]:
    """Return u with the given speeds, and the numbers of the speeds to be found."""
    u = np.zeros(model.free_count)
    find = (find,) if isinstance(find, str) else find
    unknown: list[int] = []
    for name in (*speeds, *find):
        body = model.bodies[model.index(name)]
        free = body.speeds[body.speeds < model.free_count]
        if not len(free):
            raise ModelError(
                f"equilibrium: the {body.joint.kind} joint of {name!r} has no free speed. Remedy: leave it out; "
                "drives have their speed from their motion"
            )
        if name in speeds:
            value = np.atleast_1d(numbers(speeds[name]))
            if value.shape != (len(free),) or not np.all(np.isfinite(value)):
                raise ModelError(
                    f"equilibrium: the speeds of {name!r} must be {len(free)} finite numbers "
                    f"({', '.join(body.joint.speed_names)}), not {speeds[name]!r}"
                )
            u[free] = value
        if name in find:
            unknown += free.tolist()
    return u, np.array(sorted(set(unknown)), dtype=int)


def _check_steady(model: Model, t: float, q: Vector, u: Vector) -> None:
    """Raise a SimulationError if the balance is lost as the scene moves."""
    search = BalanceSearch(model, t, q, u, np.zeros(0, dtype=int), ())
    most = max(LOST, 2.0 * search.imbalance(q, u).ratio)
    for tau in times_ahead(model, t, u):
        search.t = t + tau
        q_later, _ = moved_on(model, t, q, u, tau)
        later = search.imbalance(q_later, u)
        if later.ratio > most:
            raise SimulationError(
                f"the scene balances at t = {t:.6g} s but not {tau:.3g} s later, when {later} remains: drives, "
                "loads or gravity change its forces. Remedy: steady=False for the equilibrium at one time, or a run"
            )
