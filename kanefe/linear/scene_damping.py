"""Damping of bodies by which the modes of the whole scene have given ratios.

The damping of a body acts on the rates of its own coordinates alone. With the modes phi of the scene without damping,
mass-normalised, and phi_b their part in the coordinates of body b, C_b shall satisfy

    sum_b phi_b^T C_b phi_b = 2 zeta omega    of each mode, and 0 between two of them.

With the pseudo-inverse psi of all phi_b, ``C = sum_k 2 zeta_k omega_k psi_k^T psi_k`` does so as far as modes are no
more than coordinates. Of several bodies the parts of C between two are left out, and factors L_b of ``C_b = L_b L_b^T``
are adjusted by least squares; such a C_b never feeds energy in.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import scipy.linalg

from kanefe.arguments import checked
from kanefe.bodies.flexible import FlexibleBody
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.fe_model.damping import ModalDamping
from kanefe.frames import Matrix, Vector
from kanefe.linear.linearisation import linearised

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.scene.scene import Scene

ELASTIC = 1e-9
"""Square of a frequency, relative to the largest, below which a motion of the scene is rigid: round-off of the rest."""

BENDS = 0.5
"""Fraction of the strain energy of a mode in bodies below which it is one of springs, whose dampers are theirs."""

BETWEEN = 0.1
"""Weight of the damping between two modes against that of each, dimensionless, where bodies share both."""

ROUND_OFF = 1e-12
"""Part of the mean of a damping matrix that is added to its diagonal, so that it has a factor."""

MOST_PAIRED = 50
"""Number of modes above which the damping between two of them is left as it comes, for the memory that it takes."""

MOST_STEPS = 200
"""Number of steps in which the damping of several bodies is adjusted."""

MET = 0.1
"""Deviation of the ratio of a mode, relative to the one asked for, above which a warning says so."""


@dataclass(frozen=True)
class SceneDamping:
    """A damping ratio for the elastic modes of a whole scene, with all that its bodies carry.

    `ModalDamping` is that of a body alone, with its interfaces held: what it carries lowers frequencies and ratios.

    Parameters
    ----------
    ratio : float or sequence of float
        One ratio for all modes with half or more of their strain energy in flexible bodies, or those of the first of
        them; the last one applies to all further modes. 0.05 is 5 % of critical damping.
    overdamped : bool
        Whether ratios above 1 are intended.

    Raises
    ------
    ModelError
        If a ratio is negative or not finite, or above 1 without `overdamped`.

    Examples
    --------
    An arm with 1 % in itself has 0.41 % with a tool of its own weight; then 1 % of the scene is asked for:

    >>> import kanefe as kf
    >>> from kanefe_fem import Material, Rectangle, beam_body, straight_beam
    >>> model = straight_beam(0.8, Rectangle(0.01, 0.04), Material(E=70e9, nu=0.33, rho=2700.0), elements=8)
    >>> body = beam_body(model, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=4), kf.ModalDamping(0.01))
    >>> scene = kf.System()
    >>> arm = scene.add_flexible_body("arm", body)
    >>> tool = scene.add_rigid_body("tool", 1.0, 1e-3, parent=arm.interface("tip"))
    >>> print((100 * kf.equilibrium(scene.copy()).linearise().modes().damping_ratios[:2]).round(3))
    [0.409 0.41 ]
    >>> kf.SceneDamping(0.01).put_on(scene)
    >>> print((100 * kf.equilibrium(scene).linearise().modes().damping_ratios[:2]).round(3))
    [1. 1.]
    """

    ratio: float | Sequence[float]
    overdamped: bool = False

    def __post_init__(self) -> None:
        ModalDamping(self.ratio, self.overdamped)  # the same checks

    @checked
    def put_on(self, scene: Scene, start: Start = None) -> None:
        """Replace the damping of all flexible bodies of a scene by one that gives its modes these ratios.

        To be called when all bodies, joints and springs are there. Joints, springs and other loads keep their own
        damping, which adds to these ratios. The modes are those of the scene at a start, without gyroscopic terms; as
        joints turn far, they change, and the ratios with them.

        Parameters
        ----------
        scene : System
            Not frozen yet.
        start : state, optional
            About which its modes are taken: see `kanefe.linearise`; default: the start of the scene.

        Raises
        ------
        ModelError
            If the scene is frozen or has no flexible body with a basis of modes, or more ratios are given than it has
            modes.

        Warns
        -----
        AccuracyWarning
            If a mode misses its ratio by a tenth, because bodies share it with each other or with springs.
        """
        scene._check_open("damping of the scene")
        entries = [entry for entry in scene._entries if is_reduced(entry.flexible)]
        if not entries:
            raise ModelError("SceneDamping: the scene has no flexible body with modes. Remedy: dampers in its joints")
        bare = scene.copy()
        for entry in bare._entries:
            entry.flexible = undamped(entry.flexible)
        found = linearised(cast("Any", bare), None, start, None, None)
        modes = _ElasticModes(found, {entry.name for entry in entries})
        damped = _damping(modes, ModalDamping(self.ratio, self.overdamped).ratios(len(modes.omegas)))
        for entry in entries:
            entry.flexible = replace(cast("FlexibleBody", entry.flexible), damping=damped[entry.name])


def is_reduced(body: object) -> bool:
    """Return whether a body is flexible with coordinates of a basis, of which each may be damped with each."""
    return type(body) is FlexibleBody and body.free_count > 0


def undamped(body: FlexibleBody | None) -> FlexibleBody | None:
    """Return a body of modes without damping, others as they are."""
    return replace(body, damping=np.zeros_like(body.damping)) if body is not None and is_reduced(body) else body


class _ElasticModes:
    """Modes of a scene without damping that deform its bodies.

    Attributes
    ----------
    omegas : ndarray, shape (modes,)
        rad/s.
    parts : dict of str to ndarray, shape (k, modes)
        Mass-normalised, in the coordinates of each body.
    """

    def __init__(self, found: Any, names: set[str]) -> None:
        small, p = found.small, found.position_count
        M, K = (0.5 * (matrix + matrix.T)[:p, :p] for matrix in (found.mass, found.stiffness))
        squares, shapes = scipy.linalg.eigh(K, M)
        tangents = small.along_positions.z[: found.model.free_count, :p] @ shapes
        bodies = [body for body in found.model.bodies if body.name in names]
        parts = {body.name: tangents[body.flexible.speeds] for body in bodies}
        strain = np.zeros(p)
        for body in bodies:
            part = parts[body.name]
            k = len(part)
            strain += np.einsum("im,ij,jm->m", part, body.flexible.body.stiffness[:k, :k], part)
        kept = (squares > ELASTIC * squares.max()) & (strain > BENDS * squares)
        self.omegas: Vector = np.sqrt(squares[kept])
        self.parts: dict[str, Matrix] = {name: part[:, kept] for name, part in parts.items()}


def _damping(modes: _ElasticModes, ratios: Vector) -> dict[str, Matrix]:
    """Return the damping matrices of bodies by name; warn of ratios that they do not give."""
    parts = list(modes.parts.values())
    scales = [1.0 / np.abs(part).max(axis=1) for part in parts]  # coordinates have units of their own
    scaled = [scale[:, None] * part for scale, part in zip(scales, parts, strict=True)]
    inverse = np.linalg.pinv(np.vstack(scaled))
    wanted = 2.0 * ratios * modes.omegas
    rows = np.split(inverse, np.cumsum([len(part) for part in parts])[:-1], axis=1)
    factors = [row.T * np.sqrt(wanted) for row in rows]
    if len(parts) > 1 and wanted.any():
        factors = _adjusted(factors, scaled, wanted)
    had = sum(np.square(factor.T @ part).sum(axis=0) for factor, part in zip(factors, scaled, strict=True))
    _warn_of_missed_ratios(modes.omegas, ratios, had / (2.0 * modes.omegas))
    own = (scale[:, None] * factor for scale, factor in zip(scales, factors, strict=True))
    return {name: factor @ factor.T for name, factor in zip(modes.parts, own, strict=True)}


def _adjusted(factors: list[Matrix], parts: list[Matrix], wanted: Vector) -> list[Matrix]:
    """Return factors L_b of ``C_b = L_b L_b^T`` by which modes are damped as wanted, and little by each other."""
    from scipy.optimize import least_squares

    roots = np.sqrt(np.where(wanted > 0.0, wanted, wanted.max()))
    unit = [part / roots for part in parts]
    factors = [np.linalg.cholesky(f @ f.T + ROUND_OFF * np.trace(f @ f.T) * np.eye(len(f))) for f in factors]
    ends = np.cumsum([factor.size for factor in factors])
    upper = np.triu_indices(len(wanted)) if len(wanted) <= MOST_PAIRED else 2 * (np.arange(len(wanted)),)
    weights = np.where(upper[0] == upper[1], 1.0, BETWEEN)
    goal = np.diag(wanted / roots**2)

    def split(x: Vector) -> list[Matrix]:
        return [piece.reshape(len(f), -1) for piece, f in zip(np.split(x, ends[:-1]), factors, strict=True)]

    def missed(x: Vector) -> Vector:
        found = sum((part.T @ f) @ (f.T @ part) for part, f in zip(unit, split(x), strict=True))
        return np.asarray(weights * (found - goal)[upper])

    def rates(x: Vector) -> Matrix:
        columns = []
        for part, f in zip(unit, split(x), strict=True):
            moved = part.T @ f  # (modes, columns of the factor)
            both = part.T[:, None, :, None] * moved[None, :, None, :]
            columns.append((both + both.swapaxes(0, 1))[upper].reshape(len(weights), -1))
        return weights[:, None] * np.hstack(columns)

    start = np.concatenate([factor.ravel() for factor in factors])
    return split(least_squares(missed, start, jac=rates, max_nfev=MOST_STEPS).x)


def _warn_of_missed_ratios(omegas: Vector, asked: Vector, had: Vector) -> None:
    missed = np.abs(had - asked) > MET * asked
    if missed.any():
        i = int(np.flatnonzero(missed)[0])
        warnings.warn(
            f"SceneDamping: {missed.sum()} of {len(omegas)} modes miss their ratio by more than a tenth, first that at "
            f"{omegas[i] / (2.0 * np.pi):.4g} Hz, {100 * had[i]:.3g} % for {100 * asked[i]:.3g} %: bodies share them "
            "with each other or with springs. Remedy: damping of these springs, or other ratios",
            AccuracyWarning,
            stacklevel=outside(),
        )
