"""Bounds against true errors: random scenes by fixed seeds, with answers by brute force.

Of each scene the bound of each quantity and its true error are printed, and what all evaluations took in relation to
one run at the setting that was found. Errors that the reference itself does not know better are left out.
"""

from __future__ import annotations

import time
import warnings

import numpy as np

from certified_scenes import known_scene

SEEDS = range(100)
"""Of the scenes; fixed before anything was measured."""


def of_scene(seed: int) -> tuple[str, bool, np.ndarray, np.ndarray, np.ndarray, float, float]:
    """Return name, whether it was met, errors, bounds and what is allowed of quantities that count, CPU time, work."""
    known = known_scene(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        begun = time.process_time()
        result = known.build(0).simulate((0.0, known.span), accuracy=known.accuracy, of=known.of)
        seconds = time.process_time() - begun
        every = round((len(result.times) - 1) / 500)
        exact, unknown = known.reference(np.asarray(result.times)[::every])
    errors = np.array([a.apart(b) for a, b in zip(known.read(result, every), exact, strict=True)])
    found, counts = result.accuracy, errors > unknown
    values = (errors[counts], found.bounds[counts], found.allowed[counts])
    return (known.name, found.is_met, *values, seconds, found.work)


def certified(count: int) -> None:
    """Print a line for each scene, and the figures of all."""
    ratios, shares, works, refused = [], [], [], []
    for seed in SEEDS[:count]:
        name, is_met, errors, bounds, allowed, seconds, work = of_scene(seed)
        own = bounds / np.maximum(errors, 1e-300)
        ratios += own[np.isfinite(own)].tolist()
        shares += (errors / allowed).tolist() if is_met else []
        works.append(work)
        refused += [] if is_met else [f"{seed} ({name})"]
        text = " ".join(f"{one:.3g}" for one in own)
        print(
            f"{seed:4d}  {name:24s} {'met' if is_met else 'refused':8s} {seconds:7.2f} s  bound/error {text}",
            flush=True,
        )
    values = np.array(ratios)
    print(f"\n{count} scenes, {len(values)} quantities whose error the reference knows")
    print(f"error at most the bound: {100 * np.mean(values >= 1.0):.1f} % (goal 95 %)")
    print(f"error above two bounds: {np.sum(values < 0.5)} (goal 0)")
    middle, high = np.median(values), np.quantile(values, 0.9)
    print(f"bound / error: median {middle:.2g} (goal 3), 90 % quantile {high:.2g} (goal 10)")
    print(f"error / allowed where met: largest {np.max(shares):.2g}, median {np.median(shares):.2g}")
    print(f"refused: {len(refused)} (goal 5 %): {', '.join(refused) or 'none'}")
    print(f"work of all evaluations / that of the answer: median {np.median(works):.2g}, largest {np.max(works):.2g}")
