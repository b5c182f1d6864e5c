"""Checkpoints of a run on its way: what is kept from time to time, and when it is written."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING

from kanefe.errors import FileError, SimulationWarning, outside
from kanefe.integrate.clock import Clock
from kanefe.integrate.stepper import Stepper

if TYPE_CHECKING:
    from kanefe.integrate.checkpoint import CheckpointFile, Progress


class Checkpoints:
    """Those of a run, if it has a file.

    Parameters
    ----------
    file : CheckpointFile or None
    progress : function
        Returns how far the run has come.
    clock : Clock
    stepper : Stepper
        At whose time they are.
    """

    def __init__(
        self, file: CheckpointFile | None, progress: Callable[[], Progress], clock: Clock, stepper: Stepper
    ) -> None:
        self._file, self._progress, self._clock, self._stepper = file, progress, clock, stepper
        self._kept: tuple[float, Progress] | None = None

    def begin(self) -> None:
        """Write the first one; raise a FileError if that is not possible."""
        if self._file is not None:
            self._kept = time.monotonic(), self._progress()
            self.write(is_first=True)

    def keep(self, every: float) -> None:
        """Keep how far the run has come from time to time (s): an error in a step must not reach the file."""
        now = time.monotonic()
        if self._file is not None and (self._kept is None or now - self._kept[0] >= every):
            self._kept = now, self._progress()
            if self._file.is_due:
                self.write()

    def end(self, is_at_end: bool) -> None:
        """Write the last one: of the end where the run stands there, else of a moment before."""
        if self._file is not None and is_at_end:
            self._kept = 0.0, self._progress()
        self.write()

    def write(self, is_first: bool = False) -> None:
        """Write what is kept; but at first, a warning tells that it cannot be written."""
        if self._file is None or self._kept is None:
            return
        with self._clock.part("checkpoints"):
            try:
                self._file.write(self._kept[1])
            except FileError as error:
                if is_first:
                    raise
                warnings.warn(
                    f"no checkpoint at t = {self._stepper.t:.6g} s: {error}", SimulationWarning, stacklevel=outside()
                )
