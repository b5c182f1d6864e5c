"""An enriched basis of a body: the change in a run with it estimates the error of the run without it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.basis import Basis, Options, Reduction
from kanefe.reduction.error_estimate import residual_shapes
from kanefe.reduction.load_cases import Load, some_groups
from kanefe.reduction.orthonormal import orthonormal_modes


@dataclass(frozen=True, repr=False)
class Enriched(Options):
    """A basis, and the static response to its residuals: those of its modes, of loads and of inertia.

    It has up to twice as many coordinates and one for each load, each by one static solve. To estimate the error of a
    reduced body in a scene, run the scene with both: the difference of any result is the error of the smaller body, up
    to the much smaller error of the enriched one.

    Parameters
    ----------
    reduction : Reduction
        The basis to be enriched, such as ``CraigBampton(modes=6)``.

    Raises
    ------
    ModelError
        If `reduction` is not a reduction.

    Examples
    --------
    >>> import kanefe as kf
    >>> Enriched(kf.FreeInterface(modes=6))
    Enriched(reduction=FreeInterface(modes=6))
    """

    reduction: Reduction

    def __post_init__(self) -> None:
        if not hasattr(self.reduction, "basis"):
            raise ModelError(
                f"Enriched needs a reduction, such as Enriched(CraigBampton(modes=6)), not {self.reduction!r}"
            )

    @property
    def loads(self) -> Sequence[Load]:
        """Loads of the basis to be enriched."""
        return self.reduction.loads

    @property
    def error_up_to(self) -> float | None:
        """Frequency in Hz up to which the error of the enriched basis is estimated."""
        return self.reduction.error_up_to

    def basis(self, problem: StaticProblem) -> Basis:
        """Return the modes of the basis, and the residual shapes."""
        chosen = self.reduction.basis(problem)
        matrices = problem.stiffness, problem.mass, problem.rigid_modes, problem.largest_masses
        modes = orthonormal_modes(chosen.columns, *matrices)
        residual = residual_shapes(problem, modes, some_groups(problem, self.loads))
        kept = {name: value for name, value in chosen.record.items() if name != "error_estimate"}
        return Basis(np.hstack((modes, residual)), {**kept, "residual_shapes": residual.shape[1]})
