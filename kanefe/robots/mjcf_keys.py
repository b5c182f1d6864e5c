"""Keyframes of MJCF: which one is asked for, and the start that it gives to each joint."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.robots.description import NotTaken

WIDTHS = (7, 6), (4, 3), (1, 1), (1, 1)
"""Numbers of coordinates and of speeds of a free, ball, slide and hinge joint: mjtJoint."""


def number_of(key: str | int, names: Sequence[str], source: object) -> int:
    """Return the number of a keyframe by name or number, as MuJoCo counts them.

    Raises
    ------
    ModelError
        If the file has no such keyframe, or several of that name; the message lists those that there are.
    """
    found = [i for i, name in enumerate(names) if key == (name if isinstance(key, str) else i)]
    if len(found) == 1 and key != "":
        return found[0]
    listed = ", ".join(f"{i} ({name!r})" if name else f"{i} (without a name)" for i, name in enumerate(names))
    raise ModelError(f"key: {source} has no keyframe {key!r}. It has: {listed or 'none'}")


def start_at(model: Any, key: int, names: Sequence[str]) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    """Return coordinates and speeds of each joint at a keyframe, in MuJoCo's order: m, rad, Euler parameters, and 1/s.

    Mocap bodies, which rest, are moved to where it puts them. A number that is not finite raises a ModelError.
    """
    for what in ("qpos", "qvel", "mpos", "mquat"):
        if not np.isfinite(getattr(model, f"key_{what}")[key]).all():
            raise ModelError(f"key: {what} of the keyframe has a number that is not finite. Remedy: correct the file")
    for body, mocap in enumerate(model.body_mocapid.tolist()):
        if mocap >= 0:
            model.body_pos[body] = model.key_mpos[key].reshape(-1, 3)[mocap]
            model.body_quat[body] = model.key_mquat[key].reshape(-1, 4)[mocap]
    coordinates, speeds = {}, {}
    for joint, name in enumerate(names):
        places, rates = WIDTHS[model.jnt_type[joint]]
        coordinates[name] = model.key_qpos[key, model.jnt_qposadr[joint] :][:places].tolist()
        speeds[name] = model.key_qvel[key, model.jnt_dofadr[joint] :][:rates].tolist()
    return coordinates, speeds


def record_what_is_left(model: Any, key: int, controls: Sequence[str], not_taken: NotTaken) -> None:
    """Record what a keyframe sets beside the start of joints: inputs and states of actuators, and its time."""
    for what in controls:
        not_taken.add_acting("actuators at the keyframe", what)
    if model.key_time[key]:
        not_taken.add_silent("time of the keyframe", f"{model.key_time[key]:g} s")
