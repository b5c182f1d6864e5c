"""Runs in an environment of pyNastran: places of grid points, asked for over pipes."""

from __future__ import annotations

# before the peer: see there
from peer_answers import Answer, answer_requests  # isort: skip
from pyNastran.bdf.bdf import BDF  # isort: skip


def places(path: str) -> Answer:
    """Return labels and places in basic coordinates of all grid points of a deck."""
    deck = BDF(debug=False)
    deck.read_bdf(path, xref=True)
    return {
        "labels": [int(label) for label in deck.nodes],
        "places": [[float(x) for x in node.get_position()] for node in deck.nodes.values()],
    }


if __name__ == "__main__":
    answer_requests(places)
