"""Equilibrium: rest under loads, and steady motion at given speeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.linalg

from kanefe.equations.model import Model
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Matrix, Vector, numbers
from kanefe.kane.loop_closure import project_positions, project_speeds
from kanefe.linear.imbalance import BALANCED, Imbalance, worst_imbalance
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.state import model_in_state, model_of
from kanefe.linear.tangents import DIFFERENCE_STEP, tangent_steps
from kanefe.linear.targets import Named

if TYPE_CHECKING:
    from kanefe.linear.linearisation import Linearisation
    from kanefe.linear.state import Freezable

LARGEST_ITERATIONS = 200

LARGEST_HALVINGS = 12

PATIENCE = {True: 80, False: 20}
"""Iterations without a better balance after which a search ends, of one that settles and of one that does not: what
settles may go through worse."""

STILL = 1e-14
"""Step, in rad or scene lengths, after which nothing is left that moves."""

LARGEST_STEP = 0.3
"""Of one iteration, in rad or scene lengths."""

NEUTRAL = 1e-11
"""Singular value of the scaled stiffness, of the largest, below which nothing resists a motion."""

POLISHED = 1e-13
"""Imbalance below which iterations go on only while they help."""

SAMPLES = (0.37, 1.1, 2.6, 5.3)
"""How far a steady motion is followed to see whether it stays in balance: rad or m of its fastest speed, or s."""


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A state of rest or of steady motion, found by `equilibrium`.

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

    model: Model
    time: float
    state: Vector
    imbalance: Imbalance
    iterations: int

    @property
    def coordinates(self) -> dict[str, float]:
        """Coordinates q by name."""
        names = self.model.coordinate_names()
        return dict(zip(names, self.state.tolist(), strict=False))

    def position(self, body: str, interface: str = "") -> Vector:
        """Return where the frame of a body or interface is, in N, m."""
        return self.model.kinematics(body, self.time, self.state, interface).position

    def joint_coordinates(self, body: str) -> Vector:
        """Return the coordinates of a body's joint, rad and m."""
        terms = self.model.bodies[self.model.index(body)]
        return np.array(terms.joint_coordinates(self.time, self.state[: self.model.coordinate_count]))

    def deflection(self, body: str, interface: str) -> Vector:
        """Return displacement (m) and slopes (rad) of an interface in the mesh frame, shape (6,)."""
        terms = self.model.flexible_terms(body)
        return np.array(terms.body.interface(interface).moved(self.state[terms.eta])[0])

    def joint_reactions(self) -> dict[str, Vector]:
        """Return what each joint exerts on its body: see `Model.joint_reactions`."""
        return self.model.joint_reactions(self.time, self.state)

    def linearise(self, *, inputs: Named | None = None, outputs: Named | None = None) -> Linearisation:
        """Linearise about this state: see `kanefe.linearise`."""
        from kanefe.linear.linearisation import linearise

        return linearise(self.model, self.time, self.state, inputs=inputs, outputs=outputs)


def equilibrium(
    scene: Freezable | Model,
    *,
    t: float = 0.0,
    start: Sequence[float] | np.ndarray | None = None,
    speeds: Mapping[str, Any] | None = None,
    find: Sequence[str] = (),
    steady: bool = True,
) -> Equilibrium:
    """Find a state in which nothing accelerates: at rest, or in steady motion.

    Driven joints move as they are driven; a blade on a shaft at a steady rate is balanced in the frame that spins.
    Loops stay closed. From the start the scene goes to where it would settle if it moved in thick oil (Newton's
    method on a stiffness made positive); if there is no such place, to the nearest unstable one. A start that is in
    balance stays, also if it is unstable: see ``equilibrium(...).linearise().modes()``.

    Parameters
    ----------
    scene : System or Model
    t : float
        Time at which loads and drives are taken, s.
    start : array_like, optional
        State y = (q, u) where the search begins; its speeds do not count. Default: the start of the scene.
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
        If there is no balance: the message says what is left over, along which coordinate, and what to try.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> spring = kf.CoordinateForce(stiffness=100.0)
    >>> ball = scene.add_rigid_body("ball", 2.0, joint=kf.Prismatic("z", forces=spring))
    >>> round(float(kf.equilibrium(scene).joint_coordinates("ball")[0]), 6)
    -0.1962
    """
    model = model_of(scene, "equilibrium", t)
    y = None if start is None else numbers(start).astype(float)
    if y is None or y.shape == (model.coordinate_count + model.free_count,):
        q = model.initial_coordinates if y is None else y[: model.coordinate_count]
        if model.constraints and start is None:
            q = project_positions(model, t, q)
        y = np.concatenate((q, np.zeros(model.free_count), model.initial_states))
    model, time, q, _ = model_in_state(model, t, y, "equilibrium")
    u, found = _given_speeds(model, speeds or {}, find)
    if len(found) and model.constraints:
        raise ModelError(
            "equilibrium: speeds to be found and loops at once are not offered. Remedy: give the speeds, and try "
            "several"
        )
    search = _Search(model, time, q, u, found, tuple(speeds or {}) if len(found) else ())
    state = search.run()
    if steady:
        _check_steady(model, time, *state)
    q, u = state
    return Equilibrium(
        model, time, np.concatenate((*state, model.initial_states)), search.imbalance(q, u), search.iterations
    )


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


class _Search:
    """Newton's method for a state without accelerations.

    Unknown are the independent tangents p, and speeds that are to be found; the equations are the leading
    accelerations. In the metric of the mass matrix their Jacobian is minus a stiffness over mass.
    """

    def __init__(self, model: Model, t: float, q: Vector, u: Vector, found: np.ndarray, held: Sequence[str]) -> None:
        self.model, self.t, self.q, self.u, self.found = model, t, q, u, found
        self.iterations = 0
        self._held = np.zeros(model.free_count, dtype=bool)
        self._held[found] = True
        for name in held:
            at = model.bodies[model.index(name)].speeds
            self._held[at[at < model.free_count]] = True

    def run(self) -> tuple[Vector, Vector]:
        """Return q and u in balance."""
        start = self._closed(self.q, self.u)
        state, imbalance = self._iterate(start, settles=not len(self.found))
        if imbalance.ratio > BALANCED:
            other, again = self._iterate(start, settles=False)
            if again.ratio < imbalance.ratio:
                state, imbalance = other, again
        if imbalance.ratio > BALANCED:
            raise SimulationError(self._advice(imbalance))
        return state

    def imbalance(self, q: Vector, u: Vector) -> Imbalance:
        """Return what balances worst in a state."""
        du = self._rates(q, u)
        N, leading = np.eye(len(du)), np.arange(len(du))
        if self.model.constraints:
            small = SmallMotions(self.model, self.t, q, u)
            N, leading = small.speeds.N, small.speeds.leading
        return worst_imbalance(self.model, self.t, q, u, du, N, leading)

    def _rates(self, q: Vector, u: Vector) -> Vector:
        """Return the accelerations."""
        z = self.model.initial_states
        return self.model.parts(self.model.rhs(self.t, np.concatenate((q, u, z))))[1]

    def _closed(self, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        if not self.model.constraints:
            return q, u
        q = project_positions(self.model, self.t, q)
        return q, project_speeds(self.model, self.t, q, u)

    def _iterate(self, start: tuple[Vector, Vector], settles: bool) -> tuple[tuple[Vector, Vector], Imbalance]:
        """Return the best state on the way from the start, and its imbalance."""
        (q, u), best = start, self.imbalance(*start)
        state, improved = start, 0
        for count in range(LARGEST_ITERATIONS):
            if best.ratio <= POLISHED or count - improved > PATIENCE[settles]:
                break
            z, du = self._step(q, u, settles)
            if _length(self.model, z) < STILL and not du.any():
                break
            self.iterations += 1
            q_new, u_new, now = self._advanced(q, u, z, du, settles)
            if not np.isfinite(now.ratio) or (best.ratio <= BALANCED and not now.ratio < 0.5 * best.ratio):
                break
            q, u = q_new, u_new
            if now.ratio < 0.99 * best.ratio:
                improved = count
            if now.ratio < best.ratio:
                state, best = (q, u), now
        return state, best

    def _step(self, q: Vector, u: Vector, settles: bool) -> tuple[Vector, Vector]:
        """Return the tangent z and the change of u of one iteration."""
        model = self.model
        small = SmallMotions(model, self.t, q, u)
        P, lead = small.along_positions, small.speeds.leading
        kept = np.flatnonzero(~self._held[small.positions.leading])
        M = small.speeds.N.T @ small.mass() @ small.speeds.N
        L = np.linalg.cholesky(M) if len(M) else M
        residual = L.T @ small.du[lead]
        if small.is_holonomic and not len(self.found) and len(kept) == len(lead):
            # stiffness over mass in coordinates of unit mass
            H = -L.T @ P.ddu[lead] @ np.linalg.inv(L.T)
            lowest = float(scipy.linalg.eigvalsh(0.5 * (H + H.T)).min(initial=0.0))
            size = float(np.abs(H).max(initial=0.0))
            shift = -1.5 * lowest if settles and lowest < -1e-9 * size else 0.0
            p = np.linalg.solve(L.T, _solved(H + shift * np.eye(len(H)), residual))
            return P.z @ p, P.du @ p
        columns = P.ddu[np.ix_(lead, kept)]
        if len(self.found):
            columns = np.hstack((columns, small.along_speeds.ddu[np.ix_(lead, self.found)]))
        x = _solved(-L.T @ columns, residual)
        z, du = P.z[:, kept] @ x[: len(kept)], P.du[:, kept] @ x[: len(kept)]
        du[self.found] += x[len(kept) :]
        return z, du

    def _advanced(self, q: Vector, u: Vector, z: Vector, du: Vector, settles: bool) -> tuple[Vector, Vector, Imbalance]:
        """Return the state after the step: no longer than the scene is linear, and halved while it goes too far.

        Too far to settle: where the forces push back harder than they pushed on. Else: where accelerations are larger.
        """
        share = LARGEST_STEP / max(_length(self.model, z), LARGEST_STEP)
        before, pushed = self._size(q, u, z)
        for _ in range(LARGEST_HALVINGS):
            q_new, u_new = self._closed(self.model.advance(q, share * z), u + share * du)
            size, push = self._size(q_new, u_new, z)
            if push >= -0.9 * pushed if settles else size < before:
                break
            share *= 0.5
        return q_new, u_new, self.imbalance(q_new, u_new)

    def _size(self, q: Vector, u: Vector, z: Vector) -> tuple[float, float]:
        """Return du^T M du of a state, and the force along a tangent."""
        du = self._rates(q, u)
        forces = self.model.mass_matrix(self.t, np.concatenate((q, u, self.model.initial_states))) @ du
        return float(du @ forces), float(z @ forces)

    def _advice(self, imbalance: Imbalance) -> str:
        text = f"the scene has no balance that could be found at t = {self.t:.6g} s: {imbalance} is left over"
        if imbalance.ratio > 0.5:
            return (
                f"{text}, and nothing holds it. Remedy: a spring, a support or a drive there; of a body that falls, "
                "gravity=False; of one that spins or runs steadily, its speed in speeds={...}"
            )
        return (
            f"{text} after {self.iterations} iterations. Remedy: start=..., a state nearer to the balance (such as "
            "the end of a damped run), or loads and speeds raised in steps, each from the last state"
        )


def _length(model: Model, z: Vector) -> float:
    """Return how far a tangent goes where it goes farthest, in rad or scene lengths."""
    return DIFFERENCE_STEP / float(tangent_steps(model, z[:, None])[0]) if z.any() else 0.0


def _solved(H: Matrix, right: Vector) -> Vector:
    """Return the least x of ``H x = right`` with rows and columns scaled alike; what nothing resists stays."""
    if not H.size:
        return np.zeros(H.shape[1])
    columns = np.sqrt(np.abs(H).max(axis=0))
    rows = np.sqrt(np.abs(H).max(axis=1))
    floor = 1e-12 * max(float(columns.max()), 1e-300)
    columns, rows = (np.where(x > floor, x, 1.0) for x in (columns, rows))
    x = np.linalg.lstsq(H / rows[:, None] / columns[None, :], right / rows, rcond=NEUTRAL)[0]
    return np.asarray(x / columns)


def _check_steady(model: Model, t: float, q: Vector, u: Vector) -> None:
    """Raise a SimulationError if the balance is lost as what moves moves on."""
    driven = model.driven_speeds(t)[0] if model.driven_count else np.zeros(0)
    fastest = float(max(np.abs(u).max(initial=0.0), np.abs(driven).max(initial=0.0)))
    times = [tau / fastest for tau in SAMPLES] if fastest > 0.0 else []
    if not model.route.is_constant or model.driven_count:
        times += list(SAMPLES)
    search = _Search(model, t, q, u, np.zeros(0, dtype=int), ())
    for tau in times:
        if any(t + tau > motion.span[1] for motion, _ in model.drives):
            continue
        search.t = t + tau
        q_later = model.advance(q, tau * u)
        if model.constraints:
            q_later = project_positions(model, t + tau, q_later)
        later = search.imbalance(q_later, u)
        # the coordinates that turn carry the round-off of the turn
        if later.ratio > 1e-6:
            raise SimulationError(
                f"the scene balances at t = {t:.6g} s but not {tau:.3g} s later, when {later} is left over: drives, "
                "loads or gravity change what it feels. Remedy: steady=False for the balance at one time, or a run"
            )
