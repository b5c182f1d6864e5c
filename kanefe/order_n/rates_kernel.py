"""A kernel that evaluates the rates of a scene, and its calls from Python."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.compiler.entries import Bound, Call
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.evaluation.evaluation import (
    ASKED,
    AT_TIME,
    DONE_AS,
    IS_IMPLICIT,
    LEAST_PIVOT,
    SHARE_OF_DAMPING,
    SHARE_OF_RATES,
    SHARE_OF_STIFFNESS,
)
from kanefe.kernels.steppers.step_commands import RATES, VECTOR
from kanefe.tree.model_data import QUADRATURES


class RatesKernel:
    """A kernel of rates, in space or in the plane, with the tables of a scene; several threads may use it.

    Parameters
    ----------
    evaluation : Bound
        Takes what `kanefe.kernels.evaluation.evaluation.evaluate` takes, without the tables.
    memory_size : int
        Of its memory.
    state_size : int
        Numbers of a state and its quadratures.
    driven : int
        Driven coordinates.
    constants : ndarray
        Values of loads, those written that never change.

    Attributes
    ----------
    memory_size : int
    """

    def __init__(
        self, evaluation: Bound, memory_size: int, state_size: int, driven: int, constants: np.ndarray
    ) -> None:
        self._evaluation = evaluation
        self.memory_size = memory_size
        self._state_size, self._driven, self._constants = state_size, driven, constants
        self._idle: list[RatesCall] = []
        self.give_back = self._idle.append

    def prepared(self, drives: np.ndarray, inputs: np.ndarray, vectors: np.ndarray, memory: np.ndarray) -> Call:
        """Return a call with arrays that stay where they are, the last of `memory_size`."""
        return self._evaluation.prepared(ASKED, drives, inputs, vectors, memory)

    def take(self) -> RatesCall:
        """Return a call that nobody else uses until it is handed to `give_back`."""
        try:
            return self._idle.pop()
        except IndexError:
            return self.new_call()

    def rates(self, t: float, y: Vector) -> Vector | None:
        """Return dy/dt of a state without quadratures, of a scene that nothing drives; None where it is not regular."""
        try:  # a small scene takes as long as a handful of calls in Python: this makes few
            call = self._idle.pop()
        except IndexError:
            call = self.new_call()
        call.state[...] = y
        numbers = call.numbers
        numbers[AT_TIME] = t
        call.run()
        found = call.rates.copy()
        self._idle.append(call)
        return found if numbers[DONE_AS] == RATES and numbers[LEAST_PIVOT] >= NEAR_SINGULAR else None

    def new_call(self) -> RatesCall:
        """Return a call that its user keeps."""
        vectors = np.zeros((VECTOR.stiffness_direction + 1, self._state_size))
        return RatesCall(self, vectors, np.zeros((self._driven, 3)), self._constants.copy())


class RatesCall:
    """A call of a kernel of rates from Python, whose arrays stay where they are: of one thread at a time.

    Attributes
    ----------
    vectors : ndarray, shape (4, state)
        The state, its rates and the pushes of a linearly implicit evaluation.
    at, slope : ndarray, shape (state,)
        The first two of them.
    state, rates : ndarray, shape (state - 2,)
        Of these, what is not a quadrature.
    drives : ndarray, shape (driven, 3)
    inputs : ndarray
        Values of loads; those that never change are written.
    call : Call
    run, numbers
        Those of the call.
    """

    def __init__(self, kernel: RatesKernel, vectors: np.ndarray, drives: np.ndarray, inputs: np.ndarray) -> None:
        self.vectors, self.at, self.slope = vectors, vectors[VECTOR.at], vectors[VECTOR.slope]
        self.state, self.rates = self.at[:-QUADRATURES], self.slope[:-QUADRATURES]
        self.drives, self.inputs = drives, inputs
        self.call = kernel.prepared(drives, inputs, vectors, np.empty(kernel.memory_size))
        self.run, self.numbers = self.call.run, self.call.numbers

    def __call__(self, t: float) -> tuple[float, float]:
        """Evaluate the rates at a time, s; return how it ended and the smallest pivot of the constraints."""
        numbers = self.numbers
        numbers[AT_TIME] = t
        self.run()
        return numbers[DONE_AS], numbers[LEAST_PIVOT]

    def share(self, is_implicit: bool, damping: float, stiffness: float, rates: float) -> None:
        """Let evaluations from now on be linearly implicit with these shares, or not."""
        self.call.places[IS_IMPLICIT] = is_implicit
        numbers = self.numbers
        numbers[SHARE_OF_DAMPING], numbers[SHARE_OF_STIFFNESS], numbers[SHARE_OF_RATES] = damping, stiffness, rates
