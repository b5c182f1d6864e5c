"""Terminal or notebook, and progress bars for either."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from importlib.util import find_spec
from typing import Any, TypeVar

Part = TypeVar("Part")

LONG = 2.0
"""Time after which work that is usually short shows a bar, s."""

DELAY = 0.5
"""Time after which a notebook shows a bar, s: shorter work shows none."""


def is_notebook() -> bool:
    """Return whether the code runs in a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell is not None and getattr(shell, "kernel", None) is not None


def is_watched() -> bool:
    """Return whether output is shown while the code runs: on a terminal or in a notebook."""
    return sys.stderr.isatty() or is_notebook()


def long_work(what: str, parts: Iterable[Part], total: int | None = None) -> Iterable[Part]:
    """Return the parts of some work, with a bar of the time left once it has taken long; see `is_watched`.

    Parameters
    ----------
    what : str
        Name of the work, for the bar.
    parts : iterable
    total : int, optional
        Number of parts, where they have no length.
    """
    if not is_watched():
        return parts
    layout = "{desc}: {percentage:3.0f}%|{bar}| [{elapsed}<{remaining}]"
    bar: Iterable[Part] = progress_bar(
        iterable=parts, total=total, desc=what, bar_format=layout, leave=False, delay=LONG
    )
    return bar


def progress_bar(**options: Any) -> Any:
    """Return a bar of tqdm: a widget in a notebook that has them, else text."""
    from tqdm import tqdm

    if not is_notebook():
        return tqdm(**options)
    if find_spec("ipywidgets") is not None:
        from tqdm.notebook import tqdm
    return tqdm(**{"delay": DELAY} | options)
