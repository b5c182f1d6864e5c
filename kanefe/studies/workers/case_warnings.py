"""The warnings of a case, also where several run in threads of one process."""

from __future__ import annotations

import threading
import warnings
from typing import Any

_lock = threading.Lock()
_thread = threading.local()
_users = 0
_shown: Any = None
_filters: Any = None


class CaseWarnings:
    """Collects the warnings of this thread; the others' go where they went.

    Attributes
    ----------
    texts : list of str
        Each warning once, as ``Category: text``, in the order in which they came. Those of files left open, which
        depend on when the garbage collector comes by, go where they went.

    Examples
    --------
    >>> with Told() as told:
    ...     warnings.warn("it is late", UserWarning, stacklevel=1)
    >>> told.texts
    ['UserWarning: it is late']
    """

    def __init__(self) -> None:
        self.texts: list[str] = []
        self._is_open = False

    def __enter__(self) -> CaseWarnings:
        global _users, _shown, _filters
        with _lock:
            self._is_open = True
            _users += 1
            if _users == 1:
                _filters = warnings.catch_warnings()
                _filters.__enter__()
                warnings.simplefilter("always")
                _shown, warnings.showwarning = warnings.showwarning, _show
        _thread.told = self
        return self

    def __exit__(self, *error: object) -> None:
        _thread.told = None
        self.close()

    def close(self) -> None:
        """Let warnings go where they went; from another thread, too, which leaves this one behind."""
        global _users
        with _lock:
            if not self._is_open:
                return
            self._is_open = False
            _users -= 1
            if _users == 0:
                _filters.__exit__(None, None, None)  # which puts showwarning back, too

    def add(self, text: str) -> None:
        """Take in a warning."""
        if text not in self.texts:
            self.texts.append(text)


def _show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
    told = getattr(_thread, "told", None)
    # files that are left open are told when the garbage collector comes by, in whichever case that is
    if told is None or issubclass(category, ResourceWarning):
        _shown(message, category, *place, **more)
    else:
        told.add(f"{category.__name__}: {message}")
