"""Poses that functions of the user give, called by kernels as they call those of the house."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.joints.link import LinkKernel
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler.addresses import stand_in
from kanefe.kernels.links.places import WrittenMotion

if TYPE_CHECKING:
    from kanefe.joints.given_pose import GivenPose

WRITTEN = WrittenMotion.number_count


class PoseInPython:
    """The functions of a link that ask a pose for its values, as long as this object is kept.

    Where the pose raises an error, which kernels cannot pass on, no numbers are written: for what is not finite the
    pose is asked again from Python, and raises it there. Ctrl-C comes once, and is kept until then.

    Parameters
    ----------
    pose : GivenPose
    """

    def __init__(self, pose: GivenPose) -> None:
        self._pose = pose
        self._interrupt: BaseException | None = None
        self._codes = [self._code(self._put_real), self._code(self._put_complex)]

    def kernel(self) -> LinkKernel:
        """Return the functions as a link has them."""
        if IS_COMPILED:
            real, complex_ = (ctypes.cast(code, ctypes.c_void_p).value or 0 for code in self._codes)
        else:
            real, complex_ = self._codes
        return LinkKernel(real, np.zeros(0), complex_)

    def _code(self, put: Any) -> Any:
        if not IS_COMPILED:
            return stand_in(lambda numbers, q, out: np.copyto(out, self._written(float(q[0].real))))
        return ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)(put)

    def _put_real(self, _: int, q: int, out: int) -> None:
        found = (ctypes.c_double * WRITTEN).from_address(out)
        found[:] = self._written(ctypes.c_double.from_address(q).value).tolist()

    def _put_complex(self, _: int, q: int, out: int) -> None:
        """Write pairs of real and imaginary part: the time is never complex."""
        found = (ctypes.c_double * (2 * WRITTEN)).from_address(out)
        found[::2] = self._written(ctypes.c_double.from_address(q).value).tolist()

    def _written(self, t: float) -> np.ndarray:
        """Return what a link writes, its velocities and accelerations for partial ones (Eq. 13-16)."""
        try:
            p, v, a, A, w, dw = self._pose.at(t)
            return np.concatenate((p, A.ravel(), v, A @ w, a, A @ dw))
        except Exception:  # noqa: BLE001  # raised again where Python goes on
            return np.full(WRITTEN, np.nan)
        except BaseException as interrupt:  # noqa: BLE001  # likewise, by `raise_interrupt`
            self._interrupt = interrupt
            return np.full(WRITTEN, np.nan)

    def raise_interrupt(self) -> None:
        """Raise Ctrl-C that came while a kernel asked; once."""
        interrupt, self._interrupt = self._interrupt, None
        if interrupt is not None:
            raise interrupt
