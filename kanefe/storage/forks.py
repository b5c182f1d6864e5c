"""Children that are forked while another thread simulates.

What that thread has locked is locked in the child for ever, since the thread is not there. Before Python 3.12 this
holds for each ``functools.cached_property`` too, whose lock all objects of its class share.
"""

from __future__ import annotations

import os
import sys
from functools import cached_property
from threading import RLock
from types import ModuleType

_LOCK = type(RLock())
_PACKAGES = ("kanefe", "kanefe_fem")


def renew_locks_in_children() -> None:
    """Give modules, and properties of classes, new locks in each child that is forked from now on."""
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=_renew_locks)


def _renew_locks() -> None:
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] in _PACKAGES:
            _renew_locks_of(module)


def _renew_locks_of(module: ModuleType) -> None:
    for name, held in list(vars(module).items()):
        if isinstance(held, _LOCK):
            setattr(module, name, RLock())
        elif isinstance(held, type) and sys.version_info < (3, 12):
            for attribute in vars(held).values():
                if isinstance(attribute, cached_property):
                    attribute.lock = RLock()  # type: ignore[attr-defined]
