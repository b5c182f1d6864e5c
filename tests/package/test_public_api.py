"""What users call: names, signatures, members and commands, compared with a snapshot of them.

A change that is meant is written down with ``PYTHONPATH=.:fem:tests/shared python tests/package/test_public_api.py``,
which makes the snapshot anew; its difference then shows what changes for users. The snapshot knows no module paths and
no annotations, so that files may move and types be sharpened; what counts of a parameter is its name, its kind and its
default.
"""

from __future__ import annotations

import ast
import inspect
import json
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cached_property
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from repository import ROOT
from whole_signatures import whole_signature

SNAPSHOT = Path(__file__).with_name("public_api.json")
PACKAGES = ("kanefe", "kanefe.fatigue", "kanefe.studies", "kanefe_fem")

SPOKEN = {"__call__", "__contains__", "__enter__", "__exit__", "__getitem__", "__iter__", "__len__"}
"""Special methods that users call by writing something else; those that Python makes by itself are left out."""


class Written:
    """A default that stands in a signature as the given text."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def written(value: Any) -> str:
    """Return a default as text, the same with every version of Python and numpy."""
    if value is ...:  # of a keyword in a group
        return "..."
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, np.ndarray):
        return f"array({value.tolist()})"
    if isinstance(value, Enum):
        return f"{type(value).__name__}.{value.name}"
    if value is None or isinstance(value, (bool, int, float, complex, str, bytes)):
        return repr(value)
    if isinstance(value, (tuple, list)):
        inner = ", ".join(map(written, value))
        comma = "," if len(value) == 1 else ""
        return f"({inner}{comma})" if isinstance(value, tuple) else f"[{inner}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{written(k)}: {written(v)}" for k, v in value.items()) + "}"
    if is_dataclass(value) and not isinstance(value, type):
        parts = (f"{f.name}={written(getattr(value, f.name))}" for f in fields(value) if f.repr)
        return f"{type(value).__name__}({', '.join(parts)})"
    if isinstance(value, type) or callable(value):
        return getattr(value, "__qualname__", type(value).__name__)
    # the mark of a field that has a factory is private to Python
    return "<factory>" if repr(value) == "<factory>" else f"<{type(value).__name__}>"


def signature(function: Callable[..., Any]) -> str:
    """Return the parameters without annotations."""
    bare = whole_signature(function)
    parameters = [
        p.replace(annotation=p.empty, default=p.empty if p.default is p.empty else Written(written(p.default)))
        for p in bare.parameters.values()
    ]
    return str(bare.replace(parameters=parameters, return_annotation=bare.empty))


def is_ours(cls: type) -> bool:
    return cls.__module__.partition(".")[0] in PACKAGES


def set_in_init(cls: type) -> list[str]:
    """Return the attributes that the constructor of a class assigns."""
    if "__init__" not in vars(cls) or is_dataclass(cls):
        return []
    tree = ast.parse(textwrap.dedent(inspect.getsource(vars(cls)["__init__"])))
    found = (node for node in ast.walk(tree) if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store))
    return [node.attr for node in found if ast.unparse(node.value) == "self"]


def member(value: Any) -> str:
    """Return the kind of an attribute of a class, and its signature."""
    if isinstance(value, (property, cached_property)):
        return "property"
    if isinstance(value, (classmethod, staticmethod)):
        return f"{type(value).__name__} {signature(value.__func__)}"
    if inspect.isfunction(value):
        return f"method {signature(value)}"
    return "attribute"


def members(cls: type, public: set[type]) -> Iterator[tuple[str, str]]:
    """Yield (name, description) of what users may call on a class; inherited members too, but nothing of Python's."""
    found: dict[str, str] = {}
    for base in reversed([base for base in cls.__mro__ if is_ours(base)]):
        found |= dict.fromkeys([*inspect.get_annotations(base), *set_in_init(base)], "attribute")
        found |= {name: member(value) for name, value in vars(base).items()}
    if is_dataclass(cls):
        found |= {f.name: "field" for f in fields(cls)}
    for name in sorted(found):
        if name in SPOKEN or not name.startswith("_"):
            yield name, found[name]
    known = [base.__name__ for base in cls.__mro__[1:-1] if base in public or base.__module__ == "builtins"]
    if known:
        yield "(bases)", ", ".join(known)


def describe(name: str, thing: Any, public: set[type]) -> Iterator[tuple[str, str]]:
    """Yield (name, description) of a public name and of all below it."""
    if not isinstance(thing, type):
        yield name, f"function {signature(thing)}" if callable(thing) else "value"
        return
    kind = "warning" if issubclass(thing, Warning) else "exception" if issubclass(thing, BaseException) else "class"
    # signatures of what Python makes itself, as for exceptions, hang on its version
    own = any("__init__" in vars(base) or "__new__" in vars(base) for base in thing.__mro__ if is_ours(base))
    yield name, f"{kind} {signature(thing)}" if own else kind
    for inner, text in members(thing, public):
        yield f"{name}.{inner}", text


def command_line() -> Iterator[tuple[str, str]]:
    """Yield (command, its options) of the program, plugins included."""
    import typer

    (main,) = (point.load() for point in entry_points(group="console_scripts", name="kanefe"))
    built: list[typer.Typer] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.Typer, "__call__", lambda self: built.append(self))
        main()
    (app,) = built
    yield from described_command("$ kanefe", typer.main.get_command(app))


def described_command(name: str, command: Any) -> Iterator[tuple[str, str]]:
    inner = getattr(command, "commands", {})
    for word in sorted(inner):
        yield from described_command(f"{name} {word}", inner[word])
    if not inner:
        options = ["/".join((*p.opts, *p.secondary_opts)) for p in command.params if p.param_type_name == "option"]
        arguments = [f"<{p.name}>" for p in command.params if p.param_type_name == "argument"]
        yield name, " ".join(("command", *arguments, *sorted(options)))


def api() -> dict[str, str]:
    """Return all that users can name, and what it is."""
    found: dict[str, str] = {}
    loaded = {package: import_module(package) for package in PACKAGES}
    loaded["kanefe.shapes"] = loaded["kanefe"].shapes
    things = {f"{p}.{name}": getattr(module, name) for p, module in loaded.items() for name in sorted(module.__all__)}
    public = {thing for thing in things.values() if isinstance(thing, type)}
    for name, thing in things.items():
        found |= dict(describe(name, thing, public))
    return found | dict(command_line())


def changes(before: dict[str, str], now: dict[str, str]) -> list[str]:
    """Return a line for each name that is gone, new or changed."""
    lines = [f"gone:    {name}  ({before[name]})" for name in before if name not in now]
    lines += [f"new:     {name}  ({now[name]})" for name in now if name not in before]
    for name in before:
        if now.get(name, before[name]) != before[name]:
            lines += [f"changed: {name}", f"    was  {before[name]}", f"    is   {now[name]}"]
    return lines


def test_the_public_names_are_those_of_the_snapshot() -> None:
    lines = changes(json.loads(SNAPSHOT.read_text(encoding="utf-8")), api())
    if lines:
        pytest.fail(
            "\n".join(["the public interface is not that of the snapshot:", *lines])
            + "\nRemedy: undo it, or if it is meant: "
            "PYTHONPATH=.:fem:tests/shared python tests/package/test_public_api.py",
            pytrace=False,
        )


@pytest.mark.parametrize("package", PACKAGES)
def test_no_public_name_is_that_of_a_file(package: str) -> None:
    # importing the file would put a module in the place of what users call
    assert [name for name in import_module(package).__all__ if find_spec(f"{package}.{name}")] == []


def functions(thing: Any) -> list[Callable[..., Any]]:
    """Return a public function, or the methods of a public class."""
    if isinstance(thing, type):
        bases = [base for base in thing.__mro__ if is_ours(base)]
        inner = [getattr(value, "__func__", value) for base in bases for value in vars(base).values()]
        written = [value for value in inner if inspect.isfunction(value)]
        return [value for value in written if value.__name__ != "__init__" or not is_dataclass(thing)]
    return [thing] if inspect.isfunction(thing) else []


def test_no_public_function_takes_more_than_ten_arguments() -> None:
    things = [getattr(import_module(package), name) for package in PACKAGES for name in import_module(package).__all__]
    found = [function for thing in things for function in functions(thing)]
    assert len(found) > 500
    counts = {f.__qualname__: len({*inspect.signature(f).parameters} - {"self", "cls"}) for f in found}
    assert {name: count for name, count in counts.items() if count > 10} == {}, "see CONTRIBUTING.md, Style"


def test_what_changes_is_named() -> None:
    before = {"f": "function (a, b=1)", "g": "function ()", "h": "value"}
    now = {"f": "function (a, b=2)", "h": "value", "i": "class"}
    assert changes(before, now) == [
        "gone:    g  (function ())",
        "new:     i  (class)",
        "changed: f",
        "    was  function (a, b=1)",
        "    is   function (a, b=2)",
    ]


def test_the_snapshot_knows_no_places() -> None:
    text = SNAPSHOT.read_text(encoding="utf-8")
    assert " at 0x" not in text
    assert str(ROOT) not in text
    for name, described in json.loads(text).items():
        assert "kanefe." not in described, name
    assert '"kanefe.System.simulate": "method (self, ' in text
    assert '"$ kanefe verify": "command <cases> --json --tol"' in text
    assert '"$ kanefe demo": "command ' in text


if __name__ == "__main__":
    SNAPSHOT.write_text(json.dumps(api(), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"written: {SNAPSHOT}")
