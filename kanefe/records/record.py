"""What is to be recorded of a run: channels, and when."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Literal, get_args

from kanefe.errors import ModelError
from kanefe.integrate.trajectory import is_finite_number
from kanefe.scene.targets import Named, asked_for

Keep = Literal["values", "extremes"]
"""Values of a channel that are kept: all, or only the least and the largest one."""


@dataclass(frozen=True)
class Record:
    """Channels to be recorded during a run: see ``record=`` of `kanefe.System.simulate`.

    Parameters
    ----------
    channels : str, sequence or mapping of str
        As for `kanefe.Result.to_dataframe`: ``"position arm/tip x"``, ``"joint_reaction arm"``. A mapping gives other
        names.
    step : float, optional
        Time between the values, s; default: the output times.
    at : str or sequence of str
        Names of events: only the values just before these are recorded.
    keep : "values" or "extremes"
        With "extremes" only the least and the largest of the values, and their times.

    Raises
    ------
    ModelError
        If an argument is not valid.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, -9.81, 0))
    >>> rod = scene.add_rigid_body("rod", mass=1.0, inertia=1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    >>> load = kf.Record("joint_reaction rod force_y", step=1e-4, keep="extremes")
    >>> result = scene.simulate((0.0, 2.0), record=["position rod", load])
    >>> result.records["joint_reaction rod force_y"].values.shape
    (2,)
    """

    channels: Named
    step: float | None = None
    at: str | Sequence[str] = ()
    keep: Keep = "values"

    def __post_init__(self) -> None:
        for _, text in asked_for(self.channels):
            if not isinstance(text, str) or not text.strip():
                raise ModelError(f"a channel of a record must be a text, such as 'position arm x', not {text!r}")
        if not asked_for(self.channels):
            raise ModelError("a record without channels. Remedy: at least one, such as 'position arm x'")
        if self.step is not None and not (is_finite_number(self.step) and self.step > 0):
            raise ModelError(f"step of a record must be above zero s, not {self.step!r}")
        is_list = isinstance(self.at, Collection) and not isinstance(self.at, (Mapping, Set))
        if not is_list or any(not isinstance(name, str) for name in self.events):
            raise ModelError(f"at of a record must be names of events, not {self.at!r}")
        if self.events and self.step is not None:
            raise ModelError("a record has step= or at=, not both. Remedy: two records")
        if not isinstance(self.keep, str) or self.keep not in get_args(Keep):
            raise ModelError(f"keep of a record must be one of {', '.join(get_args(Keep))}, not {self.keep!r}")

    @property
    def events(self) -> tuple[str, ...]:
        """Names of the events at which it records."""
        return (self.at,) if isinstance(self.at, str) else tuple(self.at)


def records_of(asked: object) -> tuple[Record, ...]:
    """Return the records of an argument ``record=``: texts together are one, at the output times.

    Raises
    ------
    ModelError
        If it is no channel, no record, and no sequence of these.
    """
    if isinstance(asked, (str, dict)):
        return (Record(asked),)
    if isinstance(asked, Record):
        return (asked,)
    if not isinstance(asked, (list, tuple)):
        raise ModelError(f"record must be channels, such as 'position arm x', or kanefe.Record(...), not {asked!r}")
    texts = [one for one in asked if isinstance(one, str)]
    wrong = [one for one in asked if not isinstance(one, (str, Record))]
    if wrong:
        raise ModelError(
            f"record must list channels, such as 'position arm x', or kanefe.Record(...), not {wrong[0]!r}"
        )
    return (*((Record(texts),) if texts else ()), *(one for one in asked if isinstance(one, Record)))
