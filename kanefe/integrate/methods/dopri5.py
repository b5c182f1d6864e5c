"""Dormand and Prince's method of order 5 with 7 stages, the last of which is the first of the next step.

The coefficients (Dormand & Prince, Journal of Computational and Applied Mathematics 6, 1980) are those that scipy
carries.
"""

from __future__ import annotations

from kanefe.integrate.methods.explicit import Tableau, explicit_method, tableau


def coefficients() -> Tableau:
    """Return the tableau."""
    from scipy.integrate import RK45

    # the quartic part of the dense output is all that the cubic through both ends lacks
    return tableau(RK45.A, RK45.B, RK45.C, order=5, errors=[RK45.E], dense=[RK45.P[:, 3]])


METHOD = explicit_method("dopri5", "explicit, of Dormand & Prince: loose tolerances", coefficients, 5)
