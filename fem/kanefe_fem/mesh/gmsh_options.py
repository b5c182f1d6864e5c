"""Options of gmsh that a source sets, put back afterwards: they are those of the process, not of a model."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterator
from typing import Any

_KINDS = ("Number", "String", "Color")

_ASSIGNED = re.compile(r"^\s*([A-Z]\w*\.[A-Z]\w*(?:\.\w+)?)\s*[-+*/]?=", re.MULTILINE)


@contextlib.contextmanager
def kept_options(gmsh: Any, script: str) -> Iterator[None]:
    """Put the options back that the commands of a script, or calls of ``gmsh.option.set...``, change meanwhile."""
    found: dict[tuple[str, str], Any] = {}
    setters = {name: getattr(gmsh.option, name) for name in _setters() if hasattr(gmsh.option, name)}

    def remember(kind: str, option: str) -> None:
        if (kind, option) not in found:
            with contextlib.suppress(Exception):  # gmsh raises bare Exception, of an option that is not there
                found[kind, option] = getattr(gmsh.option, f"get{kind}")(option)

    def recording(kind: str, setter: Callable[..., Any]) -> Callable[..., Any]:
        def recorded(name: str, *values: Any) -> Any:
            remember(kind, name)
            return setter(name, *values)

        return recorded

    for option in dict.fromkeys(_ASSIGNED.findall(script)):
        for kind in _KINDS:
            remember(kind, option.replace("Color.", "") if kind == "Color" else option)
    gmsh.logger.stop()  # discards the errors of options of another kind
    gmsh.logger.start()
    for name, setter in setters.items():
        setattr(gmsh.option, name, staticmethod(recording(_setters()[name], setter)))
    try:
        yield
    finally:
        for name, setter in setters.items():
            setattr(gmsh.option, name, staticmethod(setter))
        for (kind, option), value in found.items():
            values = value[:4] if kind == "Color" else (value,)
            with contextlib.suppress(Exception):  # some options can only be read
                setters[f"set{kind}"](option, *values)


def _setters() -> dict[str, str]:
    """Return the kind of option that each function of ``gmsh.option`` sets."""
    return {name: kind for kind in _KINDS for name in (f"set{kind}", f"set_{kind.lower()}")}
