"""Processors that machine code is made for: this one, and the generations that a wheel serves."""

import hashlib
import os
import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

from kanefe.storage.files import cache_folder


class Generation(NamedTuple):
    """Processors that a wheel has machine code for.

    Attributes
    ----------
    features : str
        What they need of those features that `/proc/cpuinfo` tells.
    compiler_name : str
        What the compiler calls them.
    """

    features: str
    compiler_name: str


GENERATIONS = {
    "x86-64-v3": Generation("avx avx2 bmi1 bmi2 f16c fma movbe", "haswell"),
    "x86-64": Generation("sse2", "x86-64"),
}
"""Processor generations for which wheels are made, best first."""


def processors_here() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def generations_here() -> list[str]:
    """Return the generations of processors that this one belongs to, best first."""
    can = set(_features().split())
    return [name for name, of in GENERATIONS.items() if can.issuperset(of.features.split())]


@cache
def own_folder() -> Path:
    """Return the folder of machine code that is made for this processor."""
    machine = _machine()
    processor = hashlib.sha256(f"{machine} {_features()}".encode()).hexdigest()[:8]
    return folder_for(f"{machine}-{processor}")


def folder_for(processors: str) -> Path:
    """Return the folder of machine code in the cache that is made for some processors: a generation, or this one."""
    return cache_folder() / "kernels" / processors


def _machine() -> str:
    if hasattr(os, "uname"):
        return os.uname().machine
    import platform  # 2 ms of a new process

    return platform.machine()


@cache
def _features() -> str:
    """Return what the processor has beyond the least of its kind, as Linux names it."""
    try:
        with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
            flags = re.search(r"^(?:flags|Features)\s*:(.*)$", file.read(20_000), re.MULTILINE)
    except OSError:
        flags = None
    if flags:
        return flags[1]
    import platform

    return platform.processor()
