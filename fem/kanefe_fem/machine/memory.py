"""The free memory, and what meshes and factors take of it."""

from __future__ import annotations

from pathlib import Path

from kanefe.errors import ModelError
from kanefe.storage.files import LARGEST_SHARE, usable_memory

SHARE = 0.9
"""Fraction of the free memory that a factorisation may take without a warning."""


class MemoryWarning(UserWarning):
    """A computation needs more memory than the machine has."""


BYTES_OF_A_NODE = 88
"""Memory of a mesh per node, bytes: three coordinates, and the eight nodes of its cell."""


def check_size(nodes: int, what: str) -> None:
    """Raise a ModelError that begins with `what` if a mesh of so many nodes does not fit into memory."""
    needed, usable = BYTES_OF_A_NODE * min(nodes, 10**30), LARGEST_SHARE * usable_memory()
    if needed > usable:
        raise ModelError(
            f"{what}: a mesh of so many nodes takes {needed / 2**30:.3g} GiB, but only {usable / 2**30:.3g} GiB are "
            "available here. Remedy: fewer"
        )


def free_memory() -> float | None:
    """Return the free memory of this machine or of the control group of this process, in bytes; None if unknown."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        free = 1024.0 * next(float(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    except (OSError, StopIteration, ValueError, IndexError):
        return None
    group = Path("/sys/fs/cgroup")
    try:
        limit, used = ((group / name).read_text().strip() for name in ("memory.max", "memory.current"))
        return free if limit == "max" else min(free, float(limit) - float(used))
    except (OSError, ValueError):
        return free


def rough_size(unknowns: int) -> float:
    """Return an upper bound, in bytes, of the factor of the stiffness of a solid with so many unknowns.

    The factor of a body with n unknowns in space has about ``c n^(4/3)`` entries, with c about 10 for slender bodies of
    quadratic tetrahedra and 25 for a cube.
    """
    return 8.0 * 30.0 * float(unknowns) ** (4.0 / 3.0)
