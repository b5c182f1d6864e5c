"""Decks: input files drawn at random against CalculiX, and the time to read large ones against meshio.

    python tests/benchmarks/decks.py [--json FILE] [--quick]

CalculiX (Debian: `apt install calculix-ccx`) runs each drawn deck; nodes, sets and masses of what `read_mesh` makes of
it are compared with its own. Places of grid points of drawn bulk data are compared with those of pyNastran, for which
an environment is made; it loses CP of GRDSET, which the deck that it reads therefore has at each point.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.clocks import seconds
from benchmarks.command_line import parser, run
from benchmarks.goals import Figure, Goal
from benchmarks.peer_process import NoPeers, Peers, peer_python

UNLIKE = Goal("input files of {} drawn at random whose nodes, sets or masses differ from CalculiX's", 0)
PLACES = Goal(
    "2000 grid points in systems in systems, drawn {} times: largest distance from pyNastran's, relative", 1e-12
)
TIME = Goal("time to read a deck of {} nodes, {}, relative to meshio's", 1.0)

NASTRAN = Path(__file__).with_name("peer_nastran.py")

SIDE, QUICK_SIDE = 46, 15
"""Number of nodes along each edge of the cube of a deck that is timed."""

ROUNDS = 5
"""Of the comparison of times, which alternate."""

SAME = 1e-9
"""Largest difference of places, in sizes of the body, and of masses: decks have ten digits in both."""


def measured(options: argparse.Namespace) -> list[Figure]:
    """Return the figures: decks that differ, and times."""
    return [
        _unlike(range(10 if options.quick else 100)),
        _places(options, range(2 if options.quick else 10)),
        *(_time(which, QUICK_SIDE if options.quick else SIDE) for which in (".inp", ".bdf", ".bdf in free fields")),
    ]


def _unlike(seeds: range) -> Figure:
    goal = Goal(UNLIKE.what.format(len(seeds)), UNLIKE.limit)
    if shutil.which("ccx") is None:
        return goal.skipped("there is no CalculiX (apt install calculix-ccx)")
    found = {seed: what for seed in seeds if (what := difference(seed))}
    return goal.figure(len(found), "; ".join(f"{seed}: {what}" for seed, what in found.items()))


def difference(seed: int) -> str:
    """Return in what a deck differs from what CalculiX reads; "": in nothing."""
    import numpy as np

    from benchmarks.drawn_decks import DENSITIES, REFERENCE, answer_of, deck_of
    from kanefe.fe_model.shapes import measures
    from kanefe_fem import read_mesh

    deck = deck_of(seed)
    with tempfile.TemporaryDirectory() as folder:
        answer = answer_of(deck, Path(folder))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            mesh = read_mesh(Path(folder) / "a.inp")
    nodes = np.asarray(mesh.nodes)
    size = float(np.ptp(nodes[mesh.body_nodes], axis=0).max())

    def is_same(rows: np.ndarray, points: list[np.ndarray]) -> bool:
        """Whether nodes are those points, in any order."""
        ours, theirs = nodes[rows], np.array(points).reshape(-1, 3)
        if ours.shape != theirs.shape:
            return False
        far = np.abs(ours[:, None] - theirs[None]).max(axis=2)
        return bool((far.min(axis=0) <= SAME * size).all() and (far.min(axis=1) <= SAME * size).all())

    if not is_same(mesh.body_nodes, list(answer.points.values())):
        return "nodes"
    names = {"".join(name.split()).upper(): rows for name, rows in mesh.points.items()}
    for name, labels in answer.sets.items():
        points = [answer.points.get(label, np.array(REFERENCE)) for label in labels]
        if not is_same(names.get("".join(name.split()).upper(), np.zeros(0, dtype=int)), points):
            return f"set {name}"
    mass = sum(
        DENSITIES[name.upper()] * measures(block.kind, nodes[block.nodes])[0].sum()
        for name, blocks in mesh.cells.items()
        for block in blocks
    )
    return "" if abs(mass - answer.mass) <= SAME * answer.mass else f"mass: {mass} kg, and {answer.mass} kg"


def _places(options: argparse.Namespace, seeds: range) -> Figure:
    """Return the largest distance of points from where pyNastran has them, in sizes of what all have."""
    import numpy as np
    import platformdirs

    from benchmarks.drawn_bulk_data import bulk_of
    from kanefe.imports.bulk_data import bulk_cards
    from kanefe.imports.grid_points import grid_points

    goal = Goal(PLACES.what.format(len(seeds)), PLACES.limit)
    folder = options.env or Path(platformdirs.user_cache_dir("kanefe")) / "nastran"
    try:
        python = peer_python(folder, ("pyNastran==1.4.1", "setuptools<81"), "import pyNastran.bdf.bdf")
    except NoPeers as reason:
        return goal.skipped(str(reason))
    found = []
    with Peers(python, NASTRAN) as peers, tempfile.TemporaryDirectory() as drawn:
        path = Path(drawn) / "a.bdf"
        for seed in seeds:
            path.write_text(bulk_of(seed), encoding="ascii")
            ours = grid_points(bulk_cards(path))
            path.write_text(bulk_of(seed, explicit=True), encoding="ascii")
            answer = peers.ask("places", path=str(path))
            theirs = np.array(answer["places"])[np.argsort(answer["labels"])]
            points = ours.points[np.argsort(ours.labels)]
            if not np.array_equal(np.sort(ours.labels), np.sort(answer["labels"])):
                raise RuntimeError(f"pyNastran has other grid points in the deck {seed}")
            found.append(np.abs(points - theirs).max() / np.abs(theirs).max())
    return goal.figure(max(found))


def _time(which: str, side: int) -> Figure:
    import numpy as np

    from kanefe_fem import read_mesh

    goal, suffix = Goal(TIME.what.format(side**3, which), TIME.limit), which.partition(" ")[0]
    try:
        import meshio
    except ImportError:
        return goal.skipped("there is no meshio")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"cube{suffix}"
        path.write_text(cube(side, which), encoding="ascii")
        mesh = read_mesh(path)
        theirs = meshio.read(path)
        if not np.allclose(theirs.points, mesh.nodes) or len(theirs.cells[0].data) != mesh.cell_count:
            raise RuntimeError(f"meshio reads another mesh of {path}")
        both: list[Callable[[], object]] = [lambda: _parsed(path), lambda: meshio.read(path)]
        ratios = sorted(seconds(both[0]) / seconds(both[1]) for _ in range(ROUNDS))
    return goal.figure(ratios[ROUNDS // 2])


def _parsed(path: Path) -> object:
    """Return the mesh of a deck before it is checked, which meshio does not do."""
    from kanefe_fem.mesh.abaqus_deck import read_abaqus_mesh
    from kanefe_fem.mesh.nastran_deck import read_nastran_mesh

    return read_abaqus_mesh(path, False) if path.suffix == ".inp" else read_nastran_mesh(path, {})


def cube(side: int, which: str) -> str:
    """Return a deck of bricks with so many nodes along each edge, as programs write it."""
    import numpy as np

    nodes = np.indices((side, side, side)).reshape(3, -1).T * 0.1
    first = (np.indices((side - 1,) * 3).reshape(3, -1).T @ (side**2, side, 1)) + 1
    offsets = np.array(((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)))
    cells = first[:, None] + (offsets @ (side**2, side, 1))[None]
    if which == ".inp":
        places = [f"{i:7d}, {x:13.6g}, {y:13.6g}, {z:13.6g}" for i, (x, y, z) in enumerate(nodes.tolist(), 1)]
        bricks = [f"{i}, " + ", ".join(map(str, row)) for i, row in enumerate(cells.tolist(), 1)]
        return "\n".join(["*HEADING", "*NODE", *places, "*ELEMENT, TYPE=C3D8R, ELSET=ALL", *bricks, ""])
    if "free" in which:
        places = [f"GRID,{i},,{x:.6g},{y:.6g},{z:.6g}" for i, (x, y, z) in enumerate(nodes.tolist(), 1)]
        bricks = [
            f"CHEXA,{i},1,{','.join(map(str, row[:6]))},+\n+,{row[6]},{row[7]}"
            for i, row in enumerate(cells.tolist(), 1)
        ]
        return "\n".join(["BEGIN BULK", *places, *bricks, "ENDDATA", ""])
    places = [f"GRID    {i:8d}        {x:8.4f}{y:8.4f}{z:8.4f}" for i, (x, y, z) in enumerate(nodes.tolist(), 1)]
    bricks = []
    for i, row in enumerate(cells.tolist(), 1):
        bricks += [
            "CHEXA   " + "".join(f"{x:8d}" for x in (i, 1, *row[:6])) + "+",
            "+       " + f"{row[6]:8d}{row[7]:8d}",
        ]
    return "\n".join(["BEGIN BULK", *places, *bricks, "ENDDATA", ""])


if __name__ == "__main__":
    options = parser(__doc__, quick="ten decks, and small ones to be timed").parse_args()
    sys.exit(run(options, measured))
