"""Floquet modes: small motions about a periodic motion, such as of two blades on a flexible tower."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers
from kanefe.integrate.run_checks.structural_damping import warn_of_structural_damping
from kanefe.linear.modes.eigenvalues import OfEigenvalues
from kanefe.linear.modes.hill import Hill, hill_motions
from kanefe.linear.modes.mode_shapes import body_masses
from kanefe.linear.modes.periodic_motion import Around, motion_around
from kanefe.linear.modes.unresisted import unresisted_around
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.state import check_no_rigid_contacts, model_in_state
from kanefe.linear.tangents import tangent_names

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.linear.state import Freezable

RIGID = 1e-7
"""Eigenvalue relative to the largest that may be zero: a double one is accurate to the root of round-off only."""

REACH_OF_RIGID = 4
"""Harmonics on either side of motions without restoring force: coordinates in rotating axes need two."""

REPORTED_SHARE = 0.005
"""Smallest fraction of a mode for which ``print`` lists a harmonic."""


@dataclass(frozen=True, eq=False)
class FloquetModes(OfEigenvalues):
    """Motions ``x = Re(exp(lambda t) sum_k v_k exp(i k W t))`` about a motion with the period 2 pi / W.

    Each mode oscillates at several frequencies at once, those of its harmonics, ``Im lambda / 2 pi + k / period``.
    Which harmonic is k = 0 is a convention: here the one with the largest share of the motion, so that without periodic
    terms the modes are those of `Linearisation.modes`. Lowest frequency first; one of each conjugate pair; ``print``
    shows a table.

    Attributes
    ----------
    small : SmallMotions
        At the start of the period.
    period : float
        s.
    eigenvalues : ndarray of complex, shape (modes,)
        1/s.
    orders : ndarray of int, shape (harmonics,)
        k, ascending.
    shapes : ndarray of complex, shape (harmonics, states, modes)
        v_k over the states of `Linearisation`, with unit kinetic energy measure in total.
    is_rigid : ndarray of bool, shape (modes,)
        Whether there is no restoring force.
    """

    small: SmallMotions
    period: float
    eigenvalues: np.ndarray
    orders: np.ndarray
    shapes: np.ndarray
    is_rigid: np.ndarray

    @property
    def multipliers(self) -> np.ndarray:
        """Factor of each mode from one period to the next, ``exp(lambda period)``; growing above magnitude one."""
        return np.asarray(np.exp(self.eigenvalues * self.period))

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, with units in brackets, as those of a `Linearisation`."""
        small = self.small
        p, r = tangent_names(small.model), small.model.speed_names()
        return (*(p[i] for i in small.positions.leading), *(r[i] for i in small.speeds.leading))

    @cached_property
    def metric(self) -> Matrix:
        """Mass matrix over the free speeds at the start of the period."""
        n = self.small.model.free_count
        return self.small.mass[:n, :n]

    @cached_property
    def tangents(self) -> np.ndarray:
        """Shapes as tangents of the tree, complex, (harmonics, free, modes)."""
        small = self.small
        p = len(small.positions.leading)
        return np.einsum("ip,kpj->kij", small.along_positions.z, self.shapes[:, :p])

    @cached_property
    def shares(self) -> np.ndarray:
        """Share of each harmonic in each mode, by kinetic energy measure, (harmonics, modes)."""
        z = self.tangents
        parts = np.einsum("kij,il,klj->kj", z.conj(), self.metric, z).real
        return np.asarray(parts / np.maximum(parts.sum(axis=0), 1e-300))

    @cached_property
    def participation(self) -> dict[str, Vector]:
        """Share of each body in the kinetic energy measure of each mode, by name, each (modes,)."""
        z = self.tangents
        masses = body_masses(self.small)
        parts = {name: np.einsum("kij,il,klj->j", z.conj(), M, z).real for name, M in masses.items()}
        total = sum(parts.values())
        return {name: part / np.where(total > 0.0, total, 1.0) for name, part in parts.items()}

    def harmonics(self, mode: int) -> list[tuple[int, float, float]]:
        """Return order k, frequency (Hz; negative: it turns backwards) and share of the harmonics of a mode.

        The largest first; those with a share below `REPORTED_SHARE` are left out.
        """
        if not 0 <= mode < len(self.eigenvalues):
            raise ModelError(f"there is no mode {mode}: there are 0 to {len(self.eigenvalues) - 1}")
        own = self.eigenvalues[mode].imag / (2.0 * np.pi)
        parts = [
            (int(k), float(own + k / self.period), float(share))
            for k, share in zip(self.orders, self.shares[:, mode], strict=True)
            if share >= REPORTED_SHARE
        ]
        return sorted(parts, key=lambda part: -part[2])

    def __str__(self) -> str:
        rigid, others = np.flatnonzero(self.is_rigid).tolist(), np.flatnonzero(~self.is_rigid).tolist()
        lines = [f"period {self.period:.6g} s, {1.0 / self.period:.6g} Hz"]
        lines += ["rigid motions (without restoring force):"] if rigid else []
        lines += [f"{i:4d}  {self._harmonics_in_words(i)}" for i in rigid]
        head = f"{'frequency [Hz]':>14}  {'[rad/s]':>11}  {'damping [%]':>11}  {'multiplier':>10}"
        lines += [f"{'mode':>4}  {head}  harmonics (share)"] if others else []
        sizes = np.abs(self.multipliers)
        for i in others:
            value = self.eigenvalues[i]
            if value.imag == 0.0:
                kind = f"{'diverges' if value.real > 0.0 else 'decays':>14}  {'':>11}  {f'{value.real:.4g} 1/s':>11}"
            else:
                damping = 100 * self.damping_ratios[i] + 0.0
                kind = f"{self.frequencies[i]:14.6g}  {abs(value.imag):11.6g}  {damping:11.4g}"
            unstable = "  (unstable)" if self.grows[i] else ""
            lines.append(f"{i:4d}  {kind}  {sizes[i]:10.4g}  {self._harmonics_in_words(i)}{unstable}")
        return "\n".join(lines)

    def _harmonics_in_words(self, mode: int) -> str:
        """Return the harmonics of a mode, and the body that moves most in it."""
        parts = ", ".join(f"{k:+d}: {f:.4g} Hz {100 * share:.0f} %" for k, f, share in self.harmonics(mode)[:4])
        return f"{parts}; most in {max(self.participation, key=lambda name: self.participation[name][mode])}"


@checked("period", "t", "start")
def floquet(
    scene: Freezable | Model, *, period: float | None = None, t: float | None = None, start: Start = None
) -> FloquetModes:
    """Find the modes about a periodic motion, by Hill's method.

    For scenes whose small motions change with the azimuth, so that modes frozen at one azimuth are wrong: a rotor with
    two blades, any bladed rotor on a flexible support, a pendulum with a shaken pivot. The motion itself is steady, or
    it is found near the start (for trees without free rotations), such as that of blades under gravity.

    Parameters
    ----------
    scene : System or Model
    period : float, optional
        s, after which the scene is the same again. Default: one revolution of the slowest driven or free joint that
        rotates at the start.
    t : float, optional
        Start of the period, s; default: the time of the state, or zero.
    start : state, optional
        A state on or near the motion, as `kanefe.System.simulate` takes it, such as an `Equilibrium`; default: the
        start of the scene. Its speeds are those of the steady motion.

    Raises
    ------
    ModelError
        If the scene is not the same after the period, rolls, or has a periodic motion that cannot be searched for.
    SimulationError
        If no periodic motion is found, or the modes have too many harmonics.

    Examples
    --------
    An inverted pendulum with a pivot that is shaken fast enough:

    >>> import numpy as np
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> a, w = 0.05, 100.0
    >>> shake = kf.Motion(
    ...     lambda t: a * np.cos(w * t), lambda t: -a * w * np.sin(w * t), lambda t: -a * w * w * np.cos(w * t)
    ... )
    >>> pivot = scene.add_frame("pivot", joint=kf.Prismatic("z", motion=shake))
    >>> rod = scene.add_rigid_body("rod", 1.0, com=(0, 0, 0.5), parent=pivot, joint=kf.Revolute("y"))
    >>> kf.floquet(scene, period=2 * np.pi / 100).is_stable
    True
    """
    model, time, q, u = model_in_state(scene, t, start, "floquet")
    check_no_rigid_contacts(model, "floquet")
    warn_of_structural_damping(model, "floquet")
    seconds = _period(model, time, u) if period is None else numbers(period)
    if np.shape(seconds) != () or not np.isfinite(seconds) or not seconds > 0.0:
        raise ModelError(f"the period of floquet must be above zero s, not {period!r}")
    around = motion_around(model, time, q, u, float(seconds))
    if not around.points[0].is_holonomic:
        raise ModelError("floquet: scenes that roll are not supported. Remedy: modes() of a state that rolls steadily")
    rate = 2.0 * np.pi / float(seconds)
    hill = hill_motions(around.harmonics, rate, around.weights)
    return _listed(around, float(seconds), hill)


def _period(model: Model, t: float, u: Vector) -> float:
    """Return the period of the slowest rotating coordinate."""
    driven = model.driven_speeds(t)[0] if model.driven_count else np.zeros(0)
    full = np.concatenate((u, driven))
    rates = []
    for body in model.bodies:
        for name, where in zip(body.joint.speed_names, body.speeds, strict=True):
            if "[rad/s]" in name and abs(full[where]) > 0.0:
                rates.append(abs(float(full[where])))
    if not rates:
        raise ModelError("floquet: nothing turns at the start, so that the period is not known. Remedy: period=, in s")
    return 2.0 * np.pi / min(rates)


def _listed(around: Around, period: float, hill: Hill) -> FloquetModes:
    """Return the modes with their largest harmonics in the middle, one of each conjugate pair, lowest first."""
    small, values, shapes = around.points[0], hill.values, hill.shapes
    rate, reach = 2.0 * np.pi / period, len(shapes) // 2
    size = np.abs(values).max(initial=0.0)
    none = np.zeros(len(values), dtype=bool)
    raw = FloquetModes(small, period, values, np.arange(-reach, reach + 1), shapes, none)
    shifts = raw.shares.argmax(axis=0) - reach
    # of two harmonics with equal shares the one with the lower frequency is k = 0
    wide = np.zeros((4 * reach + 1, *shapes.shape[1:]), dtype=complex)
    found = values + 1j * rate * shifts
    for j, shift in enumerate(shifts):
        wide[reach - shift : 3 * reach + 1 - shift, :, j] = shapes[:, :, j]
    turned = found.imag < -1e-9 * size
    found = np.where(turned, found.conj(), found)
    wide = np.where(turned, wide[::-1].conj(), wide)
    found = np.where(np.abs(found.imag) <= 1e-9 * size, 0.0, found.imag) * 1j + np.where(
        np.abs(found.real) <= 1e-12 * size, 0.0, found.real
    )
    is_rigid = _rigid(around, found, rate, RIGID * size)
    found = np.where(is_rigid, 0.0, found)
    kept = _one_of_each(found, rate, is_rigid, 1e-7 * size)
    order = kept[np.lexsort((-found[kept].real, found[kept].imag, ~is_rigid[kept]))]
    found, wide, is_rigid = found[order], wide[:, :, order], is_rigid[order]
    orders = np.arange(-2 * reach, 2 * reach + 1)
    modes = FloquetModes(small, period, found, orders, wide, is_rigid)
    sizes = np.sqrt(np.einsum("kij,il,klj->j", modes.tangents.conj(), modes.metric, modes.tangents).real)
    return FloquetModes(small, period, found, orders, wide / np.where(sizes > 0.0, sizes, 1.0), is_rigid)


def _rigid(around: Around, values: np.ndarray, rate: float, noise: float) -> np.ndarray:
    """Return which motions have no restoring force: those with the lowest eigenvalues, as many as the rank says.

    Their eigenvalues are zero except for noise; those in rotating coordinates are multiples of the rate.
    """
    around_zero = np.abs(values) <= noise
    if not around_zero.any():
        return around_zero
    turning = np.abs(values - 1j * rate * np.round(values.imag / rate)) <= noise
    harmonics = min(REACH_OF_RIGID, len(around.points) // 4)
    count = unresisted_around(around.points, around.matrices, rate, harmonics) - int(np.sum(turning & ~around_zero))
    lowest = np.argsort(np.abs(values), kind="stable")[: max(count, 0)]
    return around_zero & np.isin(np.arange(len(values)), lowest)


def _one_of_each(values: np.ndarray, rate: float, is_rigid: np.ndarray, noise: float) -> np.ndarray:
    """Return one motion of each conjugate pair, and one of the two zeros of a motion without restoring force.

    Equal values are pairs too, of which every other is kept. A motion that is its own conjugate, except for a whole
    number of revolutions, is real from period to period and is kept.
    """
    kept: list[int] = []
    left = list(range(len(values)))
    while left:
        i = left.pop(0)
        kept.append(i)
        turns = 2.0 * values[i].imag / rate
        near = noise if round(turns) else 0.0  # about zero, the rank decides
        is_own = abs(turns - round(turns)) * rate <= near and not is_rigid[i]
        partner = min(left, key=lambda j: abs(values[j] - values[i]), default=None)
        if partner is not None and not is_own and abs(values[partner] - values[i]) <= max(noise, 1e-9 * rate):
            left.remove(partner)
    return np.array(kept, dtype=int)
