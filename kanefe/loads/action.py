"""What a load between frames is given and what it gives: motions of its ends, its action, its tangent, its kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector

NO_STATES = np.zeros(0)


class End(NamedTuple):
    """Motion of an end of a load seen from N, in components of N.

    Attributes
    ----------
    p : ndarray, shape (3,)
        Origin, m.
    A : ndarray, shape (3, 3)
        From the end's axes to those of N.
    v, w : ndarray, shape (3,)
        Velocity of the origin (m/s) and angular velocity (rad/s).
    """

    p: Vector
    A: Matrix
    v: Vector
    w: Vector


class Action(NamedTuple):
    """What a load does at a state.

    Attributes
    ----------
    wrenches : ndarray, shape (ends, 6)
        Force (N) and moment about the origin of each end (N m) on what carries it, in components of N.
    potential : float
        Energy in it, J.
    taken, given : float
        Power that it takes from the scene for good, and power that it gives beyond its potential, W: the two books of
        an energy balance.
    rates : ndarray, shape (states,)
        Rates of its internal states.
    """

    wrenches: Matrix
    potential: float = 0.0
    taken: float = 0.0
    given: float = 0.0
    rates: Vector = NO_STATES


class Tangent(NamedTuple):
    """Stiffness and damping of a load at a state, for the iterations of implicit methods.

    Attributes
    ----------
    rows : ndarray, shape (r, 6 ends)
        Partial derivatives of r relative rates by velocity and angular velocity of each end, in components of N.
    stiffness, damping : ndarray, shape (r,)
        Of each.
    """

    rows: Matrix
    stiffness: Vector
    damping: Vector


class LoadKernel(NamedTuple):
    """What compiled code evaluates a load by: a function of one C signature for all loads, and its numbers.

    The function is ``void f(double t, const double *numbers, const double *inputs, const double *ends,
    const double *states, double *out)``. An end is 18 numbers: p (3), A (9, row by row), v (3) and w (3) of `End`. What
    it writes are the numbers of `Action`: potential, power taken, power given, then force and moment of each end, then
    the rates of its states. `out` comes as zeros.

    Attributes
    ----------
    real : function or int
        A kernel of `kanefe.kernels`, or the address of such a function from ``numba.cfunc`` or any compiler.
    numbers : ndarray
        Constants that the function is given.
    complex_ : function, int or None
        The same for complex numbers (pairs of real and imaginary part; `numbers` and `t` stay real), from which exact
        derivatives come; None: derivatives of the scene are by differences.
    watch : function, int or None
        A function of the same signature that writes to `out` the values of the functions of its `events`, in their
        order; None: they are called from Python.
    change : function, int or None
        A function of the same signature, with `watch`, for the actions of its events: `inputs` is the number of an
        event, and `out` has a zero and the states; it writes by how much the potential energy (J) grows, and the
        states after that event. None: actions are called from Python.
    """

    real: Callable[..., None] | int
    numbers: Vector
    complex_: Callable[..., None] | int | None = None
    watch: Callable[..., None] | int | None = None
    change: Callable[..., None] | int | None = None
