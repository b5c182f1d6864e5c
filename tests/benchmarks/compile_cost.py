"""CPU time of building each library, and its machine code: ``python tests/benchmarks/compile_cost.py [NAME]...``.

Libraries are built in this process and written nowhere. A function counts what it alone has: a kernel that one before
it has called too is translated already. On a busy machine only what is measured in the same run can be compared.

``--inlined N``: of each library too the N kernels that are laid into their callers most, by how many instructions there
would be less if each were there once.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from kanefe.kernels.compiler._numba_alone import build_alone
from kanefe.kernels.compiler.build import all_libraries
from kanefe.kernels.compiler.compiled_functions import CompiledFunction


class Laid(NamedTuple):
    """A function that is laid into its callers.

    Attributes
    ----------
    name : str
    copies : int
        In how many places.
    whole : int
        Its instructions with those of what is laid into it.
    """

    name: str
    copies: int
    whole: int

    @property
    def excess(self) -> int:
        """How many instructions there are more than if it were there once."""
        return (self.copies - 1) * self.whole


def main(given: Sequence[str] | None = None) -> None:
    """Print the tables, as a command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="of libraries; else all")
    parser.add_argument("--inlined", type=int, default=0, metavar="N", help="how many inlined kernels are listed")
    options = parser.parse_args(given)
    if not build_alone():
        sys.exit("this version of numba builds in its own way, which is not measured")
    whole = 0.0
    for library, units in sorted(all_libraries().items(), key=lambda item: -item[0].seconds):
        if not options.names or library.name in options.names:
            whole += _print_library(library.name, units, options.inlined)
    print(f"{'all':40s} {whole:7.2f} s")


def _print_library(name: str, units: Sequence[CompiledFunction], inlined: int) -> float:
    from kanefe.kernels.compiler._numba_module import object_codes

    made, began = [], time.process_time()
    for unit in units:
        before = time.process_time()
        made.append((unit.symbol, unit.compile()))
        print(f"    {unit.name:36s} {time.process_time() - before:7.2f} s")
    translated = time.process_time()
    laid = _laid_in([function.library for _, function in made]) if inlined else []
    before = time.process_time()
    size = sum(map(len, object_codes(made)))
    optimised = time.process_time() - before
    print(
        f"{name:40s} {translated - began + optimised:7.2f} s: translated {translated - began:.2f}, "
        f"optimised {optimised:.2f}; {size / 1000:.0f} kB",
        flush=True,
    )
    for one in laid[:inlined]:
        print(f"        {one.excess:7d} instructions more: {one.copies:3d} of {one.whole:5d}, {one.name}")
    return translated - began + optimised


def _laid_in(libraries: Sequence[Any]) -> list[Laid]:
    """Return the functions that are laid into others, those first that give most instructions."""
    from kanefe.kernels.compiler._numba_module import _reached

    calls: dict[str, Counter[str]] = {}
    callers: defaultdict[str, Counter[str]] = defaultdict(Counter)
    own, is_laid = {}, set()
    for library in _reached(libraries):
        for function in library._final_module.functions:
            if function.is_declaration:
                continue
            instructions = [one for block in function.blocks for one in block.instructions]
            called = Counter(list(one.operands)[-1].name for one in instructions if one.opcode == "call")
            own[function.name], calls[function.name] = len(instructions), called
            for name, count in called.items():
                callers[name][function.name] += count
            if b"alwaysinline" in b" ".join(function.attributes):
                is_laid.add(function.name)

    @cache
    def whole(name: str) -> int:
        return int(own[name] + sum(count * whole(one) for one, count in calls[name].items() if one in is_laid))

    @cache
    def copies(name: str) -> int:
        return sum(count * copies(one) for one, count in callers[name].items()) if name in is_laid else 1

    found = [Laid(_plain(name), copies(name), whole(name)) for name in is_laid]
    return sorted(found, key=lambda one: -one.excess)


def _plain(name: str) -> str:
    """Return the name of a kernel of its name in machine code: numbers of letters, and as many letters."""
    parts, rest = [], name.removeprefix("_ZN")
    while digits := rest[: len(rest) - len(rest.lstrip("0123456789"))]:
        end = len(digits) + int(digits)
        parts.append(rest[len(digits) : end])
        rest = rest[end:]
    return ".".join(parts).removeprefix("kanefe.kernels.") or name


if __name__ == "__main__":
    main()
