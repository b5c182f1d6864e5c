"""Campbell diagram: how the modes of a scene change with its speed, each followed from speed to speed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers
from kanefe.instants.instant import Instant
from kanefe.instants.missed_statics import warn_of_missed
from kanefe.linear.azimuth import CONSTANT
from kanefe.linear.eigenvalues import growth_noise
from kanefe.linear.equilibria import balanced
from kanefe.linear.floquet_modes import FloquetModes, floquet
from kanefe.linear.linearisation import Linearisation, linearised
from kanefe.linear.modes import Modes, modes_of
from kanefe.linear.state import model_of
from kanefe.linear.unsettled import warn_of_imbalance

if TYPE_CHECKING:
    from kanefe.linear.state import Freezable
    from kanefe.views.plots import Figure

SURE = 0.7
"""Correlation of a mode with its follower from which on it is taken for the same: below, a speed between is tried."""

DEEPEST = 5
"""How often an interval between two speeds is halved to follow modes through it."""

SIDE = 4
"""Harmonics to either side by which Floquet's modes are known again."""

MOST_SHIFT = 2
"""By how many harmonics the name of such a mode may change between two speeds."""

AnyModes = Modes | FloquetModes

ALIKE = 1e-3
"""Difference of two eigenvalues, of their size, below which their modes mix freely and any order is right."""


MOST_ORDERS = 100
"""Lines of excitation in one picture."""


@dataclass(frozen=True, eq=False)
class Campbell:
    """Modes over the speed, column by column the same mode; made by `campbell`.

    Attributes
    ----------
    speeds : ndarray, shape (S,)
        rad/s.
    eigenvalues : ndarray of complex, shape (S, modes)
        1/s, in the frame of the scene. A whirl whose frequency falls through zero goes on with a negative imaginary
        part: seen from a frame that spins faster it turns backwards.
    modes : tuple of Modes, or of FloquetModes
        All modes at each speed.
    numbers : ndarray of int, shape (S, modes)
        Which of the modes at a speed each column is.
    correlations : ndarray, shape (S, modes)
        Of each mode with itself at the speed before it was followed from (1 at the first); low values mark places
        where modes veer or mix.
    """

    speeds: np.ndarray
    eigenvalues: np.ndarray
    modes: tuple[AnyModes, ...]
    numbers: np.ndarray
    correlations: np.ndarray

    @property
    def frequencies(self) -> np.ndarray:
        """Damped frequencies, abs(Im lambda) / 2 pi, Hz, shape (S, modes)."""
        return np.asarray(np.abs(self.eigenvalues.imag) / (2.0 * np.pi))

    @property
    def damping_ratios(self) -> np.ndarray:
        """``-Re lambda / |lambda|``, shape (S, modes)."""
        size = np.abs(self.eigenvalues)
        return np.asarray(np.divide(-self.eigenvalues.real, size, out=np.zeros_like(size), where=size > 0.0))

    @property
    def grows(self) -> np.ndarray:
        """Whether each mode grows, shape (S, modes)."""
        pairs = zip(self.eigenvalues, self.modes, strict=True)
        return np.array([values.real > growth_noise(values, m.eigenvalues) for values, m in pairs])

    @checked
    def critical_speeds(self, order: float = 1.0) -> list[tuple[float, int]]:
        """Return the speeds (rad/s) at which a mode has `order` times the frequency of rotation, with its column.

        Between the speeds of the diagram by straight lines. In a frame that spins with the rotor an
        unbalance stands still: its critical speeds are those of order 0, where a frequency falls to zero.
        """
        found = []
        for j, values in enumerate(self.eigenvalues.T):
            # squares: a frequency that falls to zero may go on as the growth of a divergence
            squares = -np.real(values**2) - (order * self.speeds) ** 2
            turns = _continued(self.speeds, values.imag) if order == 0.0 else squares
            for i in range(len(self.speeds) - 1):
                (x, y), (a, b) = self.speeds[i : i + 2], turns[i : i + 2]
                if a * b >= 0.0:
                    x, y, a, b = x**2, y**2, squares[i], squares[i + 1]
                    if a * b >= 0.0 and not (b == 0.0 and a != 0.0):
                        continue
                    found.append((float(np.sqrt(x + (y - x) * a / (a - b))), j))
                else:
                    found.append((float(x + (y - x) * a / (a - b)), j))
        return sorted(found)

    @checked
    def plot(self, path: str | Path | None = None, *, orders: Sequence[float] = (1.0,)) -> Figure:
        """Draw frequencies and damping over the speed, and write the picture to `path` if given.

        Parameters
        ----------
        path : path, optional
        orders : sequence of float
            Multiples of the rotation at which the scene is excited: drawn as lines, with their critical speeds; 0 in
            a frame that spins with the rotor.

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
        critical = [(speed, order) for order in multiples.tolist() for speed, _ in self.critical_speeds(order)]
        curves = CampbellCurves(
            self.speeds,
            self.eigenvalues,
            self.frequencies,
            self.damping_ratios,
            self.grows,
            self._labels(),
            multiples,
            critical,
        )
        return campbell_picture(curves, path)

    def _labels(self) -> list[str]:
        """Return a name for each mode, with the body that moves most in it, unless that is the same one in all."""
        first = self.modes[0]
        shares = first.participation
        leading = [max(shares, key=lambda name: shares[name][number]) for number in self.numbers[0]]
        several = len(set(leading)) > 1
        return [f"mode {j + 1}{f' ({name})' if several else ''}" for j, name in enumerate(leading)]


@checked("speeds", "modes", "balance")
def campbell(
    build: Callable[[float], Freezable | Model],
    speeds: Sequence[float] | np.ndarray,
    *,
    modes: int = 6,
    balance: bool = True,
) -> Campbell:
    """Follow the modes of a scene over its speed.

    Whether the scene stays what it is as it turns is measured at the fastest speed. One that changes, such as a bladed
    rotor on a tower, has Floquet's modes (see `floquet`) with the period of a turn, followed with all their harmonics:
    the frequency drawn is that of the largest at the first speed, as the scene sees it.

    Parameters
    ----------
    build : callable
        Speed (rad/s) -> scene, such as one whose shaft is driven by ``Motion.steady(speed)``. The same bodies and
        joints at every speed.
    speeds : array_like, shape (S,)
        Ascending, at least two, rad/s. Where a mode changes too much from one to the next to be known again, speeds
        between are tried.
    modes : int
        How many modes are followed: those of lowest frequency at the first speed, rigid motions left out.
    balance : bool
        Linearise about the steady state at each speed; False: about the start of each scene, with an
        `UnsettledWarning` where that is not in balance.

    Raises
    ------
    ModelError
        If the speeds do not ascend, or the scenes have different coordinates.
    SimulationError
        If a scene has no balance at a speed.

    Examples
    --------
    ``kf.campbell(rotor, np.linspace(0, 500, 26), modes=4).plot("campbell.png")``
    """
    at = numbers(speeds)
    if at.ndim != 1 or len(at) < 2 or not np.all(np.isfinite(at)) or np.any(np.diff(at) <= 0.0):
        raise ModelError(f"the speeds of a Campbell diagram must be two or more that ascend, rad/s, not {speeds!r}")
    if isinstance(modes, bool) or not isinstance(modes, (int, np.integer)) or modes < 1:
        raise ModelError(f"modes must be a whole number of 1 or more, not {modes!r}")
    if not callable(build):
        raise ModelError(f"campbell needs a function of the speed that returns a scene, not {build!r}")

    of = _modes_over_speed(build, at, balance)
    first = of(at[0])
    own = np.flatnonzero(~first.is_rigid)
    if len(own) < modes:
        raise ModelError(f"the scene has {len(own)} modes at {at[0]:.6g} rad/s, not {modes}. Remedy: modes={len(own)}")
    followed = [_first(first, own[:modes])]
    for before, after in pairwise(at):
        followed.append(_follow(of, float(before), followed[-1], float(after), of(float(after)), DEEPEST))
    return Campbell(
        speeds=at,
        eigenvalues=np.array([f.values for f in followed]),
        modes=tuple(f.modes for f in followed),
        numbers=np.array([f.numbers for f in followed]),
        correlations=np.array([f.sureness for f in followed]),
    )


def _modes_over_speed(
    build: Callable[[float], Freezable | Model], at: Vector, balance: bool
) -> Callable[[float], AnyModes]:
    """Return the modes at a speed as a function: Floquet's, if the scene changes as it turns."""

    def state(speed: float, steady: bool) -> Linearisation:
        model = model_of(build(speed), f"campbell at {speed:.6g} rad/s")
        if not balance:
            return linearised(model, None, None, None, None)
        return balanced(model, start=model.initial_state, steady=steady).linearise()

    def of_periodic(speed: float) -> AnyModes:
        lin = state(float(speed), False)
        if speed == 0.0:
            still = modes_of(lin)
            none = np.zeros(1, dtype=int)
            return FloquetModes(lin.small, np.inf, still.eigenvalues, none, still.vectors[None], still.is_rigid)
        return floquet(lin.model, period=2.0 * np.pi / abs(float(speed)), t=lin.time, start=lin.state)

    fastest = float(at[np.abs(at).argmax()])
    if fastest != 0.0:
        lin = state(fastest, False)
        if not balance:
            warn_of_imbalance(lin.imbalance, f"campbell at {fastest:.6g} rad/s")
        else:
            warn_of_missed(Instant(lin.model, lin.time, lin.state), f"campbell at {fastest:.6g} rad/s")
        if lin.change > CONSTANT:
            return of_periodic
    return lambda speed: modes_of(state(float(speed), True))


class _Candidates(NamedTuple):
    """What modes may go on as: themselves, their conjugates, and Floquet's named by another of their harmonics.

    Attributes
    ----------
    values : ndarray of complex, shape (c,)
    shapes : ndarray of complex, shape (harmonics, free, c)
    numbers : ndarray of int, shape (c,)
        The mode that each is of.
    """

    values: np.ndarray
    shapes: np.ndarray
    numbers: np.ndarray


def _candidates(modes: AnyModes) -> _Candidates:
    count = len(modes.eigenvalues)
    if isinstance(modes, Modes):
        values = np.concatenate((modes.eigenvalues, modes.eigenvalues.conj()))
        shapes = np.concatenate((modes.tangents, modes.tangents.conj()), axis=1)[None]
        return _Candidates(values, shapes, np.tile(np.arange(count), 2))
    z = np.zeros((2 * SIDE + 1, *modes.tangents.shape[1:]), dtype=complex)
    for k, shape in zip(modes.orders, modes.tangents, strict=True):
        if abs(k) <= SIDE:
            z[k + SIDE] = shape
    rate = 2.0 * np.pi / modes.period
    all_values, all_shapes = [], []
    for shift in range(-MOST_SHIFT, MOST_SHIFT + 1) if rate > 0.0 else (0,):
        moved = np.zeros_like(z)
        first, last = max(0, shift), min(len(z), len(z) + shift)
        moved[first - shift : last - shift] = z[first:last]
        values = modes.eigenvalues + 1j * shift * rate
        all_values += [values, values.conj()]
        all_shapes += [moved, moved[::-1].conj()]
    numbers_of = np.tile(np.arange(count), len(all_values))
    return _Candidates(np.concatenate(all_values), np.concatenate(all_shapes, axis=2), numbers_of)


class _Followed(NamedTuple):
    """Which modes at a speed are those that are followed, as what, and how sure that is."""

    modes: AnyModes
    numbers: np.ndarray
    values: np.ndarray
    shapes: np.ndarray
    sureness: np.ndarray


def _first(modes: AnyModes, numbers_of: np.ndarray) -> _Followed:
    found = _candidates(modes)
    at = [np.flatnonzero((found.numbers == i) & (found.values == modes.eigenvalues[i]))[0] for i in numbers_of]
    return _Followed(modes, numbers_of, found.values[at], found.shapes[:, :, at], np.ones(len(at)))


def _follow(
    of: Callable[[float], AnyModes], before: float, old: _Followed, after: float, new: AnyModes, depth: int
) -> _Followed:
    """Return the followed modes at the next speed."""
    found = _matched(old, new)
    if depth == 0 or found.sureness.min() >= SURE:
        return found
    middle = 0.5 * (before + after)
    between = _follow(of, before, old, middle, of(middle), depth - 1)
    found = _follow(of, middle, between, after, new, depth - 1)
    return found._replace(sureness=np.minimum(between.sureness, found.sureness))


def _matched(old: _Followed, new: AnyModes) -> _Followed:
    """Return the best followers, each another one.

    A mode is the same as its conjugate: both are candidates, so that a whirl is followed through zero frequency.
    """
    if old.modes.state_names != new.state_names:
        raise ModelError(
            "modes can be followed only between scenes of the same coordinates. Remedy: build the scene alike at "
            "every speed, with the same bodies, modes and joints"
        )
    M, count = new.metric, len(new.eigenvalues)
    ahead, behind = _candidates(new), _candidates(old.modes)
    others = ahead.values
    alike = _correlation(old.shapes, ahead.shapes, M)
    values = old.values
    # modes of one frequency mix freely: there it is the space that they span which is followed
    for i, value in enumerate(values):
        same = np.abs(behind.values - value) <= ALIKE * np.abs(value)
        if np.count_nonzero(same) > 1:
            alike[i] = np.minimum(_correlation(behind.shapes[:, :, same], ahead.shapes, M).sum(axis=0), 1.0)
    for value in new.eigenvalues:
        same = np.abs(others - value) <= ALIKE * np.abs(value)
        if np.count_nonzero(same) > 1:
            alike[:, same] = np.minimum(alike[:, same].sum(axis=1, keepdims=True), 1.0)
    size = np.maximum(np.abs(values), 1e-12 * np.abs(others).max(initial=0.0))[:, None]
    cost = (1.0 - alike) + 0.2 * np.minimum(np.abs(values[:, None] - others[None, :]) / size, 1.0)
    cost[:, new.is_rigid[ahead.numbers]] += 1.0
    # of the two that a divergence has, the one that grows
    cost += 1e-3 * ((others.imag == 0.0) & (others.real < 0.0))[None, :]
    by_mode = cost.reshape(len(values), -1, count)  # candidates repeat the modes in their order
    best = by_mode.argmin(axis=1)
    rows, columns = linear_sum_assignment(by_mode.min(axis=1))
    chosen = columns[np.argsort(rows)]
    at = best[np.arange(len(chosen)), chosen] * count + chosen
    return _Followed(new, chosen, others[at], ahead.shapes[:, :, at], alike[np.arange(len(chosen)), at])


def _correlation(a: np.ndarray, b: np.ndarray, M: Matrix) -> Matrix:
    """Return the modal assurance criterion of shapes (harmonics, free, a) and b in the metric M, (a, b), 0 to 1.

    (Allemang, "The modal assurance criterion: twenty years of use and abuse", Sound and Vibration 37 (2003) 14-23.)
    """
    weighted = np.einsum("ij,kjb->kib", M, b)
    cross = np.abs(np.einsum("kia,kib->ab", a.conj(), weighted, optimize=True)) ** 2
    own_a = np.einsum("kia,ij,kja->a", a.conj(), M, a, optimize=True).real
    own_b = np.einsum("kib,kib->b", b.conj(), weighted).real
    return np.asarray(cross / np.maximum(np.outer(own_a, own_b), 1e-300))


def _continued(speeds: Vector, frequencies: Vector) -> Vector:
    """Return frequencies with the signs that continue them: each eigenvalue has a conjugate, told by its sign only."""
    found = np.array(frequencies)
    for i in range(1, len(found)):
        expected = found[0]
        if i > 1:
            slope = (found[i - 1] - found[i - 2]) / (speeds[i - 1] - speeds[i - 2])
            expected = found[i - 1] + slope * (speeds[i] - speeds[i - 1])
        if abs(found[i] + expected) < abs(found[i] - expected):
            found[i] = -found[i]
    return found
