"""What joints do, for kernels that still work on rows of arrays and tuples of numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, as_vector, numbers_of
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.joints.axis import force_along
from kanefe.kernels.joints.ball import force_through_ball
from kanefe.kernels.joints.by_kind import partials as partial_velocities
from kanefe.kernels.joints.free import moved_freely as accelerations_of_free
from kanefe.kernels.tree import AxisFrame, BallFrame, Frames, FreeFrame, Links


@inlined
def partials(rows: np.ndarray, geometry: np.ndarray, i: int, work: np.ndarray) -> tuple[Numbers, Numbers]:
    """Return the partial velocity of the origin and the partial angular velocity of a link of one coordinate, in N."""
    v, w = partial_velocities(Links(rows, geometry)[i], Frames(work)[i])
    return numbers_of(v), numbers_of(w)


@inlined
def through_axis(
    rows: np.ndarray, geometry: np.ndarray, i: int, applied: Any, force: Numbers, moment: Numbers, work: np.ndarray
) -> tuple[Any, Numbers, Numbers]:
    """Return the acceleration along a link's coordinate by what it needs from its parent, and what is left of that."""
    frame = Frames(work)[i]
    v, w = partial_velocities(Links(rows, geometry)[i], frame)
    rest, f, n = force_along(AxisFrame(frame), v, w, applied, as_vector(force), as_vector(moment))
    return rest, numbers_of(f), numbers_of(n)


@inlined
def through_ball(i: int, force: Numbers, moment: Numbers, work: np.ndarray) -> tuple[Numbers, Numbers]:
    """Return the turning of a spherical link by what it needs from its parent, and the force that is left of that."""
    n = as_vector(moment)
    turning, f = force_through_ball(BallFrame(Frames(work)[i]), 0.0 * n, as_vector(force), n)
    return numbers_of(turning), numbers_of(f)


@inlined
def moved_freely(i: int, force: Numbers, moment: Numbers, work: np.ndarray) -> tuple[Numbers, Numbers]:
    """Return the accelerations of a free body by what acts on it."""
    a, alpha = accelerations_of_free(FreeFrame(Frames(work)[i]), as_vector(force), as_vector(moment))
    return numbers_of(a), numbers_of(alpha)
