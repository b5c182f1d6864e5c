"""Card of a run."""

from __future__ import annotations

from kanefe.integrate.status import summary
from kanefe.results.reader import Reader
from kanefe.views.cards.card import card, picture, table
from kanefe.views.still import picture_of_run
from kanefe.views.thumbnail import SIZE

MOST = 12
"""Largest number of bodies that are listed."""


def run_card(result: Reader) -> str:
    """Return the card of a run: status, statistics, bodies, and a picture of the end."""
    status, *lines = summary(result.status, result.statistics, result.events).splitlines()
    facts = [(line.split()[0], line.split(maxsplit=1)[1]) for line in lines]
    facts.append(("outputs", f"{len(result.times)}, {result.times[0]:.6g} to {result.times[-1]:.6g} s"))
    rows = [(name, *_body(result, name)) for name in result.bodies[:MOST]]
    if len(result.bodies) > MOST:
        rows.append(("...", f"{len(result.bodies) - MOST} more bodies", ""))
    still = picture_of_run(result)
    shown = picture(still, SIZE[0], f"the scene at {result.times[-1]:.6g} s") if still else ""
    return card(status, shown, table(facts), table(rows, ("body", "", "joint")))


def _body(result: Reader, name: str) -> tuple[str, str]:
    shape = result.body(name)
    if shape.is_flexible:
        return f"flexible, {shape.mass:.5g} kg, {shape.basis.shape[1]} modes", shape.joint
    return f"rigid, {shape.mass:.5g} kg" if shape.mass > 0.0 else "massless", shape.joint
