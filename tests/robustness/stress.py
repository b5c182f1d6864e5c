"""Try what breaks multibody programs, and print the worst figure of each against its limit; exit 1 if one fails.

    python tests/robustness/stress.py [--quick] [--method NAME] [--json FILE] [--html FILE] [CASE ...]

runs the cases of ``kanefe stress`` and all the long ones, in full: 40 minutes; the short form takes some minutes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "shared"))

from kanefe.checks.robustness.case import Effort
from kanefe.checks.robustness.runner import stress
from kanefe.errors import KanefeError
from robustness.outcomes import check_long_method
from robustness.registry import CASES


def main(given: Sequence[str] | None = None) -> int:
    """Run the cases asked for; the exit code is 1 if one fails, 2 if the user can mend something."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", metavar="CASE", help="such as drift slopes; default: all")
    parser.add_argument("--quick", action="store_true", help="the short form: less of everything")
    parser.add_argument("--method", metavar="NAME", help="method of the runs over a million steps")
    parser.add_argument("--json", metavar="FILE", help="write the findings to this file; - for standard output")
    parser.add_argument("--html", metavar="FILE", help="write the table to this file as a page")
    options = parser.parse_args(given)
    try:
        if options.method is not None:
            check_long_method(options.method)
        effort = Effort(options.quick, options.method)
        return stress(options.cases, CASES, effort, json_path=options.json, html_path=options.html)
    except KanefeError as error:
        print(f"stress: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
