"""Checks of the output times and the material of a recovery."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.results.body_shape import BodyShape
from kanefe_fem.recovery.joined_fields import shell_groups
from kanefe_fem.recovery.strain_fields import checked_elasticity


def nearest_frames(stored: np.ndarray, times: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the indices of the output times nearest to the given times."""
    wanted = np.atleast_1d(numbers(times))
    if wanted.ndim != 1 or np.isnan(wanted).any():
        raise ModelError(f"times must be numbers in s, shape (n,), not {times!r}")
    slack = 0.5 * float(np.diff(stored).max()) if len(stored) > 1 else 0.0
    outside = ~((wanted >= stored[0] - slack) & (wanted <= stored[-1] + slack))
    if outside.any():
        raise ModelError(
            f"the time {wanted[outside][0]:g} s was not stored: the run has {stored[0]:g} to {stored[-1]:g} s. "
            "Remedy: choose times of the run"
        )
    return np.abs(stored[None] - wanted[:, None]).argmin(axis=1)


def material_row(name: str, shape: BodyShape, material: int | str) -> int:
    """Return the row of the table of moduli of a material, given as its group of cells or its number."""
    own = shape.elasticity
    if own is not None and own.shell is not None:
        groups = shell_groups(shape)
        count = len(own.shell.forces) + (0 if own.ribs is None else len(own.ribs.stiffness)) + len(own.table)
    else:
        groups = list(shape.provenance.get("materials", {}))
        count = len(checked_elasticity(name, shape).table)
    if isinstance(material, str):
        if material not in groups or len(groups) != count:
            known = ", ".join(groups) if len(groups) == count else f"numbers 0 to {count - 1}"
            raise ModelError(f"body {name!r} has no material of the group {material!r}. It has: {known}")
        if groups.count(material) > 1:
            rows = ", ".join(str(i) for i, one in enumerate(groups) if one == material)
            raise ModelError(f"{material!r} are several groups of {name!r}. Remedy: one of the numbers {rows}")
        return groups.index(material)
    if not 0 <= material < count:
        raise ModelError(f"material {material} of body {name!r} is none of 0 to {count - 1}")
    return int(material)
