"""The loads of a scene that have values, by name: for inputs, buckling and functions of the user."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.loads.field_load import FieldLoad
    from kanefe.loads.joint_load import JointLoad
    from kanefe.loads.point_load import PointLoad

    SceneLoad = PointLoad | JointLoad | FieldLoad


def scene_loads(model: ModelData) -> Iterator[SceneLoad]:
    """Yield the loads of a scene that have values: forces, torques, motors, tractions and pressures."""
    for body in model.bodies:
        yield from (load for load, _ in body.loads)
        yield from body.joint_loads
        yield from body.field_loads


def named_loads(model: ModelData) -> dict[str, SceneLoad]:
    """Return these loads by label; repeated labels are numbered from the second on."""
    seen: dict[str, int] = {}
    found = {}
    for load in scene_loads(model):
        seen[load.label] = seen.get(load.label, 0) + 1
        found[load.label if seen[load.label] == 1 else f"{load.label} #{seen[load.label]}"] = load
    return found
