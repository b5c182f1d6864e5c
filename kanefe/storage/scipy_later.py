"""Parts of scipy that are imported on first use: rigid scenes run without them, and start sooner.

For modules that such scenes load, instead of ``import scipy.linalg``, ``import scipy.sparse as sp`` and
``import scipy.sparse.linalg as spla``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__all__ = ["scipy", "sp", "spla"]

if TYPE_CHECKING:
    import scipy
    import scipy.interpolate
    import scipy.linalg
    import scipy.sparse as sp
    import scipy.sparse.linalg as spla
else:

    class _Later:
        """A package whose parts are imported on first use."""

        def __init__(self, name: str, parts: tuple[str, ...] = ()) -> None:
            self._name, self._parts = name, parts

        def __getattr__(self, name: str) -> Any:
            if name in self._parts:
                return import_module(f"{self._name}.{name}")
            return getattr(import_module(self._name), name)

    scipy, sp, spla = _Later("scipy", ("interpolate", "linalg")), _Later("scipy.sparse"), _Later("scipy.sparse.linalg")
