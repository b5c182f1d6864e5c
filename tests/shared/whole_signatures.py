"""Signatures with the keywords that are written as one group: ``**options: Unpack[RunKeywords]``."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

from kanefe.arguments import _NamesOfHints


def whole_signature(function: Callable[..., Any]) -> inspect.Signature:
    """Return the signature of a function with each keyword of its group, whose defaults are not said."""
    bare = inspect.signature(function)
    *others, last = (None, *bare.parameters.values())
    found = re.search(r"Unpack\[(\w+)\]", str(getattr(last, "annotation", "")))
    if found is None:
        return bare
    plain = inspect.unwrap(function.func if isinstance(function, partial) else function)
    names = _NamesOfHints(sys.modules[plain.__module__], {})
    group = names[found[1]]
    keywords = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=..., annotation=hint.__forward_arg__)
        for name, hint in group.__annotations__.items()
    ]
    return bare.replace(parameters=[*others[1:], *keywords])
