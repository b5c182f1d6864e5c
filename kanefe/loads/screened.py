"""What a load tells screened runs of itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

EARLIER = {
    "not_screened": "refused",
    "pull_column": "pull",
    "strongest_pull": "strongest",
    "highest_forcing": "forcing",
    "slip_damping": "slip_damping",
    "stuck": "stuck",
}
"""Attributes of loads of users that said the same one by one, before there was this record."""


class ScreenedLoad(NamedTuple):
    """What `kanefe.screen` has to know of a load, which declares it as its ``screened``.

    Attributes
    ----------
    refused : str or None
        Its property that screened runs do not support; empty: they support it; None: internal states that move.
    pull : str
        Name in `columns` of a tension that must neither vanish nor exceed a limit, such as that of a rope; empty: none.
    strongest : float
        That limit, N.
    forcing : float
        Highest frequency of its own excitation, rad/s, such as that of a rotor.
    slip_damping : float
        Force beyond the friction limit over the slip speed, N s/m, of a load whose first state is the slip path; 0:
        none.
    stuck : callable or None
        (factor) -> the load with static friction between surfaces multiplied by it; None: it has none.

    Examples
    --------
    In a load of a user that pulls like a rope, and breaks at 500 N:

    >>> import kanefe as kf
    >>> class Strap(kf.Load):
    ...     columns = ("tension [N]",)
    ...     screened = kf.ScreenedLoad(pull="tension [N]", strongest=500.0)
    """

    refused: str | None = None
    pull: str = ""
    strongest: float = math.inf
    forcing: float = 0.0
    slip_damping: float = 0.0
    stuck: Callable[[float], Any] | None = None


def screening_of(load: Any) -> ScreenedLoad:
    """Return what a load tells screened runs, also if it does so by attributes of its own."""
    said: ScreenedLoad = load.screened
    said = said._replace(**{new: getattr(load, old) for old, new in EARLIER.items() if hasattr(load, old)})
    if said.refused is None:
        return said._replace(refused="loads whose internal states move by themselves" if load.has_rates else "")
    return said
