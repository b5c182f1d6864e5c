"""What does not yield: a unilateral constraint, and the law of its impacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.kernels.contact.laws.normal_law import normal_law

NEWTON, POISSON = "newton", "poisson"


@dataclass(frozen=True)
class Rigid:
    """A unilateral constraint in the place of a normal force: gap >= 0, force >= 0, and one of them zero.

    Where bodies meet, their speeds jump. By Newton's law the contact parts with a share of the speed at which it came;
    by Poisson's with an impulse that is a share of the one that stopped it. They differ where friction or other
    contacts take part in the impact (Glocker, "Set-Valued Force Laws", 2001, chapter 8).

    Parameters
    ----------
    restitution : float
        That share, 0 to 1.
    impact : "newton" or "poisson"

    Raises
    ------
    ModelError
        If the restitution is no number of 0 to 1, or there is no such law.

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
    impact: str = NEWTON

    def __post_init__(self) -> None:
        e = numbers(self.restitution)
        if e.shape != () or not 0.0 <= e <= 1.0:
            raise ModelError(f"restitution of Rigid must be a number of 0 to 1, not {self.restitution!r}")
        if not isinstance(self.impact, str) or self.impact not in (NEWTON, POISSON):
            raise ModelError(f"impact of Rigid must be 'newton' or 'poisson', not {self.impact!r}")
        object.__setattr__(self, "restitution", float(np.asarray(e)))


def check_normal(given: object, label: str) -> None:
    """Raise a ModelError if something is no law of a contact that yields or is rigid."""
    if not isinstance(given, Rigid):
        normal_law(given, label)


def not_by_newton(times: dict[str, list[float]]) -> str:
    """Return what is told of impacts that were Poisson's where Newton's was asked for: of contacts, when, s."""
    counts = ", ".join(f"{name!r} {len(of_one)}" for name, of_one in sorted(times.items()))
    return (
        f"impacts with restitution by Poisson's law, where by Newton's they have no impulses: rigid contact {counts}; "
        f"the first at t = {min(map(min, times.values())):.6g} s. What is between several surfaces cannot part from "
        "all of them as Newton's law has it. Remedy: kanefe.Rigid(..., impact='poisson') where that is meant, "
        "or restitution 0"
    )
