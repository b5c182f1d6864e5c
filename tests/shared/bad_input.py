"""Calls with one bad argument each, and what became of them: a clear error, or a fault.

Run as a program, in a process of its own, it tries a range of the cases of a seed, and prints a line of JSON for
each that is a fault.
"""

from __future__ import annotations

import contextlib
import inspect
import io
import itertools
import json
import os
import random
import re
import resource
import signal
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

import kanefe as kf

NAN, INF = float("nan"), float("inf")
MOST_SECONDS = 20
"""Of one call; the good ones take below one."""

MOST_MEMORY = 8 * 2**30
"""Of the process, bytes: what has no end becomes a MemoryError."""


class Bad(NamedTuple):
    """A bad value: how it is made, and a pattern of the hints that it may fit."""

    make: Callable[[], Any]
    fits: str


ANY = r"\b(Any|object)\b"
ARRAY = rf"{ANY}|Sequence|tuple|array|Vector|Matrix|Collection"
BAD = {
    "NaN": Bad(lambda: NAN, ANY),
    "inf": Bad(lambda: INF, ANY),
    "-inf": Bad(lambda: -INF, ANY),
    "complex": Bad(lambda: 1j, ANY),
    "huge whole": Bad(lambda: 10**400, ANY),
    "huge": Bad(lambda: 1e300, r"."),
    "tiny": Bad(lambda: 1e-300, r"."),
    "negative": Bad(lambda: -1.0, r"."),
    "zero": Bad(lambda: 0, r"."),
    "fraction": Bad(lambda: 1.5, rf"{ANY}|float|\bLoadValue|VectorLoad"),
    "True": Bad(lambda: True, rf"{ANY}|bool|int\b"),
    "None": Bad(lambda: None, rf"{ANY}|None|Optional"),
    "text": Bad(lambda: "nonsense", rf"{ANY}|str|Path|Literal|Named|Nodes|Target|PlaceLike|Units|Kind|Order|Quantity"),
    "number in text": Bad(
        lambda: "1.0", rf"{ANY}|str|Path|Literal|Named|Nodes|Target|PlaceLike|Units|Kind|Order|Quantity"
    ),
    "no text": Bad(lambda: "", rf"{ANY}|str|Path|Literal|Named|Units|Target"),
    "bytes": Bad(lambda: b"x", ANY),
    "object": Bad(object, ANY),
    "class": Bad(lambda: int, rf"{ANY}|Callable|type|PlaceLike|Axes|LoadValue|VectorLoad|Quantity|Field|Function"),
    "generator": Bad(lambda: (x for x in (1.0, 2.0, 3.0)), rf"{ANY}|Iterable|Iterator"),
    "endless": Bad(itertools.count, rf"{ANY}|Iterable|Iterator"),
    "empty list": Bad(list, r"."),
    "mapping": Bad(lambda: {"a": "b"}, rf"{ANY}|Mapping|dict"),
    "set": Bad(lambda: {"a"}, rf"{ANY}|Set|Collection|Iterable"),
    "texts": Bad(lambda: ["a", "b"], rf"{ANY}|str|Literal|Named|Kind|Sequence\[Load\]"),
    "three axes": Bad(lambda: np.zeros((2, 3, 4)), rf"{ANY}"),
    "array of NaN": Bad(lambda: np.full(3, NAN), ANY),
    "array of complex": Bad(lambda: np.array([1j, 0, 0]), ANY),
    "array of objects": Bad(lambda: np.array([None, object(), 1]), ANY),
    "array of texts": Bad(lambda: np.array(["1", "2", "3"]), rf"{ANY}|str|Load\b"),
    "seven numbers": Bad(lambda: [1.0] * 7, rf"{ARRAY}|VectorLoad|Orientation|Frames|Nodes"),
    "ragged": Bad(lambda: [[1.0], [1.0, 2.0]], ANY),
    "function": Bad(lambda: len, rf"{ANY}|Callable|Load|PlaceLike|Field|Axes|Function|Factorise|Law|progress"),
}
"""By name. A hint that says nothing of a value takes it: such an argument is judged by the exception that it raises."""

REMEDY = re.compile(
    r"Remedy|must|needs|has:|has none|known|there (is|are)|one of|there:|only|no such|"
    r"expected|wants|instead|are:|takes|It has",
    re.I,
)


SYNONYMS = {
    "kanefe_fem.Orthotropic": ("nu",),
    "kanefe_fem.Orthotropic.transversely_isotropic": ("nu",),
    "kanefe.System.add_gear": ("gear",),
    "kanefe.Krylov": ("frequency", "load"),
    "kanefe.FreeInterface": ("load",),
    "kanefe_fem.cylinder_mesh": ("root",),
    "kanefe_fem.solid_model": ("group", "material"),
    "kanefe_fem.solid_body": ("group", "material"),
    "kanefe_fem.read_mesh": ("mesh file",),
}
"""Words by which messages of a function name its arguments, beside their own names."""

BY_ARGUMENT = {
    "start": ("state",),
    "find": ("body",),
    "speeds": ("body",),
    "dt": ("step",),
    "simulate": ("run",),
    "path": ("file", "data set"),
    "fps": ("every",),
    "gravity": ("steep",),
    "length": ("distribution",),
    "spreading": ("spread",),
    "wind": ("waves",),
    "build": ("needs a system",),
    "scale": ("triangles",),
}
"""The same, for arguments that have one meaning wherever they are."""


class Hang(BaseException):
    """A call that takes too long."""


class Case(NamedTuple):
    """A call with one argument replaced."""

    name: str
    argument: str
    bad: str


def hint_of(function: Callable[..., Any], argument: str) -> tuple[str, Any]:
    """Return the text of the hint of an argument, and its default."""
    found = inspect.signature(function).parameters.get(argument)
    if found is None:
        return "Any", None
    return str(found.annotation), found.default


def may_be_taken(function: Callable[..., Any], case: Case) -> bool:
    """Return whether a value may be right for an argument, as far as its kind says."""
    hint, default = hint_of(function, case.argument)
    if case.bad == "None" and default is None:
        return True
    if "inf" in case.bad and "inf" in repr(default):
        return True
    return hint == "<class 'inspect._empty'>" or re.search(BAD[case.bad].fits, hint) is not None


def cases(calls: dict[str, Callable[[], tuple[Callable[..., Any], dict[str, Any]]]]) -> Iterator[Case]:
    """Yield each pair of an argument and a bad value."""
    for name, made in calls.items():
        for argument in made.arguments:
            for bad in BAD:
                yield Case(name, argument, bad)
        yield Case(name, "no_such_argument", "zero")


def names_it(message: str, case: Case, value: object) -> bool:
    """Return whether a message names the argument, in its own or in plain words, or shows the value."""
    told = message.lower().replace("-", " ").replace("_", " ")
    plain = case.argument.lower().split("_")
    words = ["".join(plain), " ".join(plain), *plain, *BY_ARGUMENT.get(case.argument, ()), *SYNONYMS.get(case.name, ())]
    stems = [re.escape(re.sub("(ies|s)$", "", word)) + (r"\w*" if len(word) > 3 else r"\b") for word in words]
    is_named = any(re.search(rf"\b{stem}", told) for stem in stems)
    return is_named or any(text[:15] in message for text in (repr(value), str(value)))


def verdict(case: Case, made: Any) -> tuple[str, str]:
    """Return what became of a call with one bad argument, and what it said."""

    def ring(*_: object) -> None:
        raise Hang

    function, arguments = made.good()
    value = BAD[case.bad].make()
    arguments = {**arguments, case.argument: value}
    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(MOST_SECONDS)
    try:
        function(**arguments)
    except kf.KanefeError as error:
        signal.alarm(0)
        text = str(error)
        if not names_it(text, case, value):
            return "UNNAMED", text
        return ("clear", text) if REMEDY.search(text) else ("NO REMEDY", text)
    except Hang:
        return "HANG", traceback.format_exc()[-300:]
    except TypeError as error:
        signal.alarm(0)
        if "unexpected keyword argument" in str(error) and case.argument == "no_such_argument":
            return "clear", str(error)
        return raw(error)
    except Exception as error:  # noqa: BLE001 (any other is the fault that is looked for)
        signal.alarm(0)
        return raw(error)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    if case.argument == "no_such_argument":
        return "SILENT", "taken"
    return ("taken", "") if may_be_taken(function, case) else ("SILENT", "taken")


def raw(error: Exception) -> tuple[str, str]:
    """Return the verdict of an exception that is none of kanefe."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"RAW {type(error).__name__}", f"{error} @{os.path.basename(last.filename)}:{last.lineno}"


FINE = {"clear", "taken"}


def tried(chosen: list[Case], calls: dict[str, Any]) -> Iterator[dict[str, str]]:
    """Yield the faults among some cases."""
    for case in chosen:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            found, said = verdict(case, calls[case.name])
        if found not in FINE:
            yield {**case._asdict(), "verdict": found, "said": said[:400]}


def main(seed: int, start: int, stop: int, quick: str = "") -> None:
    """Try the cases from `start` to `stop` of an order of all of them, or of those of quick calls."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    from good_calls import CALLS, QUICK

    every = list(cases(QUICK if quick else CALLS))
    random.Random(seed).shuffle(every)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for number in range(start, min(stop, len(every))):
            print(json.dumps({"at": number, **every[number]._asdict()}), file=sys.stderr, flush=True)
            for fault in tried([every[number]], CALLS):
                print(json.dumps(fault), flush=True)
    print(json.dumps({"tried": min(stop, len(every)) - start, "of": len(every)}), flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:4]), *sys.argv[4:])
