"""What meshes, element orders and numbers of modes cost and bring: errors of S3 and the demo against a finer body.

Meshes of tetrahedra with every edge halved.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from importlib.resources import as_file, files

import numpy as np

from benchmarks.work_precision import steel_bar, swinging_arm
from benchmarks.work_precision.runs import run
from benchmarks.work_precision.scene import BenchScene, Setting
from kanefe.bodies.flexible import FlexibleBody
from kanefe.equations.model import Model
from kanefe.fe_model.model import Cells
from kanefe.reduction import CraigBampton
from kanefe_fem import demo
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh_files import read_mesh
from kanefe_fem.solids.body import solid_body

SETTING = Setting("auto", rtol=1e-9)
"""Method and tolerance of all runs: their time error must be far below the error of the bodies."""


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
"""Curve, label and function that makes the body."""


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
            mesh,
            {"arm": demo.ALUMINIUM},
            demo.INTERFACES,
            reduction=reduction,
            damping=demo.DAMPING,
            order=order,
            cache=False,
            progress=False,
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


# In VTK's numbers of the quadratic element. The octahedron that is left in the middle is cut along one diagonal.
TETRAHEDRA = (
    (0, 4, 6, 7),
    (4, 1, 5, 8),
    (6, 5, 2, 9),
    (7, 8, 9, 3),
    (6, 8, 4, 5),
    (6, 8, 5, 9),
    (6, 8, 9, 7),
    (6, 8, 7, 4),
)


TRIANGLES = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))


EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))


def refined(mesh: Mesh) -> Mesh:
    """Return a mesh of quadratic tetrahedra with each cut into eight, of the same curved shape.

    Lines and single points are left out.
    """
    lifted = mesh.with_order(2)
    places = _barycentric()
    parts = [_ordered(part, places) for part in TETRAHEDRA]

    def cut(block: Cells) -> Cells:
        return Cells("tetra", np.concatenate([block.nodes[:, part] for part in parts]))

    def cut_facets(block: Cells) -> Cells:
        return Cells("triangle", np.concatenate([block.nodes[:, list(part)] for part in TRIANGLES]))

    halves = replace(
        lifted,
        cells={name: tuple(cut(block) for block in blocks) for name, blocks in lifted.cells.items()},
        facets={name: tuple(cut_facets(block) for block in blocks) for name, blocks in lifted.facets.items()},
        lines={},
        points={},
    ).with_order(2)
    nodes = np.array(halves.nodes)
    for old, new in zip(lifted.cell_blocks, halves.cell_blocks, strict=True):
        for number, part in enumerate(parts):
            own = new.nodes[number * len(old.nodes) : (number + 1) * len(old.nodes), 4:]
            at = np.array([places[part[list(edge)]].mean(axis=0) for edge in EDGES])
            nodes[own] = np.einsum("ec,ncx->nex", _shape_functions(at), lifted.nodes[old.nodes])
    return replace(halves, nodes=nodes)


def _barycentric() -> np.ndarray:
    """Return the coordinates of the ten nodes, (10, 4)."""
    corners = np.eye(4)
    return np.concatenate((corners, [corners[list(edge)].mean(axis=0) for edge in EDGES]))


def _shape_functions(at: np.ndarray) -> np.ndarray:
    """Return the shape functions of the quadratic tetrahedron at barycentric coordinates, (points, 10)."""
    of_corners = at * (2.0 * at - 1.0)
    return np.concatenate((of_corners, np.stack([4.0 * at[:, a] * at[:, b] for a, b in EDGES], axis=1)), axis=1)


def _ordered(part: tuple[int, ...], places: np.ndarray) -> np.ndarray:
    """Return the corners of a part so that its volume is positive."""
    corners = places[list(part), 1:]
    is_odd = np.linalg.det(corners[1:] - corners[0]) < 0.0
    return np.array(part)[[0, 2, 1, 3] if is_odd else [0, 1, 2, 3]]
