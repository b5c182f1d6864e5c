"""How a study gets on, for who waits."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from kanefe.storage import watched


class Bar:
    """Counts cases; silent without a bar of tqdm."""

    def __init__(self, bar: Any = None) -> None:
        self._bar = bar

    def update(self, cases: int, failures: int) -> None:
        """Take in cases that are done, and how many failed so far."""
        if self._bar is not None:
            if failures:
                self._bar.set_postfix_str(f"{failures} failed", refresh=False)
            self._bar.update(cases)


@contextmanager
def progress_bar(wanted: bool | None, total: int, done: int) -> Iterator[Bar]:
    """Show a bar of cases with the time left; none off a terminal, unless it is wanted."""
    if not (watched.is_watched() if wanted is None else wanted):
        yield Bar()
        return
    layout = "{desc}: {percentage:3.0f}%|{bar}| {n}/{total} cases [{elapsed}<{remaining}{postfix}]"
    with watched.progress_bar(total=total, initial=done, desc="study", bar_format=layout, leave=False) as bar:
        yield Bar(bar)
