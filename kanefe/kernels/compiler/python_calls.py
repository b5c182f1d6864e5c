"""Functions in Python that kernels call as they call each other."""

import ctypes
from collections.abc import Callable

import numpy as np

from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler.addresses import stand_in
from kanefe.kernels.compiler.arrays import Prepared


class PythonCall:
    """A function that kernels call, as long as this object is kept.

    Parameters
    ----------
    function : function
        Without arguments: it reads and writes what the kernel knows too.
    """

    def __init__(self, function: Callable[[], None]) -> None:
        self._function = function
        self._raised: BaseException | None = None
        if IS_COMPILED:
            self._code = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(self._call)
            address = ctypes.cast(self._code, ctypes.c_void_p).value or 0
        else:
            address = stand_in(self._call)
        self._prepared = Prepared(address, np.zeros(1, dtype=np.int64), np.zeros(1))

    def for_kernels(self) -> Prepared:
        """Return the call as kernels take it."""
        return self._prepared

    def raise_again(self) -> None:
        """Raise what the function has raised, which kernels cannot pass on; once."""
        raised, self._raised = self._raised, None
        if raised is not None:
            raise raised

    def _call(self, *_: object) -> None:
        try:
            self._function()
        except BaseException as error:  # noqa: BLE001  # raised again where Python goes on
            self._raised = error
