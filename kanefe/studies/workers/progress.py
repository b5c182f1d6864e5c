"""Progress bar of a study."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from kanefe.storage import watched


class Bar:
    """Counts cases; does nothing without a bar of tqdm."""

    def __init__(self, bar: Any = None) -> None:
        self._bar = bar

    def update(self, cases: int, failures: int) -> None:
        """Add cases that are done; `failures` is the total number of failed cases."""
        if self._bar is not None:
            if failures:
                self._bar.set_postfix_str(f"{failures} failed", refresh=False)
            self._bar.update(cases)


@contextmanager
def progress_bar(wanted: bool | None, total: int, done: int) -> Iterator[Bar]:
    """Show a bar of cases with the time left; without a terminal only if it is wanted."""
    if not (watched.is_watched() if wanted is None else wanted):
        yield Bar()
        return
    layout = "{desc}: {percentage:3.0f}%|{bar}| {n}/{total} cases [{elapsed}<{remaining}{postfix}]"
    with watched.progress_bar(total=total, initial=done, desc="study", bar_format=layout, leave=False) as bar:
        yield Bar(bar)
