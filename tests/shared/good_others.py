"""Good calls of what needs files of other programs, a compiler or a whole study."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import import_writers
import kanefe as kf
import kanefe_fem as fem
from good_bodies import EXPECTED
from good_call import CALLS, FILES, Call, call, files, on
from good_elements import BEAM, SECTION, chain
from good_scenes import FRAME, adds, beam, cantilever
from good_seas import SEA, sea
from good_studies import study
from kanefe.fe_model.model import Cells
from steel_beams import STEEL, steel_beam


@cache
def job(kind: str) -> list[Path]:
    """Return the files of a job of Abaqus, Ansys or Nastran."""
    made: list[Path] = getattr(import_writers, f"{kind}_job")(FILES, steel_beam(2), np.arange(1, 4))
    return made


READING = {"groups": None, "units": "m, kg, s", **EXPECTED}


def reads(kind: str, names: tuple[str, ...], /, **more: Any) -> None:
    function = getattr(kf, f"read_{kind}")
    CALLS[f"kanefe.read_{kind}"] = Call(
        lambda: (function, {**dict(zip(names, job(kind), strict=True)), **READING, **more})
    )


reads("abaqus", ("nodes", "stiffness", "mass"), damping=None, substructure=None, trusted=False)
reads("calculix", ("deck", "matrices"), trusted=False)
reads("ansys", ("nodes", "stiffness", "mass", "mapping"), damping=None, generalised=())
if find_spec("pyyeti"):
    reads("nastran", ("bulk", "matrices"), names=None, freedoms=None, generalised=())


@cache
def compiled() -> Any:
    from numba import cfunc, types

    numbers = types.CPointer(types.float64)

    @cfunc(types.void(types.float64, types.float64, numbers, numbers))
    def spring(d: float, rate: float, c: Any, out: Any) -> None:
        out[0] = out[1] = c[0] * d
        out[2] = 0.5 * c[0] * d**2

    return spring


CALLS["kanefe.CompiledLaw"] = Call(
    lambda: (kf.CompiledLaw, {"function": compiled(), "depth": 1e-3, "constants": (1e5,), "slopes": False})
)
STRESS = 2e8 * np.sin(np.arange(40.0))
CURVE = kf.fatigue.SNCurve(160e6, 1e6, 5.0, 9.0)
KNEE = {"cycles": 1e6, "slope": 5.0, "slope_below": 9.0}
CALLS["kanefe.fatigue.SNCurve"] = Call(lambda: (kf.fatigue.SNCurve, {"amplitude": 160e6, **KNEE}))
CALLS["kanefe.fatigue.SNCurve.from_range"] = Call(
    lambda: (kf.fatigue.SNCurve.from_range, {"stress_range": 320e6, **KNEE})
)
CALLS["kanefe.fatigue.Goodman"] = Call(lambda: (kf.fatigue.Goodman, {"ultimate": 500e6}))
CALLS["kanefe.fatigue.Gerber"] = Call(lambda: (kf.fatigue.Gerber, {"ultimate": 500e6}))
CALLS["kanefe.fatigue.Walker"] = Call(lambda: (kf.fatigue.Walker, {"gamma": 0.5}))
CALLS["kanefe.fatigue.count_cycles"] = Call(lambda: (kf.fatigue.count_cycles, {"history": STRESS}))
CALLS["kanefe.fatigue.damage"] = Call(
    lambda: (kf.fatigue.damage, {"history": STRESS, "curve": CURVE, "mean_stress": kf.fatigue.Walker()})
)
on("kanefe.fatigue.SNCurve.life", lambda: CURVE, amplitude=200e6)
on("kanefe.fatigue.Cycles.histogram", lambda: kf.fatigue.count_cycles(STRESS), bins=8)
files("kanefe.Study.table", study().table, store="store")


def turned(heading_deg: float, seed: int) -> kf.System:
    scene = kf.System()
    scene.add_rigid_body("mass", 1.0, joint=kf.Prismatic("x", position=1.0 + seed))
    return scene


@cache
def table() -> kf.StudyTable:
    cases = {"heading_deg": [0.0, 90.0, 180.0], "seed": [0, 1, 2, 3]}
    made = kf.Study(turned, kf.studies.peak("position", "mass", component="x"), duration=0.01, **cases)
    return made.run("serial", FILES / "table", progress=False)


on("kanefe.StudyTable.case", table, key=0)
on("kanefe.StudyTable.column", table, name="seed")
on("kanefe.StudyTable.save", table, path="table.csv")
on("kanefe.StudyTable.operability", table, limit=1.0, over="seed", band=0.9)
chances = cache(lambda: table().operability(1.0))
on("kanefe.studies.Operability.to_html", chances, path="chances.html")
on("kanefe.studies.Operability.plot", chances, angle="heading_deg", radius=None, output=None, path="chances.png")
files(
    "kanefe.Ship.from_rao", kf.Ship.from_rao, path="seas.csv", sea=sea(), speed=0.0, heading_deg=30.0, slowest_hz=0.03
)


@cache
def spectrum() -> Any:
    import xarray

    values = 0.01 * np.outer(np.ones(4), [0.1, 1.0, 0.1, 0.0])
    return xarray.DataArray(values, coords={"freq": [0.1, 0.2, 0.3, 0.4], "dir": [0.0, 90.0, 180.0, 270.0]})


CALLS["kanefe.Sea.from_wavespectra"] = Call(lambda: (kf.Sea.from_wavespectra, {"spectrum": spectrum(), **SEA}))


def lined() -> kf.FiniteElementModel:
    return fem.straight_beam(1.0, SECTION, STEEL, elements=2)


adds(
    "kanefe.System.add_line_load",
    lambda s: {
        "member": s.add_flexible_body(
            "lined", fem.beam_body(lined(), {"root": "clamped"}, reduction=kf.CraigBampton(modes=2))
        ),
        "line": "span",
        "load": (0.0, 1.0, 0.0),
        "follows": False,
    },
)
CALLS["kanefe.System.with_bodies"] = Call(lambda: (cantilever().with_bodies, {"bodies": {"beam": beam()}}))
on("kanefe.FlexibleBody.rebuilt", beam, reduction=kf.CraigBampton(modes=3), stiffening="full", refined=1, order=None)
adds("kanefe.System.add_segmented_body", lambda s: {"name": "b", "body": chain(), **FRAME, "gravity": True})
adds("kanefe.System.segmented_body", lambda s: {"name": s.add_segmented_body("b", chain()).name})
call(
    "kanefe_fem.preloaded",
    fem.preloaded,
    model=steel_beam(2),
    preload=fem.Preload(held={"root": ("x", "y", "z", "rx", "ry", "rz")}, forces={"tip": (1.0, 0.0, 0.0)}),
)
call(
    "kanefe_fem.beam_model_from_mesh",
    fem.beam_model_from_mesh,
    mesh=fem.Mesh(
        nodes=np.array([[0, 0, 0], [0, 0, 1.0], [1.0, 0, 1.0]]),
        dimension=1,
        cells={},
        lines={"leg": (Cells("line", np.array([[0, 1], [1, 2]])),)},
        points={"foot": np.array([0])},
        source="portal",
    ),
    sections={"leg": SECTION},
    materials=STEEL,
    **BEAM,
)
