"""Input and output of loads between frames: motions of ends, action, tangent, and compiled function."""

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
        Rotation matrix from the end's axes to those of N.
    v, w : ndarray, shape (3,)
        Velocity of the origin (m/s) and angular velocity (rad/s).
    """

    p: Vector
    A: Matrix
    v: Vector
    w: Vector


class Action(NamedTuple):
    """Forces, energy and powers of a load at a state.

    Attributes
    ----------
    wrenches : ndarray, shape (ends, 6)
        Force (N) and moment about its origin (N m) on the body of each end, in components of N.
    potential : float
        Potential energy, J.
    taken, given : float
        Power that it dissipates, and power that it supplies other than from its potential, W, for the energy balance.
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
        Partial derivatives of r relative rates with respect to velocity and angular velocity of each end, components
        of N.
    stiffness, damping : ndarray, shape (r,)
        Stiffness and damping for each of these.
    """

    rows: Matrix
    stiffness: Vector
    damping: Vector


class LoadKernel(NamedTuple):
    """The compiled function of a load, of one C signature for all loads, and its numbers.

    The function is ``void f(double t, const double *numbers, const double *inputs, const double *ends,
    const double *states, double *out)``. An end is 18 numbers: p (3), A (9, row by row), v (3) and w (3) of `End`. It
    writes the numbers of `Action`: potential, power taken, power given, then force and moment of each end, then the
    rates of its states. `out` is filled with zeros before the call.

    Attributes
    ----------
    real : function or int
        A kernel of `kanefe.kernels`, or the address of such a function from ``numba.cfunc`` or any compiler.
    numbers : ndarray
        Constants passed to the function.
    complex_ : function, int or None
        The function for complex numbers (pairs of real and imaginary part; `numbers` and `t` stay real), for exact
        derivatives; None: derivatives of the scene are differences.
    watch : function, int or None
        A function of the same signature that writes to `out` the values of the functions of its `events`, in their
        order; None: they are called from Python.
    change : function, int or None
        A function of the same signature, with `watch`, for the actions of its events: `inputs` is the number of an
        event, and `out` has a zero and the states; it writes by how much the potential energy (J) grows, and the
        states after that event. None: actions are called from Python.
    tell : function, int or None
        A function of the same signature that writes to `out` what `Load.tell` returns; None: that is called from
        Python.
    """

    real: Callable[..., None] | int
    numbers: Vector
    complex_: Callable[..., None] | int | None = None
    watch: Callable[..., None] | int | None = None
    change: Callable[..., None] | int | None = None
    tell: Callable[..., None] | int | None = None
