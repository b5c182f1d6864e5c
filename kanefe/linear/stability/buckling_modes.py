"""Buckling of a scene: load factors at which the stiffness along a motion vanishes, and the shapes of these motions.

    (K + factor dK) p = 0

with K and dK of `kanefe.linear.stability.load_path`: linearised buckling of bodies, joints, springs and loops at once.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.frames import Matrix, Vector
from kanefe.linear.modes.mode_shapes import Shapes
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.stability.load_path import LoadPath, load_path

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.linear.state import Freezable

SYMMETRIC = 1e-7
"""Asymmetry of the scaled dK, relative to its largest entry, that is round-off: differences leave about 1e-10."""

AFFECTED = 1e-9
"""Inverse of a load factor, relative to the largest, below which the loads do not affect a motion."""

CHANGE = 0.2
"""Change of the lowest factor with the upper half of the modes of bodies from which more modes are asked for: columns
and strips on which it was 0.003 to 0.08 were right to 0.1 to 2 %, one without a factor of the lower half 40 % off."""

FAR = 0.1
"""Displacement before buckling above which buckling is nonlinear, rad or scene lengths."""


@dataclass(frozen=True, eq=False)
class Buckling(Shapes):
    """Load factors at which a scene buckles, lowest first, and shapes; ``print`` shows a table.

    Attributes
    ----------
    path : LoadPath
        The scene at rest, and the raised loads.
    factors : ndarray, shape (k,)
        Multiples of the raised loads.
    vectors : ndarray, shape (p, k)
        Over the independent coordinates; the largest displacement is one rad or one scene length.
    reversed_factor : float
        The lowest factor for reversed loads; inf if those do not buckle the scene.
    change_by_modes : float
        What the upper half of the modes of reduced bodies takes from the lowest factor, relative to it; inf if it does
        not buckle without them. More modes take less.
    """

    path: LoadPath
    factors: Vector
    vectors: Matrix
    reversed_factor: float
    change_by_modes: float

    @property
    def _small(self) -> SmallMotions:
        return self.path.small

    @cached_property
    def tangents(self) -> np.ndarray:
        """Shapes as tangents of the tree (free, k), real: what `Model.advance` takes."""
        return self.path.along(self.vectors)

    def __str__(self) -> str:
        lines = [f"buckling {self.path}", f"{'mode':>4}  {'factor':>14}  moves (share of kinetic energy)"]
        lines += [f"{i:4d}  {factor:14.6g}  {self.describe(i)}" for i, factor in enumerate(self.factors)]
        if not len(self.factors):
            lines.append("      no factor: these loads stiffen")
        if len(self.factors) and self.change_by_modes > 0.0:
            lines.append(
                f"the upper half of the modes of bodies lowers the first by {100 * self.change_by_modes:.2g} %"
            )
        if np.isfinite(self.reversed_factor):
            lines.append(f"with reversed loads it buckles at {self.reversed_factor:.6g} times")
        return "\n".join(lines)


@checked("loads", "count", "t", "start")
def buckling(
    scene: Freezable | Model,
    *,
    loads: str | Sequence[str] | None = None,
    count: int = 6,
    t: float | None = None,
    start: Start = None,
) -> Buckling:
    """Find the load factors at which a scene buckles, and the buckling shapes.

    Linear buckling: the stiffness at rest under the constant loads, and its change with the raised loads and with the
    displacement that these cause. Flexible bodies need ``stiffening="full"``. With few modes of a body the factors are
    too high; static shapes at loaded interfaces, or a chain of several bodies, improve them.

    Parameters
    ----------
    scene : System or Model
        At rest under its loads.
    loads : str or sequence of str, optional
        Loads that are raised in proportion: ``"gravity"``, and loads by the names that ``linearise(inputs="load ...")``
        takes; all others are constant. Default: gravity and all loads that do not depend on the state.
    count : int
        Largest number of factors.
    t : float, optional
        Time at which functions of time are evaluated, s; default: that of the start, or zero.
    start : state, optional
        Where the search for the rest under the constant loads begins, as `kanefe.System.simulate` takes it.

    Returns
    -------
    Buckling

    Raises
    ------
    ModelError
        If a flexible body has no geometric stiffness, no load is raised, the scene is not held or not stable under the
        constant loads, or loads have no potential, such as follower forces, for which there is
        `kanefe.stability_limit`.
    SimulationError
        If there is no rest under the constant loads.

    Warns
    -----
    AccuracyWarning
        If the displacement before buckling is large, so that linear factors are inaccurate.

    Examples
    --------
    A rigid rod on a hinge with a spring, under its weight: k / (m g l / 2).

    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -10.0))
    >>> hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=100.0))
    >>> rod = scene.add_rigid_body("rod", 2.0, 0.2, com=(0, 0, 0.5), joint=hinge)
    >>> kf.buckling(scene).factors.round(6)
    array([10.])
    """
    if not isinstance(count, (int, np.integer)) or isinstance(count, bool) or count < 1:
        raise ModelError(f"buckling: count must be a whole number of at least 1, not {count!r}")
    path = load_path(scene, t, start, loads, "buckling")
    scale = 1.0 / np.sqrt(np.diag(path.K))
    K, dK = (X * np.outer(scale, scale) for X in (path.K, path.dK))
    _check_symmetric(path, dK)
    values, vectors = _softened(K, dK)
    least = AFFECTED * np.abs(values).max(initial=0.0)
    softens, stiffens = values < -least, values > least
    order = np.flatnonzero(softens)[:count]
    found = scale[:, None] * vectors[:, order]
    sizes = np.array([path.moved_by(z) for z in path.along(found).T])
    signs = np.array([z[np.abs(z).argmax()] for z in path.along(found).T])
    result = Buckling(
        path=path,
        factors=-1.0 / values[order],
        vectors=found / (sizes * np.where(signs < 0.0, -1.0, 1.0)),
        reversed_factor=float(1.0 / values[-1]) if stiffens.any() else np.inf,
        change_by_modes=_change_by_modes(path, K, dK, values[0] if softens.any() else 0.0),
    )
    _warn_of_displacement(result)
    _warn_of_modes(result)
    return result


def _softened(K: Matrix, dK: Matrix) -> tuple[Vector, Matrix]:
    """Return values and vectors of ``dK p = value K p``, lowest first: factors are minus their inverse."""
    # from L^-1 dK L^-T, K = L L^T
    inverse = np.linalg.inv(np.linalg.cholesky(0.5 * (K + K.T)))
    values, vectors = np.linalg.eigh(inverse @ (0.5 * (dK + dK.T)) @ inverse.T)
    return values, inverse.T @ vectors


def _change_by_modes(path: LoadPath, K: Matrix, dK: Matrix, lowest: float) -> float:
    upper = np.isin(path.small.positions.leading, _upper_modes(path.small.model))
    if lowest >= 0.0 or not upper.any():
        return 0.0
    kept = np.flatnonzero(~upper)
    fewer = _softened(K[np.ix_(kept, kept)], dK[np.ix_(kept, kept)])[0][0] if len(kept) else 0.0
    return float(lowest / fewer - 1.0) if fewer < AFFECTED * lowest else np.inf


def _upper_modes(model: Model) -> Vector:
    """Return the tangents of the upper half of the coordinates of each reduced body, which are sorted by frequency."""
    found = [np.zeros(0, dtype=int)]
    for body in model.bodies:
        terms = body.flexible
        if terms is not None and terms.body.provenance.get("reduction", {}).get("method") not in (None, "None"):
            own = np.arange(terms.speeds.start, terms.speeds.stop)
            found.append(own[(len(own) + 1) // 2 :])
    return np.concatenate(found)


def _warn_of_modes(found: Buckling) -> None:
    if len(found.factors) and found.change_by_modes > CHANGE:
        warnings.warn(
            f"buckling: the upper half of the modes of bodies lowers the first factor by "
            f"{100 * found.change_by_modes:.2g} %, so that others may lower it by several per cent more. Remedy: "
            "more modes in the reduction, and the loads by name in its loads=",
            AccuracyWarning,
            stacklevel=outside(),
        )


def _check_symmetric(path: LoadPath, dK: Matrix) -> None:
    size = np.abs(dK).max(initial=0.0)
    if np.abs(dK - dK.T).max(initial=0.0) > SYMMETRIC * max(size, 1.0e-300):
        which = " and ".join(path.turning) or "a raised load"
        raise ModelError(
            f"buckling: {which} has no potential (it turns with its body, or is a torque about a fixed axis), and such "
            "a load may first cause flutter, which static buckling does not show. Remedy: "
            "kanefe.stability_limit(scene)"
        )


def _warn_of_displacement(found: Buckling) -> None:
    if not len(found.factors):
        return
    before = found.factors[0] * found.path.moved_by(found.path.displacement)
    if before > FAR:
        warnings.warn(
            f"before it buckles at {found.factors[0]:.4g} times its loads, the scene moves by some {before:.2g} rad or "
            "scene lengths, beyond the range of linear buckling. Remedy: kanefe.equilibrium_path, which follows "
            "the equilibria as the loads are raised",
            AccuracyWarning,
            stacklevel=outside(),
        )
