"""How a run ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from kanefe.errors import SimulationError

Kind = Literal["finished", "stopped", "failed"]


@dataclass(frozen=True)
class RunStatus:
    """How a run ended, and what to do about it. Its text is one or two sentences.

    Attributes
    ----------
    kind : "finished", "stopped" or "failed"
        Stopped: by a terminal event or a limit that the call gave. Failed: it could not go on.
    time : float
        Up to which there are results, s.
    reason : str
        Why it ended before the end of the span; empty if it did not.
    remedy : str
        What to try.

    Examples
    --------
    >>> status = RunStatus("failed", 0.5, "no step is small enough", "check loads for jumps")
    >>> print(status)
    the run failed at t = 0.5 s: no step is small enough. Remedy: check loads for jumps
    >>> status.is_finished
    False
    """

    kind: Kind
    time: float
    reason: str = ""
    remedy: str = ""

    @property
    def is_finished(self) -> bool:
        """Whether the whole span was run."""
        return self.kind == "finished"

    def raise_if_failed(self) -> None:
        """Raise a SimulationError with the text of this status if the run failed."""
        if self.kind == "failed":
            raise SimulationError(str(self))

    def __str__(self) -> str:
        text = f"the run {'' if self.is_finished else 'was ' if self.kind == 'stopped' else ''}{self.kind}"
        text += f" at t = {self.time:.6g} s"
        if self.reason:
            text += f": {self.reason}"
        return text + (f". Remedy: {self.remedy}" if self.remedy else "")

    @classmethod
    def of_error(cls, time: float, error: Exception) -> RunStatus:
        """Return the status of a run that an error ended, whose text may hold a remedy."""
        reason, _, remedy = str(error).partition(". Remedy: ")
        return cls("failed", time, reason, remedy or "check what the functions of the scene give there")
