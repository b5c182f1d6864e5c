"""Error against CPU time, figures against goals and against Exudyn, and what skipping saves.

    python tests/benchmarks/bench.py [--scenes S1,S3] [--methods auto,rk4] [--quick] [--peer] [--png FILE] ...

measures on one core and one thread. It compares methods and tolerances, or by one option each: ``--bodies``, mesh size,
element order and number of modes (S3, demo); ``--skips``, what skipping saves; ``--certified``, bounds against true
errors of random scenes; ``--figures``, the figures that have goals, with the exit code 1 if one misses its goal.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "shared"))

from benchmarks.clocks import use_one_core
from benchmarks.command_line import parser
from benchmarks.work_precision.options import Options, check


def arguments(given: Sequence[str] | None = None) -> Options:
    """Return the options of the command line."""

    def names(text: str) -> tuple[str, ...]:
        return tuple(name.strip() for name in text.split(",") if name.strip())

    options = parser(__doc__, quick="fewer tolerances and repetitions: a minute or two")
    options.add_argument("--scenes", type=names, default=(), help="such as S1,S3; default: S1,S2,S3,S4,C06,demo")
    options.add_argument("--methods", type=names, default=(), help="such as auto,rk4; default: all there are")
    options.add_argument("--peer", action="store_true", help="also run Exudyn, in an environment of its own")
    options.add_argument("--bodies", action="store_true", help="instead: mesh size, element order and number of modes")
    options.add_argument("--skips", action="store_true", help="instead: what skipping saves")
    options.add_argument("--figures", action="store_true", help="instead: the figures that have goals")
    options.add_argument("--certified", action="store_true", help="instead: bounds against true errors")
    options.add_argument("--csv", type=Path, metavar="FILE", help="write the runs to this file as a table")
    options.add_argument("--png", type=Path, metavar="FILE", help="draw the curves into this file")
    options.add_argument(
        "--tests", type=Path, metavar="FOLDER", help="with --figures: the repository whose test suite is timed as well"
    )
    return Options(**vars(options.parse_args(given)))


def main(given: Sequence[str] | None = None) -> int:
    """Measure; the exit code is 1 if a goal is missed, 2 if the user can mend something."""
    options = arguments(given)
    all_cores = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
    use_one_core(options.core)
    os.environ.pop("KANEFE_JIT", None)
    # numpy reads the number of threads when it is imported, which these do
    from benchmarks.work_precision.measured import measured
    from kanefe.errors import KanefeError

    try:
        check(options)
        if options.certified:
            from benchmarks.certified_bounds import certified

            certified(12 if options.quick else 100)
            return 0
        return measured(options, all_cores)
    except KanefeError as error:
        print(f"bench: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
