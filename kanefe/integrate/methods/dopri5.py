"""Dormand and Prince's method of order 5 with 7 stages, the last of which is the first of the next step.

Coefficients of Dormand & Prince, Journal of Computational and Applied Mathematics 6, 1980; those of the dense output of
Shampine, Mathematics of Computation 46, 1986, as scipy carries them.
"""

from __future__ import annotations

from kanefe.integrate.methods.explicit import Tableau, explicit_method, tableau

NODES = 0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0

STAGES = (
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
)
"""Coefficients of all stages but the first."""

STEP = 35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84

ERROR = -71 / 57600, 0.0, 71 / 16695, -71 / 1920, 17253 / 339200, -22 / 525, 1 / 40

QUARTIC = (
    -12715105075 / 11282082432,
    0.0,
    87487479700 / 32700410799,
    -10690763975 / 1880347072,
    701980252875 / 199316789632,
    -1453857185 / 822651844,
    69997945 / 29380423,
)
"""Coefficients of the dense output: the difference from the cubic through both ends."""


def coefficients() -> Tableau:
    """Return the tableau."""
    return tableau(((), *STAGES), STEP, NODES, order=5, errors=[ERROR], dense=[QUARTIC])


METHOD = explicit_method("dopri5", "explicit method of Dormand & Prince: for loose tolerances", coefficients, 5)
