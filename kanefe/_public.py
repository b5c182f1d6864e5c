"""Public names of a package, read from the imports that its `__init__` shows to type checkers.

A method such as ``body.report()`` belongs to an object of a lower layer, its function to a higher one. The method gets
its function by name from `served`; `kanefe/__init__.py` names the module that has it.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

SERVED: dict[str, str] = {}
"""Modules of the functions of upper rooms that methods of lower ones call."""


def served(name: str) -> Callable[..., Any]:
    """Return a function of an upper room; its module is imported now."""
    return getattr(import_module(SERVED[name]), name)


def homes(path: str, name: str = "") -> dict[str, str]:
    """Return the module of each name that a file imports by lines ``from x import name as name``.

    A star stands for all such names of that package, so that additions to `kanefe.joints` and the like are public.

    Parameters
    ----------
    path : str
        The file ``__init__.py`` of a package.
    name : str, optional
        Of the package; default: that of the folder.
    """
    found: dict[str, str] = {}
    package = Path(path).parent
    name = name or package.name
    for line in Path(path).read_text(encoding="utf-8").splitlines():
        word, _, rest = line.strip().partition(" ")
        module, _, names = rest.partition(" import ")
        if word != "from" or not module.startswith(f"{name.partition('.')[0]}."):
            continue
        if names.startswith("*"):
            room = package.parents[name.count(".")].joinpath(*module.split("."))
            found |= dict.fromkeys(homes(str(room / "__init__.py"), module), module)
        elif (words := names.split())[1:] == ["as", words[0]]:
            found[words[0]] = module
    return found


def lazy(path: str, namespace: dict[str, Any]) -> tuple[list[str], Callable[[str], object], Callable[[], list[str]]]:
    """Return the names, `__getattr__` and `__dir__` of a package whose names are imported when they are first used."""
    name_of_package = namespace["__name__"]
    modules = homes(path, name_of_package)
    rooms = f"from {name_of_package} import {{0}} as {{0}}"
    text = Path(path).read_text(encoding="utf-8")

    def imported(name: str) -> object:
        if rooms.format(name) in text:  # a package whose own names are public
            return import_module(f"{name_of_package}.{name}")
        if name not in modules:
            raise AttributeError(f"module {name_of_package!r} has no attribute {name!r}")
        namespace[name] = getattr(import_module(modules[name]), name)
        return namespace[name]

    return list(modules), imported, lambda: sorted(namespace.get("__all__", modules))
