"""Campbell diagram: the modes of a scene over its speed, each followed from speed to speed."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.frames import Vector, numbers
from kanefe.linear.modes.eigenvalues import growth_noise
from kanefe.linear.modes.modes import Modes
from kanefe.linear.over_speed.critical_speeds import CriticalSpeed, critical_speeds
from kanefe.linear.over_speed.followed_modes import DEEPEST, SURE, AnyModes, Curves
from kanefe.linear.over_speed.modes_over_speed import ascending_speeds, modes_over_speed
from kanefe.linear.over_speed.stability_over_speed import StabilityOnset, stability_onsets

if TYPE_CHECKING:
    from kanefe.linear.state import Freezable
    from kanefe.views.plots import Figure

USUAL = 6
"""Default number of modes that are followed."""

MOST_ORDERS = 100
"""Largest number of excitation lines in one picture."""


@dataclass(frozen=True, eq=False)
class Campbell:
    """Modes over the speed, each column the same mode; returned by `campbell`.

    Columns are the modes that oscillate at the first speed, lowest frequency first, then those that begin to oscillate
    below the highest of these or drop below it; NaN before that.

    Attributes
    ----------
    speeds : ndarray, shape (S,)
        rad/s.
    eigenvalues : ndarray of complex, shape (S, modes)
        1/s, in the frame of the scene. A whirl whose frequency passes through zero continues with a negative imaginary
        part: in a frame that spins faster it turns backwards.
    modes : tuple of Modes, or of FloquetModes
        All modes at each speed.
    numbers : ndarray of int, shape (S, modes)
        Number of each column among the modes at a speed; -1 before it begins.
    correlations : ndarray, shape (S, modes)
        Of each mode with itself at the speed from which it was followed (1 at the first); low values show where modes
        veer or mix.
    """

    speeds: np.ndarray
    eigenvalues: np.ndarray
    modes: tuple[AnyModes, ...]
    numbers: np.ndarray
    correlations: np.ndarray
    _curves: Curves = field(repr=False)
    _undamped: Callable[[], Curves] = field(repr=False)

    @property
    def frequencies(self) -> np.ndarray:
        """Damped frequencies, abs(Im lambda) / 2 pi, Hz, shape (S, modes)."""
        return np.asarray(np.abs(self.eigenvalues.imag) / (2.0 * np.pi))

    @property
    def damping_ratios(self) -> np.ndarray:
        """``-Re lambda / |lambda|``, shape (S, modes)."""
        size = np.abs(self.eigenvalues)
        return np.asarray(np.divide(-self.eigenvalues.real, size, out=np.zeros_like(size), where=size != 0.0))

    @property
    def grows(self) -> np.ndarray:
        """Whether each mode grows, shape (S, modes)."""
        pairs = zip(self.eigenvalues, self.modes, strict=True)
        return np.array([values.real > growth_noise(values, m.eigenvalues) for values, m in pairs])

    @checked
    def critical_speeds(self, order: float = 1.0, *, damped: bool = True) -> list[CriticalSpeed]:
        """Return the speeds at which a followed mode has `order` times the frequency of rotation, ascending.

        The scene is built at further speeds until each crossing is found to 1e-12 of the speed.

        Parameters
        ----------
        order : float
            Zero or more. In a frame that spins with the rotor an unbalance is at rest: its critical speeds are those of
            order 0, where a frequency or a real eigenvalue is zero.
        damped : bool
            Use the damped frequencies ``abs(Im lambda)``; False: those of the scene without damping and circulatory
            forces, see `Linearisation.undamped`.

        Raises
        ------
        ModelError
            If the order is not a number of zero or more; or without damping, if the scene changes with the azimuth or
            rolls.

        Warns
        -----
        AccuracyWarning
            If a mode that is not followed crosses too, or a mode cannot be followed where it may cross.

        Examples
        --------
        ``for found in diagram.critical_speeds(): print(found, found.shape("disc"))``
        """
        if numbers(order).shape != () or not np.isfinite(order) or order < 0.0:
            raise ModelError(f"order must be a multiple of the rotation, zero or more, not {order!r}")
        curves = self._refined if damped else self._undamped()
        self._warn_of_others(curves, float(order))
        return critical_speeds(curves, float(order))

    def stability_limits(self) -> list[StabilityOnset]:
        """Return the speeds at which the scene begins or ceases to be stable, ascending.

        All modes count, also those that are not followed; rigid motions do not. Found like critical speeds.
        """
        return stability_onsets(lambda speed: self._curves.at(speed).modes, self._refined.speeds)

    @cached_property
    def _refined(self) -> Curves:
        return self._curves.refine()

    def _warn_of_others(self, curves: Curves, order: float) -> None:
        """Warn of modes that are not followed and are below the line of an order: they cross it somewhere."""
        if order == 0.0:
            return
        for speed in self.speeds[::-1].tolist():
            at = curves.at(speed)
            below = _oscillating(at.modes, order * abs(speed) / (2.0 * np.pi))
            missing = np.setdiff1d(below, at.numbers)
            if len(missing):
                warnings.warn(
                    f"of the modes below order {order:g} at {speed:.6g} rad/s {len(missing)} are not followed, such as "
                    f"one of {at.modes.frequencies[missing[0]]:.6g} Hz: their critical speeds are not reported. "
                    f"Remedy: campbell(..., modes={len(curves.born) + len(missing)})",
                    AccuracyWarning,
                    stacklevel=outside(),
                )
                return

    @checked
    def plot(self, path: str | Path | None = None, *, orders: Sequence[float] = (1.0,)) -> Figure:
        """Draw frequencies and damping over the speed, and write the picture to `path` if given.

        Parameters
        ----------
        path : path, optional
        orders : sequence of float
            Multiples of the speed at which the scene is excited, drawn as lines with their critical speeds; 0 in a
            frame that spins with the rotor.

        Raises
        ------
        ModelError, MissingDependency
            If the kind of file is unknown, or matplotlib is not installed.
        """
        from kanefe.views.linear_plots import CampbellCurves, campbell_picture

        multiples = np.atleast_1d(numbers(orders)) if np.size(orders) else np.zeros(0)
        if multiples.ndim != 1 or not np.all(np.isfinite(multiples)) or np.any(multiples < 0.0):
            raise ModelError(f"orders must be multiples of the rotation, zero or more, not {orders!r}")
        if len(multiples) > MOST_ORDERS:
            raise ModelError(f"orders must be {MOST_ORDERS} at most, lines of one picture, not {len(multiples)}")
        critical = [(found.speed, order) for order in multiples.tolist() for found in self.critical_speeds(order)]
        shown = _diagram(self._refined, self._refined.speeds, self._undamped)
        curves = CampbellCurves(
            shown.speeds,
            shown.eigenvalues,
            shown.frequencies,
            shown.damping_ratios,
            shown.grows,
            self._labels(),
            multiples,
            critical,
        )
        return campbell_picture(curves, path)

    def _labels(self) -> list[str]:
        """Return a name for each mode, with the body that moves most in it unless that is the same for all modes."""
        leading = []
        for column in self.numbers.T:
            row = int(np.argmax(column >= 0))
            shares = self.modes[row].participation
            leading.append(max(shares, key=lambda name: shares[name][column[row]]))
        several = len(set(leading)) > 1
        return [f"mode {j + 1}{f' ({name})' if several else ''}" for j, name in enumerate(leading)]


@checked("speeds", "modes", "balance")
def campbell(
    build: Callable[[float], Freezable | Model],
    speeds: Sequence[float] | np.ndarray,
    *,
    modes: int | None = None,
    balance: bool = True,
) -> Campbell:
    """Follow the modes of a scene over its speed.

    At the fastest speed it is measured whether the scene changes with the azimuth. If it does, as a bladed rotor on a
    tower, its modes are Floquet modes (see `floquet`) with the period of one revolution, followed with all harmonics;
    the frequency is that of the largest harmonic at the first speed, in the frame of the scene.

    Parameters
    ----------
    build : callable
        Speed (rad/s) -> scene, such as one whose shaft is driven by ``Motion.steady(speed)``. The same bodies and
        joints at every speed.
    speeds : array_like, shape (S,)
        Ascending, at least two, rad/s. Intermediate speeds are added where a mode changes too much to be identified,
        and for pictures and critical speeds also where curves bend.
    modes : int, optional
        Number of modes to follow: the lowest that oscillate at the first speed, and those that are below the highest of
        them at other speeds. Rigid motions and overdamped modes do not count. Default: six, or all.
    balance : bool
        Linearise about the steady state at each speed; False: about the start of each scene, with an
        `UnsettledWarning` if that is not in balance. Within 0.5 % of a critical speed in the frame of the shaft, where
        the bow of a rotor due to unbalance is unbounded, that bow is left out.

    Raises
    ------
    ModelError
        If the speeds do not ascend, nothing rotates, or the scenes have different coordinates.
    SimulationError
        If a scene has no balance at a speed.

    Warns
    -----
    AccuracyWarning
        If a mode cannot be identified from one speed to the next.

    Examples
    --------
    ``kf.campbell(rotor, np.linspace(0, 500, 26), modes=4).plot("campbell.png")``
    """
    at = ascending_speeds(speeds, "a Campbell diagram")
    if modes is not None and (isinstance(modes, bool) or not isinstance(modes, (int, np.integer)) or modes < 1):
        raise ModelError(f"modes must be a whole number of 1 or more, not {modes!r}")
    if not callable(build):
        raise ModelError(f"campbell needs a function of the speed that returns a scene, not {build!r}")

    scene = modes_over_speed(build, at, balance)
    curves = _followed(scene.modes, at, modes)
    found = _diagram(curves, at, cache(lambda: _followed(scene.undamped, at, modes).refine()))
    scene.warn("campbell")
    _warn_of_mixed(found)
    return found


def _followed(of: Callable[[float], AnyModes], at: Vector, modes: int | None) -> Curves:
    """Return the followed modes, evaluated at the speeds of a diagram."""
    own = _oscillating(of(float(at[0])))
    count = min(USUAL, len(own)) if modes is None else modes
    if not len(own):
        raise ModelError(
            f"nothing oscillates at {at[0]:.6g} rad/s, from where modes are followed. Remedy: other speeds"
        )
    if len(own) < count:
        raise ModelError(
            f"the scene has {len(own)} modes that oscillate at {at[0]:.6g} rad/s, not {modes}. Remedy: modes={len(own)}"
        )
    curves = Curves(of, float(at[0]), own[:count])
    for speed in at.tolist():
        found = curves.at(speed)
        highest = np.abs(found.values[:count].imag).max() / (2.0 * np.pi)
        if isinstance(found.modes, Modes):  # the frequency of Floquet modes is a convention
            curves.add(speed, np.setdiff1d(_oscillating(found.modes, highest), found.numbers))
    return curves


def _oscillating(modes: AnyModes, below: float = np.inf) -> np.ndarray:
    """Return the numbers of the oscillating modes with a frequency below a limit (Hz)."""
    return np.flatnonzero(~modes.is_rigid & (modes.eigenvalues.imag != 0.0) & (modes.frequencies < below))


def _diagram(curves: Curves, speeds: Vector, undamped: Callable[[], Curves]) -> Campbell:
    """Return the diagram of the followed modes at some speeds."""
    found = [curves.at(float(speed)) for speed in speeds]
    shape = (len(speeds), len(curves.born))
    modes, correlations = np.full(shape, -1), np.full(shape, np.nan)
    for i, one in enumerate(found):
        modes[i, : len(one.numbers)], correlations[i, : len(one.numbers)] = one.numbers, one.sureness
    return Campbell(
        speeds, curves.values(speeds), tuple(one.modes for one in found), modes, correlations, curves, undamped
    )


def _warn_of_mixed(diagram: Campbell) -> None:
    """Warn where a mode could not be identified: results beyond are unreliable."""
    for speed, sureness in zip(diagram.speeds[1:], diagram.correlations[1:], strict=True):
        unsure = np.flatnonzero(sureness < SURE)
        if len(unsure):
            warnings.warn(
                f"mode {unsure[0] + 1} cannot be identified reliably on the way to {speed:.6g} rad/s (correlation "
                f"{sureness[unsure[0]]:.2g} after the interval was divided {DEEPEST} times). Remedy: more speeds there",
                AccuracyWarning,
                stacklevel=outside(),
            )
            return
