"""Card of a flexible body."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.views.cards.card import card, picture, table
from kanefe.views.still import picture_of_body
from kanefe.views.thumbnail import SIZE

MOST_FREQUENCIES = 6
DENSE = 400
"""Number of free coordinates up to which frequencies are computed for the card."""


def body_card(body: FlexibleBody) -> str:
    """Return the card of a body: picture, mass, modes, interfaces."""
    x, y, z = np.round(body.center_of_mass, 9) + 0.0
    principal = ", ".join(f"{body.inertia[i, i]:.5g}" for i in range(3))
    rows = [
        ("mass", f"{body.mass:.6g} kg"),
        ("centre of mass", f"({x:.5g}, {y:.5g}, {z:.5g}) m"),
        ("J_xx, J_yy, J_zz", f"{principal} kg m2, about the origin"),
        ("mesh", f"{len(body.nodes)} nodes, {_cells(body)}"),
        ("coordinates", f"{body.free_count} free, {body.fixed_count} fixed at interfaces"),
    ]
    if 0 < body.free_count <= DENSE:
        first = ", ".join(f"{f:.4g}" for f in body.frequencies[:MOST_FREQUENCIES])
        rows.append(("frequencies", f"{first}{', ...' if body.free_count > MOST_FREQUENCIES else ''} Hz"))
    names = [f"{frame.name}{' (fixed)' if frame.is_held else ''}" for frame in body.interfaces]
    rows.append(("interfaces", ", ".join(names) or "none"))
    if source := body.provenance.get("source"):
        rows.append(("source", str(source)))
    return card("flexible body", picture(picture_of_body(body), SIZE[0], "the body"), table(rows))


def _cells(body: FlexibleBody) -> str:
    return ", ".join(f"{len(block.nodes)} {block.kind}" for block in body.cells) or "no cells"
