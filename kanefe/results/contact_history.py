"""Outputs of a contact in a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.errors import ModelError

STATUS = "open", "sticks", "slips"


class ContactHistory(NamedTuple):
    """Outputs of a contact at the output times.

    Attributes
    ----------
    force : ndarray, shape (T, 3)
        Force on the touching body or points, in components of N, N.
    normal, tangential : ndarray, shape (T,)
        Sum of the normal forces of all points, and magnitude of the friction force, N.
    penetration : ndarray, shape (T,)
        Of the deepest point, m; negative: the gap.
    slip : ndarray, shape (T,)
        Sliding distance so far, the weighted mean of all points, m.
    point : ndarray, shape (T, 3)
        Centre of the normal forces in N, m; without contact, the point closest to the surface.
    work : ndarray, shape (T,)
        Energy that sliding has dissipated so far, J.
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
        """Return two lines: numbers of times of each status, largest forces, sliding distance and work."""
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


def contact_history(outputs: np.ndarray, columns: Sequence[str], name: str) -> ContactHistory:
    """Return the outputs of a contact as a `ContactHistory`.

    Raises
    ------
    ModelError
        If the load is not a contact.
    """
    if not is_contact(columns):
        raise ModelError(f"load {name!r} is not a contact. Remedy: result.load({name!r})")
    normal, tangential, penetration, slip, *_, work, status = outputs[..., 3:].T
    return ContactHistory(
        outputs[..., :3],
        normal,
        tangential,
        penetration,
        slip,
        outputs[..., 7:10],
        work,
        np.array(STATUS)[status.astype(int)],
    )
