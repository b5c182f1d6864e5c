"""Which body to take when something bends: error of the tip over CPU time and coordinates, for all kinds of bodies.

    python tests/benchmarks/bending.py [--env FOLDER] [--json FILE] [--png FILE] [--machine TEXT] [--quick]

A strip of spring steel, 1 m x 20 mm x 1 mm, in its plane: a link that a motor slews by 90 degrees in a second, and an
elastica. With --env also the ANCF cable and the geometrically exact beam of Exudyn, in an environment of its own. Each
body is run finely and then by all methods and tolerances; its figure is that of the cheapest run that differs from the
fine one by at most `CLOSE` of the error of that.
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import sys
from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))
    from benchmarks.clocks import use_one_core

    use_one_core()

import numpy as np

from benchmarks import bending_scenes as scenes
from benchmarks.bending_picture import picture
from benchmarks.bending_scenes import LENGTH, Kind
from benchmarks.goals import median
from benchmarks.peer_process import NoPeers, Peers, peer_python
from kanefe.errors import KanefeError

SERVER = Path(__file__).with_name("peer_bending.py")
PEER_KINDS = {"exact": "Exudyn, geometrically exact", "cable": "Exudyn, ANCF cable"}
PEER_ELEMENTS = (4, 8, 16, 32, 64)
PEER_STEPS, LOAD_STEPS = (3000, 90, 300, 900), (20, 1, 5)

FINEST = "radau5", 1e-8
TOLERANCES = {
    "radau5": (1e-2, 1e-4, 1e-6),
    "dop853": (1e-2, 1e-4, 1e-6),
    "generalised-alpha": (1e-3, 1e-5, 1e-6, 1e-7, 1e-8),
}
CLOSE, LONGEST, ROUNDS = 0.2, 4.0, 5
"""Share of integration in the error; CPU time, s, from which on a run is not repeated; repetitions."""

LOAD = 5.0
"""Of the elastica, P L^2 / EI."""

ANGLES = tuple(scenes.ANGLE / 2**i for i in range(7, -1, -1))
BENDING = (
    (scenes.LINEAR, 4),
    (scenes.INERTIAL, 4),
    (scenes.FULL, 4),
    *((scenes.SEGMENTS, k) for k in (2, 4, 8, 16)),
    *((scenes.STIFF_SEGMENTS, k) for k in (4, 8, 16)),
    *((scenes.LEGENDRE, k) for k in (3, 4, 6)),
)
"""Bodies whose error is measured over how far they bend."""


class Point(NamedTuple):
    """Error of the tip over the length, CPU time in s, and how it was found; infinite where nothing was."""

    kind: str
    size: int
    coordinates: int
    error: float
    seconds: float
    how: str


Trial = Callable[[], tuple[np.ndarray, float]]


def error_of(found: Any, exact: np.ndarray) -> float:
    """Return the largest distance of the tip from where it should be, over the length."""
    return float(np.linalg.norm(np.asarray(found)[..., :2] - exact[..., :2], axis=-1).max() / LENGTH)


def best(kind: str, size: int, coordinates: int, trials: Iterable[tuple[str, Trial]], exact: np.ndarray) -> Point:
    """Return the cheapest run with nearly the same tip as the first one, which is the finest."""
    done: list[tuple[float, np.ndarray, str, Trial]] = []
    failed = ""
    for how, trial in trials:
        try:
            found, seconds = trial()
        except (KanefeError, NoPeers) as failure:
            failed = failed or f"{how}: {str(failure).splitlines()[0]}"
            continue
        if np.isfinite(found).all():
            done.append((seconds, found, how, trial))
    if not done:
        return Point(kind, size, coordinates, math.inf, math.inf, failed)
    finest = done[0][1]
    limit = CLOSE * error_of(finest, exact)
    seconds, found, how, trial = min((one for one in done if error_of(one[1], finest) <= limit), key=lambda one: one[0])
    if seconds < LONGEST:
        seconds = median([trial()[1] for _ in range(ROUNDS)])
    return Point(kind, size, coordinates, error_of(found, exact), seconds, how)


def slewed(kind: Kind, size: int, exact: np.ndarray) -> Point:
    """Return the figure of a body of the link."""
    model, count = scenes.link(kind, size)
    how = [FINEST, *((method, rtol) for method in kind.methods for rtol in TOLERANCES[method])]
    trials = [(f"{method} {rtol:g}", partial(scenes.run, model, method, rtol)) for method, rtol in how]
    return best(kind.name, size, count, trials, exact)


def hung(kind: Kind, size: int, exact: np.ndarray) -> Point:
    """Return the figure of a body of the elastica."""
    model, count = scenes.elastica(kind, size, LOAD)
    return best(kind.name, size, count, [("equilibrium", lambda: scenes.rest(model))], exact)


def of_peer(peers: Peers, do: str, exact: np.ndarray) -> list[Point]:
    """Return the figures of the peer."""
    beam = {
        "length": LENGTH,
        "line_mass": scenes.LINE_MASS,
        "line_inertia": scenes.LINE_INERTIA,
        "bending": scenes.BENDING,
        "stretching": scenes.STRETCHING,
        "angle": scenes.ANGLE,
        "slewed": scenes.SLEWED,
        "end": scenes.END,
        "samples": len(scenes.TIMES),
        "force": LOAD * scenes.BENDING / LENGTH**2,
    }
    field, name, steps = ("steps", "steps", PEER_STEPS) if do == "slew" else ("load_steps", "load steps", LOAD_STEPS)
    points = []
    for kind, title in PEER_KINDS.items():
        for elements in PEER_ELEMENTS:
            counts: list[int] = []
            request = {"beam": beam, "kind": kind, "elements": elements}
            trials = [(f"{n} {name}", partial(_asked, peers, do, counts, {**request, field: n})) for n in steps]
            found = best(title, elements, 0, trials, exact)
            points.append(found._replace(coordinates=counts[0] if counts else 0))
            print(*points[-1], flush=True)
    return points


def _asked(peers: Peers, do: str, counts: list[int], request: dict[str, Any]) -> tuple[np.ndarray, float]:
    """Return the tip and the CPU time of the peer, and add the number of its coordinates to a list."""
    answer = peers.ask(do, **request)
    counts.append(int(answer["coordinates"]))
    return np.array(answer["tip"]), float(answer["seconds"])


def reference(angle: float = scenes.ANGLE, size: int = 14, rtol: float = 1e-10) -> np.ndarray:
    """Return the motion of the tip by polynomials."""
    return scenes.run(scenes.link(scenes.LEGENDRE, size, angle)[0], "dop853", rtol)[0]


def agreement(exact: np.ndarray) -> tuple[float, float]:
    """Return how far splines of another degree, and segments extrapolated to none, are from the reference."""
    splines = scenes.run(scenes.link(scenes.SPLINES, 16, degree=scenes.FINE_DEGREE)[0], "dop853", 1e-10)[0]
    coarse, fine = (scenes.run(scenes.link(scenes.SEGMENTS, k)[0], "radau5", 1e-8)[0] for k in (16, 32))
    return error_of(splines, exact), error_of((4.0 * fine - coarse) / 3.0, exact)


def over_bending(bodies: Iterable[tuple[Kind, int]], angles: Iterable[float]) -> dict[str, list[tuple[float, float]]]:
    """Return how far the tip turns against the root, rad, and the error, for angles of the motor, by body."""
    found: dict[str, list[tuple[float, float]]] = {f"{kind.name}, {size}": [] for kind, size in bodies}
    for angle in angles:
        exact = reference(angle, 10, 1e-9)
        for kind, size in bodies:
            try:
                error = error_of(scenes.run(scenes.link(kind, size, angle)[0], *FINEST)[0], exact)
            except KanefeError as failure:
                print(kind.name, size, angle, failure)
                error = math.inf
            found[f"{kind.name}, {size}"].append((scenes.turned(exact, angle), error))
    return found


def rows_of(points: list[Point]) -> dict[str, Any]:
    """Return the table of a scene."""
    columns = ["body", "segments, functions or modes", "coordinates", "error of the tip / length", "CPU ms", "by"]
    rows = []
    for point in points:
        told = ["fails", ""] if math.isinf(point.error) else [f"{point.error:.1e}", f"{1e3 * point.seconds:.2g}"]
        rows.append([point.kind, str(point.size), str(point.coordinates), *told, point.how])
    return {"columns": columns, "rows": rows}


def rows_over_bending(found: dict[str, list[tuple[float, float]]]) -> dict[str, Any]:
    """Return the table of errors over bending."""
    turns = [turn for turn, _ in next(iter(found.values()))]
    rows = [[name, *(f"{error:.0e}" if error < np.inf else "fails" for _, error in of)] for name, of in found.items()]
    return {"columns": ["body", *(f"{turn:.2g} rad" for turn in turns)], "rows": rows}


def main() -> None:
    """Measure, print, and write what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="three sizes of each body")
    parser.add_argument("--env", type=Path, metavar="FOLDER", help="environment of Exudyn; made if it is missing")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--png", type=Path)
    parser.add_argument("--machine", default=platform.processor() or platform.machine())
    given = parser.parse_args()
    exact, at_rest = reference(), scenes.shot(LOAD)
    of_splines, of_segments = agreement(exact)
    note = (
        f"The tip turns against the root by {scenes.turned(exact):.2f} rad. Reference: 14 Legendre polynomials; 16 "
        f"splines of degree {scenes.FINE_DEGREE} agree to {of_splines:.0e} of the length, and segments, extrapolated "
        f"from 16 and 32, to {of_segments:.0e}."
    )
    print(note)
    slew: list[Point] = []
    hang: list[Point] = []
    for kind in scenes.KINDS:
        for size in kind.sizes[:3] if given.quick else kind.sizes:
            slew.append(slewed(kind, size, exact))
            hang.append(hung(kind, size, at_rest))
            print(*slew[-1], "; at rest", *hang[-1][3:], flush=True)
    if given.env:
        with Peers(peer_python(given.env, ("exudyn", "numpy"), "import exudyn"), SERVER) as peers:
            print("Exudyn", peers.ask("version")["exudyn"])
            slew += of_peer(peers, "slew", exact)
            hang += of_peer(peers, "bend", at_rest)
    bending = over_bending(BENDING, ANGLES[-3:] if given.quick else ANGLES)
    print(json.dumps(rows_over_bending(bending)["rows"], indent=1))
    where = {"machine": given.machine, "date": f"{datetime.now(UTC):%Y-%m-%d}"}
    if given.json:
        tables = {
            "slew": {**rows_of(slew), "note": note},
            "elastica": rows_of(hang),
            "bending": rows_over_bending(bending),
        }
        told = {**where, "command": "python tests/benchmarks/bending.py --env FOLDER", "tables": tables}
        given.json.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    if given.png:
        picture(slew, hang, bending, LOAD, " · ".join(where.values()), given.png)


if __name__ == "__main__":
    main()
