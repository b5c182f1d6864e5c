"""Free-interface reduction: normal modes of the body with its supports in G, and attachment modes.

Craig & Chang (1977), "On the use of attachment modes in substructure coupling for dynamic analysis"; Rubin (1975),
"Improved component-mode representation for structural dynamic analysis"; Hintz (1975), "Analytical methods in component
modal synthesis", who calls such a set statically complete. The attachment modes are the static shapes of unit forces on
the interface components that are not fixed; for a floating body the forces are balanced by its inertia. Their part
outside the normal modes are the residual attachment modes. Since the reduced matrices are projections, the inertia of
the residual is included (Rubin), not neglected (MacNeal).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.basis import Basis, Options, check_count, check_frequency
from kanefe.reduction.load_cases import Load, load_vectors
from kanefe.reduction.normal_modes import free_normal_modes


@checked("attachment")
@dataclass(frozen=True, repr=False)
class FreeInterface(Options):
    """Normal modes with all interfaces free that are not fixed in G, and attachment modes of these interfaces.

    Preferable to `CraigBampton` where interfaces carry little load: the normal modes are then those of the body in the
    scene, and exact even if they are few.

    Parameters
    ----------
    modes : int, optional
        Number of elastic normal modes.
    up_to_frequency : float, optional
        Hz. Without `modes`: all elastic normal modes up to this frequency.
    attachment : bool
        False leaves the attachment modes out: a purely modal basis, whose static response is wrong.
    loads, error_up_to
        As for `CraigBampton`.

    Raises
    ------
    ModelError
        If not exactly one of `modes` and `up_to_frequency` is given, or an option is not valid.

    Examples
    --------
    >>> FreeInterface(modes=6, loads=("centrifugal",))
    FreeInterface(modes=6, loads=('centrifugal',))
    """

    modes: int | None = None
    up_to_frequency: float | None = None
    attachment: bool = True
    loads: Sequence[Load] = ()
    error_up_to: float | None = None

    def __post_init__(self) -> None:
        if (self.modes is None) == (self.up_to_frequency is None):
            raise ModelError("FreeInterface needs either modes=<number> or up_to_frequency=<Hz>, one of them")
        check_count("free-interface", self.modes)
        check_frequency("up_to_frequency", self.up_to_frequency)
        self._check_shared(self.loads, self.error_up_to)

    def basis(self, problem: StaticProblem) -> Basis:
        """Return normal modes, attachment modes and load vectors."""
        count = None if self.modes is None else int(self.modes)
        squares, modes = free_normal_modes(problem, count, self.up_to_frequency)
        forces = np.zeros((problem.size, len(problem.released) if self.attachment else 0))
        forces[problem.released[: forces.shape[1]], range(forces.shape[1])] = 1.0
        attached = problem.checked_solution(forces, "attachment mode") if forces.shape[1] else forces
        vectors, names = load_vectors(problem, self.loads)
        frequencies = np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)
        return Basis(
            np.hstack((modes, attached, vectors)),
            {"load_vectors": names, "modes": [{"number": n + 1, "frequency": f} for n, f in enumerate(frequencies)]},
        )
