"""Which normal modes a Craig-Bampton basis needs for the response to loads up to a frequency.

Modes are ranked, and as few of the first are kept as reach the tolerance:

1. those within the frequency range that carry effective interface mass (Kammer & Triller 1996, "Selection of component
   modes for Craig-Bampton substructure representations"): the motion of an interface, or of G itself, excites them;
2. then by participation, the largest share that a mode has in the response to one of the loads;
3. the error of a basis is that of its response against a rich basis: all candidates, and the static shapes of the
   loads and of the inertia of the constraint modes, which represent all higher modes. Candidates are added until they
   reach the tolerance.

Without a frequency the range is that of the body itself, up to `SPREAD` times its first, and all modes within it are
kept, since forces at any place may excite them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg

from kanefe.errors import ModelError
from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.error_estimate import frequency_error
from kanefe.reduction.load_cases import Load, LoadGroup, some_groups
from kanefe.reduction.normal_modes import normal_modes
from kanefe.reduction.orthonormal import modes_by_mass, normalised, orthonormal_columns
from kanefe.reduction.response_model import ResponseModel

CANDIDATES = 16
"""Initial number of normal modes that are examined; it is doubled until they suffice."""

MOST_CANDIDATES = 256
"""Largest number of normal modes that are examined."""

TOLERANCE = 1e-3
"""Relative error of the response, where nothing is given."""

SPREAD = 10.0
"""Highest frequency of the range that is not given, relative to the first of the body: for equal forces a mode above it
moves less than a hundredth, SPREAD^-2, of what the first does."""

MOST_UNASKED = 32
"""Number of normal modes that are examined for a range that is not given; it ends where they no longer hold the
tolerance."""

HALVINGS = 6
"""Number of halvings by which this end is found: to 2 % of the range."""

BEYOND = 1.5
"""Highest frequency of the normal modes that are examined, relative to that of the range."""

EFFECTIVE = 1e-2
"""Effective interface mass relative to the total from which a mode within the frequency range is always kept."""


@dataclass(frozen=True, eq=False)
class ModeChoice:
    """Columns, shape (tied, m), and the record of their choice (json-able)."""

    columns: np.ndarray
    record: dict[str, Any]


def chosen_modes(
    problem: StaticProblem,
    constraint: np.ndarray,
    vectors: np.ndarray | None,
    loads: Sequence[Load],
    up_to_frequency: float | None,
    tol: float | None,
) -> ModeChoice:
    """Return the columns that a basis needs beside constraint modes.

    Parameters
    ----------
    problem : StaticProblem
    constraint : ndarray, shape (tied, c)
        Constraint modes of the released components.
    vectors : ndarray, shape (tied, v), or None
        Load vectors to be kept. None: the static shapes of the loads are kept if this makes the basis smaller.
    loads : sequence of str, LoadCase or PatchCase
        Loads of which the response is compared. Without any: all interface loads and inertial loads.
    up_to_frequency : float or None
        Hz. None: `SPREAD` times the first frequency of the body, less where `MOST_UNASKED` modes do not reach so far.
    tol : float or None
        Relative error of the response. None: `TOLERANCE`, or ``SPREAD**-2`` in a range that is not given.

    Raises
    ------
    ModelError
        If no load deforms the body, or `MOST_CANDIDATES` modes do not reach the tolerance.
    """
    groups = some_groups(problem, loads)
    statics = problem.solve(np.hstack([group.forces for group in groups]))
    found: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def candidates(count: int) -> tuple[np.ndarray, np.ndarray]:
        if count not in found:
            found[count] = _candidates(problem, count)
        return found[count]

    def choice(given: np.ndarray) -> ModeChoice:
        further = np.hstack((statics, problem.solve(problem.mass @ given))) if given.shape[1] else statics
        return _choice(problem, given, further, candidates, groups, up_to_frequency, tol)

    if vectors is not None:
        return choice(np.hstack((constraint, vectors)))
    complete = choice(np.hstack((constraint, statics)))
    try:
        modal = choice(constraint)
    except ModelError:
        return complete
    return min(modal, complete, key=lambda found: found.record["choice"]["kept_columns"])


def _choice(
    problem: StaticProblem,
    given: np.ndarray,
    statics: np.ndarray,
    candidates: Callable[[int], tuple[np.ndarray, np.ndarray]],
    groups: Sequence[LoadGroup],
    asked: float | None,
    given_tol: float | None,
) -> ModeChoice:
    """Return given columns and the normal modes needed beside them."""
    tol = given_tol or (SPREAD**-2 if asked is None else TOLERANCE)
    search, error = _examined(problem, given, statics, candidates, groups, asked, tol)
    modes, squares = search.modes, search.squares
    order, scores, reasons, forced = search.ranking(keeps_range=asked is None)
    enough, too_few = modes.shape[1], forced - 1
    while enough - too_few > 1:
        middle = (enough + too_few) // 2
        enough, too_few = (middle, too_few) if search.error(order[:middle])["value"] <= tol else (enough, middle)
    kept = np.sort(order[:enough])
    record = {
        "modes": _listed(squares, kept, scores, reasons),
        "choice": {
            "tol": tol,
            "kept_modes": len(kept),
            "kept_columns": search.rank(kept),
            "candidates": modes.shape[1],
            "error_without_modes": search.error(np.zeros(0, dtype=int))["value"],
            "error_of_all_candidates": error,
        },
        "error_estimate": search.error(kept),
    }
    return ModeChoice(np.hstack((given, modes[:, kept])), record)


def _examined(
    problem: StaticProblem,
    given: np.ndarray,
    statics: np.ndarray,
    candidates: Callable[[int], tuple[np.ndarray, np.ndarray]],
    groups: Sequence[LoadGroup],
    asked: float | None,
    tol: float,
) -> tuple[_Search, float]:
    """Return the search among as many normal modes as the range and the tolerance need, and the error of all these."""
    count = CANDIDATES
    up_to_frequency = SPREAD * _first_frequency(problem, given) if asked is None else asked
    while True:
        squares, modes = candidates(count)
        reach = np.sqrt(squares.max(initial=0.0)) / (2 * np.pi)
        is_all, is_enough = modes.shape[1] < count, asked is None and count >= MOST_UNASKED
        if is_enough and not is_all:
            up_to_frequency = min(up_to_frequency, reach / BEYOND)
        search = _Search(problem, given, modes, squares, statics, groups, up_to_frequency)
        error = search.error(np.arange(modes.shape[1]))["value"]
        if (error <= tol and reach >= BEYOND * up_to_frequency) or is_all:
            return search, error
        if is_enough:
            return search, search.lower_range(tol)
        if count >= MOST_CANDIDATES:
            raise ModelError(
                f"{count} normal modes, up to {reach:.4g} Hz, leave an error of {error:.1e} against tol={tol:g} for "
                f"loads up to {up_to_frequency:g} Hz. Remedy: loads=(...), whose static shapes are then kept, a lower "
                "up_to_frequency, or a larger tol"
            )
        count *= 2


def _listed(squares: np.ndarray, kept: np.ndarray, scores: np.ndarray, reasons: Sequence[str]) -> list[dict[str, Any]]:
    """Return what the record tells of each mode."""
    frequencies = np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)
    return [
        {
            "number": n + 1,
            "frequency": float(frequencies[n]),
            "kept": bool(np.isin(n, kept)),
            "share": float(scores[n]),
            "why": reasons[n],
        }
        for n in range(len(squares))
    ]


def _first_frequency(problem: StaticProblem, columns: np.ndarray) -> float:
    """Return the lowest frequency of a body in the span of its static shapes, Hz."""
    modes = modes_by_mass(columns, problem.stiffness, problem.mass, problem.rigid_modes, problem.largest_masses).modes
    return float(np.sqrt(modes[:, 0] @ (problem.stiffness @ modes[:, 0]))) / (2 * np.pi)


def _candidates(problem: StaticProblem, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest elastic normal modes with all interfaces held: `count`, or all if there are fewer."""
    size = len(problem.interior) - (0 if len(problem.boundary) else problem.rigid_count)
    return normal_modes(problem, min(count, size))


class _Search:
    """A rich basis of a body, and the errors of sets of normal modes against it."""

    def __init__(
        self,
        problem: StaticProblem,
        given: np.ndarray,
        modes: np.ndarray,
        squares: np.ndarray,
        statics: np.ndarray,
        groups: Sequence[LoadGroup],
        up_to_frequency: float,
    ) -> None:
        M, largest = problem.mass, problem.largest_masses
        self.problem, self.modes, self.squares = problem, modes, squares
        columns = normalised(np.hstack((modes, given, statics)), M, largest)
        rich = orthonormal_columns(columns, M, problem.rigid_modes, largest)
        self.rich = ResponseModel.of_basis(problem, rich, groups, up_to_frequency)
        self.boundary = rich[problem.boundary]
        weighted = (M @ rich).T
        self.given, self.normal = weighted @ normalised(given, M, largest), weighted @ modes
        self.has_load_vectors = given.shape[1] > len(problem.released)

    def error(self, chosen: np.ndarray) -> dict[str, Any]:
        """Return the errors of the basis with the chosen normal modes."""
        Q = self._basis(chosen)
        squares = scipy.linalg.eigvalsh(Q.T @ self.rich.stiffness @ Q) if Q.shape[1] else np.zeros(0)
        limit = self.rich.up_to_frequency
        return {**self.rich.errors(Q), "frequencies": frequency_error(self.rich.stiffness, squares, limit)}

    def lower_range(self, tol: float) -> float:
        """Lower the range of frequencies until the error of all modes is at most `tol`, and return this error."""
        whole, low, high = np.arange(self.modes.shape[1]), 0.0, self.rich.up_to_frequency
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            self.rich = replace(self.rich, up_to_frequency=middle)
            low, high = (middle, high) if self.error(whole)["value"] <= tol else (low, middle)
        self.rich = replace(self.rich, up_to_frequency=low or high)
        return float(self.error(whole)["value"])

    def rank(self, chosen: np.ndarray) -> int:
        """Return the number of coordinates of the basis with the chosen normal modes."""
        return self._basis(chosen).shape[1]

    def _basis(self, chosen: np.ndarray) -> np.ndarray:
        columns = np.hstack((self.given, self.normal[:, chosen]))
        if not columns.shape[1]:
            return columns
        vectors, sizes, _ = scipy.linalg.svd(columns, full_matrices=False)
        return np.asarray(vectors[:, sizes > 1e-9 * sizes.max()])

    def ranking(self, keeps_range: bool) -> tuple[np.ndarray, np.ndarray, list[str], int]:
        """Return the order of the modes, their largest shares in a response, reasons, and how many are always kept.

        With `keeps_range` these are all within the range of frequencies.
        """
        problem, rich = self.problem, self.rich
        coupling = self.modes.T @ (problem.mass @ problem.constraint_modes)
        whole = np.einsum("ij,ij->j", problem.constraint_modes, problem.mass @ problem.constraint_modes)
        effective = coupling**2 / whole
        loads = problem.relieved(np.hstack([group.forces for group in rich.groups]))
        direct = self.modes.T @ loads
        s2 = rich.points[:, None, None] ** 2
        amplitudes = (direct - s2 * (coupling @ (self.boundary @ rich.responses))) / (self.squares[:, None] + s2)
        if self.has_load_vectors:
            amplitudes = amplitudes - direct / self.squares[:, None]
        size = np.linalg.norm(rich.responses, axis=1)
        shares = np.column_stack(
            [(abs(amplitudes[:, :, c]).max(axis=2) / size[:, None, c].max(axis=2)).max(axis=0) for c in rich.slices()]
        )
        within = self.squares <= (2 * np.pi * rich.up_to_frequency) ** 2
        carrying = within & (effective.max(axis=1, initial=0.0) >= EFFECTIVE)
        always = within if keeps_range else carrying
        names = [f"{tie.name} {c}" for tie in problem.ties.ties for c in tie.names]
        reasons = []
        for n in range(len(shares)):
            g = int(shares[n].argmax())
            reason = f"{shares[n, g]:.1e} of the response to {rich.groups[g].name}"
            if carrying[n]:
                c = int(effective[n].argmax())
                reason = f"{effective[n, c]:.1e} of the effective mass at {names[c]}; {reason}"
            reasons.append(reason)
        scores = shares.max(axis=1)
        return np.lexsort((-scores, ~always)), scores, reasons, int(always.sum())
