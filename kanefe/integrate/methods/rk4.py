"""The classical method of order 4: no error estimate, and a cubic between the steps."""

from __future__ import annotations

from kanefe.integrate.methods.explicit import Tableau, explicit_method, tableau


def coefficients() -> Tableau:
    """Return the tableau."""
    A = [[], [0.5], [0.0, 0.5], [0.0, 0.0, 1.0]]
    return tableau(A, [1 / 6, 1 / 3, 1 / 3, 1 / 6], [0.0, 0.5, 0.5, 1.0], order=4)


METHOD = explicit_method(
    "rk4", "explicit classical Runge-Kutta method", coefficients, 4, has_error_control=False, takes_atol=False
)
