"""Hill's method: the eigenvalue problem of the harmonics of small motions with periodic coefficients.

    dx/dt = A(t) x,   x = exp(lambda t) sum_k v_k exp(i k W t)   ->   lambda v_k = sum_l A_(k-l) v_l - i k W v_k

(Hill, Acta Math. 8 (1886); Lazarus & Thomas, "A harmonic-based method for computing the stability of periodic dynamical
systems", C. R. Mecanique 338 (2010) 510-517.) Each motion has copies, lambda + i k W; those with
harmonics centred about zero are kept. Unlike products of transition matrices, the method also finds motions that decay
within a period.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg

from kanefe.errors import SimulationError
from kanefe.frames import Vector

REACHES = (2, 4, 6, 9, 13, 19, 28)
"""Numbers of harmonics on either side that are tried in turn until the last ones vanish."""

EMPTY = 1e-7
"""Size of the last harmonics, relative to all, below which they count as zero."""

LARGEST = 2400
"""Largest number of rows of the eigenvalue problem: larger ones take minutes and too much memory."""


class Hill(NamedTuple):
    """Motions, one for each state.

    Attributes
    ----------
    values : ndarray of complex, shape (x,)
        1/s.
    shapes : ndarray of complex, shape (2 reach + 1, x, x)
        Harmonics from -reach to reach, states, motions.
    """

    values: np.ndarray
    shapes: np.ndarray


def hill_matrix(harmonics: np.ndarray, rate: float, reach: int) -> np.ndarray:
    """Return the matrix of harmonics -reach to reach from the Fourier coefficients of A, as numpy's FFT orders them."""
    count, size = len(harmonics), harmonics.shape[1]
    orders = np.arange(-reach, reach + 1)
    H = np.zeros((len(orders), size, len(orders), size), dtype=complex)
    for i, k in enumerate(orders):
        for j, other in enumerate(orders):
            if abs(k - other) <= count // 2:
                H[i, :, j, :] = harmonics[k - other]
        H[i, range(size), i, range(size)] -= 1j * k * rate
    return H.reshape(len(orders) * size, -1)


def hill_motions(harmonics: np.ndarray, rate: float, weights: Vector) -> Hill:
    """Return the motions of Fourier coefficients (n, x, x) of A with the rate W (rad/s) and weights (x,) of the states.

    Raises
    ------
    SimulationError
        If they have too many harmonics.
    """
    scaled = harmonics * weights[:, None] / weights
    size = len(weights)
    for reach in REACHES:
        if (2 * reach + 1) * size > LARGEST:
            break
        values, shapes = _motions(hill_matrix(scaled, rate, reach), reach)
        shares = (np.abs(shapes) ** 2).sum(axis=1)
        shares = shares / shares.sum(axis=0)
        middles = np.arange(-reach, reach + 1) @ shares
        chosen = _distinct(values, np.abs(middles), rate, size)
        ends = shares[[0, -1]][:, chosen].max(initial=0.0)
        if len(chosen) == size and ends <= EMPTY:
            return Hill(values[chosen], shapes[:, :, chosen] / weights[:, None])
    raise SimulationError(
        f"floquet: harmonics up to {reach} of {rate / 2 / np.pi:.4g} Hz do not resolve the motions of {size} states. "
        "Remedy: fewer modes of the flexible bodies, or a faster rotation: at a slow one modes change as frozen ones do"
    )


def _motions(H: np.ndarray, reach: int) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues and eigenvectors (harmonics, states, motions) of a matrix of harmonics.

    In cosines and sines, ``(v_k + v_-k) / sqrt(2)`` and ``i (v_k - v_-k) / sqrt(2)``, it is real, and solved in a third
    of the time.
    """
    blocks = H.reshape(2 * reach + 1, len(H) // (2 * reach + 1), 2 * reach + 1, -1)
    rows = _in_waves(blocks, np.sqrt(0.5), 1j * np.sqrt(0.5))
    waves = _in_waves(rows.transpose(2, 3, 0, 1), np.sqrt(0.5), -1j * np.sqrt(0.5)).transpose(2, 3, 0, 1)
    values, vectors = scipy.linalg.eig(waves.real.reshape(H.shape), check_finite=False)
    found = vectors.astype(complex).reshape(2 * reach + 1, -1, len(H))
    cosines, sines = found[reach + 1 :], found[:reach][::-1]
    shapes = found.copy()
    shapes[reach + 1 :] = np.sqrt(0.5) * (cosines - 1j * sines)
    shapes[:reach] = (np.sqrt(0.5) * (cosines + 1j * sines))[::-1]
    return values, shapes


def _in_waves(harmonics: np.ndarray, even: float, odd: complex) -> np.ndarray:
    """Return cosines, at the positive orders, and sines at the negative ones, along the first axis."""
    reach = len(harmonics) // 2
    above, below = harmonics[reach + 1 :], harmonics[:reach][::-1]
    found = np.array(harmonics)
    found[reach + 1 :] = even * (above + below)
    found[:reach] = (odd * (above - below))[::-1]
    return found


def _distinct(values: np.ndarray, middles: np.ndarray, rate: float, size: int) -> np.ndarray:
    """Return the numbers of at most `size` motions that are not copies, those with harmonics closest about zero."""
    order = np.argsort(middles)
    # the number of motions is known: the closest ones, unless one is a copy of another
    chosen: list[int] = []
    scale = 1e-6 * max(float(np.abs(values[order[:size]]).max(initial=0.0)), rate)
    for i in order:
        if len(chosen) == size or middles[i] > 1.0:
            break
        copies = [j for j in chosen if _is_copy(values[i] - values[j], rate, scale)]
        # equal motions, such as those of a symmetric rotor, are distinct; copies are a whole number of harmonics apart
        if not any(abs(values[i].imag - values[j].imag) > 0.5 * rate for j in copies):
            chosen.append(int(i))
    return np.array(chosen, dtype=int)


def _is_copy(difference: complex, rate: float, scale: float) -> bool:
    turns = difference.imag / rate
    return abs(difference.real) <= scale and abs(turns - round(turns)) * rate <= scale
