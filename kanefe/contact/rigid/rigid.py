"""What does not yield: a unilateral constraint, and the law of its impacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.arguments import positive
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.kernels.contact.laws.normal_law import normal_law

STRONGE, NEWTON, POISSON, DISTRIBUTING = "stronge", "newton", "poisson", "distributing"
IMPACT_LAWS = STRONGE, NEWTON, POISSON, DISTRIBUTING
"""Laws of impact, the default first; what is written to tables is their number here."""


@dataclass(frozen=True)
class Rigid:
    """A unilateral constraint in the place of a normal force: gap >= 0, force >= 0, and one of them zero.

    Where bodies meet, their speeds jump. Without friction and other contacts the contact parts with a share of the
    speed at which it came. Else laws differ:

    - "stronge": friction is followed through the impact, and the square of that share is given back of the energy
      stored in it (W. J. Stronge, 1990). Where several contacts strike at once it is "poisson".
    - "poisson": the impulse of parting is a share of the one of approach, with the friction of whole impulses; less,
      where it would give energy (Glocker & Pfeiffer, 1995).
    - "distributing": all contacts of an impact yield for a moment, and share it by their `stiffness` (Liu, Zhao &
      Brogliato, Proc. R. Soc. Lond. A 464 (2008) 3193-3211). One contact has Stronge's impulse.
    - "newton": the share is one of speeds, with the friction of whole impulses. With friction, and with unlike
      restitutions, it can make energy (Kane & Levinson, "Dynamics", 1985); a run tells where it did.

    Parameters
    ----------
    restitution : float
        That share, 0 to 1.
    impact : "stronge", "newton", "poisson" or "distributing"
    stiffness : float
        Of a contact relative to the others of an impact that is distributed: the factor of ``depth ** exponent``.
    exponent : float
        Of the depth there, at least 1: 3/2 of balls (Hertz), 1 of faces.

    Raises
    ------
    ModelError
        If the restitution is no number of 0 to 1, there is no such law, or a number is out of its range.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    >>> ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z", position=1.0))
    >>> scene.add_contact("c", ball, floor, normal=kf.Rigid(restitution=0.8))
    >>> result = scene.simulate((0.0, 4.5), rtol=1e-8)
    >>> result.events["c rest"].round(6)
    array([4.063713])
    """

    restitution: float = 0.0
    impact: str = STRONGE
    stiffness: float = 1.0
    exponent: float = 1.5

    def __post_init__(self) -> None:
        e = numbers(self.restitution)
        if e.shape != () or not 0.0 <= e <= 1.0:
            raise ModelError(f"restitution of Rigid must be a number of 0 to 1, not {self.restitution!r}")
        if not isinstance(self.impact, str) or self.impact not in IMPACT_LAWS:
            known = ", ".join(f"{law!r}" for law in IMPACT_LAWS[:-1])
            raise ModelError(f"impact of Rigid must be {known} or {DISTRIBUTING!r}, not {self.impact!r}")
        stiffness, exponent = (
            positive(self.stiffness, "stiffness of Rigid"),
            positive(self.exponent, "exponent of Rigid"),
        )
        if exponent < 1.0:
            raise ModelError(f"exponent of Rigid must be a number of at least 1, not {self.exponent!r}")
        for name, value in (("restitution", float(np.asarray(e))), ("stiffness", stiffness), ("exponent", exponent)):
            object.__setattr__(self, name, value)


def check_normal(given: object, label: str) -> None:
    """Raise a ModelError if something is no law of a contact that yields or is rigid."""
    if not isinstance(given, Rigid):
        normal_law(given, label)
