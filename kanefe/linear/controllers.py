"""A linear controller with states behind a linearised scene: both as one system, for the margins of their loop."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg

from kanefe.errors import ModelError
from kanefe.frames import Matrix
from kanefe.linear.input_to_output import ScaledSystem

WANTED = "Remedy: four matrices A, B, C and D, such as ([[-10.0]], [[1.0]], [[10.0]], [[0.0]])"


def in_series(of: ScaledSystem, controller: Any) -> ScaledSystem:
    """Return a system whose output goes through a controller, of one input and one output: see `Linearisation.margins`.

    Its states are scaled so that rows and columns of the whole are alike.
    """
    if controller is None or of.D.shape != (1, 1):
        return of
    a, b, c, d = _matrices(controller)
    A = np.block([[of.A, np.zeros((len(of.A), len(a)))], [b @ of.C, a]])
    B, C = np.vstack((of.B, b @ of.D)), np.hstack((d @ of.C, c))
    A, (scale, _) = scipy.linalg.matrix_balance(A, permute=False, separate=True)
    return ScaledSystem(A, B / scale[:, None], C * scale, d @ of.D)


def _matrices(controller: Any) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """Return the matrices of a controller, checked."""
    if getattr(controller, "dt", None) not in (None, 0):
        raise ModelError(
            f"margins: the controller is sampled (dt = {controller.dt!r} s), and margins are of continuous ones. "
            "Remedy: add_controller and kanefe.sampled_loop, whose poles tell whether the loop is stable"
        )
    given: list[Any] = [getattr(controller, name, None) for name in "ABCD"]
    if any(part is None for part in given):
        if not isinstance(controller, (tuple, list)) or len(controller) != 4:
            raise ModelError(f"margins: {type(controller).__name__} is no controller. {WANTED}")
        given = list(controller)
    try:
        a, b, c, d = (np.atleast_2d(np.asarray(part, dtype=float)) for part in given)
    except (TypeError, ValueError) as error:
        raise ModelError(f"margins: the matrices of the controller are no numbers ({error}). {WANTED}") from None
    n = len(a) if a.size else 0
    a, b, c = a.reshape(n, -1) if n else np.zeros((0, 0)), b.reshape(-1, 1), c.reshape(1, -1)
    if a.shape != (n, n) or b.shape != (n, 1) or c.shape != (1, n) or d.shape != (1, 1):
        raise ModelError(
            "margins: the controller must have one input and one output: A (n, n), B (n, 1), C (1, n) and D (1, 1), "
            f"not {', '.join(str(np.shape(part)) for part in given)}. {WANTED}"
        )
    if not all(np.isfinite(part).all() for part in (a, b, c, d)):
        raise ModelError(f"margins: the matrices of the controller must be finite. {WANTED}")
    return a, b, c, d
