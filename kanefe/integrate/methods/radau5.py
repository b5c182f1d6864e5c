"""Radau IIA of order 5 with the exact Jacobian: see `kanefe.kernels.steppers.radau`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.equations.routes import newton_pattern, tree_matrix
from kanefe.frames import Vector
from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.kernel_set import Kernels, Memory
from kanefe.integrate.methods.method import Method
from kanefe.kernels.values.tensors import Matrix as Square
from kanefe.tree.model_data import QUADRATURES, ModelData

if TYPE_CHECKING:
    from kanefe.equations.model import Model
    from kanefe.order_n.tree_matrix import TreePattern


def radau_iia() -> dict[str, Any]:
    """Return the coefficients of Radau IIA of order 5, as `kanefe.kernels.steppers.radau` has them.

    The inverse of its matrix has one real eigenvalue and a pair of complex ones (Hairer & Wanner, Solving Ordinary
    Differential Equations II, 1996, table 5.6 and IV.8).
    """
    r = np.sqrt(6.0)
    nodes = np.array([(4.0 - r) / 10.0, (4.0 + r) / 10.0, 1.0])
    powers = np.vander(nodes, 3, increasing=True)
    # collocation: exact integrals of 1, c and c^2 from zero to each node
    A = (nodes[:, None] ** np.arange(1, 4) / np.arange(1, 4)) @ np.linalg.inv(powers)
    values, shapes = np.linalg.eig(np.linalg.inv(A))
    real, upper = int(np.argmin(abs(values.imag))), int(np.argmax(values.imag))
    shape, pair = shapes[:, real].real, shapes[:, upper] / shapes[2, upper]
    T = np.column_stack((shape / shape[2], pair.real, -pair.imag))
    gamma = values[real].real
    # the error estimate: a formula of order 3 with the rates at the start, whose share is 1 / gamma
    error = np.linalg.solve(powers.T, 1.0 / np.arange(1, 4) - np.array([1.0 / gamma, 0.0, 0.0]))
    weights = gamma * (np.linalg.inv(A).T @ (error - A[2]))
    of_stages = {"T": Square(*T.ravel()), "T_inverse": Square(*np.linalg.inv(T).ravel())}
    eigenvalues = {"gamma": gamma, "alpha": values[upper].real, "beta": values[upper].imag}
    return {"nodes": nodes, "weights": weights, **of_stages, **eigenvalues}


def of_order_three(rtol: float) -> float:
    """Return the estimate of order 3 that a step of order 5 may have (Hairer & Wanner 1996, IV.8, the code RADAU5).

    With it a vibration loses energy as rtol^(5/6) a period; for tight tolerances it is lowered so that it does as rtol.
    """
    return min(0.1 * rtol ** (2.0 / 3.0), 0.6 * rtol**0.8)


@cache
def _coefficients() -> dict[str, Any]:
    return radau_iia()


@dataclass(frozen=True)
class CompiledRadau(Compiled):
    """Makes the steppers of the method: with dense matrices, or with those of a tree where that is less work."""

    of_tree: Callable[[TreePattern], Kernels]

    def kernels_for(self, model: Model) -> Kernels:
        """Return the kernels that run a scene."""
        pattern = newton_pattern(model.route)
        return self.load() if pattern is None else self.of_tree(pattern)


def _whole(model: ModelData) -> dict[str, int]:
    """Return how much is solved for: internal states of loads that move between events beside the speeds."""
    followed = model.state_count if model.states_move else 0
    rows, unknowns = model.free_count + model.state_count + QUADRATURES, model.free_count + followed
    return {"followed": followed, "unknowns": unknowns, "factor_size": unknowns, "jacobian_rows": rows}


def _whole_of_tree(pattern: TreePattern, model: ModelData) -> dict[str, int]:
    """Return the same, and how much there is of the linearised equations of a tree."""
    size, entries = len(pattern.factors.diagonals), len(pattern.factors.columns)
    own = {"tree_speeds": len(pattern.coordinates), "tree_unknowns": len(pattern.unknowns)}
    own |= {"tree_size": size, "row_ends": size + 1, "entry_count": entries, "mass_count": len(pattern.masses)}
    return _whole(model) | {"factor_size": 0, "jacobian_rows": 0} | own


def _prepare(memory: Memory) -> None:
    step = memory.step
    for name, value in _coefficients().items():
        if isinstance(value, np.ndarray):
            getattr(step, name)[:] = value
        else:
            setattr(step, name, value)


def _prepare_tree(pattern: TreePattern, memory: Memory) -> None:
    """Write also where the entries of the linearised equations are."""
    _prepare(memory)
    step = memory.step
    step.row_starts[:], step.columns[:], step.diagonals[:] = pattern.factors
    step.mass_places[:], step.mass_rows[:], step.mass_speeds[:] = pattern.masses, pattern.mass_rows, pattern.mass_speeds
    step.turn_places[:], step.of_coordinates[:] = pattern.turns, pattern.coordinates
    step.of_unknowns[:] = pattern.unknowns


def _linearise(pattern: TreePattern, memory: Memory) -> Callable[[float, Vector], None]:
    """Return what writes the linearised equations of a tree at a state."""
    matrix, step = tree_matrix(memory.dynamics.route), memory.step
    ones = pattern.factors.diagonals[pattern.coordinates]

    def put(t: float, y: Vector) -> None:
        matrix.put_entries(t, y)
        step.known[:] = np.bincount(pattern.known, matrix.known.values, len(step.known))
        step.known[ones] += 1.0
        step.masses[:] = matrix.masses.values

    return put


@cache
def _kernels() -> Kernels:
    from kanefe.kernels.steppers import radau, radau_polynomial

    return Kernels(
        advance=radau.advance_radau,
        interpolate=radau_polynomial.interpolate_radau,
        record=radau_polynomial.RadauStep,
        whole=_whole,
        has_jacobian=True,
        of_tolerance=of_order_three,
        prepare=_prepare,
        settles_outputs=True,
        scales_with_forces=True,
        restart_share=0.0,  # vibrations may begin there
    )


def _kernels_of_tree(pattern: TreePattern) -> Kernels:
    whole, prepare = partial(_whole_of_tree, pattern), partial(_prepare_tree, pattern)
    return replace(_kernels(), whole=whole, prepare=prepare, differentiate=partial(_linearise, pattern))


METHOD = Method(
    name="radau5",
    about="Radau IIA with the exact Jacobian: for stiff scenes, follows vibrations",
    stepper=CompiledRadau(_kernels, _kernels_of_tree),
    order=5,
    has_fixed_steps=True,
    takes_atol=True,
    least_rtol=1e-12,
)
