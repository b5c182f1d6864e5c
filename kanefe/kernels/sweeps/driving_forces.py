"""The forces that drives need, by the accelerations of all rows."""

import numpy as np

from kanefe.kernels.joints.by_kind import partials
from kanefe.kernels.language import dot, kernel
from kanefe.kernels.tree import Frames, Links


@kernel
def turn_driven_rotors(links: Links, drives: np.ndarray, applied: np.ndarray) -> None:
    """Take what the rotors behind the gears of driven coordinates need from what is applied along these."""
    for i in range(len(links)):
        link = links[i]
        if link.drive >= 0:
            applied[link.speed] -= link.armature * drives[link.drive, 2]


@kernel
def put_driving_forces(links: Links, frames: Frames, applied: np.ndarray, forces: np.ndarray) -> None:
    """Write the forces that driven coordinates need beyond what is applied to them."""
    for i in range(len(links)):
        link, frame = links[i], frames[i]
        if link.drive < 0:
            continue
        v, w = partials(link, frame)
        f = frame.f + frame.M @ frame.a + frame.H @ frame.alpha
        n = frame.n + frame.H.T @ frame.a + frame.J @ frame.alpha
        forces[link.drive] = dot(v, f) + dot(w, n) - applied[link.speed]
