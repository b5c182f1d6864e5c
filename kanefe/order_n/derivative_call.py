"""The call of the kernels that give exact derivatives of the rates, prepared once."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler.entries import LATER, Call
from kanefe.kernels.evaluation.derivatives import derivatives
from kanefe.kernels.evaluation.evaluation import ASKED, AT_TIME, evaluate
from kanefe.kernels.scene import Scene, memory_size
from kanefe.kernels.steppers.step_commands import VECTOR


class DerivativeCall:
    """A call whose arrays stay where they are: of one thread at a time.

    Parameters
    ----------
    scene : Scene
    size, driven, inputs : int
        Numbers of a state; driven coordinates; values of loads.

    Attributes
    ----------
    drives, inputs, vectors : ndarray
        What it evaluates.
    evaluation : Call
        That it makes.
    """

    def __init__(self, scene: Scene, size: int, driven: int, inputs: int) -> None:
        self.drives, self.inputs = np.empty((driven, 3)), np.empty(inputs)
        self.vectors, memory = np.empty((2, size), dtype=complex), np.empty(memory_size(scene), dtype=complex)
        arguments = ASKED, scene, self.drives, self.inputs, self.vectors, memory
        self.evaluation = evaluate.bound(*arguments, is_complex=True).prepared()
        self._bound = derivatives.bound(self.evaluation.for_kernels(), self.vectors, LATER, LATER, is_complex=True)

    def __call__(
        self, t: float, y: Vector, drives: np.ndarray, inputs: np.ndarray, directions: Matrix
    ) -> tuple[bool, Matrix]:
        """Return whether the mass matrix was regular, and derivatives of dy/dt along the rows of directions."""
        self.evaluation.numbers[AT_TIME] = t
        self.vectors[VECTOR.at], self.drives[:], self.inputs[:] = y, drives, inputs
        along = np.ascontiguousarray(directions, dtype=float)
        found = np.empty_like(along)
        return bool(self._bound(along, found)), found

    def prepared(self, along: Matrix, found: Matrix) -> Call:
        """Return the call for directions and derivatives that stay where they are."""
        return self._bound.prepared(along, found)
