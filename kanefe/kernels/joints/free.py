"""Free links, which move as if alone: velocity in the joint's fixed frame, angular velocity in axes of the link."""

import numpy as np

from kanefe.kernels.joints.motion import has_inverse, orientation, put_three, three
from kanefe.kernels.language import Matrix, Vector, diagonal, inlined, symmetric
from kanefe.kernels.tree import FreeFrame, Link


@inlined
def move_free(link: Link, R: Matrix, q: np.ndarray, u: np.ndarray) -> tuple[Matrix, Vector, Vector, Vector]:
    """Return axes, arm, velocity and turning."""
    turned = R @ orientation(q, link.coordinate + 3)
    arm, velocity = R @ three(q, link.coordinate), R @ three(u, link.speed)
    return turned, arm, velocity, turned @ three(u, link.speed + 3)


@inlined
def eliminate_free(link: Link, frame: FreeFrame) -> bool:
    """Write the inverses of the inertia; return whether there are such.

    The parent feels nothing, and does not move where there is an armature.
    """
    rotor = diagonal(link.armature)
    M, H = frame.M + rotor, frame.H
    moving = M.inverse
    resists = frame.J + rotor - symmetric(H.T @ moving @ H)
    turning = resists.inverse
    frame.moving, frame.turning = moving, turning
    return has_inverse(M, moving) and has_inverse(resists, turning)


@inlined
def moved_freely(frame: FreeFrame, f: Vector, n: Vector) -> tuple[Vector, Vector]:
    """Return the accelerations of a free body by force and moment on it."""
    alpha = frame.turning @ (n - frame.H.T @ (frame.moving @ f))
    return frame.moving @ (f - frame.H @ alpha), alpha


@inlined
def accelerate_free(
    link: Link, frame: FreeFrame, fixed: Matrix, carried: tuple[Vector, Vector], applied: np.ndarray, du: np.ndarray
) -> tuple[Vector, Vector]:
    """Write du; return the accelerations of the link.

    Parameters
    ----------
    fixed : Matrix
        Axes of the joint's fixed frame, to N.
    carried : (Vector, Vector)
        Its accelerations as if it was fixed to its parent.
    """
    R, speed = frame.R, link.speed
    f, n = fixed @ three(applied, speed) - frame.f, R @ three(applied, speed + 3) - frame.n
    moving, turning = moved_freely(frame, f, n)
    put_three(du, speed, fixed.T @ (moving - carried[0]))
    put_three(du, speed + 3, R.T @ (turning - carried[1]))
    return moving, turning
