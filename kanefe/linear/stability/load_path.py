"""The change of the stiffness of a scene with proportionally raised loads, for buckling and flutter.

At rest under ``kept loads + factor x raised loads``, to first order in the factor,

    K(factor) = K + factor dK,    dK = dK/df + (dK/dq) dq/df,    dq/df = K^-1 df

K is the tangent stiffness of the scene at rest under the kept loads, df the generalised forces of the raised loads.
Both parts of dK are found together, by differences of the stiffness with slightly raised loads and their displacement.
(Zienkiewicz & Taylor, The Finite Element Method, vol. 2, on linearised buckling.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.given_state import Start
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.linear.equilibrium.balance import closed, step_length
from kanefe.linear.equilibrium.equilibria import balanced
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.stability.raised_loads import chosen_loads, scaled_model
from kanefe.linear.state import Freezable, check_no_rigid_contacts, model_in_state
from kanefe.linear.tangents import difference, tangent_names, tangent_steps
from kanefe.tree.stiffening_check import unstiffened

if TYPE_CHECKING:
    from kanefe.tree.load_names import SceneLoad

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
    raised, kept = chosen_loads(model, time, loads, what)
    _check_spread(raised, what)
    _check_stiffening(model, what)
    none = scaled_model(model, time, raised, 0.0)
    y = np.concatenate((q, np.zeros(model.free_count), model.initial_states))
    found = balanced(none, t=time, start=None if start is None else y)
    rest = np.zeros(model.free_count)
    small = SmallMotions(none, time, found.q, rest)
    if small.is_moving:
        raise ModelError(f"{what}: a driven joint moves. Remedy: a time t at which all drives are at rest")
    M, C, K = matrices_at_rest(small)
    check_resisted(small, M, K, what)
    loaded = SmallMotions(scaled_model(model, time, raised, 1.0), time, found.q, rest)
    p = np.linalg.solve(K, M @ (loaded.du - small.du)[small.positions.leading])
    z = small.positions.N @ p

    def stiffness(factor: float) -> Matrix:
        return _stiffness_beside(small, scaled_model(model, time, raised, factor), factor * z, what)

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
    q, _ = closed(model, small.t, model.advance(small.q, z), small.u)
    beside = SmallMotions(model, small.t, q, small.u)
    if not np.array_equal(beside.positions.leading, small.positions.leading):
        raise ModelError(f"{what}: the loops are close to a singular position. Remedy: a start away from it")
    return matrices_at_rest(beside)[2]


def matrices_at_rest(small: SmallMotions) -> tuple[Matrix, Matrix, Matrix]:
    """Return mass, factor of the rates and stiffness of a scene at rest."""
    if not small.is_holonomic:
        raise ModelError(
            "a scene that rolls has more coordinates than speeds and no stiffness of its coordinates alone. Remedy: "
            "linearise(...).modes() at several loads"
        )
    N, lead = small.positions.N, small.positions.leading
    M = N.T @ small.mass @ N
    return M, -M @ small.along_speeds.ddu[lead], -M @ small.along_positions.ddu[lead]


def _check_spread(raised: dict[str, SceneLoad | None], what: str) -> None:
    """Raise a ModelError for distributed loads that turn with the frame of their body alone."""
    for name, load in raised.items():
        if load is not None and load.turns_with_frame:
            raise ModelError(
                f"{what}: {name} turns with the frame of its body, but not as its surface deforms, which changes the "
                "stiffness. Remedy: add_pressure(..., follows=True), a traction in fixed directions, forces on "
                "interfaces, or loads= without it"
            )


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


def check_resisted(small: SmallMotions, M: Matrix, K: Matrix, what: str, may_tip: bool = False) -> None:
    """Raise a ModelError if the scene is not held, or (unless it `may_tip`) not stable, under the kept loads."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(M), 1e-300))
    squares, vectors = np.linalg.eigh(0.5 * (K + K.T) * np.outer(scale, scale))
    largest = float(np.abs(squares).max())
    weakest = int(np.abs(squares).argmin()) if may_tip else 0
    least = float(abs(squares[weakest]) if may_tip else squares[0])
    if least > RESISTED * largest:
        return
    worst = int(small.positions.leading[np.abs(vectors[:, weakest]).argmax()])
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
