"""Who looks on, a terminal or a notebook, and the progress bars of either."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from typing import Any

DELAY = 0.5
"""Time after which a notebook shows a bar, s: shorter work leaves no trace in its outputs."""


def is_notebook() -> bool:
    """Return whether the code runs in a notebook, which shows what a cell returns."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell is not None and getattr(shell, "kernel", None) is not None


def is_watched() -> bool:
    """Return whether somebody sees what is printed while it runs."""
    return sys.stderr.isatty() or is_notebook()


def progress_bar(**options: Any) -> Any:
    """Return a bar of tqdm: of a notebook, if it has the widgets for one, else of text."""
    from tqdm import tqdm

    if not is_notebook():
        return tqdm(**options)
    if find_spec("ipywidgets") is not None:
        from tqdm.notebook import tqdm as tqdm_of_notebooks

        return tqdm_of_notebooks(**options, delay=DELAY)
    return tqdm(**options, delay=DELAY)
