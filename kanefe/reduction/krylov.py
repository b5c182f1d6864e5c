"""Krylov reduction: matches moments of the response to loads around chosen frequencies.

Around an angular frequency w the shapes ``(K - w^2 M)^-1 F`` and then ``(K - w^2 M)^-1 M`` times the last ones span a
space in which the response of the projected body to harmonic loads F has the same value and the same first 2 j - 1
derivatives with respect to w^2 as that of the full body, for j blocks (symmetric matrices; Su & Craig 1991, "Model
reduction and control of flexible structures using Krylov vectors"; Grimme 1997, "Krylov projection methods for model
reduction"). Every block is made M-orthonormal before the next solve (block Arnoldi); otherwise three of them are
already dependent up to round-off.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.statics import StaticProblem
from kanefe.frames import numbers
from kanefe.reduction.basis import Basis, Options, check_count, is_number
from kanefe.reduction.load_cases import Load, some_groups
from kanefe.reduction.orthonormal import normalised, orthonormal_columns

REFINEMENTS = 2
"""Number of corrections of a solve with the factors of an indefinite matrix."""


@checked("order")
@dataclass(frozen=True, repr=False)
class Krylov(Options):
    """Shapes that respond to loads around chosen frequencies.

    Parameters
    ----------
    frequencies : sequence of float
        Hz; 0 for statics, which needs no factorisation of its own.
    order : int
        Number of blocks of shapes around each frequency.
    loads : sequence of str, LoadCase or PatchCase
        Loads whose response is matched (see `kanefe.reduction.load_cases`). Without any: loads on the interfaces, and
        all inertial loads.
    error_up_to
        As for `CraigBampton`.

    Raises
    ------
    ModelError
        If a frequency is negative, the order is below one, or a load is not valid.

    Examples
    --------
    >>> Krylov(frequencies=(0.0, 50.0), order=2, loads=("gravity", "tip"))
    Krylov(frequencies=(0.0, 50.0), order=2, loads=('gravity', 'tip'))
    """

    frequencies: Sequence[float] = (0.0,)
    order: int = 2
    loads: Sequence[Load] = ()
    error_up_to: float | None = None

    def __post_init__(self) -> None:
        given: Any = self.frequencies
        if isinstance(given, (str, bytes)) or not isinstance(given, (Sequence, np.ndarray)):
            raise ModelError(f"the frequencies of Krylov must be a sequence in Hz, such as (0.0, 50.0), not {given!r}")
        object.__setattr__(self, "frequencies", tuple(given))
        for frequency in self.frequencies:
            if not (is_number(frequency) and np.isfinite(numbers(frequency)) and frequency >= 0):
                raise ModelError(f"a frequency of Krylov must be at least 0 Hz and finite, not {frequency!r}")
        if not self.frequencies:
            raise ModelError("Krylov needs one frequency at least. Remedy: frequencies=(0.0,)")
        check_count("Krylov", self.order)
        if self.order < 1:
            raise ModelError(f"the order of Krylov must be 1 or more, not {self.order!r}")
        self._check_shared(self.loads, self.error_up_to)

    def basis(self, problem: StaticProblem) -> Basis:
        """Return the Krylov vectors, and constraint modes of the released components."""
        groups = some_groups(problem, self.loads)
        forces = np.hstack([group.forces for group in groups])
        R = problem.rigid_modes
        span = np.zeros((problem.size, 0))
        for frequency in dict.fromkeys(float(f) for f in self.frequencies):
            solve = _solver(problem, frequency)
            block = solve(forces)
            for step in range(int(self.order)):
                block = normalised(block, problem.mass, problem.largest_masses)
                block = orthonormal_columns(block, problem.mass, np.hstack((R, span)), problem.largest_masses)
                span = np.hstack((span, block))
                if step + 1 < self.order and block.shape[1]:
                    block = solve(problem.mass @ block)
        record = {
            "load_vectors": {group.name: group.forces.shape[1] for group in groups},
            "krylov": {"frequencies": list(self.frequencies), "order": int(self.order), "vectors": span.shape[1]},
        }
        return Basis(span, record)


def _solver(problem: StaticProblem, frequency: float) -> Callable[[np.ndarray], np.ndarray]:
    """Return the solver of harmonic loads at a frequency in Hz, fixed components held."""
    if frequency == 0.0:
        return problem.solve
    moving = np.setdiff1d(np.arange(problem.size), problem.fixed)
    dynamic = (problem.stiffness - (2 * np.pi * frequency) ** 2 * problem.mass)[moving][:, moving].tocsc()
    try:
        factors = problem.factorise(dynamic, definite=False)
    except RuntimeError as error:
        raise _resonance(frequency) from error

    def solve(forces: np.ndarray) -> np.ndarray:
        wanted = np.ascontiguousarray(forces[moving])
        found = factors.solve(wanted)
        for _ in range(REFINEMENTS):
            found = found + factors.solve(wanted - dynamic @ found)
        error = np.linalg.norm(wanted - dynamic @ found) / max(np.linalg.norm(wanted), np.finfo(float).tiny)
        if not error < 1e-6:
            raise _resonance(frequency)
        shapes = np.zeros(forces.shape)
        shapes[moving] = found
        return shapes

    return solve


def _resonance(frequency: float) -> ModelError:
    return ModelError(
        f"{frequency:g} Hz is a natural frequency of the body, where its response to loads is not finite. "
        "Remedy: another frequency for Krylov, some percent away"
    )
