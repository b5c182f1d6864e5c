"""Campbell diagram: how the modes of a scene change with its speed, each followed from speed to speed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers
from kanefe.linear.equilibria import equilibrium
from kanefe.linear.linearisation import linearise
from kanefe.linear.modes import Modes
from kanefe.linear.state import model_of

if TYPE_CHECKING:
    from kanefe.linear.state import Freezable
    from kanefe.views.plots import Figure

SURE = 0.7
"""Correlation of a mode with its follower from which on it is taken for the same: below, a speed between is tried."""

DEEPEST = 5
"""How often an interval between two speeds is halved to follow modes through it."""

ALIKE = 1e-3
"""Difference of two eigenvalues, of their size, below which their modes mix freely and any order is right."""


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
    modes : tuple of Modes
        All modes at each speed.
    numbers : ndarray of int, shape (S, modes)
        Which of the modes at a speed each column is.
    correlations : ndarray, shape (S, modes)
        Of each mode with itself at the speed before it was followed from (1 at the first); low values mark places
        where modes veer or mix.
    """

    speeds: np.ndarray
    eigenvalues: np.ndarray
    modes: tuple[Modes, ...]
    numbers: np.ndarray
    correlations: np.ndarray

    @property
    def frequencies(self) -> np.ndarray:
        """|Im lambda| / 2 pi, Hz, shape (S, modes)."""
        return np.asarray(np.abs(self.eigenvalues.imag) / (2.0 * np.pi))

    @property
    def damping_ratios(self) -> np.ndarray:
        """``-Re lambda / |lambda|``, shape (S, modes)."""
        size = np.abs(self.eigenvalues)
        return np.asarray(np.divide(-self.eigenvalues.real, size, out=np.zeros_like(size), where=size > 0.0))

    @property
    def grows(self) -> np.ndarray:
        """Whether each mode grows, shape (S, modes)."""
        noise = np.array([1e-9 * np.abs(m.eigenvalues).max(initial=0.0) for m in self.modes])
        return np.asarray(self.eigenvalues.real > noise[:, None])

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


def campbell(
    build: Callable[[float], Freezable | Model],
    speeds: Sequence[float] | np.ndarray,
    *,
    modes: int = 6,
    balance: bool = True,
) -> Campbell:
    """Follow the modes of a scene over its speed.

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
        Linearise about the steady state at each speed; False: about the start of each scene.

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

    def of(speed: float) -> Modes:
        model = model_of(build(float(speed)), f"campbell at {speed:.6g} rad/s")
        if not balance:
            return linearise(model).modes()
        return equilibrium(model, start=model.initial_state).linearise().modes()

    first = of(at[0])
    own = np.flatnonzero(~first.is_rigid)
    if len(own) < modes:
        raise ModelError(f"the scene has {len(own)} modes at {at[0]:.6g} rad/s, not {modes}. Remedy: modes={len(own)}")
    followed = [_Followed(first, own[:modes], np.zeros(modes, dtype=bool), np.ones(modes))]
    for before, after in pairwise(at):
        followed.append(_follow(of, float(before), followed[-1], float(after), of(float(after)), DEEPEST))
    return Campbell(
        speeds=at,
        eigenvalues=np.array([f.values for f in followed]),
        modes=tuple(f.modes for f in followed),
        numbers=np.array([f.numbers for f in followed]),
        correlations=np.array([f.sureness for f in followed]),
    )


class _Followed(NamedTuple):
    """Which modes at a speed are those that are followed, whether as their conjugates, and how sure that is."""

    modes: Modes
    numbers: np.ndarray
    is_conjugate: np.ndarray
    sureness: np.ndarray

    @property
    def values(self) -> np.ndarray:
        values = self.modes.eigenvalues[self.numbers]
        return np.where(self.is_conjugate, values.conj(), values)

    @property
    def shapes(self) -> np.ndarray:
        shapes = self.modes.tangents[:, self.numbers]
        return np.where(self.is_conjugate, shapes.conj(), shapes)


def _follow(
    of: Callable[[float], Modes], before: float, old: _Followed, after: float, new: Modes, depth: int
) -> _Followed:
    """Return the followed modes at the next speed."""
    found = _matched(old, new)
    if depth == 0 or found.sureness.min() >= SURE:
        return found
    middle = 0.5 * (before + after)
    between = _follow(of, before, old, middle, of(middle), depth - 1)
    found = _follow(of, middle, between, after, new, depth - 1)
    return found._replace(sureness=np.minimum(between.sureness, found.sureness))


def _matched(old: _Followed, new: Modes) -> _Followed:
    """Return the best followers, each another one.

    A mode is the same as its conjugate: both are candidates, so that a whirl is followed through zero frequency.
    """
    if old.modes.linearisation.state_names != new.linearisation.state_names:
        raise ModelError(
            "modes can be followed only between scenes of the same coordinates. Remedy: build the scene alike at "
            "every speed, with the same bodies, modes and joints"
        )
    n, count = new.linearisation.model.free_count, len(new.eigenvalues)
    M = new.linearisation.small.mass()[:n, :n]
    candidates = np.hstack((new.tangents, new.tangents.conj()))
    others = np.concatenate((new.eigenvalues, new.eigenvalues.conj()))
    alike = _correlation(old.shapes, candidates, M)
    values = old.values
    # modes of one frequency mix freely: there it is the space that they span which is followed
    everything = np.hstack((old.modes.tangents, old.modes.tangents.conj()))
    of_everything = np.concatenate((old.modes.eigenvalues, old.modes.eigenvalues.conj()))
    for i, value in enumerate(values):
        same = np.abs(of_everything - value) <= ALIKE * np.abs(value)
        if np.count_nonzero(same) > 1:
            alike[i] = np.minimum(_correlation(everything[:, same], candidates, M).sum(axis=0), 1.0)
    for value in new.eigenvalues:
        same = np.abs(others - value) <= ALIKE * np.abs(value)
        if np.count_nonzero(same) > 1:
            alike[:, same] = np.minimum(alike[:, same].sum(axis=1, keepdims=True), 1.0)
    size = np.maximum(np.abs(values), 1e-12 * np.abs(others).max(initial=0.0))[:, None]
    cost = (1.0 - alike) + 0.2 * np.minimum(np.abs(values[:, None] - others[None, :]) / size, 1.0)
    cost[:, np.tile(new.is_rigid, 2)] += 1.0
    # of the two that a divergence has, the one that grows
    cost += 1e-3 * ((others.imag == 0.0) & (others.real < 0.0))[None, :]
    as_conjugate = cost[:, count:] < cost[:, :count]
    rows, columns = linear_sum_assignment(np.minimum(cost[:, :count], cost[:, count:]))
    chosen = columns[np.argsort(rows)]
    is_conjugate = as_conjugate[np.arange(len(chosen)), chosen]
    return _Followed(new, chosen, is_conjugate, alike[np.arange(len(chosen)), chosen + count * is_conjugate])


def _correlation(a: np.ndarray, b: np.ndarray, M: Matrix) -> Matrix:
    """Return the modal assurance criterion of shapes, columns of a and b, in the metric M, shape (a, b), 0 to 1.

    (Allemang, "The modal assurance criterion: twenty years of use and abuse", Sound and Vibration 37 (2003) 14-23.)
    """
    cross = np.abs(a.conj().T @ M @ b) ** 2
    own_a, own_b = (np.einsum("ik,ij,jk->k", x.conj(), M, x).real for x in (a, b))
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
