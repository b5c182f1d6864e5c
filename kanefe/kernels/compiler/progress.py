"""The share of a build that is done, by time: what each library takes was measured, and is kept with the code."""

import time
from collections.abc import Callable, Sequence

from kanefe.kernels.compiler.libraries import Library

EVERY = 5.0
"""Time between two lines of progress, s; on a terminal one line is written anew each second."""

ALMOST = 0.97
"""Share of a library beyond which time alone does not count it as done."""


class BuildProgress:
    """What is done of libraries that are being built.

    Parameters
    ----------
    libraries : sequence of Library
    jobs : int
        How many are built side by side.
    say : function (str)
    """

    def __init__(self, libraries: Sequence[Library], jobs: int, say: Callable[[str], None]) -> None:
        self._seconds = {one.name: one.seconds for one in libraries}
        self._jobs, self._say = jobs, say
        self._began = self._said = time.monotonic()
        self._share = dict.fromkeys(self._seconds, 0.0)  # as far as the builders have told
        self._since: dict[str, float] = {}  # when they told
        self._ends: dict[str, float] = {}
        say(f"preparing the solver, once: about {self.expected:.0f} s ({', '.join(self._seconds)})")

    @property
    def expected(self) -> float:
        """How long it takes in all on the machine where it was measured, s."""
        return max(sum(self._seconds.values()) / self._jobs, *self._seconds.values())

    @property
    def share(self) -> float:
        """What is done, from 0 to 1."""
        now, done = time.monotonic(), 0.0
        for name, seconds in self._seconds.items():
            share = self._share[name]
            if 0.0 <= share < 1.0 and name in self._since:
                by_time = share + (now - self._since[name]) / seconds
                share = max(share, min(by_time, self._ends.get(name, ALMOST), ALMOST))
            done += seconds * share
        return done / sum(self._seconds.values())

    def note(self, name: str, line: str) -> None:
        """Take a line of a builder: its share now and after the next step, or that it is done; none when it begins."""
        if line.startswith("done"):
            self._share[name] = 1.0
        elif line:
            share, after = line.split()
            self._share[name], self._ends[name] = float(share), float(after)
        self._since[name] = time.monotonic()
        self.tell()

    def tell(self) -> None:
        """Say how much is done, if that is due."""
        now = time.monotonic()
        if now - self._said >= EVERY:
            self._said = now
            self._say(f"preparing the solver: {100 * self.share:.0f} % after {now - self._began:.0f} s")

    def end(self) -> None:
        """Say that all is done."""
        self._say(f"the solver is prepared, in {time.monotonic() - self._began:.0f} s")
