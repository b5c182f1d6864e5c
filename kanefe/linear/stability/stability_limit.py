"""The load factor above which the rest of a scene is unstable: divergence, or flutter due to follower loads.

    M d2p/dt2 + C dp/dt + (K + factor dK) p = 0

with the matrices of `kanefe.linear.stability.load_path`. A load without potential makes dK unsymmetric; two modes may
merge and grow while the stiffness is still positive in every direction. (Bolotin, Nonconservative Problems of the
Theory of Elastic Stability, 1963.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.linear.modes.eigenpairs import eigenpairs, rate_weights
from kanefe.linear.modes.mode_shapes import Shapes
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.stability.load_path import LoadPath, load_path

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.linear.state import Freezable

GROWS = 1e-9
"""Growth of a mode, relative to its eigenvalue, above which it counts: smaller growth may be round-off of eigenvalues
that are 1e5 times as large."""

FARTHER = 1.05
"""Ratio of successive load factors that are examined."""

FARTHEST = 1e4
"""Largest load that is examined, in multiples of the smallest that could buckle the scene."""

DIGITS = 1e-10
"""Relative accuracy of the load factor."""


@dataclass(frozen=True, eq=False)
class StabilityLimit(Shapes):
    """Load factor above which a scene at rest is unstable, and the growing motion; ``print`` shows them.

    Attributes
    ----------
    path : LoadPath
        The scene at rest, and the raised loads.
    factor : float
        Multiple of the raised loads; inf: stable up to `looked_at`.
    eigenvalue : complex
        Of the motion that begins to grow there, 1/s: zero for divergence, i 2 pi f for flutter with the frequency f.
    vector : ndarray of complex, shape (p, 1) or (p, 0)
        Its shape over the independent coordinates; the largest displacement is one rad or one scene length.
    looked_at : float
        The largest factor that was examined.
    """

    path: LoadPath
    factor: float
    eigenvalue: complex
    vector: np.ndarray
    looked_at: float

    @property
    def is_flutter(self) -> bool:
        """Whether the motion oscillates as it grows."""
        return bool(np.isfinite(self.factor) and abs(self.eigenvalue.imag) > 0.0)

    @property
    def frequency(self) -> float:
        """Frequency of the flutter, Hz; zero for divergence."""
        return abs(self.eigenvalue.imag) / (2.0 * np.pi)

    @property
    def _small(self) -> SmallMotions:
        return self.path.small

    @cached_property
    def tangents(self) -> np.ndarray:
        """Shape as tangents of the tree (free, 1), complex: what `Model.advance` takes."""
        return self.path.along(self.vector)

    def __str__(self) -> str:
        if not np.isfinite(self.factor):
            return f"stable up to {self.looked_at:.6g} times its loads, {self.path}"
        how = f"flutter at {self.frequency:.6g} Hz" if self.is_flutter else "divergence"
        return f"stable up to {self.factor:.6g} times its loads, {self.path}; then {how} of {self.describe(0)}"


@checked("loads", "up_to", "t", "start")
def stability_limit(
    scene: Freezable | Model,
    *,
    loads: str | Sequence[str] | None = None,
    up_to: float | None = None,
    t: float | None = None,
    start: Start = None,
) -> StabilityLimit:
    """Find the load factor above which the rest of a scene is unstable: divergence, or flutter.

    For follower loads, to which `buckling` does not apply. Linear in the factor, as `buckling`; damping is included,
    and small damping may lower the limit. Factors are examined in steps of 5 %, and the limit between the first two
    that differ is found by bisection: a narrower window of instability is not detected.

    Parameters
    ----------
    scene : System or Model
        At rest under its loads.
    loads, t, start
        As for `buckling`.
    up_to : float, optional
        The largest factor to examine; default: 10,000 times the lowest factor at which divergence is possible.

    Raises
    ------
    ModelError, SimulationError
        As `buckling`, but not for loads without potential.

    Examples
    --------
    Ziegler's double pendulum: two bars with springs at the joints, masses 2 m and m at their ends, and a force along
    the second bar; (7/2 - sqrt(2)) k / l.

    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> hinge = kf.Revolute("z", forces=kf.CoordinateForce(stiffness=1.0))
    >>> a = scene.add_rigid_body("a", 2.0, 0.0, com=(1, 0, 0), joint=hinge)
    >>> b = scene.add_rigid_body("b", 1.0, 0.0, com=(1, 0, 0), parent=a, at=(1, 0, 0), joint=hinge)
    >>> scene.add_force(b, (-1, 0, 0), point=(1, 0, 0), follows=True)
    >>> limit = kf.stability_limit(scene)
    >>> limit.is_flutter, round(limit.factor, 6)
    (True, 2.085786)
    """
    path = load_path(scene, t, start, loads, "stability_limit")
    scale = 1.0 / np.sqrt(np.diag(path.K))
    K, dK = (X * np.outer(scale, scale) for X in (path.K, path.dK))
    # up to this factor K + factor dK is positive definite
    first = float(np.linalg.eigvalsh(0.5 * (K + K.T))[0]) / max(float(np.linalg.norm(dK, 2)), 1e-300)
    last = FARTHEST * first
    if up_to is not None:
        given = numbers(up_to)
        if given.shape != () or not (np.isfinite(given) and given > 0.0):
            raise ModelError(f"stability_limit: up_to must be a positive finite factor, not {up_to!r}")
        last = float(given)
    if _growing(path, 0.0) is not None:
        raise ModelError(
            "stability_limit: a motion grows even without the raised loads. Remedy: linearise(scene).modes() shows "
            "which one"
        )
    below, above, found = 0.0, min(first, last), None
    while True:
        found = _growing(path, above)
        if found is not None or above >= last:
            break
        below, above = above, min(FARTHER * above, last)
    if found is None:
        none = np.zeros((len(path.K), 0), dtype=complex)
        return StabilityLimit(path, np.inf, 0j, none, above)
    while above - below > DIGITS * above:
        middle = 0.5 * (below + above)
        mode = _growing(path, middle)
        if mode is None:
            below = middle
        else:
            above, found = middle, mode
    value, p = found
    size = path.moved_by(path.along(p[:, None]).real[:, 0])
    at_limit = 1j * abs(value.imag) if abs(value.imag) > GROWS * abs(value) else 0j
    return StabilityLimit(path, above, at_limit, p[:, None] / (size or 1.0), above)


def _growing(path: LoadPath, factor: float) -> tuple[complex, np.ndarray] | None:
    """Return eigenvalue and shape of the motion that grows most at a factor; None if none grows."""
    p = len(path.K)
    rates = np.linalg.solve(path.M, np.hstack((path.K + factor * path.dK, path.C)))
    A = np.block([[np.zeros((p, p)), np.eye(p)], [-rates[:, :p], -rates[:, p:]]])
    values, vectors = eigenpairs(A, rate_weights(A, p))
    shares = values.real / np.maximum(np.abs(values), 1e-300)
    # the ratio is meaningless for eigenvalues of round-off
    noise = 1e-13 * np.abs(values).max(initial=0.0)
    shares = np.where(np.abs(values.real) > noise, shares, 0.0)
    worst = int(shares.argmax())
    if shares[worst] <= GROWS:
        return None
    shape = vectors[:p, worst]
    largest = shape[np.abs(shape).argmax()]
    return complex(values[worst]), shape * (abs(largest) / largest)
