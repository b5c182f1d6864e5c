"""Terminal or notebook, and progress bars for either."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from typing import Any

DELAY = 0.5
"""Time after which a notebook shows a bar, s: shorter work shows none."""


def is_notebook() -> bool:
    """Return whether the code runs in a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell is not None and getattr(shell, "kernel", None) is not None


def is_watched() -> bool:
    """Return whether output is shown while the code runs: on a terminal or in a notebook."""
    return sys.stderr.isatty() or is_notebook()


def progress_bar(**options: Any) -> Any:
    """Return a bar of tqdm: a widget in a notebook that has them, else text."""
    from tqdm import tqdm

    if not is_notebook():
        return tqdm(**options)
    if find_spec("ipywidgets") is not None:
        from tqdm.notebook import tqdm
    return tqdm(**options, delay=DELAY)
