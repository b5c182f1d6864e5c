"""A table of the contacts of a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kanefe.results.contact_history import STATUS, ContactHistory

HEADER = (
    "contact",
    "first touch [s]",
    "touches",
    "largest normal [N]",
    "at [s]",
    "tangential [N]",
    "held",
    "slip [m]",
    "work [J]",
)

OPEN, STICKS, _ = STATUS


def contact_report(times: np.ndarray, contacts: Mapping[str, ContactHistory], events: Mapping[str, np.ndarray]) -> str:
    """Return a table with a line for each contact, in columns of text.

    Parameters
    ----------
    times : ndarray, shape (T,)
        Output times, s. Largest forces and the share of sticking in the time of contact are found from these; times
        and numbers of touches from events.
    contacts : dict of str to ContactHistory
    events : dict of str to ndarray
        Times by name, s.
    """
    rows = [HEADER, *(_row(name, times, history, events) for name, history in contacts.items())]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def _row(name: str, times: np.ndarray, history: ContactHistory, events: Mapping[str, np.ndarray]) -> tuple[str, ...]:
    history = ContactHistory(*map(np.atleast_1d, history))  # an instant has no axis of times
    touched = history.status != OPEN
    touches = events.get(f"{name} touch", np.zeros(0))
    begins = bool(touched[0])
    if not (touched.any() or len(touches)):
        return (name, "never", *["-"] * (len(HEADER) - 2))
    # a contact that begins without depth has no event of touch
    first = float(touches[0] if len(touches) else times[np.argmax(touched)])
    largest = int(np.argmax(history.normal))
    held = np.count_nonzero(history.status == STICKS) / max(np.count_nonzero(touched), 1)
    return (
        name,
        "from the start" if begins else f"{first:.6g}",
        f"{max(len(touches) + begins, 1)}",
        f"{history.normal[largest]:.5g}",
        f"{times[largest]:.5g}",
        f"{history.tangential.max():.5g}",
        f"{100.0 * held:.3g} %",
        f"{history.slip[-1]:.4g}",
        f"{history.work[-1]:.4g}",
    )
