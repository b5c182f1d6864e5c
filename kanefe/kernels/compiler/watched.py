"""Processes that build for another end with it."""

import ctypes
import signal
import sys

PARENT_DEATH_SIGNAL = 1
"""Number of a request to Linux's prctl: that for the signal which a process gets when its parent ends."""


def end_with_parent() -> None:
    """Have the system end this process when the one that made it ends, where it can (Linux)."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PARENT_DEATH_SIGNAL, signal.SIGKILL)
