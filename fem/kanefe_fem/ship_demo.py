"""``kanefe demo --ship``: five minutes of a helicopter on a moving deck."""

from __future__ import annotations

import math
import time
from importlib.resources import as_file, files
from pathlib import Path
from typing import NamedTuple

import numpy as np

import kanefe as kf
from kanefe_fem.sramss import lashing_lengths, spatial_gear, spatial_scene, state_at
from kanefe_fem.sramss.spatial import SADDLES, SHOES

SPAN, RISE = 300.0, 20.0  # s
TENSION = 2000.0  # N, of each lashing at rest
WET = 0.15  # friction of the shoes on a wet deck

COMPONENTS = 60
SLOWEST, FASTEST = 0.4, 1.1  # rad/s
SIZES = (0.3, 0.4, 0.7, math.radians(3.0), math.radians(1.0), math.radians(0.3))
"""Standard deviations of the deck's motion along and about x, y and z, m and rad: a frigate in a rough sea, assumed."""


class Passage(NamedTuple):
    """A run of the demonstration, and what it is called."""

    name: str
    result: kf.Result


def deck_motion(seed: int = 1, span: float | None = None) -> kf.PoseTable:
    """Return the motion of a deck for a time (s; five minutes): sums of harmonics of random phases, grown from rest."""
    end = SPAN if span is None else span
    times = np.linspace(0.0, end, round(10 * end) + 1)
    random = np.random.default_rng(seed)
    rates = random.uniform(SLOWEST, FASTEST, COMPONENTS)
    phases = random.uniform(0.0, 2.0 * math.pi, (len(SIZES), COMPONENTS))
    x = np.clip(times / RISE, 0.0, 1.0)
    grown = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    share = math.sqrt(2.0 / COMPONENTS)
    motions = [
        size * share * grown * np.cos(np.outer(times, rates) + p).sum(axis=1)
        for size, p in zip(SIZES, phases, strict=True)
    ]
    turns = [kf.euler_angles("xyz", angles) for angles in np.column_stack(motions[3:])]
    return kf.PoseTable(times, np.column_stack(motions[:3]), turns)


def ship_demo(out: Path) -> None:
    """Run five minutes on a wet deck, loose and lashed; print what slips, write pictures and a VTK series."""
    print("kanefe demo --ship: a helicopter on compliant skids, a wet deck in a rough sea, five minutes\n")
    began = time.perf_counter()
    with as_file(files("kanefe_fem") / "data" / "skid_gear.msh") as path:
        gear = spatial_gear(path)
    lengths = lashing_lengths(gear, TENSION)
    prepared = time.perf_counter()
    _row("gear", f"{gear.mass:.1f} kg, {len(gear.nodes)} nodes of beams, {gear.free_count} modes, 4 saddles, 8 shoes")
    _row("prepared in", f"{prepared - began:.1f} s, with the lengths of the lashings for {TENSION:g} N")
    motion, passages = deck_motion(), []
    for name, lashings in (("loose", None), ("lashed", lengths)):
        rest = kf.equilibrium(spatial_scene(gear, mu=WET, lashings=lashings))
        scene = spatial_scene(gear, motion, mu=WET, lashings=lashings)
        result = scene.simulate((0.0, SPAN), start=state_at(scene, rest), rtol=1e-4, output_step=0.1)
        passages.append(Passage(name, result))
        _tell(name, result)
    for name, result in passages:
        result.plot("contacts", *(SHOES[0], SHOES[4]), path=out / f"ship_{name}.png")
    passages[-1].result.to_vtk(out / "ship.pvd", every=15)
    print(f"\nwritten under {out}/: ship_loose.png, ship_lashed.png, ship.pvd (open it in ParaView)")


def _tell(name: str, result: kf.Result) -> None:
    shoes = [result.contact(shoe) for shoe in SHOES]
    slipped = [
        f"{shoe} at {result.events[f'{shoe} slip'][0]:.1f} s" for shoe in SHOES if len(result.events[f"{shoe} slip"])
    ]
    seconds = result.statistics["seconds"]
    _row(
        name, f"{SPAN:g} s in {seconds:.1f} s, {SPAN / seconds:.0f} times real time, {result.statistics['steps']} steps"
    )
    _row("", f"slid by {max(shoe.slip[-1] for shoe in shoes):.3f} m; first: {slipped[0] if slipped else 'never'}")
    _row("", f"largest load of a shoe {max(shoe.normal.max() for shoe in shoes):.0f} N")
    if name == "lashed":
        pulls = [result.load(f"{saddle} lashing")[:, 2].max() for saddle in SADDLES]
        _row("", f"largest pull of a lashing {max(pulls):.0f} N")
        forces = np.vstack([result.coupling_force("gear", saddle)[:, :3] for saddle in SADDLES])
        _row("", f"largest force of a saddle {np.linalg.norm(forces, axis=1).max():.0f} N")


def _row(name: str, text: str) -> None:
    print(f"  {name:<12} {text}")
