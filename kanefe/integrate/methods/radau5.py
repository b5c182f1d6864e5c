"""Radau IIA of order 5 with the exact Jacobian: see `kanefe.kernels.steppers.radau`."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.kernel_set import Kernels, Memory
from kanefe.integrate.methods.method import Method
from kanefe.kernels.values.tensors import Matrix as Square
from kanefe.tree.model_data import QUADRATURES, ModelData


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


def _whole(model: ModelData) -> dict[str, int]:
    """Return how much is solved for: internal states of loads that move between events beside the speeds."""
    followed = model.state_count if model.states_move else 0
    rows = model.free_count + model.state_count + QUADRATURES
    return {"followed": followed, "unknowns": model.free_count + followed, "jacobian_rows": rows}


def _prepare(memory: Memory) -> None:
    step = memory.step
    for name, value in _coefficients().items():
        if isinstance(value, np.ndarray):
            getattr(step, name)[:] = value
        else:
            setattr(step, name, value)


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


METHOD = Method(
    name="radau5",
    about="Radau IIA with the exact Jacobian: for stiff scenes, follows vibrations",
    stepper=Compiled(_kernels),
    order=5,
    has_fixed_steps=True,
    takes_atol=True,
    least_rtol=1e-12,
)
