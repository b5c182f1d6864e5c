"""The methods that are kernels (see `kanefe.kernels.stepping`): their functions, memory and coefficients, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from kanefe.frames import Matrix
from kanefe.kernels import stepping
from kanefe.kernels._numba import pointer
from kanefe.kernels.steppers import (
    energy_momentum,
    extrapolation,
    extrapolation_dense,
    kept_quantities,
    radau,
    radau_polynomial,
)
from kanefe.kernels.steppers import extrapolation_dense as extrapolation_layout
from kanefe.kernels.steppers import radau_polynomial as radau_layout
from kanefe.kernels.steppers.explicit_steps import (
    DENSE,
    ESTIMATES,
    EXTRA,
    FIRST_RATE,
    ORDER,
    REALS,
    STAGES,
    advance_explicitly,
    interpolate_explicitly,
)

COLUMNS_OF_FIXED_STEPS = 6
"""Columns of an extrapolation with fixed steps: order 6."""


@dataclass(frozen=True, eq=False)
class KernelMethod:
    """A method.

    Attributes
    ----------
    name : str
    advance, interpolate : function
        Kernels.
    rows, rows_per_speed, reals : int
        Rows of vectors that it takes, further ones for every speed, and reals.
    integers : dict of int to int
        Its own integers at the start.
    table : ndarray
        Its coefficients.
    is_implicit : bool
        Whether it wants linearly implicit evaluations.
    keeps_balance : bool
        Whether it wants energy and momenta.
    of_tolerance : function
        The estimate that a step may have, for a relative tolerance.
    """

    name: str
    advance: Callable[..., Any]
    interpolate: Callable[..., Any]
    rows: int
    reals: int
    integers: dict[int, int]
    table: Matrix
    is_implicit: bool = False
    rows_per_speed: int = 0
    keeps_balance: bool = False
    of_tolerance: Callable[[float], float] = float

    @cached_property
    def pointers(self) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """The two functions as pointers of one type for all methods."""
        return pointer(self.advance), pointer(self.interpolate)


def _of_order_three(rtol: float) -> float:
    """Return the estimate of order 3 that a step of order 5 may have (Hairer & Wanner 1996, IV.8, the code RADAU5)."""
    return 0.1 * rtol ** (2.0 / 3.0)


@cache
def kernel_method(name: str) -> KernelMethod:
    """Return a method by its name."""
    if name == "extrapolation":
        return KernelMethod(
            name,
            extrapolation.advance_extrapolating,
            extrapolation_dense.interpolate_extrapolating,
            extrapolation_layout.rows_needed(),
            extrapolation_layout.reals_needed(),
            {},
            np.zeros((1, 1)),
            is_implicit=True,
        )
    if name == "energy-momentum":
        return KernelMethod(
            name,
            energy_momentum.advance_keeping,
            energy_momentum.interpolate_keeping,
            kept_quantities.ROWS,
            kept_quantities.REALS,
            {},
            np.zeros((1, 1)),
            is_implicit=True,
            keeps_balance=True,
        )
    from kanefe.integrate.methods import tableaus

    if name == "radau5":
        rows, rows_per_speed = radau_layout.rows_needed()
        return KernelMethod(
            name,
            radau.advance_radau,
            radau_polynomial.interpolate_radau,
            rows,
            radau_layout.REALS,
            {stepping.JACOBIAN_ROW: radau_layout.JACOBIAN_ROWS},
            tableaus.radau_iia(),
            rows_per_speed=rows_per_speed,
            of_tolerance=_of_order_three,
        )
    makers = {
        "rk4": tableaus.classical,
        "dopri5": tableaus.dormand_prince_5,
        "dop853": tableaus.dormand_prince_8,
    }
    tableau = makers[name]()
    integers = {
        STAGES: tableau.stages,
        EXTRA: tableau.extra,
        ESTIMATES: tableau.estimates,
        DENSE: tableau.dense,
        ORDER: tableau.order,
    }
    rows = FIRST_RATE + tableau.stages + 1 + tableau.extra
    return KernelMethod(
        name,
        advance_explicitly,
        interpolate_explicitly,
        rows,
        REALS,
        integers,
        tableau.table,
    )
