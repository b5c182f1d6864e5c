"""Bodies that slide as they land: friction that is larger at rest does not hold them."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe.checks.robustness.contact_changes import OUTPUTS, SPAN, missed_changes, thrown
from kanefe.checks.robustness.runs import follow
from kanefe.result import Result


@pytest.mark.parametrize("seed", [42, 69])
def test_what_slides_as_it_lands_is_no_longer_held(seed: int) -> None:
    """A slip that is placed before the touch, where there is no force yet, would let nothing go."""
    model = thrown(seed).freeze()
    result = Result(model, follow(model, SPAN, rtol=10.0 ** (-2 - seed % 6), output_step=SPAN / OUTPUTS))
    assert missed_changes(result) == 0
    contact = result.contact("contact")
    slides = (np.array(contact.status) == "slips") & (contact.normal > 1e-3 * contact.normal.max())
    friction = np.linalg.norm(contact.force[slides, :2], axis=1) / contact.normal[slides]
    mu = model.loads[0].friction.mu
    assert model.loads[0].friction.static > 1.05 * mu
    np.testing.assert_allclose(friction, mu, rtol=1e-6)
