"""Equilibrium: rest under loads, and steady motion at given speeds."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.given_state import knows_states
from kanefe.equations.model import Model
from kanefe.errors import AccuracyWarning, ModelError, SimulationError, SimulationWarning, outside
from kanefe.frames import Vector, numbers
from kanefe.instants.instant import Instant
from kanefe.instants.missed_statics import warn_of_missed
from kanefe.kane.bearing_loads import with_consistent_loads
from kanefe.kane.loop_closure import project_positions
from kanefe.kane.state import State
from kanefe.linear.azimuth import moved_on, times_ahead
from kanefe.linear.equilibrium.balance import BalanceSearch
from kanefe.linear.equilibrium.contact_continuation import felt, is_put_down
from kanefe.linear.equilibrium.dynamic_relaxation import found_or_fallen
from kanefe.linear.equilibrium.other_rest import OtherRest, OtherRestWarning, other_rest
from kanefe.linear.equilibrium.rigid_rest import Found, rest_on_contacts, undetermined
from kanefe.linear.imbalance import BALANCED, Imbalance
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.state import at_rest, rested_states, started_model
from kanefe.scene.targets import Named
from kanefe.tree.bending import Bending, worst_bending

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.linear.linearisation import Linearisation
    from kanefe.linear.state import Freezable

MOST_ROUNDS, SAME_LOADS = 30, 1e-10
"""Largest number of searches, each under the joint loads of the previous one, and the relative change of these loads at
which they end."""

LOST = 1e-6
"""Imbalance later on above which the equilibrium is lost: rotating coordinates carry the round-off of the rotation."""

MOST_NAMED = 6
"""Largest number of modal coordinates of a body that are listed individually."""


class Equilibrium(Instant):
    """A state of rest or of steady motion, found by `equilibrium`; it has all outputs of a `Result` for one time.

    Stresses of what stands or spins steadily: ``kanefe_fem.recover(found, "blade").von_mises``. A run that starts from
    it: ``scene.simulate((0.0, 1.0), start=found)``.

    Attributes
    ----------
    model : Model
    time : float
        s.
    state : ndarray
        y = (q, u, z) of the model, named by `Model.state_names`.
    imbalance : Imbalance
        What is left over where it balances worst.
    iterations : int
    """

    def __init__(
        self,
        model: Model,
        time: float,
        state: Vector,
        imbalance: Imbalance,
        iterations: int,
        begun: Model,
        small: SmallMotions,
    ) -> None:
        super().__init__(model, time, state)
        self.imbalance, self.iterations, self._begun, self._small = imbalance, iterations, begun, small

    def __str__(self) -> str:
        left = "nothing is left free to move"
        if self.imbalance.name:
            left = f"largest imbalance: {self.imbalance}, {self.imbalance.ratio:.1e} of the forces there"
        lines = [f"equilibrium at t = {self.time:g} s after {self.iterations} iterations; {left}"]
        told = [f"  {name}: {value:.6g}" for name, value in self.coordinates.items()]
        for body in reversed(self.model.bodies):
            if body.flexible is not None and body.flexible.body.free_count > MOST_NAMED:
                eta = self.q[body.flexible.eta]
                at = int(np.argmax(np.abs(eta)))
                told[body.flexible.eta] = [
                    f"  {body.name}: {len(eta)} modal coordinates, the largest eta {at}: {eta[at]:.6g}"
                ]
        bending = self.bending
        told += [f"  bending inside bodies: {bending}"] if bending is not None else []
        other = [f"  {self.other_rest}"] if self.other_rest is not None else []
        return "\n".join([*lines, *told, *self._contacts_in_words(), *other])

    @property
    def bending(self) -> Bending | None:
        """The largest rotation inside a flexible body: of the one that is nearest to its reach, or farthest beyond."""
        return worst_bending(self.model, np.array([self.time]), self.q[None])

    @cached_property
    def other_rest(self) -> OtherRest | None:
        """Another rest on contacts that is near, if the one that was found is close to tipping, or has lifted some."""
        if not self.contacts:
            return None
        return other_rest(self.model, self.time, self.q, self.u, self._begun)

    @property
    def carrying(self) -> dict[str, float]:
        """Normal forces of the contacts that carry something, by name, N; see ``contact(name)`` for more of one."""
        forces = {name: float(self.contact(name).normal) for name in self.contacts}
        return {name: force for name, force in forces.items() if force > 0.0}

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Rigid contacts whose normal forces are not unique for rigid bodies: those of least norm are given."""
        return undetermined(State(self.model, self.time, self.q, self.u, self.z))

    def _contacts_in_words(self) -> list[str]:
        """Return a line for each contact."""
        lines, carrying, shared = [], self.carrying, self.undetermined
        for name in self.contacts:
            one = self.contact(name)
            if name not in carrying:
                lines.append(f"  contact {name}: carries nothing, gap {-float(one.penetration):.4g} m")
                continue
            rubs = f", friction {float(one.tangential):.6g} N" if float(one.tangential) > 0.0 else ""
            how = " (not unique for rigid bodies: of least norm)" if name in shared else ""
            lines.append(f"  contact {name}: carries {carrying[name]:.6g} N{how}{rubs}")
        return lines

    def linearise(self, *, inputs: Named | None = None, outputs: Named | None = None) -> Linearisation:
        """Linearise about this state: see `kanefe.linearise`."""
        from kanefe.linear.linearisation import linearised

        return linearised(self.model, self.time, self.state, inputs, outputs, self._small)


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
    """Find a state in which nothing accelerates: at rest, or in steady motion.

    Driven joints move as they are driven; a blade on a shaft at a steady rate is balanced in the frame that spins.
    Loops stay closed. From the start the scene goes to where it would settle if it moved in thick oil (Newton's
    method on a stiffness made positive); if there is no such place, to the nearest unstable one. A start that is in
    balance stays, also if it is unstable: see ``equilibrium(...).linearise().modes()``. A rotor beyond a critical speed
    would run away in oil that spins with it: it is balanced beside the start, where gyroscopic forces hold it.

    On rigid contacts it rests so that none pulls and none is entered. What sticks stays where it touches, as far as its
    friction holds; ``carrying`` tells what each contact carries.

    Parameters
    ----------
    scene : System or Model
    t : float, optional
        Time at which loads and drives are taken, s; default: that of the start, or zero.
    start : state, optional
        Where the search begins, as `kanefe.System.simulate` takes it; its speeds do not count. Default: the start of
        the scene.
    speeds : mapping of str to float or sequence, optional
        Free joint speeds that are kept, by body, rad/s and m/s: of a rotor that nothing drives or brakes. All other
        speeds are zero.
    find : sequence of str, optional
        Bodies whose joint speeds are found (trim), from those in `speeds` on, while their coordinates, and those of
        bodies with given speeds, stay: the precession of a top at a given lean.
    steady : bool
        Whether the balance must also hold later, as drives turn and loads change; False: at time t only.

    Raises
    ------
    ModelError
        If a name or a number makes no sense.
    SimulationError
        If there is no balance: the message says what is left over, along which coordinate, or which contact slips, and
        what to try.

    Warns
    -----
    AccuracyWarning
        If the modes of a body miss much of how gravity, spin or tractions deform it, or if it is bent beyond the reach
        of its kinematics.
    OtherRestWarning
        If contacts that touched at the start have lifted, or the rest is near to tipping off those that carry least.

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
        warnings.warn(f"equilibrium: {found.other_rest}", OtherRestWarning, stacklevel=outside())
    if (bending := found.bending) is not None and bending.is_too_far:
        warnings.warn(f"equilibrium: {bending.remark}", AccuracyWarning, stacklevel=outside())
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
    """Return what `equilibrium` does, without a word on modes: for analyses that ask for many.

    `slack` (1/s2): what is hardly resisted, see `BalanceSearch`.
    """
    with warnings.catch_warnings():  # of contacts that begin deep: a rest is what they are told to start from
        warnings.filterwarnings("ignore", "contact .* begins .* deep", SimulationWarning)
        falling, time, y = started_model(scene, t, start, "equilibrium")
        if start is None or not knows_states(falling, start):
            falling, y = _slack_unless_balanced(falling, time, y)
    model, q = at_rest(falling, time, y), falling.parts(y)[0]
    begun = replace(model, initial_coordinates=q)
    if model.constraints and start is None:
        q = project_positions(model, time, q)
    u, found = _given_speeds(model, speeds or {}, find)
    if len(found) and model.is_constrained:
        raise ModelError(
            "equilibrium: speeds to be found and rigid contacts or loops at once are not supported. Remedy: give the "
            "speeds, and try several"
        )
    held = tuple(speeds or {}) if len(found) else ()
    may_part = any(load.may_part for load in model.loads) and is_put_down(model)
    settle = BalanceSearch.run if may_part or model.rigid_contacts else _beside_or_settled

    def search_from(model: Model, q: Vector) -> Found:
        return _under_its_loads(model, time, q, u, found, held, slack, settle)

    if model.rigid_contacts:
        stiff = model

        def feel(q: Vector, yielding: Callable[[float], Model]) -> Vector:
            return felt(stiff, time, q, u, found, held, yielding)

        model, search, state = rest_on_contacts(model, time, q, u, search_from, feel, not may_part)
    else:
        if may_part:
            led = felt(model, time, q, u, found, held)
            model, search, state = _on_contacts(falling, time, q, u, search_from, led)
        else:
            model, search, state = search_from(model, q)
    q, u = state
    if steady:
        _check_steady(model, time, *state)
    z = rested_states(model, time, np.concatenate((*state, model.initial_states)))
    y = np.concatenate((*state, z))
    return Equilibrium(
        at_rest(model, time, y), time, y, search.imbalance(q, u), search.iterations, begun, search.small(q, u)
    )


def _slack_unless_balanced(model: Model, t: float, y: Vector) -> tuple[Model, Vector]:
    """Return a model and its state with slack anchors of friction, unless those that it has leave it in balance.

    Others would stay in the rest that is found from there, as if something had been wound up.
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
    """Return a balance on contacts that yield, from where the search among them has led, or as the scene falls."""

    def resting(q: Vector) -> Model:
        return at_rest(model, t, np.concatenate((q, u, model.initial_states)))

    return found_or_fallen(lambda q: search(resting(q), q), led, lambda: model, t, q, u)


def _under_its_loads(
    model: Model,
    t: float,
    q: Vector,
    u: Vector,
    found: np.ndarray,
    held: tuple[str, ...],
    slack: float,
    settle: Callable[[BalanceSearch], tuple[Vector, Vector]],
) -> tuple[Model, BalanceSearch, tuple[Vector, Vector]]:
    """Return an equilibrium with the joint loads on friction there, and the search that found it."""
    for _ in range(MOST_ROUNDS):
        search = BalanceSearch(model, t, q, u, found, held, slack=slack)
        q, u = state = settle(search)
        z = with_consistent_loads(model, t, q, u, model.initial_states)
        if np.allclose(z, model.initial_states, rtol=SAME_LOADS, atol=0.0):
            return model, search, state
        model = replace(model, initial_states=z)
    raise SimulationError(
        "no equilibrium of the scene was found: friction that follows the loads of joints changes these again "
        "and again. Remedy: a run to rest, or CoordinateForce(friction=...), which is given"
    )


def _beside_or_settled(search: BalanceSearch) -> tuple[Vector, Vector]:
    """Return where a scene settles; beyond a critical speed, where it whirls about itself.

    In thick oil that spins with it a rotor would run away from its axis; its gyroscopic forces hold it beside that.
    A balance beside the start counts where nothing diverges (a whirl may grow, and does not settle elsewhere then), and
    where it would settle at none within the reach of its bodies.
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
    if isinstance(find, str):
        find = (find,)
    numbers_found: list[int] = []
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
            numbers_found += free.tolist()
    return u, np.array(sorted(set(numbers_found)), dtype=int)


def _check_steady(model: Model, t: float, q: Vector, u: Vector) -> None:
    """Raise a SimulationError if the balance is lost as what moves moves on."""
    search = BalanceSearch(model, t, q, u, np.zeros(0, dtype=int), ())
    most = max(LOST, 2.0 * search.imbalance(q, u).ratio)
    for tau in times_ahead(model, t, u):
        search.t = t + tau
        q_later, _ = moved_on(model, t, q, u, tau)
        later = search.imbalance(q_later, u)
        if later.ratio > most:
            raise SimulationError(
                f"the scene balances at t = {t:.6g} s but not {tau:.3g} s later, when {later} is left over: drives, "
                "loads or gravity change what it feels. Remedy: steady=False for the equilibrium at one time, or a run"
            )
