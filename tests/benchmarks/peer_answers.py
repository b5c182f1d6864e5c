"""Answers of a peer in an environment of its own to requests over pipes, a line of JSON each."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from typing import Any

Answer = dict[str, Any]

# What the libraries print must not get between the answers: import this before them.
ANSWERS = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)


def answer_requests(*functions: Callable[..., Answer]) -> None:
    """Answer by functions of these names until there are no more requests."""
    known = {function.__name__: function for function in functions}
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = known[request.pop("do")](**request)
        except Exception as error:  # noqa: BLE001  (the other side tells of it)
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=ANSWERS, flush=True)
