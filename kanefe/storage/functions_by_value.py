"""The door to cloudpickle: pickles of objects with functions that other processes cannot import."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any


def dumps_by_value() -> Callable[[Any], bytes] | None:
    """Return `cloudpickle.dumps`, which also pickles functions of scripts; None if it is not installed."""
    if find_spec("cloudpickle") is None:
        return None
    import cloudpickle

    return cloudpickle.dumps  # type: ignore[no-any-return]
