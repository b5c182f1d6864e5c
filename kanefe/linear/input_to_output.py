"""Norms and margins of a linearised scene from its eigenvalues, without polynomials and Gramians of all states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.linalg
from scipy.optimize import brentq

from kanefe.errors import ModelError
from kanefe.frames import Matrix
from kanefe.integrate.run_checks.structural_damping import warn_of_structural_damping
from kanefe.linear.frequency_response import place_of
from kanefe.linear.modes.eigenpairs import eigenpairs, rate_weights
from kanefe.linear.modes.eigenvalues import growth_noise
from kanefe.linear.state_space import StateSpace

UNSEEN = 1e-12
"""Size of the residue of a mode, relative to the largest, below which it is round-off: no input moves it, or no output
sees it."""

WORST_BASIS = 1e8
"""Condition number of the eigenvectors above which modes coincide: half of the digits of their residues are lost."""

STRIDE = 0.05
"""Distance of frequencies at which a response is looked at, relative to the distance from the nearest pole, within
which its power series converges: it cannot turn back in less."""

BEYOND = 1e3
"""Highest frequency that is looked at, relative to the highest pole; the lowest likewise."""

REAL = 1e-10
"""Imaginary part of a response, relative to its size, below which its sign is round-off."""


class ScaledSystem(NamedTuple):
    """A system ``dx/dt = A x + B w``, ``y = C x + D w``, in units in which positions and speeds are alike."""

    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix


class Residues(NamedTuple):
    """Modes that an input moves and an output sees: ``H(s) = sum of c b / (s - value)``.

    Attributes
    ----------
    values : ndarray of complex, shape (k,)
        Eigenvalues of both signs, 1/s.
    b : ndarray of complex, shape (k, inputs)
    c : ndarray of complex, shape (outputs, k)
    """

    values: np.ndarray
    b: np.ndarray
    c: np.ndarray


@dataclass(frozen=True)
class Margins:
    """How far a loop ``w = -gain y`` around one input and one output is from the verge of stability.

    Attributes
    ----------
    gain, gain_frequency : float
        Smallest factor above one on the gain that brings the loop there, infinite if none does; its frequency, Hz.
    reduction, reduction_frequency : float
        Largest factor below one that does, zero if none does.
    phase, phase_frequency : float
        Least change of phase that does, rad, infinite if the response has nowhere size one.
    distance, distance_frequency : float
        Least distance of the response from -1, the reciprocal of the largest sensitivity.
    is_stable : bool
        Whether the closed loop is stable; without that the others are no margins.
    """

    gain: float
    gain_frequency: float
    reduction: float
    reduction_frequency: float
    phase: float
    phase_frequency: float
    distance: float
    distance_frequency: float
    is_stable: bool

    def __str__(self) -> str:
        return (
            f"the closed loop is {'stable' if self.is_stable else 'unstable'}; gain margin {self.gain:.4g} at "
            f"{self.gain_frequency:.4g} Hz, phase margin {np.degrees(self.phase):.4g} degrees at "
            f"{self.phase_frequency:.4g} Hz, {self.distance:.4g} from -1 at {self.distance_frequency:.4g} Hz"
        )


def tell_of_losses(of: StateSpace, what: str) -> None:
    """Warn that what is made of A, B, C, D goes without loss factors, which are no states."""
    if of.structural is not None:
        warn_of_structural_damping(of.small.model, what)


def channels_of(of: StateSpace, output: str | None = None, input: str | None = None) -> ScaledSystem:
    """Return the system of one output and one input, or of all of them, without drives that no input moves."""
    tell_of_losses(of, "a norm, a margin or a modal form")
    rows = slice(None) if output is None else [place_of(of.output_names, output, "output")]
    columns = slice(None) if input is None else [place_of(of.input_names, input, "input")]
    B, positions, drives = of.B[:, columns], of.position_count, len(of.small.drives)
    driven = np.r_[positions - drives : positions, of.moving_count - drives : of.moving_count]
    kept = np.arange(len(of.A)) if np.any(B[driven]) else np.setdiff1d(np.arange(len(of.A)), driven)
    A = of.A[np.ix_(kept, kept)]
    weights = rate_weights(A, int(np.count_nonzero(kept < positions)), arms=len(of.A) - of.moving_count)
    return ScaledSystem(
        weights[:, None] * A / weights,
        weights[:, None] * B[kept],
        of.C[rows][:, kept] / weights,
        of.D[rows][:, columns],
    )


def residues(of: ScaledSystem) -> Residues | None:
    """Return the modes that matter between inputs and outputs; None if modes coincide, as rigid motions do."""
    values, vectors = eigenpairs(of.A, np.ones(len(of.A)))
    if not len(values) or np.linalg.cond(vectors) > WORST_BASIS:
        return None
    b, c = np.linalg.solve(vectors, of.B), of.C @ vectors
    sizes = np.abs(c).max(axis=0, initial=0.0) * np.abs(b).max(axis=1, initial=0.0)
    kept = sizes > UNSEEN * sizes.max(initial=0.0)
    return Residues(values[kept], b[kept], c[:, kept])


def h2_norm(of: ScaledSystem) -> float:
    """Return the H2 norm from all inputs to all outputs: see `Linearisation.h2_norm`."""
    found = residues(of)
    values = np.linalg.eigvals(of.A) if found is None else found.values
    if np.any(of.D) or np.any(values.real >= -growth_noise(values, values)):
        return float("inf")
    if found is None:
        gramian = scipy.linalg.solve_continuous_lyapunov(of.A, -of.B @ of.B.T)
        square = np.trace(of.C @ gramian @ of.C.T)
    else:
        gramian = -(found.b @ found.b.conj().T) / (values[:, None] + values.conj()[None, :])
        square = np.trace(found.c @ gramian @ found.c.conj().T).real
    return float(np.sqrt(max(square, 0.0)))


def margins(of: ScaledSystem, gain: float) -> Margins:
    """Return the margins of the loop around a system of one input and one output: see `Linearisation.margins`."""
    if of.D.shape != (1, 1):
        raise ModelError(
            f"margins are of one output and one input, and the linearisation has {len(of.C)} and {of.B.shape[1]}. "
            "Remedy: margins(output=..., input=...)"
        )
    B, D = gain * of.B, gain * float(of.D[0, 0])
    values = _damped_poles(of.A)
    response = _response(of.A, B, of.C, D)
    at = _frequencies(values)
    L = response(at)
    closed = np.linalg.eigvals(of.A - B @ of.C / (1.0 + D)) if D != -1.0 else np.array([np.inf])
    # where the response is real, and where it has size one
    imaginary = np.where(np.abs(L.imag) > REAL * np.abs(L), L.imag, 0.0)
    real = _roots(at, imaginary, lambda w: response(w).imag)
    sizes = list(zip(real, response(np.array(real)), strict=True))
    if not np.any(np.abs(values) <= np.sqrt(np.finfo(float).eps) * np.abs(values).max(initial=0.0)):
        sizes.append((0.0, response(np.zeros(1))[0]))
    sizes.append((np.inf, complex(D)))
    factors = [(w, -1.0 / value.real) for w, value in sizes if value.real < 0.0]
    ones = _roots(at, np.abs(L) - 1.0, lambda w: np.abs(response(w)) - 1.0)
    angles = [(w, abs(np.angle(-value))) for w, value in zip(ones, response(np.array(ones)), strict=True)]
    low = int(np.argmin(np.abs(1.0 + L)))
    up = min(((f, w) for w, f in factors if f > 1.0), default=(np.inf, np.nan))
    down = max(((f, w) for w, f in factors if f <= 1.0), default=(0.0, np.nan))
    turn = min(((angle, w) for w, angle in angles), default=(np.inf, np.nan))
    two_pi = 2.0 * np.pi
    return Margins(
        up[0],
        up[1] / two_pi,
        down[0],
        down[1] / two_pi,
        float(turn[0]),
        turn[1] / two_pi,
        float(np.abs(1.0 + L[low])),
        float(at[low]) / two_pi,
        bool(np.all(closed.real < growth_noise(closed, closed))) if np.isfinite(closed).all() else False,
    )


def _damped_poles(A: Matrix) -> np.ndarray:
    """Return the eigenvalues; raise a ModelError if a motion is undamped."""
    values = np.linalg.eigvals(A)
    noise = growth_noise(values, values)
    undamped = (np.abs(values.real) <= noise) & (np.abs(values.imag) > np.sqrt(noise * np.abs(values).max(initial=0.0)))
    if undamped.any():
        raise ModelError(
            f"a motion at {np.abs(values[undamped][0].imag) / (2 * np.pi):.6g} Hz is undamped: the response is "
            "infinite there, and has no margins. Remedy: damp the scene"
        )
    return values


def _response(A: Matrix, B: Matrix, C: Matrix, D: float) -> Callable[[np.ndarray], np.ndarray]:
    """Return the response over frequencies (rad/s), by the Schur form: also where modes coincide."""
    T, Z = scipy.linalg.schur(A, output="complex")
    b, c = Z.conj().T @ B[:, 0], C[0] @ Z

    def response(w: np.ndarray) -> np.ndarray:
        s, x = 1j * np.asarray(w), np.zeros((len(T), *np.shape(w)), dtype=complex)
        for i in reversed(range(len(T))):
            x[i] = (b[i] + np.tensordot(T[i, i + 1 :], x[i + 1 :], 1)) / (s - T[i, i])
        return np.asarray(np.tensordot(c, x, 1) + D)

    return response


def _frequencies(values: np.ndarray) -> np.ndarray:
    """Return frequencies, rad/s, that are nowhere further apart than `STRIDE` of the distance to the nearest pole."""
    sizes = np.abs(values)
    sizes = sizes[sizes > np.sqrt(np.finfo(float).eps) * sizes.max(initial=0.0)]
    low, high = (sizes.min() / BEYOND, sizes.max() * BEYOND) if len(sizes) else (1.0 / BEYOND, BEYOND)
    found, w = [low], low
    while w < high:
        w += STRIDE * min(float(np.abs(1j * w - values).min()), w)
        found.append(w)
    return np.array(found)


def _roots(at: np.ndarray, values: np.ndarray, function: Callable[[np.ndarray], np.ndarray]) -> list[float]:
    """Return where a function of the frequency changes its sign, between values that are not zero."""
    told = np.flatnonzero(values)
    turns = np.flatnonzero(np.sign(values[told[:-1]]) != np.sign(values[told[1:]]))
    return [brentq(function, at[told[i]], at[told[i + 1]], rtol=1e-13) for i in turns]
