"""What method="auto" takes against the best method by hand, in scenes drawn by a seed: all rows.

    python tests/benchmarks/auto_by_hand.py [--seeds 100-130] [--seconds 3]

For each of three errors, relative to the size of the scene, the fastest run of auto that keeps it counts against the
fastest by hand, over all tolerances; and the error of auto over rtol, up to where chaos sets in. Times are CPU times of
second runs. A scene counts where two references agree.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

import kanefe as kf
from benchmarks.auto_choice import BY_HAND, Raced, ran
from benchmarks.drawn_scenes import drawn

ERRORS = 1e-3, 1e-4, 1e-5
TOLERANCES = 1e-3, 1e-4, 1e-5, 1e-6, 1e-7
METHODS = "auto", "dopri5", *BY_HAND
FINEST = ("dop853", 1e-11), ("radau5", 1e-9), ("vern9", 1e-11)
MOST_FOR_REFERENCE, AGREED = 20.0, 1e-7
SHORT = 0.05
"""Time of auto below which a run is reported apart, s."""


def rows_of(seed: int, most_seconds: float) -> list[str]:
    """Return the rows of a seed: its ratios, or why it has none."""
    scene = drawn(seed)
    title = f"{seed} {', '.join(scene.words)}"
    raced = Raced(
        scene.scene, scene.seconds, lambda result: np.hstack([result.position(name) for name in scene.bodies])
    )
    ran(raced, "auto", 1e-3, None, 1, most_seconds)  # what is compiled is compiled
    fine = [ran(raced, method, rtol, None, 1, MOST_FOR_REFERENCE) for method, rtol in FINEST]
    found = [places for run, places in fine if np.isfinite(run.seconds)]
    if len(found) < 2 or np.abs(found[0] - found[1]).max() > AGREED * scene.size:
        return [f"{title}: no two references agree"]
    runs = []
    for method in METHODS:
        for rtol in TOLERANCES:
            try:
                run, _ = ran(raced, method, rtol, found[0], 1, most_seconds)
            except kf.ModelError:
                break
            if not np.isfinite(run.seconds):
                break
            runs.append((method, rtol, run.seconds, run.error / scene.size))
    worst = max((error / rtol for method, rtol, _, error in runs if method == "auto"), default=np.nan)
    lines = []
    for wanted in ERRORS:
        keeping = [(seconds, method) for method, _, seconds, error in runs if error <= wanted]
        ours = min((seconds for seconds, method in keeping if method == "auto"), default=np.inf)
        if not keeping:
            continue
        seconds, method = min(keeping)
        if np.isinf(ours):
            lines.append(f"{title}: {wanted:g}: auto did not keep it within {most_seconds:g} s")
            continue
        lines.append(
            f"{title}: {wanted:g}: {ours / seconds:.2f} ({ours:.3g} s, {method} {seconds:.3g} s"
            f"{', short' if ours < SHORT else ''}); error of auto / rtol up to {worst:.2g}"
        )
    return lines


def main() -> int:
    """Measure, as a command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="100-130")
    parser.add_argument("--seconds", type=float, default=3.0, help="largest time of a run")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    first, last = map(int, options.seeds.split("-"))
    ratios: dict[bool, list[float]] = {True: [], False: []}
    for seed in range(first, last):
        for line in rows_of(seed, options.seconds):
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
