"""Explicit Runge-Kutta methods from their coefficients, as `kanefe.kernels.steppers.explicit_steps` reads them.

A method is a file with a tableau; `explicit_method` makes a row of the table of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from kanefe.frames import Matrix
from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.kernel_set import Kernels, Memory
from kanefe.integrate.methods.method import Method
from kanefe.integrate.stepper import LEAST_STEPS


class Tableau(NamedTuple):
    """The coefficients of a method.

    Attributes
    ----------
    table : ndarray
        See `kanefe.kernels.steppers.explicit_steps`.
    stages, extra, estimates, dense, order : int
        Stages of a step, further ones for the dense output, rows of error estimates and of dense output, and the order
        of the error that is estimated.
    """

    table: Matrix
    stages: int
    extra: int
    estimates: int
    dense: int
    order: int


def tableau(
    A: Sequence[Sequence[float]],
    b: Sequence[float],
    c: Sequence[float],
    *,
    order: int,
    errors: Sequence[Sequence[float]] = (),
    extra: Sequence[Sequence[float]] = (),
    extra_c: Sequence[float] = (),
    dense: Sequence[Sequence[float]] = (),
) -> Tableau:
    """Return a tableau; rows may end where only zeros follow.

    Parameters
    ----------
    A, b, c : sequences
        Of the stages. The rates at the end of the step are one stage more, whether or not the method has it as its own.
    order : int
        Of the error that is estimated.
    errors : sequences
        Weights of the error, the rates at the end included. Two: see `explicit_steps`.
    extra, extra_c : sequences
        Further stages, after the rates at the end, for the dense output.
    dense : sequences
        Weights of the polynomials ``x^2 (1 - x)^2 (d_0 + x (d_1 + (1 - x) (d_2 + ...)))`` that the dense output has
        beyond the cubic through states and rates at both ends.
    """
    rows = [[node, *row] for node, row in zip(c, A, strict=True)]
    rows += [[1.0, *b], *([node, *row] for node, row in zip(extra_c, extra, strict=True))]
    rows += [[0.0, *weights] for weights in (*errors, *dense)]
    table = np.zeros((len(rows), max(map(len, rows))))
    for i, row in enumerate(rows):
        table[i, : len(row)] = row
    return Tableau(table, len(c), len(extra), len(errors), len(dense), order)


def weights(of_first: float, start: int = 2, *others: float) -> tuple[float, ...]:
    """Return weights of stages: of the first one, and of those from number `start` on."""
    return (of_first, *(0.0,) * (start - 2), *others)


def explicit_method(name: str, about: str, coefficients: Callable[[], Tableau], order: int, **options: Any) -> Method:
    """Return the row of an explicit method.

    Parameters
    ----------
    name, about : str
    coefficients : function
        Returns the tableau; called when the method is first used.
    order : int
        Of convergence.
    **options
        Further attributes of `Method`, in place of those of a method with error control that also takes fixed steps.
    """

    @cache
    def load() -> Kernels:
        return _kernels(coefficients())

    return Method(
        name=name,
        about=about,
        stepper=Compiled(load),
        order=order,
        is_explicit=True,
        **{"has_fixed_steps": True, "takes_atol": True} | options,
    )


REACH = 0.01
"""Fraction of a step behind its end up to which its polynomial is as good as within: see
`kanefe.kernels.events.foreseen_events`."""


def _look_at_contacts(memory: Memory) -> None:
    """Limit steps where contacts may begin: in free flight no error does, and a step would end behind a touch.

    Events are looked for at four places of each step: a run has as many of them as steps with functions of the user.
    """
    from kanefe.kernels.events.watched_run import SHARES

    step = memory.step
    if any(load.acts_at_once for load in memory.dynamics.model.loads):
        step.largest = min(step.largest, (step.stop - step.time) / LEAST_STEPS * len(SHARES))


def _kernels(found: Tableau) -> Kernels:
    from kanefe.kernels.steppers import explicit_steps as kernel

    own = {name: int(getattr(found, name)) for name in ("stages", "extra", "estimates", "dense", "order")}
    own["rate_count"] = found.stages + 1 + found.extra
    return Kernels(
        advance=kernel.advance_explicitly,
        interpolate=kernel.interpolate_explicitly,
        record=kernel.ExplicitStep,
        whole=lambda model: own,
        table=found.table,
        prepare=_look_at_contacts,
        reach=REACH,
    )
