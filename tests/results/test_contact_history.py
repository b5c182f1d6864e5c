"""What a contact did, as it is printed."""

from __future__ import annotations

import numpy as np

from kanefe.results.contact_history import ContactHistory


def test_a_contact_is_printed_in_two_lines() -> None:
    zeros, force = np.zeros((4, 3)), np.array((0.0, 5.0, 2.0, 0.0))
    slip = np.array((0.0, 0.0, 0.01, 0.01))
    status = np.array(("open", "sticks", "slips", "open"))
    found = ContactHistory(zeros, force, 0.4 * force, 1e-3 * force, slip, zeros, 0.8 * slip, status)
    assert str(found) == (
        "contact at 4 times: open at 2, sticks at 1, slips at 1\n"
        "  largest normal force 5 N, friction 2 N, penetration 0.005 m; slid 0.01 m, which took 0.008 J"
    )
