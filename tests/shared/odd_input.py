"""Drawn calls with one or two odd arguments each, gone on with as a user would: into a scene, run, rest, modes, files.

Run as a program, in a process of its own, it tries a range of the draws of a seed, and prints a line of JSON for each
that is a fault.
"""

from __future__ import annotations

import contextlib
import datetime
import io
import json
import os
import random
import re
import resource
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from decimal import Decimal
from fractions import Fraction
from functools import cache, partial
from typing import Any

import numpy as np

import kanefe as kf
import kanefe_fem as fem
from bad_input import (
    AS_GOOD,
    BAD,
    MOST_LETTERS,
    MOST_MEMORY,
    NOT_BAD,
    SAME,
    TEXT,
    Case,
    Hang,
    ended,
    hint_of,
    is_number,
    is_numeric,
    may_be_taken,
    names_it,
    raw,
)
from gone_on import gone_on


def of_good(change: Callable[[np.ndarray], Any]) -> Callable[[Any, random.Random], Any]:
    """Return a maker of a value from the numbers of a good one, or of three."""
    return lambda good, _: change(np.array(good if is_numeric(good) else (1.0, 2.0, 3.0), dtype=float))


def read_only(numbers: np.ndarray) -> np.ndarray:
    numbers.setflags(write=False)
    return numbers


def strided(numbers: np.ndarray) -> np.ndarray:
    return np.repeat(np.atleast_1d(numbers), 2, axis=-1)[..., ::2].reshape(numbers.shape or 1)


def one_of(numbers: np.ndarray, value: float) -> Any:
    numbers.flat[-1:] = value
    return numbers if numbers.ndim else float(numbers)


@cache
def others() -> list[Any]:
    """Return things of all kinds that belong to nothing."""
    other = kf.System()
    body = other.add_rigid_body("other", 1.0, 1.0, joint=kf.Revolute("z"))
    return [
        body,
        body.frame((1.0, 0.0, 0.0)),
        kf.Revolute("z"),
        kf.Free(),
        kf.HuntCrossley(1e5),
        kf.Coulomb(0.3),
        kf.shapes.Sphere(0.1),
        kf.ModalDamping(0.01),
        kf.CraigBampton(modes=2),
        kf.Motion.steady(1.0),
        fem.Material(E=210e9, nu=0.3, rho=7850.0),
        fem.Rectangle(0.1, 0.1),
        other.add_surface("ball", body, kf.shapes.Sphere(0.1)),
        kf.Event("e", lambda t, s: t - 1.0),
        kf.Wind((1.0, 0.0, 0.0)),
    ]


ODD: dict[str, Callable[[Any, random.Random], Any]] = {
    "large": lambda _, draw: draw.choice((1, -1)) * 10.0 ** draw.uniform(3, 12),
    "very large": lambda _, draw: draw.choice((1, -1)) * 10.0 ** draw.uniform(100, 308),
    "one very large": lambda good, draw: of_good(partial(one_of, value=10.0 ** draw.uniform(100, 308)))(good, draw),
    "small": lambda _, draw: draw.choice((1, -1)) * 10.0 ** draw.uniform(-320, -10),
    "one small": lambda good, draw: of_good(partial(one_of, value=10.0 ** draw.uniform(-320, -10)))(good, draw),
    "drawn": lambda _, draw: draw.uniform(-2, 2),
    "drawn whole": lambda _, draw: draw.randrange(-3, 60),
    "Decimal": lambda good, _: Decimal(str(good)) if is_number(good) else Decimal("1.5"),
    "Decimals": of_good(lambda numbers: [Decimal(str(x)) for x in np.atleast_1d(numbers).flat]),
    "Fractions": of_good(lambda numbers: [Fraction(str(x)) for x in np.atleast_1d(numbers).flat if np.isfinite(x)]),
    "int64": lambda *_: np.int64(2),
    "uint8": lambda *_: np.uint8(200),
    "float16": of_good(lambda numbers: np.float16(numbers)),
    "float32": of_good(lambda numbers: np.float32(numbers)),
    "longdouble": of_good(lambda numbers: numbers.astype(np.longdouble)),
    "bools": lambda *_: np.array([True, False, True]),
    "bool of numpy": lambda *_: np.bool_(True),
    "text of numpy": lambda *_: np.str_("z"),
    "date": lambda *_: datetime.timedelta(seconds=1),
    "day": lambda *_: np.datetime64("2020-01-01"),
    "masked": of_good(lambda numbers: np.ma.masked_invalid(np.append(numbers, np.nan))),
    "matrix of numpy": of_good(lambda numbers: np.atleast_2d(numbers.ravel()).view(np.matrix)),
    "fortran": of_good(np.asfortranarray),
    "swapped bytes": of_good(lambda numbers: numbers.astype(">f8")),
    "memory": of_good(lambda numbers: memoryview(np.ascontiguousarray(numbers))),
    "objects": of_good(lambda numbers: numbers.astype(object)),
    "complex numbers": of_good(lambda numbers: numbers.astype(complex)),
    "in degrees": of_good(lambda numbers: np.rad2deg(numbers)),
    "in millimetres": of_good(lambda numbers: 1000.0 * numbers),
    "transposed": of_good(lambda numbers: numbers.T if numbers.ndim > 1 else numbers.reshape(-1, 1)),
    "reversed": of_good(lambda numbers: np.flip(numbers)),
    "twice": lambda good, _: [good, good],
    "in a dict": lambda good, _: {"a": good},
    "range": lambda *_: range(3),
    "lambda": lambda *_: lambda *a, **k: 1.0,
    "lambda of NaN": lambda *_: lambda *a, **k: float("nan"),
    "lambda of much": lambda *_: lambda *a, **k: 1e200,
    "another": lambda _, draw: draw.choice(others()),
    "class of kanefe": lambda _, draw: type(draw.choice(others())),
    "NotImplemented": lambda *_: NotImplemented,
    "Ellipsis": lambda *_: ...,
}
"""Makers of odd values by name, from the good value and a source of draws; some of them may be right."""

FORMS: dict[str, tuple[Callable[[Any], bool], Callable[[Any], Any]]] = {
    **SAME,
    "read-only": (lambda good: isinstance(good, np.ndarray), lambda good: read_only(np.array(good))),
    "strided": (lambda good: isinstance(good, np.ndarray) and is_numeric(good), strided),
    "in another order": (lambda good: isinstance(good, np.ndarray), np.asfortranarray),
    "other bytes": (lambda good: isinstance(good, np.ndarray) and good.dtype == float, lambda good: good.astype(">f8")),
}
"""Other forms of good values, with which a call gives what it gives with those."""

STRANGE = {
    kind: fits
    for fits, kinds in (
        (r"\bAny\b|object", ("date", "day", "NotImplemented", "Ellipsis", "complex numbers")),
        (r"\bAny\b|object|Mapping", ("in a dict",)),
        (r"\bAny\b|object|bool", ("bools", "bool of numpy")),
        (r"\bAny\b|object|\btype\b|Callable|Load\b|Law|Quantity|Function", ("class of kanefe", "lambda")),
        (TEXT + "|Axis|Frames", ("text of numpy",)),
    )
    for kind in kinds
}
"""Odd values that are never right, and the patterns of the hints for which they may be."""

RARE = (
    "Study",
    "screen",
    "solid",
    "segmented",
    "stability",
    "campbell",
    "floquet",
    "to_fmu",
    "view",
    "recover",
    "Ship",
)
"""Parts of the names of calls that take long: tried a fifth as often."""

SECONDS_OF_RUN = 5.0


def draws_of(draw: random.Random, arguments: dict[str, Any]) -> dict[str, tuple[str, Any]]:
    """Return the arguments that are replaced, with the names of the kinds of values, and the values."""
    made = {}
    for name in draw.sample(sorted(arguments), min(len(arguments), draw.choice((1, 1, 2)))):
        good = arguments[name]
        forms = [form for form, (fits, _) in FORMS.items() if fits(good)]
        kind = draw.choice(("odd", "odd", "bad", "bad", "form" if forms else "odd"))
        if kind == "form":
            form = draw.choice(forms)
            made[name] = AS_GOOD + form, FORMS[form][1](good)
        elif kind == "odd":
            odd = draw.choice(list(ODD))
            made[name] = odd, ODD[odd](good, draw)
        else:
            bad = draw.choice([bad for bad in BAD if (name, bad) not in NOT_BAD])
            made[name] = bad, BAD[bad].make(good)
    return made


def judged(name: str, made: Any, draw: random.Random) -> tuple[dict[str, str], str, str, str]:
    """Return what was replaced, the verdict, the stage that it is of, and what was said."""
    function, arguments = made.good()
    replaced = draws_of(draw, arguments)
    kinds = {argument: kind for argument, (kind, _) in replaced.items()}
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        error, found = ended(function, {**arguments, **{one: value for one, (_, value) in replaced.items()}})
        if error is None:
            for argument, (kind, _) in replaced.items():
                if (
                    kind in BAD
                    and not is_number(BAD[kind].make(arguments[argument]))
                    and not may_be_taken(function, Case(name, argument, kind))
                ):
                    return kinds, "SILENT", "call", f"{argument} is taken"
                hint = hint_of(function, argument)[0]
                if kind in STRANGE and not re.search(STRANGE[kind] + "|inspect._empty", hint):
                    return kinds, "SILENT", "call", f"{argument} is taken for {hint}"
            stage, verdict, said = gone_on(function, arguments, found, seconds=SECONDS_OF_RUN)
            if verdict == "SILENT" and heard:
                verdict = "warned"
            if all(kind.startswith(AS_GOOD) for kind in kinds.values()) and verdict == "fine":
                verdict, said = compared(made, said)
            return kinds, verdict, stage, said
    if isinstance(error, Hang):
        return kinds, "HANG", "call", raw(error)[1]
    if not isinstance(error, kf.KanefeError):
        return kinds, *reversed(("call", raw(error)[0])), raw(error)[1]
    if all(kind.startswith(AS_GOOD) for kind in kinds.values()):
        return kinds, "REFUSED", "call", str(error)
    if len(str(error)) > MOST_LETTERS:
        return kinds, "ENDLESS WORDS", "call", str(error)
    cases = [Case(name, one, kind) for one, (kind, _) in replaced.items()]
    words = "\n".join((str(error), *getattr(error, "__notes__", ())))
    if not any(names_it(words, function, case, replaced[case.argument][1]) for case in cases):
        return kinds, "UNNAMED", "call", str(error)
    return kinds, "clear", "call", str(error)


def compared(made: Any, said: str) -> tuple[str, str]:
    """Return the verdict of a call with a good value in another form: it gives the numbers of the good one."""
    function, arguments = made.good()
    _, found = ended(function, arguments)
    wanted = gone_on(function, arguments, found, seconds=SECONDS_OF_RUN)[2]
    return ("fine", "") if said == wanted else ("SILENT", f"form changes the result: {said} for {wanted}")


FINE = {"clear", "fine", "failed", "warned"}


def tried(seed: int, number: int, calls: dict[str, Any]) -> tuple[dict[str, Any], str]:
    """Return a draw and its verdict."""
    draw = random.Random(f"{seed} {number}")
    names = sorted(calls)
    name = draw.choice(names)
    if any(part in name for part in RARE) and draw.random() < 0.8:
        name = draw.choice([one for one in names if not any(part in one for part in RARE)])
    at = {"at": number, "call": name}
    print(json.dumps(at), file=sys.stderr, flush=True)
    begun = time.process_time()
    with contextlib.redirect_stdout(io.StringIO()):
        kinds, verdict, stage, said = judged(name, calls[name], draw)
    took = round(time.process_time() - begun, 1)
    return {**at, "kinds": kinds, "verdict": verdict, "stage": stage, "seconds": took, "said": said[:600]}, verdict


def faults(seed: int, start: int, stop: int) -> Iterator[dict[str, Any]]:
    """Yield the faults of a range of draws, then the counts of all verdicts."""
    from good_calls import CALLS

    counts: Counter[str] = Counter()
    for number in range(start, stop):
        found, verdict = tried(seed, number, CALLS)
        counts[verdict] += 1
        if verdict not in FINE:
            yield found
    yield {"counts": dict(counts)}


def main(seed: int, start: int, stop: int) -> None:
    """Try the draws from `start` to `stop` of a seed."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for fault in faults(seed, start, stop):
            print(json.dumps(fault, default=str), flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:4]))
