"""The next better basis of a body: what a run with it changes is the error of the run without it."""

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
    """A basis with the statics of all it leaves unbalanced: residuals of its modes, of loads and of inertia.

    Up to twice as many coordinates and one for each load, for one static solve each. The error of a reduced body in a
    scene is estimated by running the scene with both: whatever is read from the results, the difference of the two is
    the error of the smaller body, but for the much smaller one of the richer.

    Parameters
    ----------
    reduction : Reduction
        The basis to be enriched, such as ``CraigBampton(modes=6)``.

    Raises
    ------
    ModelError
        If `reduction` is none.

    Examples
    --------
    >>> Enriched(FreeInterface(modes=6))                                                  # doctest: +SKIP
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
        """Loads of the basis that is enriched."""
        return self.reduction.loads

    @property
    def error_up_to(self) -> float | None:
        """Frequency in Hz up to which the error of the richer basis is estimated."""
        return self.reduction.error_up_to

    def basis(self, problem: StaticProblem) -> Basis:
        """Return the modes of the basis, and the residual shapes."""
        chosen = self.reduction.basis(problem)
        modes = orthonormal_modes(chosen.columns, problem.stiffness, problem.mass, problem.rigid_modes)
        residual = residual_shapes(problem, modes, some_groups(problem, self.loads))
        kept = {name: value for name, value in chosen.record.items() if name != "error_estimate"}
        return Basis(np.hstack((modes, residual)), {**kept, "residual_shapes": residual.shape[1]})
