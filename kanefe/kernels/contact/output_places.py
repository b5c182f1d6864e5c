"""How many outputs contacts have, and what they say of a status: without the code that writes them."""

from __future__ import annotations

OPEN, STICKS, SLIPS = range(3)

CONTACT_OUTPUTS = 12
"""Number of outputs of a contact as a whole: see `kanefe.contact.contact.Contact.columns`."""

POINT_OUTPUTS = 12
"""Number of outputs of a contact point: normal force and friction (N), depth and stretch (m), slip (m/s), status;
vectors in axes of the surface."""
