"""The process that measures: ``python -m kanefe_fem.bench OPTIONS``, started by ``kanefe bench``."""

from __future__ import annotations

import os
import sys

from kanefe_fem.bench.clocks import use_one_core
from kanefe_fem.bench.options import Options


def main(text: str) -> int:
    """Measure what the options ask for; the exit code is 1 if a goal is missed, 2 if the user can mend something."""
    options = Options.read(text)
    all_cores = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
    use_one_core(options.core)
    from kanefe.errors import KanefeError
    from kanefe_fem.bench.measured import measured

    try:
        return measured(options, all_cores)
    except KanefeError as error:
        print(f"kanefe: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
