"""The demonstration ``kanefe demo --ship``: five minutes of a helicopter on a moving deck."""

from __future__ import annotations

import math
import time
from importlib.resources import as_file, files
from pathlib import Path
from typing import NamedTuple

import numpy as np

import kanefe as kf
from kanefe.environment.deck_motion import DeckMotion
from kanefe_fem.recovery.recovery import recover
from kanefe_fem.sramss import lashing_lengths, spatial_gear, spatial_scene
from kanefe_fem.sramss.spatial import SADDLES, SHOES

SPAN, RISE = 300.0, 20.0  # s
TENSION = 2000.0  # tension of each lashing at rest, N
WET = 0.15  # friction of the shoes on a wet deck

SEA_STATE, HEADING_DEG = 5, 60.0
PLACE = (-40.0, 0.0, 6.0)  # position of the deck from the ship's centre of gravity: x forward, y port, z up, m


class Passage(NamedTuple):
    """A run of the demonstration, and its name."""

    name: str
    result: kf.Result


def deck_motion(span: float = SPAN) -> DeckMotion:
    """Return the motion of a frigate's deck in a rough sea, starting from rest, for a duration in s."""
    sea = kf.Sea.state(SEA_STATE, seed=1)
    return kf.Ship(kf.example_rao(), sea, heading_deg=HEADING_DEG).at(PLACE, ramp=RISE, duration=span)


def ship_demo(out: Path) -> None:
    """Run five minutes on a wet deck, loose and lashed; print slip and forces, write pictures and a VTK series."""
    print(
        "kanefe demo --ship: a helicopter on compliant skids on a frigate's wet deck, five minutes in sea state "
        f"{SEA_STATE}, {HEADING_DEG:g} degrees off head seas\n"
    )
    began = time.perf_counter()
    with as_file(files("kanefe_fem") / "data" / "skid_gear.msh") as path:
        gear = spatial_gear(path)
    lengths = lashing_lengths(gear, TENSION)
    prepared = time.perf_counter()
    _row("gear", f"{gear.mass:.1f} kg, {len(gear.nodes)} nodes of beams, {gear.free_count} modes, 4 saddles, 8 shoes")
    _row("prepared in", f"{prepared - began:.1f} s, with the lengths of the lashings for {TENSION:g} N")
    motion, passages = deck_motion(), []
    for name, lashings in (("loose", None), ("lashed", lengths)):
        scene = spatial_scene(gear, motion, mu=WET, lashings=lashings)
        rest = kf.equilibrium(scene, steady=False)
        result = scene.simulate((0.0, SPAN), start=rest.state, rtol=1e-4, output_step=0.1)
        passages.append(Passage(name, result))
        _print_run(name, result)
    for name, result in passages:
        result.plot("contacts", *(SHOES[0], SHOES[4]), path=out / f"ship_{name}.png")
    passages[-1].result.to_vtk(out / "ship.pvd", every=15)
    last = passages[-1].result
    last.to_html(out / "ship.html", stress=recover(last, "gear"), title="a helicopter on a frigate's deck")
    pages = "ship.pvd (open it in ParaView), ship.html (open it in a browser)"
    print(f"\nwritten under {out}/: ship_loose.png, ship_lashed.png, {pages}")


def _print_run(name: str, result: kf.Result) -> None:
    shoes = [result.contact(shoe) for shoe in SHOES]
    at, first = min((float(min(result.events[f"{shoe} slip"], default=math.inf)), shoe) for shoe in SHOES)
    seconds = result.statistics["seconds"]
    _row(
        name, f"{SPAN:g} s in {seconds:.1f} s, {SPAN / seconds:.0f} times real time, {result.statistics['steps']} steps"
    )
    slip = f"{first} at {at:.1f} s" if at < math.inf else "never"
    _row("", f"slid by {max(shoe.slip[-1] for shoe in shoes):.3f} m; first: {slip}")
    _row("", f"largest load of a shoe {max(shoe.normal.max() for shoe in shoes):.0f} N")
    if name == "lashed":
        pulls = [result.load(f"{saddle} lashing")[:, 2].max() for saddle in SADDLES]
        _row("", f"largest pull of a lashing {max(pulls):.0f} N")
        forces = np.vstack([result.coupling_force("gear", saddle)[:, :3] for saddle in SADDLES])
        _row("", f"largest force of a saddle {np.linalg.norm(forces, axis=1).max():.0f} N")


def _row(name: str, text: str) -> None:
    print(f"  {name:<12} {text}")
