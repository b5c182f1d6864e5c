"""The change of the stiffness of a scene with proportionally raised loads, for buckling and flutter.

At rest under ``kept loads + factor x raised loads``, to first order in the factor,

    K(factor) = K + factor dK,    dK = dK/df + (dK/dq) dq/df,    dq/df = K^-1 df

K is the tangent stiffness of the scene at rest under the kept loads, df the generalised forces of the raised loads.
Both parts of dK are found together, by differences of the stiffness with slightly raised loads and their displacement.
(Zienkiewicz & Taylor, The Finite Element Method, vol. 2, on linearised buckling.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.equations.given_state import Start
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.kane.loop_closure import project_positions
from kanefe.linear.equilibrium.balance import step_length
from kanefe.linear.equilibrium.equilibria import balanced
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.state import Freezable, check_no_rigid_contacts, model_in_state
from kanefe.linear.tangents import difference, tangent_names, tangent_steps
from kanefe.loads.functions import Constant
from kanefe.tree.load_names import named_loads
from kanefe.tree.stiffening_check import unstiffened

if TYPE_CHECKING:
    from kanefe.tree.load_names import SceneLoad

GRAVITY = "gravity"

RESISTED = 1e-11
"""Eigenvalue of the scaled stiffness, relative to the largest, below which a motion has no restoring force."""


@dataclass(frozen=True, eq=False)
class LoadPath:
    """A scene at rest, and the change of its stiffness with the loads, over its independent coordinates p.

    Attributes
    ----------
    small : SmallMotions
        At rest under the kept loads.
    raised, kept : tuple of str
        Names of loads.
    turning : tuple of str
        Names of the raised loads that may have no potential: follower forces and torques.
    M, C, K : ndarray, shape (p, p)
        Mass, factor of the rates, and stiffness.
    dK : ndarray, shape (p, p)
        Change of the stiffness with the factor of the loads.
    displacement : ndarray, shape (free,)
        Change of the tangents with the factor.
    """

    small: SmallMotions
    raised: tuple[str, ...]
    kept: tuple[str, ...]
    turning: tuple[str, ...]
    M: Matrix
    C: Matrix
    K: Matrix
    dK: Matrix
    displacement: Vector

    def along(self, p: Matrix) -> Matrix:
        """Return tangents of the tree (free, k) of independent coordinates (p, k)."""
        return np.asarray(self.small.positions.N @ p)

    def moved_by(self, tangent: Vector) -> float:
        """Return the largest displacement along a tangent, in rad or scene lengths."""
        return step_length(self.small.model, tangent)

    def __str__(self) -> str:
        kept = f"; kept: {', '.join(self.kept)}" if self.kept else ""
        return f"at t = {self.small.t:g} s; raised: {', '.join(self.raised)}{kept}"


def load_path(
    scene: Freezable | Model, t: float | None, start: Start, loads: str | Sequence[str] | None, what: str
) -> LoadPath:
    """Return the change of the stiffness of a scene at rest with its loads; a ModelError names unsupported input."""
    model, time, q, _ = model_in_state(scene, t, start, what)
    check_no_rigid_contacts(model, what)
    raised, kept = _chosen(model, time, loads, what)
    _check_stiffening(model, what)
    none = _scaled(model, time, raised, 0.0)
    y = np.concatenate((q, np.zeros(model.free_count), model.initial_states))
    found = balanced(none, t=time, start=None if start is None else y)
    rest = np.zeros(model.free_count)
    small = SmallMotions(none, time, found.q, rest)
    if small.is_moving:
        raise ModelError(f"{what}: a driven joint moves. Remedy: a time t at which all drives are at rest")
    M, C, K = _matrices(small)
    _check_resisted(small, M, K, what)
    loaded = SmallMotions(_scaled(model, time, raised, 1.0), time, found.q, rest)
    p = np.linalg.solve(K, M @ (loaded.du - small.du)[small.positions.leading])
    z = small.positions.N @ p

    def stiffness(factor: float) -> Matrix:
        return _stiffness_beside(small, _scaled(model, time, raised, factor), factor * z, what)

    reach = float(tangent_steps(model, z[:, None])[0]) if z.any() else np.inf
    first = difference(stiffness, min(reach, 1.0))
    scale = 1.0 / np.sqrt(np.diag(K))
    size = float(np.abs(first * np.outer(scale, scale)).max(initial=0.0))
    # a step over which the stiffness changes by its own size, so that round-off is small
    dK = difference(stiffness, min(reach, 1.0 / size)) if size > 0.0 else first
    turning = tuple(name for name, load in raised.items() if load is not None and load.turns)
    return LoadPath(small, tuple(raised), kept, turning, M, C, K, dK, z)


def _stiffness_beside(small: SmallMotions, model: Model, z: Vector, what: str) -> Matrix:
    """Return the stiffness of a model whose loads are raised, at tangents z from rest."""
    q = model.advance(small.q, z)
    if model.constraints:
        q = project_positions(model, small.t, q)
    beside = SmallMotions(model, small.t, q, small.u)
    if not np.array_equal(beside.positions.leading, small.positions.leading):
        raise ModelError(f"{what}: the loops are close to a singular position. Remedy: a start away from it")
    return _matrices(beside)[2]


def _matrices(small: SmallMotions) -> tuple[Matrix, Matrix, Matrix]:
    """Return mass, factor of the rates and stiffness of a scene at rest."""
    if not small.is_holonomic:
        raise ModelError(
            "a scene that rolls has more coordinates than speeds and no stiffness of its coordinates alone. Remedy: "
            "linearise(...).modes() at several loads"
        )
    N, lead = small.positions.N, small.positions.leading
    M = N.T @ small.mass @ N
    return M, -M @ small.along_speeds.ddu[lead], -M @ small.along_positions.ddu[lead]


def _chosen(
    model: Model, t: float, loads: str | Sequence[str] | None, what: str
) -> tuple[dict[str, SceneLoad | None], tuple[str, ...]]:
    """Return the loads that are raised by name (None: gravity), and the names of those that are kept."""
    there: dict[str, SceneLoad | None] = {**named_loads(model)}
    if model.gravity.any() and any(body.has_gravity for body in model.bodies):
        there[GRAVITY] = None
    laws = [name for name, load in there.items() if load is not None and load.takes_state and not load.is_constant]
    if loads is None:
        names = [name for name in there if name not in laws]
    else:
        given = (loads,) if isinstance(loads, str) else tuple(loads)
        names = [str(name).strip().removeprefix("load ") for name in given]
    for name in names:
        if name not in there:
            raise ModelError(f"{what}: the scene has no load {name!r}. It has: {', '.join(there) or 'none'}")
        if name in laws:
            raise ModelError(
                f"{what}: {name} is a function of the state, and part of the stiffness. Remedy: leave it out of loads="
            )
    raised = {name: there[name] for name in names if _size(model, t, there[name]) > 0.0}
    if not raised:
        raise ModelError(
            f"{what}: no load is raised. Remedy: add_force, add_traction or gravity, with values that are not zero at "
            f"t = {t:g} s"
        )
    for name, load in raised.items():
        if load is not None and load.is_spread and load.turns:
            raise ModelError(
                f"{what}: {name} turns with its surface, which changes the stiffness, and this change is not "
                "supported. Remedy: a traction in fixed directions, forces on interfaces, or loads= without it"
            )
    return raised, tuple(name for name in there if name not in raised)


def _size(model: Model, t: float, load: SceneLoad | None) -> float:
    return float(np.abs(model.gravity if load is None else load.value(t)).max())


def _scaled(model: Model, t: float, raised: dict[str, SceneLoad | None], factor: float) -> Model:
    """Return the model with the raised loads at time t (s) times a factor, and constant."""
    changed: dict[int, Any] = {
        id(load): replace(load, function=Constant(factor * load.value(t)))
        for load in raised.values()
        if load is not None
    }
    bodies = tuple(
        replace(
            body,
            loads=tuple((changed.get(id(load), load), frame) for load, frame in body.loads),
            joint_loads=tuple(changed.get(id(load), load) for load in body.joint_loads),
            field_loads=tuple(changed.get(id(load), load) for load in body.field_loads),
        )
        for body in model.bodies
    )
    gravity = factor * model.gravity if GRAVITY in raised else model.gravity
    return replace(model, bodies=bodies, gravity=gravity)


def _check_stiffening(model: Model, what: str) -> None:
    """Raise a ModelError for flexible bodies whose stiffness does not depend on their loads."""
    for body in model.bodies:
        flexible = None if body.flexible is None else body.flexible.body
        if flexible is not None and not flexible.bends_far and flexible.moments.quadratic_first is None:
            raise ModelError(
                f"{what}: flexible body {body.name!r} has no geometric stiffness, so that no load can buckle it. "
                "Remedy: make it with stiffening='full'"
            )
    for number, words in unstiffened(model):
        raise ModelError(
            f"{what}: flexible body {model.bodies[number].name!r} has stiffening='inertial', which leaves out what "
            f"{words} does to its stiffness. Remedy: make it with stiffening='full'"
        )


def _check_resisted(small: SmallMotions, M: Matrix, K: Matrix, what: str) -> None:
    """Raise a ModelError if the scene is not stable, or not held, under the kept loads."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(M), 1e-300))
    squares, vectors = np.linalg.eigh(0.5 * (K + K.T) * np.outer(scale, scale))
    least, largest = float(squares[0]), float(np.abs(squares).max())
    if least > RESISTED * largest:
        return
    worst = int(small.positions.leading[np.abs(vectors[:, 0]).argmax()])
    name = tangent_names(small.model)[worst]
    if least < -RESISTED * largest:
        raise ModelError(
            f"{what}: the scene is not stable even without the loads that are raised: it tips along {name}. Remedy: "
            "springs, supports, or loads= with those that tip it"
        )
    raise ModelError(
        f"{what}: without the loads that are raised there is no restoring force along {name}. Remedy: a support or a "
        "spring there, or loads= without those that hold it"
    )
