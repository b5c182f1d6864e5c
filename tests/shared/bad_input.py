"""Calls with one bad argument each, and what became of them: a clear error, or a fault.

Run as a program, in a process of its own, it tries a range of the cases of a seed, and prints a line of JSON for
each that is a fault.
"""

from __future__ import annotations

import builtins
import contextlib
import io
import itertools
import json
import math
import os
import random
import re
import resource
import signal
import sys
import tempfile
import traceback
import typing
import warnings
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from types import FunctionType, MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

import kanefe as kf
from whole_signatures import whole_signature

NAN, INF = float("nan"), float("inf")
MOST_SECONDS = 20
"""Of one call; the good ones take below one."""

MOST_MEMORY = 4 * 2**30
"""Of the process, bytes: what has no end becomes a MemoryError."""


class Bad(NamedTuple):
    """A bad value: how it is made of the good one, and a pattern of the hints that it may fit."""

    make: Callable[[Any], Any]
    fits: str


ANY = r"\b(Any|object)\b"
NUMBER = rf"{ANY}|float|Load|Vector|Law|Quantity|Damping|Friction"
WHOLE = rf"{NUMBER}|int\b|Target|Nodes|Frames"
SEVERAL = rf"{ANY}|Sequence|array|Vector|Matrix|Collection|Orientation|Frames|Nodes|Iterable|Target|Mapping|Named"
SEVERAL = rf"{SEVERAL}|Groups|Start|Axes|Units|\.\.\.\]"
TEXT = rf"{ANY}|str|Path|Literal|Named|Nodes|Target|PlaceLike|Units|Kind|Order|Quantity"
CALLABLE = rf"{ANY}|Callable|StressStiffness|type|PlaceLike|Axes|Load|Quantity|Field|Function|Factorise|Law|progress"


def is_numeric(good: Any) -> bool:
    """Return whether a good value is a number, or an array or sequence of numbers."""
    with contextlib.suppress(TypeError, ValueError):
        return (
            not isinstance(good, (str, bytes, bool, set, dict))
            and np.size(good) > 0
            and np.asarray(good).dtype.kind in "fiu"
        )
    return False


def changed(change: Callable[[np.ndarray], Any]) -> Callable[[Any], Any]:
    """Return a maker of a bad value from the numbers of a good one; where that has none, of three."""
    return lambda good: change(np.array(good if is_numeric(good) else (1.0, 2.0, 3.0), dtype=float))


def one_nan(numbers: np.ndarray) -> Any:
    numbers.flat[-1:] = NAN
    return numbers if numbers.ndim else float(numbers)


def deep(_: Any) -> Any:
    made: Any = 1.0
    for _level in range(100):
        made = [made]
    return made


def no_end(_: Any) -> Any:
    made: list[Any] = [1.0]
    made.append(made)
    return made


def wrong(*_: Any, **__: Any) -> str:
    """Return what no function of numbers returns."""
    return "wrong"


class Whatever:
    """A class whose objects are made of anything."""

    def __init__(self, *_: Any, **__: Any) -> None: ...


def fifo(_: Any) -> str:
    with contextlib.suppress(FileExistsError):
        os.mkfifo("fifo")
    return "fifo"


BAD = {
    "NaN": Bad(lambda _: NAN, ANY),
    "one NaN": Bad(changed(one_nan), ANY),
    "inf": Bad(lambda _: INF, ANY),
    "-inf": Bad(lambda _: -INF, ANY),
    "complex": Bad(lambda _: 1j, ANY),
    "huge whole": Bad(lambda _: 10**400, ANY),
    "many": Bad(lambda _: 10**9, WHOLE),
    "huge": Bad(lambda _: 1e300, NUMBER),
    "tiny": Bad(lambda _: 1e-300, NUMBER),
    "negative": Bad(lambda _: -1.0, NUMBER),
    "minus one": Bad(lambda _: -1, WHOLE),
    "zero": Bad(lambda _: 0, WHOLE),
    "fraction": Bad(lambda _: 1.5, NUMBER),
    "True": Bad(lambda _: True, rf"{ANY}|bool"),
    "None": Bad(lambda _: None, rf"{ANY}|None|Optional"),
    "text": Bad(lambda _: "nonsense", TEXT),
    "number in text": Bad(lambda _: "1.0", TEXT),
    "good in text": Bad(lambda good: f"{good} ", TEXT),
    "no text": Bad(lambda _: "", TEXT),
    "text without end": Bad(lambda _: "a" * 100_000, TEXT),
    "zero byte": Bad(lambda _: "a\0b", TEXT),
    "half a letter": Bad(lambda _: "\ud800", TEXT),
    "fifo": Bad(fifo, TEXT),
    "bytes": Bad(lambda _: b"x", ANY),
    "object": Bad(lambda _: object(), ANY),
    "class": Bad(lambda _: Whatever, CALLABLE),
    "another scene": Bad(lambda _: kf.System(), rf"{ANY}|System|Scene|Freezable"),
    "another ground": Bad(lambda _: kf.System().ground, rf"{ANY}|Frame|Target"),
    "generator": Bad(lambda _: (x for x in (1.0, 2.0, 3.0)), rf"{ANY}|Iterable|Iterator"),
    "endless": Bad(lambda _: itertools.count(), rf"{ANY}|Iterable|Iterator"),
    "empty list": Bad(lambda _: [], SEVERAL),
    "mapping": Bad(lambda _: {"a": "b"}, rf"{ANY}|Mapping|dict"),
    "set": Bad(lambda _: {"a"}, rf"{ANY}|Set|Collection|Iterable"),
    "texts": Bad(lambda _: ["a", "b"], rf"{ANY}|str|Literal|Named|Kind|Sequence\[Load\]"),
    "an axis more": Bad(lambda good: [good], SEVERAL),
    "one less": Bad(changed(lambda numbers: np.atleast_1d(numbers)[:-1]), SEVERAL),
    "one more": Bad(changed(lambda numbers: [*np.atleast_1d(numbers), *np.atleast_1d(numbers)[-1:]]), SEVERAL),
    "opposite": Bad(changed(lambda numbers: -numbers), rf"{NUMBER}|{SEVERAL}"),
    "zeros": Bad(changed(lambda numbers: 0.0 * numbers), rf"{WHOLE}|{SEVERAL}"),
    "numbers in texts": Bad(changed(lambda numbers: numbers.astype(str)), rf"{ANY}|str|Load\b"),
    "three axes": Bad(lambda _: np.zeros((2, 3, 4)), rf"{ANY}|Vector"),
    "a million": Bad(lambda _: [1.0] * 10**6, SEVERAL),
    "array of NaN": Bad(lambda _: np.full(3, NAN), ANY),
    "array of complex": Bad(lambda _: np.array([1j, 0, 0]), ANY),
    "array of objects": Bad(lambda _: np.array([None, object(), 1]), ANY),
    "sparse": Bad(lambda _: sp.eye(3), rf"{ANY}|Matrix|matrix"),
    "ragged": Bad(lambda _: [[1.0], [1.0, 2.0]], ANY),
    "deep": Bad(deep, ANY),
    "within itself": Bad(no_end, ANY),
    "wrong function": Bad(lambda _: wrong, CALLABLE),
}
"""By name. A hint that says nothing of a value takes it: such an argument is judged by the exception that it raises."""


class Called:
    """An object that is called as a function is."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self.function(*args, **kwargs)


def is_number(good: Any) -> bool:
    return isinstance(good, (int, float)) and not isinstance(good, bool)


def is_row(good: Any) -> bool:
    return isinstance(good, (list, tuple)) and len(good) > 0 and is_numeric(good)


SAME = {
    "of numpy": (lambda good: isinstance(good, (bool, int, float, str)), lambda good: np.array(good)[()]),
    "without axes": (lambda good: isinstance(good, float), np.array),
    "whole": (lambda good: isinstance(good, float) and good.is_integer(), int),
    "fraction": (lambda good: isinstance(good, float) and math.isfinite(good), Fraction),
    "list": (lambda good: type(good) is tuple, list),
    "tuple": (lambda good: isinstance(good, list), tuple),
    "array": (is_row, np.array),
    "path": (lambda good: isinstance(good, Path), str),
    "mapping": (lambda good: isinstance(good, dict), MappingProxyType),
    "object called": (lambda good: isinstance(good, FunctionType) and not hasattr(good, "is_compiled"), Called),
}
"""Other forms of good values, which are good too: of which, and how they are made."""


class Hang(BaseException):
    """A call that takes too long."""


NOT_BAD = {("dt", "many"), ("dt", "huge"), ("seed", "huge whole"), ("frequencies", "a million")}
"""Runs and tables as long as is asked for, which no limit ends but the user; seeds have no largest one."""

AS_GOOD = "good, "
"""Begins the names of cases whose value is good in another form."""

MOST_SHOWN = 15
"""Letters of a value by which a message is taken to show it; long ones are shortened."""

MOST_LETTERS = 2000
"""Of a message."""


class Case(NamedTuple):
    """A call with one argument replaced."""

    name: str
    argument: str
    bad: str


def hint_of(function: Callable[..., Any], argument: str) -> tuple[str, Any]:
    """Return the text of the hint of an argument, and its default."""
    found = whole_signature(function).parameters.get(argument)
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
        for argument, good in made.good()[1].items():
            for bad in BAD:
                if (argument, bad) not in NOT_BAD:
                    yield Case(name, argument, bad)
            for same, (fits, _) in SAME.items():
                if fits(good):
                    yield Case(name, argument, AS_GOOD + same)
        yield Case(name, "no_such_argument", "zero")


COMMON = {*dir(builtins), *dir(typing)}
"""Names in hints that say nothing of what is meant."""


def words_in(text: str) -> set[str]:
    """Return the words of a text or of a name, in snake_case or CamelCase, without the s of plurals."""
    return {re.sub("(ies|s)$", "", word.lower()) for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+", text)}


def shows(message: str, value: object) -> bool:
    """Return whether a message shows a value, or its shape."""
    forms = {repr(value)[:MOST_SHOWN]}
    if isinstance(value, float) or (isinstance(value, int) and abs(value) < MOST_MEMORY):
        forms.add(f"{value:g}")
    elif isinstance(value, np.ndarray):
        forms.add(str(value.shape))
    elif isinstance(value, (list, set)):
        forms |= {repr(one)[:MOST_SHOWN] for one in itertools.islice(value, 2)} | {f"({len(value)},)"}
    elif isinstance(value, str):
        forms.add(value[:MOST_SHOWN] or os.getcwd())  # of no text as a path, it is the folder
    return any(form in message for form in forms)


def names_it(message: str, function: Callable[..., Any], case: Case, value: object) -> bool:
    """Return whether a message says which argument it means: its name, the kinds of its hint, or the value.

    Where one argument alone could be meant, the name of what was called does as well.
    """
    kinds = set(re.findall(r"\b[A-Z]\w+", hint_of(function, case.argument)[0])) - COMMON
    called = case.name.partition(" (")[0].rpartition(".")[2].removeprefix("add_").removeprefix("from_")
    wanted = words_in(" ".join((case.argument, called, *kinds)))
    told = words_in(message)
    return shows(message, value) or any(
        one == word or (len(word) > 2 and one.startswith(word)) for word in wanted for one in told
    )


def ended(function: Callable[..., Any], arguments: dict[str, Any]) -> tuple[BaseException | None, Any]:
    """Return what a call raised or returned; a `Hang` where it took too long."""

    def ring(*_: object) -> None:
        raise Hang

    kinds = {signal.SIGPROF: signal.ITIMER_PROF, signal.SIGALRM: signal.ITIMER_REAL}  # what waits takes no processor
    before = {kind: signal.signal(kind, ring) for kind in kinds}
    try:
        signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
        signal.setitimer(signal.ITIMER_REAL, 6 * MOST_SECONDS)
        return None, function(**arguments)
    except (Exception, Hang) as error:  # noqa: BLE001 (those that are none of ours are the faults that are looked for)
        return error, None
    finally:
        for kind, timer in kinds.items():
            signal.setitimer(timer, 0)
            signal.signal(kind, before[kind])


def verdict(case: Case, made: Any) -> tuple[str, str]:
    """Return what became of a call with one argument replaced, and what it said."""
    function, arguments = made.good()
    good = arguments.get(case.argument)
    if case.bad.startswith(AS_GOOD):
        error, _ = ended(function, {**arguments, case.argument: SAME[case.bad.removeprefix(AS_GOOD)][1](good)})
        return ("taken", "") if error is None else ("REFUSED", f"{type(error).__name__}: {error}")
    value = BAD[case.bad].make(good)
    error, found = ended(function, {**arguments, case.argument: value})
    if isinstance(error, Hang):
        return "HANG", str(traceback.extract_tb(error.__traceback__)[-3:])
    if isinstance(error, kf.KanefeError):
        if not names_it(str(error), function, case, value):
            return "UNNAMED", str(error)
        if len(str(error)) > MOST_LETTERS:
            return "ENDLESS WORDS", str(error)
        return "clear", str(error)
    if error is not None:
        is_unknown = isinstance(error, TypeError) and "unexpected keyword argument" in str(error)
        return ("clear", str(error)) if is_unknown and case.argument == "no_such_argument" else raw(error)
    if case.argument == "no_such_argument":
        return "SILENT", "taken"
    if isinstance(found, (float, np.ndarray)) and np.asarray(found).dtype.kind in "fc" and np.isnan(found).any():
        return "SILENT", "NaN is returned"
    return ("taken", "") if may_be_taken(function, case) else ("SILENT", "taken")


def raw(error: BaseException) -> tuple[str, str]:
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
