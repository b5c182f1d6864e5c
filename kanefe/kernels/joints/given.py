"""Links of one coordinate whose motion a C function gives (`kanefe.kernels.links`)."""

from typing import Any

import numpy as np

from kanefe.kernels.joints.motion import Relative
from kanefe.kernels.language import Matrix, Vector, call_address, inlined, is_complex
from kanefe.kernels.tree import Frame, FunctionFrame, FunctionMotion, GivenFrame, GivenLink, Link


@inlined
def move_given(
    link: Link, numbers: np.ndarray, frame: Frame, R: Matrix, along: tuple[Any, Any, Any]
) -> tuple[Matrix, Vector, Relative]:
    """Write the partial velocities; return axes, arm and motion as the parent sees it (Eq. 13-16).

    Parameters
    ----------
    numbers : ndarray
        Constants of all given links.
    R : Matrix
        Axes of the joint's fixed frame, to N.
    along : (number, number, number)
        See `kanefe.kernels.joints.axis.motion_along`.
    """
    position, rate, acceleration = along
    own, called, found = GivenLink(link), FunctionFrame(frame), FunctionMotion(frame)
    called.coordinate[0] = position
    called.written[:] = 0.0
    address = own.complex_function if is_complex(called.coordinate[0]) else own.function
    call_address(address, (numbers[own.first_number :], called.coordinate, called.written))
    v, w, given = R @ found.by_v, R @ found.by_w, GivenFrame(frame)
    given.partial_v, given.partial_w = v, w
    square = rate * rate
    pull = square * (R @ found.by_v_rate) + acceleration * v
    twist = square * (R @ found.by_w_rate) + acceleration * w
    return R @ found.turned, R @ found.position, Relative(rate * v, rate * w, pull, twist)
