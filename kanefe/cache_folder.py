"""Where kanefe keeps what can be made again: compiled kernels and flexible bodies."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder() -> Path:
    """Return the folder of the cache: ``KANEFE_CACHE_DIR``, else kanefe's folder in the cache of the user.

    It need not be there yet.
    """
    chosen = os.environ.get("KANEFE_CACHE_DIR")
    if chosen:
        return Path(chosen).expanduser()
    import platformdirs

    return Path(platformdirs.user_cache_dir("kanefe"))
