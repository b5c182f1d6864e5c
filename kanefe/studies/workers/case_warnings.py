"""The warnings of a case, also if several cases run in threads of one process."""

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
    """Collects the warnings of this thread; those of other threads are shown as before.

    Attributes
    ----------
    texts : list of str
        Each warning once, as ``Category: text``, in order. Warnings of unclosed files, which depend on the garbage
        collector, are shown as before.

    Examples
    --------
    >>> with CaseWarnings() as collected:
    ...     warnings.warn("it is late", UserWarning, stacklevel=1)
    >>> collected.texts
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
        _thread.collector = self
        return self

    def __exit__(self, *error: object) -> None:
        _thread.collector = None
        self.close()

    def close(self) -> None:
        """Show warnings as before; also called from another thread that abandons this one."""
        global _users
        with _lock:
            if not self._is_open:
                return
            self._is_open = False
            _users -= 1
            if _users == 0:
                _filters.__exit__(None, None, None)  # which also restores showwarning

    def add(self, text: str) -> None:
        """Record a warning."""
        if text not in self.texts:
            self.texts.append(text)


def _show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
    collector = getattr(_thread, "collector", None)
    # unclosed files are reported when the garbage collector runs, which may be in another case
    if collector is None or issubclass(category, ResourceWarning):
        _shown(message, category, *place, **more)
    else:
        collector.add(f"{category.__name__}: {message}")
