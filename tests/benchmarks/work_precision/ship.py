"""Figures of a helicopter on a deck: what twenty minutes of it take."""

from __future__ import annotations

import time
from importlib.resources import as_file, files

from benchmarks.goals import Figure, Goal
from benchmarks.work_precision.machine import Machine
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe_fem.ship_demo import TENSION, deck_motion
from kanefe_fem.sramss import lashing_lengths, spatial_gear, spatial_scene
from kanefe_fem.sramss.spatial import SADDLES, SHOES

PASSAGE_GOAL = Goal("helicopter on a deck, 16 modes, 8 shoes, 4 lashings: CPU time of 20 min on one core [s]", 10.0)

SPAN, QUICK_SPAN = 1200.0, 60.0  # s
ROUGH = 0.3
RTOL, FINER = 1e-3, 1e-5


def passage(machine: Machine) -> list[Figure]:
    """Run twenty minutes on a deck in a rough sea, lashed; in a quick run one of them, twenty times as dear."""
    span = QUICK_SPAN if machine.limits.quick else SPAN
    with as_file(files("kanefe_fem") / "data" / "skid_gear.msh") as path:
        gear = spatial_gear(path)
    lashings, motion = lashing_lengths(gear, TENSION), deck_motion(span)
    seconds, pulls, slips = [], [], []
    for rtol in (RTOL, FINER):
        scene = spatial_scene(gear, motion, mu=ROUGH, lashings=lashings)
        start = equilibrium(scene, steady=False).state
        began = time.process_time()
        result = scene.simulate((0.0, span), start=start, rtol=rtol, output_step=0.5)
        seconds.append((time.process_time() - began) * SPAN / span)
        pulls.append(max(float(result.load(f"{saddle} lashing")[:, 2].max()) for saddle in SADDLES))
        slips.append(max(float(result.contact(shoe).slip[-1]) for shoe in SHOES))
    told = (
        f"rtol {RTOL:g}: largest pull {pulls[0]:.1f} N, slip {1e3 * slips[0]:.3f} mm; "
        f"rtol {FINER:g}: {pulls[1]:.1f} N, {1e3 * slips[1]:.3f} mm, {seconds[1]:.1f} s"
    )
    return [PASSAGE_GOAL.figure(seconds[0], told)]
