"""Memory of this process."""

from __future__ import annotations

import resource


def bytes_now() -> float:
    """Return the largest memory that this process has had, bytes."""
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
