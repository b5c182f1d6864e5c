"""What a run tells of its impacts: where the law asked for did not hold, made energy, or an order decides."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field

from kanefe.errors import SimulationWarning, outside


@dataclass
class ToldImpacts:
    """Impacts of which something is to be told.

    Attributes
    ----------
    by_poisson : dict of str to list of float
        Contacts by Newton's law, and when an impact was Poisson's since Newton's had no impulses, s.
    by_order : dict of str to list of float
        Contacts, and when they took part in impacts that depend on the order of those that strike.
    adding : list of (float, tuple of str, float)
        Impacts that made energy: when (s), at which contacts, and how much (J).
    """

    by_poisson: dict[str, list[float]] = field(default_factory=dict)
    by_order: dict[str, list[float]] = field(default_factory=dict)
    adding: list[tuple[float, tuple[str, ...], float]] = field(default_factory=list)

    def take(self, other: ToldImpacts) -> None:
        """Add what another has."""
        for own, new in ((self.by_poisson, other.by_poisson), (self.by_order, other.by_order)):
            for name, times in new.items():
                own.setdefault(name, []).extend(times)
        self.adding.extend(other.adding)

    def was_by_poisson(self, names: Iterable[str], t: float) -> None:
        """Note an impact of contacts by Newton's law that was Poisson's, at a time, s."""
        for name in names:
            self.by_poisson.setdefault(name, []).append(t)

    def was_by_order(self, names: Iterable[str], t: float) -> None:
        """Note an impact that depends on the order of contacts, at a time, s."""
        for name in names:
            self.by_order.setdefault(name, []).append(t)

    def clear(self) -> None:
        """Forget everything."""
        self.by_poisson.clear()
        self.by_order.clear()
        self.adding.clear()

    def warn(self) -> None:
        """Warn of what is told as a run begins."""
        for text in self.warnings:
            warnings.warn(text, SimulationWarning, stacklevel=outside())

    @property
    def warnings(self) -> list[str]:
        """What is told, a text of each kind."""
        found = []
        if self.by_poisson:
            found.append(
                f"impacts with restitution by Poisson's law, where by Newton's they have no impulses: "
                f"{_counted(self.by_poisson)}. What is between several surfaces cannot part from all of them as "
                "Newton's law has it. Remedy: kanefe.Rigid(..., impact='poisson') where that is meant, or restitution 0"
            )
        if self.adding:
            total = sum(gain for _, _, gain in self.adding)
            t, names, gain = max(self.adding, key=lambda one: one[2])
            first = min(time for time, _, _ in self.adding)
            contacts = ", ".join(f"{name!r}" for name in sorted({name for _, own, _ in self.adding for name in own}))
            found.append(
                f"impacts by Newton's law made {total:.6g} J: {len(self.adding)} of rigid contact {contacts}; "
                f"the first at t = {first:.6g} s, the largest {gain:.6g} J of {', '.join(map(repr, names))} at "
                f"t = {t:.6g} s. With friction, or unlike restitutions, that law can. Remedy: kanefe.Rigid(...) "
                "without impact="
            )
        if self.by_order:
            found.append(
                "impacts in which several rigid contacts strike at once, and the speeds after them depend on which "
                f"strikes first: {_counted(self.by_order)}. Gaps that cannot be measured decide there. Remedy: "
                "kanefe.Rigid(..., impact='distributing'), by which contacts share an impact by their stiffness, or "
                "compliant contacts, kanefe.HuntCrossley(...)"
            )
        return found


def _counted(times: dict[str, list[float]]) -> str:
    counts = ", ".join(f"{name!r} {len(of_one)}" for name, of_one in sorted(times.items()))
    return f"rigid contact {counts}; the first at t = {min(map(min, times.values())):.6g} s"
