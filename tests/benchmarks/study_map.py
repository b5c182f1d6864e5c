"""The map of the ship scene, run whole and killed twice on the way: 7 headings, 5 sea states, 10 seeds.

    PYTHONPATH=.:fem:tests/shared python tests/benchmarks/study_map.py [--duration 12] [--workers 2]

The helicopter in space stands on the wet helideck of a frigate, 45 m aft of its centre and 6 m above. The study is run
in a process of its own, which gets SIGKILL when a third of the cases is done, and again at two thirds; what goes on in
the store is to run no case twice, and the table is to be that of a study that nothing disturbed, to the last bit.
``--duration 1200`` is the map of twenty minutes a case.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from functools import cache
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import kanefe as kf
from kanefe.bodies.flexible import FlexibleBody
from kanefe.studies.table import MEASURED
from kanefe_fem.sramss import resting_on, spatial_gear, spatial_scene
from kanefe_fem.sramss.spatial import SHOES

HEADINGS = tuple(range(0, 181, 30))
SEA_STATES = tuple(range(3, 8))
SEEDS = 10

HELIDECK = (-45.0, 0.0, 6.0)
WET = 0.15
RAMP = 5.0  # s
SHARES = (1 / 3, 2 / 3)
"""Of the cases, at which the study is killed."""


@cache
def gear() -> FlexibleBody:
    with as_file(files("kanefe_fem") / "data" / "skid_gear.msh") as path:
        return spatial_gear(path)


@cache
def rest() -> kf.Equilibrium:
    return kf.equilibrium(spatial_scene(gear(), mu=WET))


def on_helideck(heading_deg: float, sea_state: int, seed: int, duration: float) -> tuple[kf.System, dict[str, Any]]:
    """Return the scene of a case, and its start."""
    sea = kf.Sea.state(sea_state, spreading=2, seed=seed)
    ship = kf.Ship(kf.example_rao(), sea, heading_deg=heading_deg)
    motion = ship.at(HELIDECK, duration=duration, ramp=RAMP)
    scene = spatial_scene(gear(), motion, mu=WET)
    return scene, {"start": resting_on(scene, rest(), motion), "t_span": (0.0, duration)}


def peaks(result: kf.Result) -> dict[str, Any]:
    """Return what is kept of a run: loads, and what slipped."""
    shoes = [result.contact(name) for name in SHOES]
    return {
        "slip": max(float(shoe.slip[-1]) for shoe in shoes),
        "slips": sum(len(result.events[f"{name} slip"]) for name in SHOES),
        "normal": max(float(shoe.normal.max()) for shoe in shoes),
        "lightest": min(float(shoe.normal.min()) for shoe in shoes),
    }


def study(duration: float) -> kf.Study:
    return kf.Study(
        on_helideck,
        peaks,
        rtol=1e-4,
        simulate={"output_step": 0.1},
        table=[{"duration": duration}],
        heading_deg=HEADINGS,
        sea_state=SEA_STATES,
        seed=range(SEEDS),
    )


def rows(store: Path) -> list[list[str]]:
    """Return the keys of each file of rows: one file for each time that the study was run."""
    found = []
    for path in sorted((store / "rows").glob("*.jsonl")):
        lines = path.read_bytes().split(b"\n")[:-1]  # what has no end was cut
        found.append([json.loads(line)["key"] for line in lines])
    return found


def start(store: Path, duration: float, workers: int) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "study_map", "--into", str(store), "--duration", str(duration)]
    folder = str(Path(__file__).parent)
    path = os.pathsep.join([folder, *filter(None, [os.environ.get("PYTHONPATH")])])
    return subprocess.Popen([*command, "--workers", str(workers)], env={**os.environ, "PYTHONPATH": path})


def killed_twice(store: Path, duration: float, workers: int) -> tuple[float, list[int]]:
    """Run the study into a store, killed twice; return the time it took, and how many cases were there each time."""
    began, there = time.perf_counter(), []
    count = len(HEADINGS) * len(SEA_STATES) * SEEDS
    for share in SHARES:
        process = start(store, duration, workers)
        while process.poll() is None and sum(map(len, rows(store))) < share * count:
            time.sleep(0.05)
        if process.poll() is not None:
            raise SystemExit(f"the study ended before it could be killed, with {process.returncode}")
        process.send_signal(signal.SIGKILL)
        process.wait()
        there.append(sum(map(len, rows(store))))
    if start(store, duration, workers).wait():
        raise SystemExit("the study did not go on after it was killed")
    return time.perf_counter() - began, there


def bits(table: kf.StudyTable) -> str:
    """Return a hash of all columns but those that tell of the machine."""
    columns = {name: values for name, values in table.lists().items() if name not in MEASURED}
    return hashlib.sha256(json.dumps(columns).encode()).hexdigest()


def told(name: str, seconds: float, table: kf.StudyTable, workers: int) -> None:
    inside, cpu = float(table.column("wall").sum()), float(table.column("cpu").sum())
    beyond = 1e3 * (seconds * workers - inside) / len(table)
    print(
        f"{name}: {seconds:.1f} s, in the cases {inside:.1f} s ({cpu:.1f} s of CPU); beyond them {beyond:.1f} ms each"
    )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--duration", type=float, default=12.0)
    options.add_argument("--workers", type=int, default=2)
    options.add_argument("--into", type=Path, help="only run the study into this store")
    given = options.parse_args()
    # under one name wherever it runs, so that all of them are the same study
    import study_map

    made = study_map.study(given.duration)
    if given.into:
        made.run("processes", store=given.into, workers=given.workers)
        return
    with tempfile.TemporaryDirectory(prefix="kanefe_map_") as folder:
        broken, whole = Path(folder) / "broken", Path(folder) / "whole"
        began = time.perf_counter()
        table = made.run("processes", store=whole, workers=given.workers)
        told("unbroken", time.perf_counter() - began, table, given.workers)
        print(table)
        seconds, there = killed_twice(broken, given.duration, given.workers)
        again = made.table(broken)
        told(f"killed with {there[0]} and {there[1]} cases done", seconds, again, given.workers)
        keys = [key for part in rows(broken) for key in part]
        twice = len(keys) - len(set(keys))
        same = bits(again) == bits(table)
        print(f"cases run twice: {twice}; the same bits: {same}")
        slipped = table.column("slip") > 0.0
        print(f"slipped: {slipped.sum()} of {len(table)}")
        if twice or not same or len(again.column("slip")) != len(made):
            raise SystemExit("MISSED")


if __name__ == "__main__":
    main()
