"""What method="auto" takes against the best method by hand, in scenes drawn by a seed: all rows.

    python tests/benchmarks/auto_by_hand.py [--seeds 100-130] [--seconds 3]

For each of three errors, relative to the size of the scene, the fastest run of auto that keeps it counts against the
fastest by hand, over all tolerances; and the error of auto over rtol, up to where chaos sets in. Times are CPU times of
second runs. A scene counts where two references agree.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

import kanefe as kf
from benchmarks.drawn_scenes import Drawn, drawn

ERRORS = 1e-3, 1e-4, 1e-5
TOLERANCES = 1e-3, 1e-4, 1e-5, 1e-6, 1e-7
BY_HAND = "dop853", "dopri5", "vern9", "radau5", "extrapolation"
FINEST = ("dop853", 1e-11), ("radau5", 1e-9), ("vern9", 1e-11)
MOST_FOR_REFERENCE, AGREED = 20.0, 1e-7
SHORT = 0.05
"""Time of auto below which a run is reported apart, s."""


class Ran(NamedTuple):
    """A run: its method, tolerance, CPU time (s) and error relative to the size; infinite where it did not end."""

    method: str
    rtol: float
    seconds: float
    error: float


def positions(scene: Drawn, method: str, rtol: float, most_seconds: float) -> tuple[np.ndarray | None, float]:
    """Return the positions of all bodies at output times, None where the run does not end, and its CPU time in s."""
    copy, began = scene.scene.copy(), time.process_time()
    step = scene.seconds / 50
    try:
        run = copy.simulate((0.0, scene.seconds), method=method, rtol=rtol, output_step=step, most_seconds=most_seconds)
    except kf.ModelError:
        return None, 0.0
    taken = time.process_time() - began
    if not run.status.is_finished:
        return None, taken
    return np.concatenate([run.position(name) for name in scene.bodies], axis=1), taken


def raced(seed: int, most_seconds: float) -> list[str]:
    """Return the rows of a seed: its ratios, or why it has none."""
    scene = drawn(seed)
    title = f"{seed} {', '.join(scene.words)}"
    positions(scene, "auto", 1e-3, most_seconds)  # what is compiled is compiled
    found = [x for x, _ in (positions(scene, *finest, MOST_FOR_REFERENCE) for finest in FINEST) if x is not None]
    if len(found) < 2 or np.abs(found[0] - found[1]).max() > AGREED * scene.size:
        return [f"{title}: no two references agree"]
    rows: list[Ran] = []
    for method in ("auto", *BY_HAND):
        for rtol in TOLERANCES:
            x, seconds = positions(scene, method, rtol, most_seconds)
            if x is None:
                break
            rows.append(Ran(method, rtol, seconds, float(np.abs(x - found[0]).max()) / scene.size))
    of_auto = [row for row in rows if row.method == "auto"]
    worst = max((row.error / row.rtol for row in of_auto), default=np.nan)
    lines = []
    for error in ERRORS:
        ours = min((row for row in of_auto if row.error <= error), key=lambda row: row.seconds, default=None)
        best = min((row for row in rows if row.error <= error), key=lambda row: row.seconds, default=None)
        if ours is None or best is None:
            lines.append(f"{title}: {error:g}: auto did not end in {most_seconds:g} s" if best else "")
            continue
        apart = ", short" if ours.seconds < SHORT else ""
        lines.append(
            f"{title}: {error:g}: {ours.seconds / best.seconds:.2f} ({ours.seconds:.3g} s, {best.method} "
            f"{best.seconds:.3g} s{apart}); error of auto / rtol up to {worst:.2g}"
        )
    return [line for line in lines if line]


def main() -> int:
    """Measure, as a command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="100-130")
    parser.add_argument("--seconds", type=float, default=3.0, help="largest CPU time of a run")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    first, last = map(int, options.seeds.split("-"))
    ratios: dict[bool, list[float]] = {True: [], False: []}
    for seed in range(first, last):
        for line in raced(seed, options.seconds):
            print(line, flush=True)
            if " s, " in line:
                ratios["short" in line].append(float(line.split(": ")[2].split()[0]))
    for is_short, found in ratios.items():
        if found:
            quantiles = ", ".join(f"{np.quantile(found, q):.2f}" for q in (0.5, 0.95, 1.0))
            what = "short runs" if is_short else f"runs above {SHORT:g} s"
            print(f"{what}: {len(found)} rows, median, 95 % and worst {quantiles}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
