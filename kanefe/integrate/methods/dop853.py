"""The method of order 8 with 12 stages, and dense output of order 7 which takes 3 more.

The coefficients (Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 1993, the code DOP853) are those
that scipy carries.
"""

from __future__ import annotations

from kanefe.integrate.methods.explicit import Tableau, explicit_method, tableau


def coefficients() -> Tableau:
    """Return the tableau."""
    from scipy.integrate import DOP853

    return tableau(
        DOP853.A,
        DOP853.B,
        DOP853.C,
        order=8,
        errors=[DOP853.E5, DOP853.E3],
        extra=DOP853.A_EXTRA,
        extra_c=DOP853.C_EXTRA,
        dense=DOP853.D,
    )


METHOD = explicit_method("dop853", "explicit, of Dormand & Prince: the choice where nothing is stiff", coefficients, 8)
