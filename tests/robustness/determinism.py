"""The same input gives the same bits: in one process, and in a new one."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Iterator

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import follow
from kanefe.errors import SimulationError
from kanefe.integrate.methods.table import METHODS, own_methods
from repository import surroundings
from robustness.random_scenes import random_description

SEEDS = (0, 1, 2, 3)
SPAN, STEP, RTOL = 0.3, 1e-3, 1e-6


def fingerprints(seeds: tuple[int, ...]) -> list[str]:
    """Return a hash of the states of random scenes with every method, made anew."""
    found = []
    for seed in seeds:
        for method in own_methods():
            model = random_description(seed).build().freeze()
            control = {"rtol": RTOL} if METHODS[method].has_error_control else {"step": STEP}
            run = follow(model, SPAN, method=method, output_step=0.1, **control)
            parts = (run.times, run.coordinates, run.speeds, run.dissipated, run.work)
            found.append(hashlib.sha256(b"".join(np.ascontiguousarray(x).tobytes() for x in parts)).hexdigest())
    return found


def determinism(effort: Effort) -> Iterator[Finding]:
    """Compare runs bit by bit."""
    seeds = SEEDS[: effort.count(4, 1)]
    first, again = fingerprints(seeds), fingerprints(seeds)
    what = f"random scenes with every method ({', '.join(own_methods())}), built and run"
    yield Finding(
        f"{what} again in one process",
        len(first),
        "runs that differ in a bit",
        float(sum(a != b for a, b in zip(first, again, strict=True))),
        0.0,
        "the same input, the same bits",
    )
    code = f"from robustness.determinism import fingerprints; print(*fingerprints({seeds!r}))"
    environment = surroundings(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    # of one thread each: a library that shares out its sums adds them in another order
    others = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
        )
        if done.returncode:
            raise SimulationError(f"a second process failed: {done.stderr.strip().splitlines()[-1:]}")
        others.append(done.stdout.split())
    yield Finding(
        f"{what} in two new processes of one thread",
        len(others[0]),
        "runs that differ in a bit",
        float(sum(a != b for a, b in zip(*others, strict=True))),
        0.0,
        "the same input, the same bits",
    )


CASES = (StressCase("determinism", "same input, same bits, one thread", determinism),)
