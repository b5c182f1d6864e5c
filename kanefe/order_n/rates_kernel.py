"""A kernel that evaluates the rates of a scene, and its calls from Python."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler.entries import Bound, Call
from kanefe.kernels.evaluation.evaluation import (
    ASKED,
    AT_TIME,
    IS_IMPLICIT,
    SHARE_OF_DAMPING,
    SHARE_OF_RATES,
    SHARE_OF_STIFFNESS,
)
from kanefe.kernels.steppers.step_commands import AT, SLOPE, STIFFNESS_DIRECTION


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

    def new_call(self) -> RatesCall:
        """Return a call that its user keeps."""
        vectors = np.zeros((STIFFNESS_DIRECTION + 1, self._state_size))
        return RatesCall(self, vectors, np.zeros((self._driven, 3)), self._constants.copy())


class RatesCall:
    """A call of a kernel of rates from Python, whose arrays stay where they are: of one thread at a time.

    Attributes
    ----------
    vectors : ndarray, shape (4, state)
        The state, its rates and the pushes of a linearly implicit evaluation.
    at, slope : ndarray, shape (state,)
        The first two of them.
    drives : ndarray, shape (driven, 3)
    inputs : ndarray
        Values of loads; those that never change are written.
    call : Call
    """

    def __init__(self, kernel: RatesKernel, vectors: np.ndarray, drives: np.ndarray, inputs: np.ndarray) -> None:
        self.vectors, self.at, self.slope = vectors, vectors[AT], vectors[SLOPE]
        self.drives, self.inputs = drives, inputs
        self.call = kernel.prepared(drives, inputs, vectors, np.empty(kernel.memory_size))

    def __call__(self, t: float, is_implicit: bool, shares: tuple[float, float, float]) -> tuple[int, float]:
        """Evaluate the rates at a time, s; return how it ended and the smallest pivot of the constraints."""
        call = self.call
        call.places[IS_IMPLICIT], call.numbers[AT_TIME] = is_implicit, t
        numbers = call.numbers
        numbers[SHARE_OF_DAMPING], numbers[SHARE_OF_STIFFNESS], numbers[SHARE_OF_RATES] = shares
        return call()  # type: ignore[no-any-return]
