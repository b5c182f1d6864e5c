"""Craig-Bampton reduction.

Craig & Bampton (1968), "Coupling of substructures for dynamic analyses": constraint modes, the static shapes of unit
interface displacements, and the normal modes with all interfaces held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.basis import Basis, Options, check_count, check_frequency, is_number
from kanefe.reduction.load_cases import Load, default_loads, load_vectors, spread_loads
from kanefe.reduction.mode_choice import chosen_modes
from kanefe.reduction.normal_modes import normal_modes


@dataclass(frozen=True, repr=False)
class CraigBampton(Options):
    """Constraint modes, and the normal modes with all interfaces held.

    The static response to forces at interfaces is exact, whatever the number of modes.

    Without a number of modes and `up_to_frequency` the choice is derived from the body: the static shapes of `loads`,
    of inertia and of all its load patterns, all normal modes up to ten times its first frequency, and those above that
    the response to these loads needs up to there. `print(body)` tells the range, and the error within it.

    Parameters
    ----------
    modes : int or "auto", optional
        Number of normal modes. "auto": those that the response to loads up to `up_to_frequency` needs (see
        `kanefe.reduction.mode_choice`).
    up_to_frequency : float, optional
        Hz. Without `modes`: all normal modes up to this frequency. With "auto": the highest frequency of the loads.
    tol : float, optional
        Largest relative error of the response that "auto" may leave. Default: 1e-3, and 1e-2 in a range that is not
        given.
    loads : sequence of str, LoadCase or PatchCase
        Load cases whose static shapes are kept too, so that the static response to them is exact (see
        `kanefe.reduction.load_cases`): among "gravity", "angular acceleration", "centrifugal", names of interfaces and
        load patterns, given forces, and single forces on contact patches. With "auto" they also define the response
        that is compared; without any, all loads of interfaces and of inertia do, and their static shapes are kept if
        this makes the basis smaller.
    error_up_to : float, optional
        Frequency in Hz up to which the error is estimated (see `kanefe.reduction.error_estimate`). "auto" always
        estimates it, up to `up_to_frequency`.

    Raises
    ------
    ModelError
        If both a number of modes and a frequency are given, or an option is not valid.

    Examples
    --------
    >>> CraigBampton(modes=8, loads=("gravity", "centrifugal"))
    CraigBampton(modes=8, loads=('gravity', 'centrifugal'))
    >>> CraigBampton(modes="auto", up_to_frequency=50.0, tol=1e-3)
    CraigBampton(modes='auto', up_to_frequency=50.0)
    """

    modes: int | Literal["auto"] | None = None
    up_to_frequency: float | None = None
    tol: float | None = None
    loads: Sequence[Load] = ()
    error_up_to: float | None = None

    def __post_init__(self) -> None:
        if not (isinstance(self.modes, str) and self.modes == "auto"):
            if self.modes is not None and self.up_to_frequency is not None:
                raise ModelError(
                    "Craig-Bampton takes modes=<number> or up_to_frequency=<Hz>, one of them, or none for a choice of "
                    "its own"
                )
            check_count("Craig-Bampton", self.modes)
        check_frequency("up_to_frequency", self.up_to_frequency)
        if self.tol is not None and not (is_number(self.tol) and 1e-9 <= self.tol < 1.0):
            raise ModelError(f"tol must be a relative error from 1e-9 to below 1, not {self.tol!r}")
        self._check_shared(self.loads, self.error_up_to)

    def basis(self, problem: StaticProblem) -> Basis:
        """Return the constraint modes of the released components, load vectors, and normal modes."""
        released = problem.constraint_modes[:, problem.released - problem.ties.interior_count]
        is_derived = self.modes in (None, "auto") and self.up_to_frequency is None
        loads, compared = _all_loads(problem, self.loads) if is_derived else (self.loads, self.loads)
        vectors, names = load_vectors(problem, loads)
        if self.modes == "auto" or is_derived:
            kept = vectors if compared else None
            choice = chosen_modes(problem, released, kept, compared, self.up_to_frequency, self.tol)
            return Basis(choice.columns, {"load_vectors": names, **choice.record})
        count = None if self.modes is None else int(self.modes)
        squares, modes = normal_modes(problem, count, self.up_to_frequency)
        frequencies = np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)
        return Basis(
            np.hstack((released, vectors, modes)),
            {"load_vectors": names, "modes": [{"number": n + 1, "frequency": f} for n, f in enumerate(frequencies)]},
        )


def _all_loads(problem: StaticProblem, given: Sequence[Load]) -> tuple[tuple[Load, ...], tuple[Load, ...]]:
    """Return the loads of a body whose static shapes are kept beside constraint modes, and all loads of it.

    Of a held body constraint modes have the statics of interfaces, of one that floats not those of its inertia.
    """
    spread = (*given, *(load for load in spread_loads(problem) if load not in given))
    every = (*spread, *(load for load in default_loads(problem) if load not in spread))
    return every if problem.rigid_count else spread, every
