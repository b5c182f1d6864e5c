"""Checks of the arguments of public functions against the type hints of their signatures.

`checked` guards a function, or the constructor of a class: its body only sees finite numbers, texts and objects of the
types in its signature; one number is a float or int of Python there, whatever type it had. Signs, shapes and meanings
are checked by the function itself. Only public entries are guarded, nothing that runs in every step.
"""

from __future__ import annotations

import builtins
import dataclasses
import inspect
import math
import re
import sys
import types
import typing
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache, partial, wraps
from importlib import import_module
from numbers import Integral, Real
from os import PathLike
from typing import Any, Literal, NamedTuple, TypeVar, overload

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers

F = TypeVar("F", bound=Callable[..., Any])

MOST_LETTERS = 120
"""Largest number of characters of a value in a message."""

NONE = ("",)
"""A name that no argument has: nothing is checked but the keywords of a group."""

PLAIN = {int, float, bool, str, type(None)}
"""Types of values that are taken as they are."""

LARGEST = sys.float_info.max
"""Largest finite number."""


def told(value: object) -> str:
    """Return a value for a message, shortened if it is long."""
    text = repr(value)
    return text if len(text) <= MOST_LETTERS else f"{text[: MOST_LETTERS - 3]}..."


def positive(value: object, what: str) -> float:
    """Return a finite number above zero; a ModelError names `what` it is otherwise."""
    number = numbers(value)
    if number.shape != () or not np.isfinite(number) or number <= 0.0:
        raise ModelError(f"{what} must be one number, finite and > 0, not {value!r}")
    return float(number)


@overload
def checked(function: F, /) -> F: ...


@overload
def checked(*held: str) -> Callable[[F], F]: ...


def checked(*held: Any) -> Any:
    """Check the arguments of a public function, or of the constructor of a class, against its type hints.

    A number must be finite, unless the default of the argument is infinite; a sequence must have a length, which a
    generator has not; a text does not count as a sequence of texts, nor True as a number. Keywords that are declared as
    a group, ``**options: Unpack[RunKeywords]``, are checked against the hints of the group, and others are refused.

    Parameters
    ----------
    *held : str
        Names of the arguments to check; the function checks the others itself. The plain decorator ``@checked`` checks
        all of them, ``@checked()`` only that keywords are known to the group.

    Raises
    ------
    ModelError
        When the function is called: the message names argument and function, what is required and what was given, or
        the unknown keyword.

    Examples
    --------
    >>> @checked
    ... def twice(length: float) -> float:
    ...     return 2.0 * length
    >>> twice("1")
    Traceback (most recent call last):
    kanefe.errors.ModelError: length= of twice must be a finite number, not '1'
    """
    if not held or isinstance(held[0], str):
        return lambda function: _guarded_thing(function, held or NONE)
    return _guarded_thing(held[0], ())


def _guarded_thing(thing: Any, held: tuple[str, ...]) -> Any:
    if isinstance(thing, type):
        thing.__init__ = _guarded(thing.__init__, thing.__name__, held)  # type: ignore[misc]
        return thing
    return _guarded(thing, thing.__name__, held)


def _guarded(function: Callable[..., Any], title: str, held: tuple[str, ...]) -> Callable[..., Any]:
    asked = cache(partial(_kinds, function, held))

    @wraps(function)
    def guarded(*args: Any, **kwargs: Any) -> Any:
        places, kinds, has_group = asked()
        plain: dict[str, float] = {}
        for name, value in (*zip(places, args, strict=False), *kwargs.items()):
            if has_group and name not in kinds:
                known = ", ".join(one for one in kinds if one not in {"self", "cls"})
                raise ModelError(f"{title} takes no {name}=. Remedy: one of {known}")
            kind = kinds.get(name)
            if kind is not None and not kind.holds(value):
                raise ModelError(f"{name}= of {title} must be {kind.words}, not {told(value)}")
            if kind is not None and kind.is_number and type(value) not in PLAIN:
                plain[name] = _plain(value)
        if plain:
            args = tuple(plain.pop(name, value) for name, value in zip(places, args, strict=False))
            kwargs.update(plain)
        return function(*args, **kwargs)

    guarded.asked = asked  # type: ignore[attr-defined]  # for tests
    return guarded


class Kind(NamedTuple):
    """The values that a type hint permits.

    Attributes
    ----------
    words : str
        Description for messages.
    holds : function of a value -> bool
        Whether a value is permitted.
    is_number : bool
        Whether one number is permitted, which the function gets as a float or int of Python.
    """

    words: str
    holds: Callable[[Any], bool]
    is_number: bool = False


def _plain(value: Any) -> Any:
    """Return a number of another type as one of Python; what is none, as it is.

    Small types of numpy overflow or lose digits in later arithmetic, arrays without axes have no hash, and fractions
    have no format.
    """
    one = value.item() if isinstance(value, (np.ndarray, np.generic)) and value.ndim == 0 else value
    if isinstance(one, bool) or not isinstance(one, Real):
        return value
    return int(one) if isinstance(one, Integral) else float(one)


def plain_numbers(thing: Any) -> None:
    """Make each field of a frozen dataclass that is one number, of whatever type, a float or int of Python."""
    for one in dataclasses.fields(thing):
        value = getattr(thing, one.name, None)
        if type(value) not in PLAIN:
            object.__setattr__(thing, one.name, _plain(value))


class _NamesOfHints(dict[str, Any]):
    """The names that type hints of a module may use, also those that it imports for type checkers only."""

    def __init__(self, module: types.ModuleType, more: Mapping[str, Any]) -> None:
        super().__init__({**vars(module), **more})
        self.module = module

    def __missing__(self, name: str) -> object:
        if hasattr(builtins, name):
            return getattr(builtins, name)
        try:
            source = inspect.getsource(self.module)
        except OSError:  # a program that is shipped without sources
            return Any
        found = re.search(rf"from (\S+) import (?:\([^)]*|[^(\n]*)\b{name}\b", source)
        if found is None:
            raise NameError(f"{self.module.__name__} has no name {name!r}, which a type hint uses")
        return getattr(import_module(found[1]), name)


def _kinds(function: Callable[..., Any], held: tuple[str, ...]) -> tuple[tuple[str, ...], dict[str, Kind | None], bool]:
    """Return the positional arguments, the kinds of all arguments (None: not checked), and whether there is a group."""
    places: list[str] = []
    found: dict[str, Kind | None] = {}
    # the constructor that dataclasses generate has globals of its own
    names = _NamesOfHints(sys.modules[function.__module__], function.__globals__)
    for one in inspect.signature(function).parameters.values():
        if one.kind is one.VAR_KEYWORD and "Unpack[" in str(one.annotation):
            (group,) = typing.get_args(eval(one.annotation, {}, names))
            return tuple(places), found | _kinds_of_group(group, held), True
        if one.kind in {one.VAR_POSITIONAL, one.VAR_KEYWORD}:
            continue
        hint = object if one.annotation is one.empty or (held and one.name not in held) else one.annotation
        while isinstance(hint, str):
            hint = eval(hint, {}, names)
        may_be_infinite = bool(np.any(np.isinf(numbers(one.default))))
        found[one.name] = None if hint is object else kind_of(hint, may_be_infinite)
        if one.kind is not one.KEYWORD_ONLY:
            places.append(one.name)
    return tuple(places), found, False


def _kinds_of_group(group: Any, held: tuple[str, ...]) -> dict[str, Kind | None]:
    """Return the kinds of the keywords of a group; each hint is evaluated in the module that defines it."""
    found: dict[str, Kind | None] = {}
    for name, hint in group.__annotations__.items():
        names = _NamesOfHints(sys.modules[hint.__forward_module__], {})
        is_held = not held or name in held
        found[name] = kind_of(eval(hint.__forward_arg__, {}, names)) if is_held else None
    return found


def kind_of(hint: Any, may_be_infinite: bool = False) -> Kind:
    """Return the kind that a type hint requires; infinite numbers are refused unless `may_be_infinite`."""
    origin, inner = typing.get_origin(hint) or hint, typing.get_args(hint)
    are_fine = partial(_are_fine, may_be_infinite)
    if origin in {typing.Union, types.UnionType}:
        kinds = [kind_of(one, may_be_infinite) for one in inner]
        words = " or ".join(dict.fromkeys(kind.words for kind in kinds))
        is_number = any(kind.is_number for kind in kinds)
        return Kind(words, lambda value: any(kind.holds(value) for kind in kinds), is_number)
    if origin is Literal:
        return Kind(" or ".join(map(repr, inner)), lambda value: any(_is_same(value, one) for one in inner))
    if hint is float:
        return _number(may_be_infinite)
    if hint is None or (isinstance(hint, type) and hint in KINDS):
        return KINDS[hint]
    if origin is np.ndarray:
        return Kind("an array of finite numbers", lambda value: _is_flags(value) or are_fine(value))
    if origin is Callable or origin is typing.get_origin(Callable[..., Any]):
        return Kind("a function", callable)
    if isinstance(origin, type) and issubclass(origin, PathLike):
        return Kind("a path", lambda value: isinstance(value, PathLike))
    if isinstance(origin, type) and origin.__module__ in {"builtins", "collections.abc"} and inner:
        return _container(origin, [kind_of(one, may_be_infinite) for one in inner], inner, are_fine)
    is_protocol = getattr(origin, "_is_protocol", False) and not getattr(origin, "_is_runtime_protocol", False)
    if hint is Any or not isinstance(origin, type) or is_protocol:
        return Kind("anything", lambda _: True)
    article = "an" if origin.__name__[0] in "AEIO" else "a"
    return Kind(f"{article} {origin.__name__}", lambda value: isinstance(value, origin))


def _are_fine(may_be_infinite: bool, value: object, ndim: int | None = None) -> bool:
    """Return whether all numbers of a value are finite, or at least numbers, and it has so many axes."""
    given = numbers(value)
    return (ndim is None or given.ndim == ndim) and not np.any(
        np.isnan(given) if may_be_infinite else ~np.isfinite(given)
    )


def _number(may_be_infinite: bool) -> Kind:
    most = math.inf if may_be_infinite else LARGEST
    return Kind(
        "a number" if may_be_infinite else "a finite number",
        lambda value: (
            -most <= value <= most
            if type(value) in {float, int}
            else isinstance(value, (Real, np.ndarray)) and _are_fine(may_be_infinite, value, 0)
        ),
        is_number=True,
    )


def _is_same(value: object, one: object) -> bool:
    """Return whether a value equals an item of a Literal; subclasses of str and numpy's integers count."""
    if isinstance(one, str):
        return isinstance(value, str) and value == one
    if isinstance(one, int) and not isinstance(one, bool):
        return _is_whole(value) and value == one
    return type(value) is type(one) and value == one


def _is_whole(value: object) -> bool:
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool) and abs(int(value)) < 2**63


def _is_flags(value: object) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.kind == "b"


_NONE = Kind("None", lambda value: value is None)
KINDS: dict[Any, Kind] = {
    None: _NONE,
    type(None): _NONE,
    int: Kind("a whole number", _is_whole, is_number=True),
    bool: Kind("True or False", lambda value: isinstance(value, (bool, np.bool_))),
    str: Kind("a text", lambda value: isinstance(value, str)),
}
"""Kinds of plain types."""


def _container(origin: type, kinds: list[Kind], inner: Sequence[Any], are_fine: Callable[..., bool]) -> Kind:
    """Return the kind of a sequence, set or mapping with items of given kinds."""
    if issubclass(origin, Mapping):
        key, of = kinds
        return Kind(
            f"a mapping of {key.words} to {of.words}",
            lambda value: (
                isinstance(value, Mapping) and all(key.holds(name) and of.holds(one) for name, one in value.items())
            ),
        )
    if not issubclass(origin, Collection):
        return Kind(f"a {origin.__name__.lower()}", lambda value: isinstance(value, origin))
    if issubclass(origin, tuple) and inner[-1] is not Ellipsis:
        return Kind(
            f"({', '.join(kind.words for kind in kinds)})",
            lambda value: (
                _is_listed(value)
                and len(value) == len(kinds)
                and all(kind.holds(one) for kind, one in zip(kinds, value, strict=True))
            ),
        )
    words = f"a sequence, each {kinds[0].words}"
    rows = typing.get_args(inner[0])
    if inner[0] is float or (rows and rows[0] in {int, float}):
        return Kind(words, lambda value: _is_listed(value) and are_fine(value, 2 if rows and len(value) else 1))

    def are_all(value: Any) -> bool:
        if isinstance(value, np.ndarray) and value.dtype.kind in "iufUb":  # all items have one type
            return inner[0] is not str and value.ndim > 0 and all(map(kinds[0].holds, value[:1]))
        return _is_listed(value, origin) and all(map(kinds[0].holds, value))

    return Kind(words, are_all)


def _is_listed(value: object, origin: type = Sequence) -> bool:
    is_array = isinstance(value, np.ndarray) and value.ndim > 0
    return is_array or (isinstance(value, (origin, Sequence)) and not isinstance(value, (str, bytes)))
