"""What a contact did in a run, by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.errors import ModelError

STATUS = "open", "sticks", "slips"


class ContactHistory(NamedTuple):
    """What a contact did at the output times.

    Attributes
    ----------
    force : ndarray, shape (T, 3)
        On what touches, in N (the inertial frame), N.
    normal, tangential : ndarray, shape (T,)
        Normal force of all points together, and size of the friction, N.
    penetration : ndarray, shape (T,)
        Of the deepest point, m; below 0: the gap.
    slip : ndarray, shape (T,)
        Path slid so far, the mean of all points by their shares, m.
    point : ndarray, shape (T, 3)
        Where the normal forces together act, and where nothing touches what is next to the surface, in N, m.
    work : ndarray, shape (T,)
        That sliding has taken so far, J.
    status : ndarray of str, shape (T,)
        "open", "sticks" or "slips".
    """

    force: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    penetration: np.ndarray
    slip: np.ndarray
    point: np.ndarray
    work: np.ndarray
    status: np.ndarray

    def __str__(self) -> str:
        """Return it in two lines: how often it touched and slid, the largest forces, and what sliding came to."""
        if not len(self.status):
            return "contact at no times"
        counts = ", ".join(f"{word} at {np.count_nonzero(self.status == word)}" for word in STATUS)
        return (
            f"contact at {len(self.status)} times: {counts}\n"
            f"  largest normal force {self.normal.max():.4g} N, friction {self.tangential.max():.4g} N, penetration "
            f"{self.penetration.max():.3g} m; slid {self.slip[-1]:.4g} m, which took {self.work[-1]:.4g} J"
        )


def is_contact(columns: Sequence[str]) -> bool:
    """Return whether a load with these columns is a contact."""
    from kanefe.contact.contact import Contact

    return tuple(columns) == Contact.columns


def contact_history(told: np.ndarray, columns: Sequence[str], name: str) -> ContactHistory:
    """Return the outputs of a load as those of a contact.

    Raises
    ------
    ModelError
        If the load is none.
    """
    if not is_contact(columns):
        raise ModelError(f"load {name!r} is not a contact. Remedy: result.load({name!r})")
    normal, tangential, penetration, slip, *_, work, status = told[..., 3:].T
    return ContactHistory(
        told[..., :3],
        normal,
        tangential,
        penetration,
        slip,
        told[..., 7:10],
        work,
        np.array(STATUS)[status.astype(int)],
    )
