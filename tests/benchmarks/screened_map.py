"""The map of the ship scene by screened runs: 7 headings, 5 sea states, 20 minutes each, on one core.

    PYTHONPATH=.:fem:tests/shared python tests/benchmarks/screened_map.py [--mu 0.6] [--seeds 1] [--whole 2]

Prints the processor time of the screened cases, what of them was integrated, and for some cases that of the whole run
with whether its events are the same.
"""

from __future__ import annotations

import argparse
import time
import warnings
from importlib.resources import as_file, files

import numpy as np

import kanefe as kf
from kanefe_fem.sramss import resting_on, spatial_gear, spatial_scene

HEADINGS, SEA_STATES = range(0, 181, 30), range(3, 8)
HELIDECK = (-45.0, 0.0, 6.0)
RTOL = 1e-6
"""At 1e-4 a whole run by itself has some slips more or less than at 1e-6, where shoes creep to their limit."""


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--mu", type=float, default=0.6)
    options.add_argument("--seeds", type=int, default=1)
    options.add_argument("--duration", type=float, default=1200.0)
    options.add_argument("--whole", type=int, default=2, help="how many cases are run whole too")
    options.add_argument("--seas", type=int, nargs="+", default=list(SEA_STATES))
    given = options.parse_args()
    warnings.simplefilter("ignore")
    with as_file(files("kanefe_fem") / "data" / "skid_gear.msh") as path:
        gear = spatial_gear(path)
    rest, rao = kf.equilibrium(spatial_scene(gear, mu=given.mu)), kf.example_rao()
    spent: dict[int, list[tuple[float, float, int]]] = {sea: [] for sea in given.seas}
    cases = [(sea, heading, seed) for sea in given.seas for heading in HEADINGS for seed in range(given.seeds)]
    compared = {round(i) for i in np.linspace(0, len(cases) - 1, given.whole)} if given.whole else set()
    for number, (state, heading, seed) in enumerate(cases):
        began = time.process_time()
        ship = kf.Ship(rao, kf.Sea.state(state, spreading=2, seed=seed), heading_deg=heading)
        motion = ship.at(HELIDECK, duration=given.duration)
        scene = spatial_scene(gear, motion, mu=given.mu)
        start = resting_on(scene, rest, motion)
        built = time.process_time()
        run = kf.screen(scene, given.duration, start=start, rtol=RTOL)
        done = time.process_time()
        spent[state].append((done - began, run.share, sum(map(len, run.events.values()))))
        if number in compared:
            whole = scene.simulate((0.0, given.duration), start=start, rtol=RTOL)
            seconds = time.process_time() - done
            apart = [name for name in whole.events if len(whole.events[name]) != len(run.events[name])]
            print(
                f"sea state {state}, heading {heading}: whole {seconds:.2f} s, screened {done - built:.2f} s and "
                f"{built - began:.2f} s to build; events {apart or 'the same'}",
                flush=True,
            )
    for state, rows in spent.items():
        seconds, share, events = (np.array(column) for column in zip(*rows, strict=True))
        each = f"{seconds.mean():.2f} s each, {100 * share.mean():.2f} % integrated"
        print(f"sea state {state}: {len(rows)} cases, {each}, {int(events.sum())} events")
    total = sum(row[0] for rows in spent.values() for row in rows)
    print(
        f"all: {total:.1f} s of one core for {len(cases)} cases; 350 on two cores: {350 * total / len(cases) / 2:.0f} s"
    )


if __name__ == "__main__":
    main()
