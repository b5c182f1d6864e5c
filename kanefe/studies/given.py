"""What a study is given: options of its runs and functions, checked, and as text for its store."""

from __future__ import annotations

import inspect
import re
import threading
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from kanefe.errors import ModelError
from kanefe.integrate.options import RunOptions
from kanefe.studies.workers.work import OF_SCREENED, SCREENED

OPTIONS = ("build", "outputs", "table", "duration", "rtol", "simulate")
"""Arguments of `Study` whose names a parameter cannot have."""


def options(duration: float | None, rtol: float | None, simulate: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the options of the runs, checked as far as possible without a scene."""
    options = dict(simulate or {})
    for name, value in (("duration", duration), ("rtol", rtol)):
        if value is not None:
            key = "t_span" if name == "duration" else name
            if key in options:
                raise ModelError(f"{name} is given twice, also as {key} in simulate")
            options[key] = (0.0, value) if name == "duration" else value
    known = {*inspect.signature(RunOptions).parameters, "start", SCREENED}
    if options.get(SCREENED):
        known.update(OF_SCREENED)
    unknown = sorted(set(options) - known)
    if unknown:
        raise ModelError(f"simulate takes no {', '.join(unknown)}. Remedy: one of {', '.join(sorted(known))}")
    return options


def check_signature(build: Callable[..., Any], parameters: Mapping[str, Any]) -> None:
    """Raise a ModelError if build does not take the parameters, or needs others."""
    try:
        signature = inspect.signature(build)
    except (TypeError, ValueError):  # of a function in C
        return
    try:
        signature.bind(**parameters)
    except TypeError as error:
        taken = [name for name in signature.parameters if name in OPTIONS and name not in parameters]
        more = f"; {', '.join(taken)} is an option of Study: rename it, or give it in table=" if taken else ""
        raise ModelError(
            f"build{signature} does not fit the parameters {', '.join(parameters)}: {error}{more}. "
            "Remedy: the names that build takes"
        ) from error


def described(function: Any) -> dict[str, str]:
    """Return the name and the source of a function, or of the class of another callable.

    Functions from interactive input have no source; their content is in the identity nevertheless.
    """
    if isinstance(function, partial):
        inner = described(function.func)
        given = [shown(value) for value in function.args]
        given += [f"{name}={shown(value)}" for name, value in function.keywords.items()]
        return {"name": f"partial({', '.join((inner['name'], *given))})", "source": inner["source"]}
    what = function if inspect.isroutine(function) else type(function)
    try:
        # Python 3.13 finds the source of piped code, other versions do not
        source = "" if inspect.getfile(what) in ("<string>", "<stdin>") else inspect.getsource(what)
    except (OSError, TypeError):
        source = ""
    return {"name": what.__qualname__, "source": source}


def shown(value: Any) -> str:
    """Return a text of a value that is the same in all processes."""
    return _ADDRESS.sub("", repr(value))


_ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")


def check_seconds(most_seconds: Any) -> None:
    """Raise a ModelError unless this is a valid time limit or None."""
    is_number = isinstance(most_seconds, (int, float)) and not isinstance(most_seconds, bool)
    if most_seconds is not None and not (is_number and 0.0 < most_seconds < threading.TIMEOUT_MAX):
        raise ModelError(f"most_seconds must be above zero, in s, not {most_seconds!r}. Remedy: None, for no limit")
