"""Load patterns that come with the matrices of a model: checked against its nodes."""

from __future__ import annotations

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.model import TRANSLATIONS, FiniteElementModel
from kanefe.fe_model.pressure_change import PressureChange
from kanefe.frames import skew

ROUND_OFF = 1e-6
"""Relative error below which a property of exported matrices counts as round-off: files often have 7 digits."""


def check_pattern(model: FiniteElementModel, name: str, pattern: NodalPattern) -> None:
    """Check that the nodal forces of a load pattern do the work of its resultants on rigid motions."""
    if not isinstance(pattern, NodalPattern):
        raise ModelError(f"load pattern {name!r} must be a NodalPattern, such as of NodalPattern.of_nodes")
    pressure = np.zeros(model.size) if pattern.pressure is None else np.asarray(pattern.pressure)
    if np.shape(pattern.traction) != (model.size, 3) or pressure.shape != (model.size,):
        raise ModelError(
            f"load pattern {name!r} has forces of shape {np.shape(pattern.traction)} and {pressure.shape}, the model "
            f"has {model.size} degrees of freedom. Remedy: the nodes and components of the matrices, in their order"
        )
    if not pattern.measure > 0 or not np.all(np.isfinite(np.column_stack((pattern.traction, pressure)))):
        raise ModelError(f"load pattern {name!r} must have finite forces and an area or length above zero")
    present = [TRANSLATIONS.index(c) for c in model.components if c in TRANSLATIONS]
    seen = present + [3 + a for a in range(3) if {0, 1, 2} - {a} <= set(present)]  # rotations that move these
    given = np.vstack((pattern.measure * np.eye(3), skew(pattern.first)))[:, present]
    given = np.column_stack((given, np.concatenate((pattern.pressure_force, pattern.pressure_moment))))[seen]
    forces = np.column_stack((np.asarray(pattern.traction)[:, present], pressure))
    error = abs((model.rigid_modes().T @ forces)[seen] - given)
    reach = 1.0 + np.linalg.norm(model.nodes, axis=1).max()
    if error.max() > ROUND_OFF * pattern.measure * reach:
        raise ModelError(
            f"the nodal forces of load pattern {name!r} have another resultant than its area, first moment and "
            f"pressure say (they differ by {error.max():.3g}). Remedy: check the order of the nodes"
        )
    if pattern.pressure_change is not None:
        _check_change(model, name, pattern, seen)


def _check_change(model: FiniteElementModel, name: str, pattern: NodalPattern, seen: list[int]) -> None:
    """Check that the resultant of a pressure that follows its surface moves and turns with a rigid body."""
    change = pattern.pressure_change
    if not isinstance(change, PressureChange):
        raise ModelError(f"pressure_change of load pattern {name!r} must be a PressureChange, not {change!r:.60}")
    count, second = 3 * len(change.points), change.second
    shapes = (change.forces.shape, change.across.shape, change.motion.shape, None if second is None else second.shape)
    square = (model.size, model.size)
    if shapes[:3] != ((count // 3, 3), (count, count), (count, model.size)) or shapes[3] not in (None, square):
        raise ModelError(
            f"pressure_change of load pattern {name!r} has arrays of shapes {shapes}, of {model.size} components"
        )
    force, moment = skew(pattern.pressure_force), skew(pattern.pressure_moment)
    error = change.over(model.rigid_modes())[:6] + np.block([[np.zeros((3, 3)), force], [force, moment]])
    reach = 1.0 + np.linalg.norm(model.nodes, axis=1).max()
    if not abs(error[np.ix_(seen, seen)]).max() <= ROUND_OFF * pattern.measure * reach:  # or not finite
        raise ModelError(
            f"pressure_change does not turn the resultant of load pattern {name!r} with the body. Remedy: check the "
            "order of the nodes, and kanefe.fe_model.pressure_change"
        )
