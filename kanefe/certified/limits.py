"""Limits of time and memory of a search."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, eq=False)
class Limits:
    """What a search may take.

    Attributes
    ----------
    seconds : float or None
        By the wall clock, s.
    memory : float or None
        Of this process, bytes.
    """

    seconds: float | None = None
    memory: float | None = None

    def too_little_memory(self, name: str, grows: float) -> str:
        """Return why a source is not raised, whose next level multiplies the memory in use; else empty."""
        if self.memory is None:
            return ""
        now = bytes_now()
        if now * grows <= self.memory:
            return ""
        return (
            f"most_memory={self.memory:g} bytes were not enough: the process has {now:.3g}, and raising {name} may "
            f"take {now * grows:.2g}"
        )


def bytes_now() -> float:
    """Return the largest memory that this process has had, bytes; 0 where the system does not tell."""
    try:
        import resource
    except ImportError:  # Windows
        return 0.0
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
