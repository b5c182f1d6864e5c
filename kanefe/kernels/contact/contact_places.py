"""Where the numbers and internal states of a contact are: see `kanefe.contact.contact_numbers`."""

from __future__ import annotations

# Numbers of a contact
(
    PROBES,
    ENDS,
    SHAPE,
    HAS_FRICTION,
    HAS_MEMORY,
    HAS_RESTITUTION,
    RESTS_AT,
    SOFTNESS,
    LAW,
    STIFFNESS,
    EXPONENT,
    DAMPING,
    MU_ALONG,
    MU_ACROSS,
    STATIC_RATIO,
    STRIBECK_SPEED,
    ANCHOR_STIFFNESS,
    ANCHOR_DAMPING,
    TORSIONAL,
    ROLLING,
    ALONG,
) = range(21)
VISCOUS = TORSIONAL  # of bristles, which do not hold against turning
BELT = ALONG + 3
POINT_REPORTS = BELT + 3
PROBE = POINT_REPORTS + 1
# Kinds of normal laws, numbers of a piece of a table, and of a function of the user: see `CompiledLaw`
KELVIN_VOIGT, TABLE, BY_FUNCTION = 1.0, 2.0, 3.0
PIECE = 6
ADDRESS, HAS_SLOPES, CONSTANTS = range(3)
# Kinds of friction
ANCHORED, BRISTLES = 1.0, 2.0
# Numbers of a probe
END, POINT, RADIUS, SHARE, RING, AXIS = 0, 1, 4, 5, 6, 7
PROBE_NUMBERS = 10
# Numbers of a probe at rest: where it was in contact, of both sides, and how it was turned
REST_NUMBERS, TURNED = 15, 6

# Internal states: slip, work of friction, lambda of a restitution; then of each probe its anchor and whether it sticks
SLIP, WORK, IMPACT = range(3)
