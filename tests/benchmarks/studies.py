"""Figures of studies: what a case costs beyond its run, what two workers gain, and what who asks holds.

    PYTHONPATH=tests/shared python tests/benchmarks/studies.py [--cases 400]

Needs two idle cores. The overhead is the time of a study times its workers, less that of its cases, over the cases;
what a study of two cases takes, with the start of its workers, is taken off and told by itself.
"""

from __future__ import annotations

import argparse
import resource
import time
from typing import Any

import kanefe as kf
from benchmarks.goals import Figure, Goal
from kanefe.studies.table import MEASURED
from study_scenes import lowest, pendulum

OVERHEAD = {
    name: Goal(f"study of short runs, {name}: time of a case beyond its run [ms]", 10.0)
    for name in ("serial", "processes", "Dask")
}
START = {
    "processes": Goal("study of two short runs, with the start of two processes [s]", 1.0),
    "Dask": Goal("study of two short runs on a Dask cluster that is there [s]", 1.0),
}
SPEED_UP = Goal("study of long runs: time of 2 workers / of 1", 1.0 / 1.9)
MEMORY = Goal("10,000 short runs: memory of who asks, beside that of 100 [MB]", 20.0)

LONG_RUN = 3000.0  # s of a pendulum


def study(cases: int, duration: float) -> kf.Study:
    return kf.Study(pendulum, lowest, duration=duration, rtol=1e-8, length=1.0, angle=0.1, seed=range(cases))


def timed(made: kf.Study, executor: Any, workers: int) -> tuple[float, kf.StudyTable]:
    began = time.perf_counter()
    table = made.run(executor, workers=workers)
    return time.perf_counter() - began, table


def overheads(cases: int) -> list[Figure]:
    """Compare the time of studies with that of their cases."""
    found = [*_overhead("serial", "serial", 1, cases), *_overhead("processes", "processes", 2, cases)]
    try:
        import distributed
    except ImportError:
        return [*found, OVERHEAD["Dask"].skipped("Dask is not installed")]
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        return [*found, *_overhead("Dask", client, 2, cases)]


def _overhead(name: str, executor: Any, workers: int, cases: int) -> list[Figure]:
    """Return the overhead of a case, and what a study of two takes."""
    (few, first), (many, second) = (timed(study(count, 1.0), executor, workers) for count in (2, cases + 2))
    inside = float(second.column("wall").sum() - first.column("wall").sum())
    each = ((many - few) * workers - inside) / cases
    figures = [OVERHEAD[name].figure(1e3 * each, f"{cases} cases of {1e3 * inside / cases:.2f} ms")]
    return [*figures, START[name].figure(few)] if name in START else figures


def speed_up(cases: int) -> list[Figure]:
    """Compare two workers with one, and their bits."""
    made = study(max(cases // 4, 8), LONG_RUN)
    one, first = timed(made, "processes", 1)
    two, second = timed(made, "processes", 2)
    same = all(first.lists()[name] == second.lists()[name] for name in first.lists() if name not in MEASURED)
    return [SPEED_UP.figure(two / one if same else float("nan"), f"{one:.2f} s and {two:.2f} s, {len(made)} cases")]


def memory() -> list[Figure]:
    """Compare the peak of the memory of a long study with that of a short one."""
    peaks = []
    for cases in (100, 10_000):
        study(cases, 0.01).run("processes", workers=2)
        peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0)
    return [MEMORY.figure(peaks[1] - peaks[0], f"{peaks[0]:.0f} and {peaks[1]:.0f} MB")]


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--cases", type=int, default=400)
    count = options.parse_args().cases
    for figure in (*overheads(count), *speed_up(count), *memory()):
        value = figure.value if isinstance(figure.value, str) else f"{figure.value:.3g}"
        print(f"{figure.what:72s} {value:>8s} {figure.goal:9s} {'ok' if figure.met else 'MISSED'}  {figure.remark}")
