"""Ways of reducing a body: each gives columns that span the motions it keeps.

Craig & Bampton (1968): constraint modes, the static shapes of unit interface displacements, and the normal modes with
all interfaces held.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from kanefe.errors import ModelError
from kanefe.reduction.normal_modes import normal_modes
from kanefe.statics import StaticProblem


class Reduction(Protocol):
    """A way of reducing a body."""

    def basis(self, problem: StaticProblem) -> np.ndarray:
        """Return columns, shape (tied, m), that span the motions kept with the fixed components at rest."""
        ...


@dataclass(frozen=True)
class CraigBampton:
    """Which fixed-interface normal modes to keep beside the constraint modes.

    Parameters
    ----------
    modes : int, optional
        How many.
    up_to_frequency : float, optional
        All those up to this frequency in Hz.

    Raises
    ------
    ModelError
        If not exactly one of the two is given, or it makes no sense.
    """

    modes: int | None = None
    up_to_frequency: float | None = None

    def __post_init__(self) -> None:
        if (self.modes is None) == (self.up_to_frequency is None):
            raise ModelError("Craig-Bampton needs either modes=<number> or up_to_frequency=<Hz>, one of them")
        if self.modes is not None and (self.modes != int(self.modes) or self.modes < 0):
            raise ModelError(f"the number of Craig-Bampton modes must be a whole number >= 0, not {self.modes!r}")
        if self.up_to_frequency is not None and not (np.isfinite(self.up_to_frequency) and self.up_to_frequency > 0):
            raise ModelError(f"up_to_frequency must be above zero Hz and finite, not {self.up_to_frequency!r}")

    def basis(self, problem: StaticProblem) -> np.ndarray:
        """Return the constraint modes of the released components, and the normal modes with all interfaces held."""
        released = problem.constraint_modes[:, problem.released - problem.ties.interior_count]
        modes = normal_modes(problem, self.modes, self.up_to_frequency)[1]
        return np.hstack((released, modes))
