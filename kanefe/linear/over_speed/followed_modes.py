"""Modes followed over the speed of a scene by their shapes, through veering and crossings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, linear_sum_assignment

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.linear.modes.floquet_modes import FloquetModes
from kanefe.linear.modes.modes import Modes

SURE = 0.7
"""Correlation of a mode with its successor, dimensionless, above which they are the same; below it an intermediate
speed is tried."""

DEEPEST = 5
"""Largest number of divisions of an interval between two speeds to follow modes through it."""

ASIDE = 0.47
"""Fraction at which an interval is divided: not the middle, which may be zero speed, where modes are double."""

SIDE = 4
"""Number of harmonics on either side by which Floquet modes are identified."""

MOST_SHIFT = 2
"""Largest number of harmonics by which the frequency of such a mode may be shifted between two speeds."""

AnyModes = Modes | FloquetModes

ALIKE = 1e-3
"""Difference of two eigenvalues, relative to their size, below which their modes mix and their order is arbitrary."""

SAME = 1e-9
"""Difference of two eigenvalues, relative to their size, below which a mode is double."""

RIVAL = 3.0
"""Least ratio of the frequency distances of another mode of the same shape and of the chosen mode."""

STILL = 1e-6
"""Eigenvalue relative to the highest frequency below which a mode is at rest."""

SLOW = 1e-4
"""Frequency relative to the speed below which a whirl is nearly at rest: there asymmetry mixes forward and backward
whirl, and its frequency can vanish over a range of speeds, where one motion grows and one decays."""

DIGITS = 1e-12
"""Relative accuracy of the speed of a crossing or a limit."""

THINNEST = 2e-3
"""Distance of a curve from the straight line between two of its points, relative to the highest frequency, that is not
visible."""


class _Candidates(NamedTuple):
    """Candidates for the continuation of modes: modes, their conjugates, and Floquet modes shifted by harmonics.

    Attributes
    ----------
    values : ndarray of complex, shape (c,)
    shapes : ndarray of complex, shape (harmonics, free, c)
    numbers : ndarray of int, shape (c,)
        The mode of each candidate.
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


class Followed(NamedTuple):
    """The followed modes at a speed, and the reliability of their identification.

    Attributes
    ----------
    modes : Modes or FloquetModes
        All modes at that speed.
    numbers : ndarray of int, shape (k,)
        The followed modes.
    values : ndarray of complex, shape (k,)
        Their eigenvalues or the conjugates that continue them, 1/s.
    shapes : ndarray of complex, shape (harmonics, free, k)
    sureness : ndarray, shape (k,)
        Correlation of each with itself at the speed from which it was followed.
    """

    modes: AnyModes
    numbers: np.ndarray
    values: np.ndarray
    shapes: np.ndarray
    sureness: np.ndarray


def root_of(function: Callable[[float], float], a: float, b: float) -> float:
    """Return the zero of a function of the speed between two speeds (rad/s)."""
    return float(brentq(function, a, b, xtol=DIGITS * max(abs(a), abs(b)), rtol=1e-15))


class Curves:
    """Modes of a scene over its speed: each speed is evaluated once, and modes are followed from the nearest known one.

    Parameters
    ----------
    of : callable
        Speed (rad/s) -> the modes there.
    start : float
        The lowest speed, rad/s.
    numbers : ndarray of int
        Numbers of the modes to follow.
    """

    def __init__(self, of: Callable[[float], AnyModes], start: float, numbers: np.ndarray) -> None:
        self._of = of
        self._known = {start: _first(of(start), numbers)}
        self._born = [start] * len(numbers)

    @property
    def speeds(self) -> Vector:
        """The known speeds, rad/s, ascending."""
        return np.array(sorted(self._known))

    @property
    def born(self) -> Vector:
        """The speed from which each mode is followed, rad/s."""
        return np.array(self._born)

    def at(self, speed: float) -> Followed:
        """Return the followed modes at a speed."""
        found = self._known.get(speed)
        if found is None:
            first = max(born for born in self._born if born <= speed)
            near = sorted((one for one in self._known if one >= first), key=lambda one: abs(one - speed))
            height = self.height
            sure = (one for one in near if not _is_unsure(self._known[one], height))
            found = self._follow(next(sure, near[0]), speed, DEEPEST)
        return found

    def values(self, speeds: Sequence[float] | Vector) -> np.ndarray:
        """Return the eigenvalues at some speeds, (S, k); NaN where a mode is not followed yet."""
        found = np.full((len(speeds), len(self._born)), complex(np.nan, np.nan))
        for row, speed in zip(found, speeds, strict=True):
            values = self.at(float(speed)).values
            row[: len(values)] = values
        return found

    def add(self, speed: float, numbers: np.ndarray) -> None:
        """Follow more modes from the last known speed on."""
        old, new = self._known[speed], _first(self._of(speed), numbers)
        parts = [np.concatenate(pair, axis=-1) for pair in zip(old[1:], new[1:], strict=True)]
        self._known[speed] = Followed(old.modes, *parts)
        self._born += [speed] * len(numbers)

    def _follow(self, before: float, after: float, depth: int) -> Followed:
        count = sum(born <= after for born in self._born)
        old = self._known[before]
        old = Followed(old.modes, *(part[..., :count] for part in old[1:]))
        found = _matched(old, self._of(after), SLOW * max(abs(before), abs(after)))
        if depth > 0 and found.sureness.min(initial=1.0) < SURE:
            middle = before + ASIDE * (after - before)
            between = self._follow(before, middle, depth - 1)
            found = self._follow(middle, after, depth - 1)
            found = found._replace(sureness=np.minimum(between.sureness[:count], found.sureness))
        self._known[after] = found
        return found

    def refine(self) -> Curves:
        """Add speeds where curves bend, until straight lines between the points represent them; return the curves."""
        if len(self._known) == 2:
            self.at(float(self.speeds.mean()))
        for _ in range(DEEPEST):
            x = self.speeds
            values = self.values(x)
            slopes = np.diff(values, axis=0) / np.diff(x)[:, None]
            turns = np.abs(np.diff(slopes, axis=0) / (0.5 * (x[2:] - x[:-2]))[:, None])
            turns = np.nan_to_num(turns).max(axis=1, initial=0.0)
            of_intervals = np.maximum(np.append(turns, 0.0), np.insert(turns, 0, 0.0))
            wide = of_intervals * np.diff(x) ** 2 / 8.0 > THINNEST * self.height
            if not wide.any():
                break
            for before, after in np.column_stack((x[:-1], x[1:]))[wide]:
                self.at(float(0.5 * (before + after)))
        return self

    @property
    def height(self) -> float:
        """The highest known frequency of the followed modes, rad/s."""
        return float(max(np.abs(found.values.imag).max(initial=0.0) for found in self._known.values()))


def _is_unsure(found: Followed, height: float) -> bool:
    """Return whether followed modes cannot be identified by shape or sense of rotation at a speed.

    A whirl of zero frequency has no sense: with damping alone its circles are two real modes with the same eigenvalue,
    in any combination. Both whirls of a symmetric rotor at rest have the same frequency too.
    """
    of_all, size = found.modes.eigenvalues, np.abs(found.values)
    apart = np.abs(of_all - found.values[:, None])
    still = np.abs(found.values.imag) <= STILL * height
    is_near, is_same = ((apart <= (share * size)[:, None]).sum(axis=1) > 1 for share in (ALIKE, SAME))
    return bool(np.any(is_same | still & (is_near | (size <= STILL * height))))


def _first(modes: AnyModes, numbers_of: np.ndarray) -> Followed:
    found = _candidates(modes)
    at = [np.flatnonzero((found.numbers == i) & (found.values == modes.eigenvalues[i]))[0] for i in numbers_of]
    return Followed(modes, numbers_of, found.values[at], found.shapes[:, :, at], np.ones(len(at)))


def _matched(old: Followed, new: AnyModes, slow: float) -> Followed:
    """Return the best continuations, a different mode for each.

    A mode and its conjugate are both candidates, so that a whirl is followed through zero frequency. Below the
    frequency `slow` (rad/s) a mode is identified by the space of all modes that are as slow, without a sense of
    rotation.
    """
    _check_same_scene(old.modes, new)
    M, count = new.metric, len(new.eigenvalues)
    ahead, behind = _candidates(new), _candidates(old.modes)
    others, values = ahead.values, old.values
    products, gram = _products(old.shapes, ahead.shapes, M), _products(ahead.shapes, ahead.shapes, M)
    own, of_others = _products(old.shapes, old.shapes, M).diagonal().real, gram.diagonal().real
    # modal assurance criterion (Allemang, "The modal assurance criterion: twenty years of use and abuse", Sound and
    # Vibration 37 (2003) 14-23)
    of_each = np.abs(products) ** 2 / np.maximum(np.outer(own, of_others), 1e-300)
    alike = of_each.copy()

    def within(among: np.ndarray) -> Vector:
        return _share(products[:, among].conj().T, gram[np.ix_(among, among)], own)

    # modes with the same frequency mix, so that the space that they span is followed; a slow whirl does not mix with
    # its conjugate, which turns the other way
    for rows, among in _several(_mixed(behind, values, old.numbers)):
        space = behind.shapes[:, :, among]
        alike[rows] = _share(_products(space, ahead.shapes, M), _products(space, space, M), of_others)
    for _, among in _several(_mixed(ahead, others, ahead.numbers)):
        alike[:, among] = np.maximum(within(among), alike[:, among].max(axis=1))[:, None]
    of_slow = np.zeros_like(alike)
    is_slow = np.abs(others.imag) <= (slow if isinstance(new, Modes) else -1.0)
    near = is_slow & is_slow[:, None] & (np.abs(others - others[:, None]) <= 2.0 * slow)
    for rows, among in _several(near):
        of_slow[:, rows] = within(among)[:, None]
    size = np.maximum(np.abs(values), 1e-12 * np.abs(others).max(initial=0.0))[:, None]
    apart = np.abs(values[:, None] - others[None, :])
    cost = 0.2 * apart / (size + apart)
    # a whirl of zero frequency is an additional rigid motion
    if np.count_nonzero(new.is_rigid) <= np.count_nonzero(old.modes.is_rigid):
        cost[:, new.is_rigid[ahead.numbers]] += 1.0
    # among mixed modes the most similar one; of the two modes of a divergence the one that grows
    cost += 1e-3 * (1.0 - of_each)
    cost += 1e-3 * ((others.imag == 0.0) & (others.real < 0.0))[None, :]
    shape = len(values), -1, count  # candidates repeat the modes in their order
    best = (cost + 1.0 - alike).reshape(shape).argmin(axis=1)
    alike = np.maximum(alike, of_slow)
    rows, columns = linear_sum_assignment((cost + 1.0 - alike).reshape(shape).min(axis=1))
    chosen = columns[np.argsort(rows)]
    at = best[np.arange(len(chosen)), chosen] * count + chosen
    # rivals with the same shape and a similar distance: both whirls of a symmetric rotor differ by frequency only
    found = np.arange(len(at)), at
    rivals = (alike >= SURE) & (apart < RIVAL * apart[found][:, None])
    is_sure = ~_has_rival(rivals, others, at) | _is_one_of_several(behind.values, values)
    return Followed(new, chosen, others[at], ahead.shapes[:, :, at], np.where(is_sure, alike[found], 0.0))


def _check_same_scene(old: AnyModes, new: AnyModes) -> None:
    if old.state_names != new.state_names:
        raise ModelError(
            "modes can be followed only between scenes of the same coordinates. Remedy: build the scene alike at "
            "every speed, with the same bodies, modes and joints"
        )


def _has_rival(near: np.ndarray, others: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return of each continuation whether one of those near it vibrates, with another frequency."""
    is_apart = np.abs(others[None, :] - others[at][:, None]) > ALIKE * np.abs(others[at])[:, None]
    return np.asarray((near & (others.imag[None, :] != 0.0) & is_apart).any(axis=1))


def _is_one_of_several(candidates: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return of each value whether several candidates have it."""
    return np.array([np.count_nonzero(np.abs(candidates - v) <= ALIKE * np.abs(v)) >= 2 for v in values])


def _share(products: np.ndarray, gram: np.ndarray, own: Vector) -> Vector:
    """Return the share of vectors with squares `own` (a,) in the space of others, from products with these (s, a)."""
    inside = np.einsum("sa,sa->a", products.conj(), np.linalg.pinv(gram, rcond=ALIKE**2, hermitian=True) @ products)
    return np.clip(inside.real / np.maximum(own, 1e-300), 0.0, 1.0)


def _mixed(candidates: _Candidates, values: np.ndarray, numbers_of: np.ndarray) -> np.ndarray:
    """Return a mask (k, c) of the candidates with the frequency of each mode: itself, and those of other modes."""
    is_other = (candidates.numbers != numbers_of[:, None]) | (candidates.values == values[:, None])
    return np.asarray(is_other & (np.abs(candidates.values - values[:, None]) <= ALIKE * np.abs(values)[:, None]))


def _several(mixed: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield groups of rows with the same set of several candidates, and the numbers of the candidates."""
    groups: dict[bytes, list[int]] = {}
    for i in np.flatnonzero(np.count_nonzero(mixed, axis=1) > 1).tolist():
        groups.setdefault(mixed[i].tobytes(), []).append(i)
    for rows in groups.values():
        yield np.array(rows), np.flatnonzero(mixed[rows[0]])


def _products(a: np.ndarray, b: np.ndarray, M: Matrix) -> np.ndarray:
    """Return the inner products of shapes (harmonics, free, a) and b in the metric M, (a, b)."""
    return np.tensordot(a.conj(), M @ b, axes=([0, 1], [0, 1]))
