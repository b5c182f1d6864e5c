"""What meshes, element orders and numbers of modes cost and bring: errors of S3 and the demo against a finer body."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from importlib.resources import as_file, files

import numpy as np

from kanefe.flexible import FlexibleBody
from kanefe.model import Model
from kanefe.reduction import CraigBampton
from kanefe_fem import demo
from kanefe_fem.bench import steel_bar, swinging_arm
from kanefe_fem.bench.refined import refined
from kanefe_fem.bench.runs import run
from kanefe_fem.bench.scene import BenchScene, Setting
from kanefe_fem.mesh import Mesh, read_mesh
from kanefe_fem.solid import solid_body

SETTING = Setting("auto", rtol=1e-9)
"""Of all runs: their error in time must be far below that of the bodies."""

BAR_CELLS = ((4, 1, 1), (8, 1, 1), (12, 2, 1), (21, 4, 3), (32, 6, 4))
FINEST_BAR, FINEST_MODES = (42, 8, 4), 24
USUAL_MODES = 8
MODES = (0, 1, 2, 4, 8, 16)


@dataclass(frozen=True)
class Trial:
    """A body and the run with it.

    Attributes
    ----------
    scene, curve, label : str
        Which scene, what is varied, and its value.
    nodes, coordinates : int
        Of the mesh and of the reduced body.
    body_seconds, run_seconds : float
        CPU time from mesh to body, and of the run.
    error : float
        Distance from the run with the finest body, m.
    """

    scene: str
    curve: str
    label: str
    nodes: int
    coordinates: int
    body_seconds: float
    run_seconds: float
    error: float

    @property
    def seconds(self) -> float:
        """CPU time of body and run."""
        return self.body_seconds + self.run_seconds


Variant = tuple[str, str, Callable[[], FlexibleBody]]
"""Curve, label and body."""


def bar_trials(quick: bool) -> Iterator[Trial]:
    """Yield the trials of S3."""

    def body(cells: tuple[int, int, int], order: int, modes: int) -> FlexibleBody:
        return steel_bar.made_body(modes, cells, order)

    meshes = BAR_CELLS[: 4 if quick else None]
    variants: list[Variant] = [
        (f"order {order}, meshes", "x".join(map(str, cells)), partial(body, cells, order, USUAL_MODES))
        for order in (1, 2)
        for cells in meshes
    ]
    variants += [
        ("order 2, 21x4x3, 0 to 16 modes", f"{modes}", partial(body, steel_bar.HINGED_CELLS, 2, modes))
        for modes in MODES
    ]
    finest = partial(body, FINEST_BAR, 2, FINEST_MODES)
    yield from _trials(steel_bar.hinged(USUAL_MODES, "S3"), steel_bar.hinged_bar, variants, finest)


def arm_trials(quick: bool) -> Iterator[Trial]:
    """Yield the trials of the demo."""
    with ExitStack() as stack:
        given = read_mesh(stack.enter_context(as_file(files("kanefe_fem") / "data" / "arm.msh")))
    halved = refined(given)

    def body(mesh: Mesh, order: int, reduction: CraigBampton = demo.REDUCTION) -> FlexibleBody:
        return solid_body(
            mesh, {"arm": demo.ALUMINIUM}, demo.INTERFACES, reduction, demo.DAMPING, order, cache=False, progress=False
        )

    variants: list[Variant] = [
        ("order 1, meshes", "given", partial(body, given, 1)),
        ("order 1, meshes", "halved", partial(body, halved, 1)),
        ("order 2, meshes", "given", partial(body, given, 2)),
    ]
    if not quick:
        variants.append(("order 2, meshes", "halved", partial(body, halved, 2)))
    variants += [
        ("order 2, given mesh, 0 to 16 modes", f"{modes}", partial(body, given, 2, CraigBampton(modes=modes)))
        for modes in MODES
    ]
    finest = partial(body, given if quick else halved, 2, CraigBampton(modes=FINEST_MODES))
    yield from _trials(swinging_arm.swinging_arm(), lambda arm: demo.swing_scene(arm).freeze(), variants, finest)


TRIALS = {"S3": bar_trials, "demo": arm_trials}
TITLES = {"S3": "S3 · hinged bar", "demo": "demo · arm of the hub"}


def _trials(
    scene: BenchScene,
    place: Callable[[FlexibleBody], Model],
    variants: Sequence[Variant],
    finest: Callable[[], FlexibleBody],
) -> Iterator[Trial]:
    exact, *_ = _timed(scene, place, finest)
    variants[0][2]()  # what compiles forms or imports is not part of the first trial
    for curve, label, make in variants:
        print(f"{scene.name}: {curve} {label}", file=sys.stderr, flush=True)
        values, body, body_seconds, run_seconds = _timed(scene, place, make)
        error = scene.error(values, exact)
        yield Trial(scene.name, curve, label, len(body.nodes), body.free_count, body_seconds, run_seconds, error)


def _timed(
    scene: BenchScene, place: Callable[[FlexibleBody], Model], make: Callable[[], FlexibleBody]
) -> tuple[np.ndarray, FlexibleBody, float, float]:
    start = time.process_time()
    body = make()
    made = time.process_time()
    model = place(body)
    found = run(model, scene, SETTING)
    return scene.measured(model, found), body, made - start, time.process_time() - made
