"""A periodic motion: its states at times of the period, and the small motions about each.

A steady motion is known. Other motions are found by Newton's method in Fourier series: with x the tangents from the
steady motion and f their rates, ``dx/dt = f(t, x)`` is solved for all harmonics at once (Hairer & Wanner's collocation
with trigonometric polynomials; Trefethen, "Spectral Methods in MATLAB", chapter 3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.linear.azimuth import moved_on
from kanefe.linear.imbalance import FLOOR, force_sizes, imbalance_of
from kanefe.linear.modes.eigenpairs import rate_weights
from kanefe.linear.modes.hill import hill_matrix
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.tangents import rotations

FEWEST, MOST = 17, 129
"""Least and largest number of azimuths at which a motion is evaluated; odd, to equal the number of Fourier terms."""

STEADY = 1e-6
"""Imbalance below which a motion continues unchanged: rotating coordinates carry the round-off of the rotation."""

FLAT = 1e-8
"""Fourier coefficients of A, relative to the largest, that the azimuths may leave out."""

MOST_NEWTON = 25
"""Largest number of iterations."""


@dataclass(frozen=True, eq=False)
class Around:
    """A motion and the matrices of its small motions at n azimuths.

    Attributes
    ----------
    points : list of SmallMotions
        At each.
    matrices : ndarray, shape (n, x, x)
        A at each.
    harmonics : ndarray of complex, shape (n, x, x)
        Fourier coefficients of A as numpy's FFT orders them.
    weights : ndarray, shape (x,)
        Of the states, by the mean of A: see `rate_weights`.
    """

    points: list[SmallMotions]
    matrices: np.ndarray
    harmonics: np.ndarray
    weights: Vector


def motion_around(model: Model, t: float, q: Vector, u: Vector, period: float) -> Around:
    """Return the motion with a period (s), from a state on or near it.

    Raises
    ------
    ModelError
        If it is not periodic, or a search for it is not supported.
    SimulationError
        If Newton's method finds no motion.
    """
    count = FEWEST
    x: Matrix | None = None
    while True:
        points, x = _states(model, t, q, u, period, count, x)
        matrices = np.array([small.state_matrix() for small in points])
        harmonics = np.fft.fft(matrices, axis=0) / count
        weights = rate_weights(matrices.mean(axis=0), len(points[0].positions.leading), arms=len(points[0].arms))
        sizes = np.abs(harmonics * weights[:, None] / weights).max(axis=(1, 2))
        if sizes[count // 4 : count - count // 4 + 1].max() <= FLAT * sizes.max():
            return Around(points, matrices, harmonics, weights)
        if count >= MOST:
            raise SimulationError(
                f"the small motions of the scene change too sharply within the period of {period:.6g} s: {count} times "
                "do not show them. Remedy: smooth loads and motions, or a run"
            )
        count, x = 2 * count - 1, None


def _states(
    model: Model, t: float, q: Vector, u: Vector, period: float, count: int, x: Matrix | None
) -> tuple[list[SmallMotions], Matrix | None]:
    times = period * np.arange(count) / count
    nominal = [moved_on(model, t, q, u, tau) for tau in times]
    points = [SmallMotions(model, t + tau, *state) for tau, state in zip(times, nominal, strict=True)]
    _check_repeats(model, t, q, u, period, points[0])
    leading = points[0].positions.leading
    if not all(np.array_equal(small.positions.leading, leading) for small in points):
        raise ModelError(
            "floquet: the independent coordinates of the loops change within the period. Remedy: more joints in the "
            "tree and fewer loops"
        )
    if _are_steady(points):
        return points, x
    if len(points[0].arms):
        raise ModelError(
            f"floquet: the motion is not steady, {_worst(points)}; periodic motions that deform viscoelastic bodies "
            "are not found here. Remedy: start=, a steady motion; or a run"
        )
    if model.constraints or rotations(model):
        raise ModelError(
            f"floquet: the motion is not steady, {_worst(points)}; periodic motions about loops or joints with free "
            "rotations are not found here. Remedy: start=, an Equilibrium that is balanced at all azimuths"
        )
    return _newton(model, t, nominal, points, period), x


def _newton(
    model: Model, t: float, nominal: list[tuple[Vector, Vector]], points: list[SmallMotions], period: float
) -> list[SmallMotions]:
    count, n = len(points), model.free_count
    x = np.zeros((count, 2 * n))
    waves = 2.0 * np.pi / period * np.fft.fftfreq(count, 1.0 / count)
    reach = count // 4
    for _ in range(MOST_NEWTON):
        rates = np.fft.ifft(1j * waves[:, None] * np.fft.fft(x, axis=0), axis=0).real
        f = np.hstack((x[:, n:], np.array([small.du for small in points])))
        left = np.fft.fft(rates - f, axis=0) / count
        harmonics = np.fft.fft(np.array([small.state_matrix() for small in points]), axis=0) / count
        weights = rate_weights(harmonics[0].real, n)
        H = hill_matrix(harmonics * weights[:, None] / weights, 2.0 * np.pi / period, reach)
        orders = np.arange(-reach, reach + 1)
        right = (left[orders] * weights).ravel()
        step = np.linalg.lstsq(H, right, rcond=1e-13)[0].reshape(2 * reach + 1, -1) / weights
        full = np.zeros((count, 2 * n), dtype=complex)
        full[orders] = step
        change = np.fft.ifft(full * count, axis=0).real
        x = x + change
        points = []
        for i, (q, u) in enumerate(nominal):
            tau = period * i / count
            points.append(SmallMotions(model, t + tau, model.advance(q, x[i, :n]), u + x[i, n:]))
        if not np.all(np.isfinite(x)) or np.abs(x * weights).max() > 1e12:
            break
        if np.abs(change * weights).max() <= 1e-9 * max(np.abs(x * weights).max(), 1e-300):
            return points
    raise SimulationError(
        f"floquet: no motion with the period {period:.6g} s was found near the start. Remedy: start=, the end of a "
        "damped run that has settled to it"
    )


def _check_repeats(model: Model, t: float, q: Vector, u: Vector, period: float, first: SmallMotions) -> None:
    q_end, u_end = moved_on(model, t, q, u, period)
    last = SmallMotions(model, t + period, q_end, u_end)
    weights = rate_weights(first.state_matrix(), len(first.positions.leading), arms=len(first.arms))
    direction = np.random.default_rng(0).standard_normal(len(weights)) / weights
    a, b = (weights * small.rates_along(direction) for small in (first, last))
    if np.abs(b - a).max() > STEADY * np.abs(a).max():
        raise ModelError(
            f"floquet: the scene is not the same after {period:.6g} s: its small motions differ by "
            f"{np.abs(b - a).max() / np.abs(a).max():.2g}. Remedy: period=, in s, after which the scene repeats"
        )


def _are_steady(points: list[SmallMotions]) -> bool:
    """Return whether a motion is steady at all of its points.

    Accelerations are first compared with the round-off of the forces at the first point; only larger ones need the
    forces of their own point.
    """
    first = points[0]
    sizes = force_sizes(first.here)
    n = first.model.free_count
    noise = 0.1 * STEADY * FLOOR * float(sizes[:n].max(initial=0.0))
    masses = np.abs(first.mass[:n, :n])
    left = (np.abs(small.speeds.N).T @ (masses @ np.abs(small.du)) for small in points)
    return all(
        forces.max(initial=0.0) <= noise or imbalance_of(small).ratio <= STEADY
        for forces, small in zip(left, points, strict=True)
    )


def _worst(points: list[SmallMotions]) -> str:
    worst = max(points, key=lambda small: imbalance_of(small).ratio)
    return f"{imbalance_of(worst)} remains at t = {worst.t:.6g} s"
