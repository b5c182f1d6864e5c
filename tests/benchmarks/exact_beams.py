"""Exact beams against Exudyn's: CPU time for equal error of the places at the end, and growth with their number.

    python tests/benchmarks/exact_beams.py [--json FILE] [--env FOLDER] [--only TEXT] [--quick]

makes an environment of its own for Exudyn. Both sides have the numbers of functions or elements and the steps that were
the fastest to reach the error; that they still do is checked. Models are built before; steps are those of
generalised-alpha. Our loads and motions are compiled, Exudyn's are functions of Python. The reference of the slewing
link is our own run with 14 functions; those of the others are in ``kanefe verify`` (G01, G10) and are good to 3e-5 and
2e-5 of the length, not to 1e-6.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "shared"))

from benchmarks.clocks import Disagreement, Race, seconds
from benchmarks.command_line import parser, run
from benchmarks.goals import Figure, Goal
from benchmarks.peer_process import Peers, peer_python

SERVER = Path(__file__).with_name("peer_beams.py")
SPECTRAL_RADIUS = 0.8


class Pair(NamedTuple):
    """What both sides take for an error (over the length); `slow`: one round only."""

    scene: str
    error: float
    goal: float
    functions: int | dict[str, int]
    options: dict[str, Any]
    elements: int
    step: float
    slow: bool = False

    @property
    def what(self) -> Goal:
        """The goal of the figure."""
        return Goal(f"{self.scene}, to {self.error:g} of the length: CPU time / Exudyn's", self.goal)


def alpha(**options: float) -> dict[str, Any]:
    """Return the options of our generalised-alpha."""
    return {"method": "generalised-alpha", **options}


PAIRS = (
    Pair("flying", 1e-3, 0.2, {"stretch": 2, "shear_y": 4, "curvature_z": 7}, alpha(rtol=2e-4), 48, 5e-3),
    Pair("slewing", 1e-3, 0.2, 4, alpha(step=0.05), 24, 0.025),
    Pair("slewing", 1e-6, 0.05, 9, alpha(step=1e-3), 700, 1e-3, slow=True),
    Pair("right angle", 1e-3, 0.2, 4, alpha(step=0.05), 12, 0.1),
    Pair("right angle", 1e-4, 0.05, 6, alpha(step=0.02), 50, 0.02, slow=True),
)
CHAIN = Goal("chain of exact beams, step of generalised-alpha: t(32) / t(4)", 9.0)


def arguments() -> argparse.Namespace:
    """Return the options of the command line."""
    return parser(__doc__, quick="three rounds, and nothing that takes Exudyn seconds").parse_args()


def measured(options: argparse.Namespace) -> list[Figure]:
    """Return all figures."""
    rounds = 3 if options.quick else 7
    figures = []
    pairs = [pair for pair in PAIRS if options.only in pair.scene and not (options.quick and pair.slow)]
    if pairs:
        import platformdirs

        folder = options.env or Path(platformdirs.user_cache_dir("kanefe")) / "exact_beams"
        with Peers(peer_python(folder, ("exudyn", "numpy"), "import exudyn, numpy"), SERVER) as peers:
            figures = [raced(peers, pair, 1 if pair.slow else rounds) for pair in pairs]
    return [*figures, *([chain(rounds)] if options.only in "chain" else [])]


def raced(peers: Peers, pair: Pair, rounds: int) -> Figure:
    """Return the ratio of times; both sides must be as good as the pair says."""
    from benchmarks.beam_scenes import ASKED, ENDS, LENGTH, SCENES, places
    from kanefe.integrate.run import integrate

    end = ENDS[pair.scene]
    model = SCENES[pair.scene][0](pair.functions)

    def ours() -> Any:
        return integrate(model, (0.0, end), output_step=end, progress=False, **pair.options)

    def theirs() -> dict[str, Any]:
        steps = round(end / pair.step)
        asked = {"scene": pair.scene, "elements": pair.elements, "steps": steps, "until": end, "rho": SPECTRAL_RADIUS}
        return peers.ask("solve", **asked, **ASKED[pair.scene])

    true = reference(pair.scene)
    errors = [
        float(abs(found - true).max() / LENGTH)
        for found in (places(pair.scene, model, ours().coordinates[-1]), theirs()["end"])
    ]
    if max(errors) > pair.error:
        raise Disagreement(f"{pair.what.what}: errors {errors[0]:.2g} and {errors[1]:.2g}")
    race = Race(lambda: seconds(ours), lambda: float(theirs()["seconds"]), rounds)
    remark = (
        f"{1e3 * race.ours:.3g} ms, {model.free_count} speeds, error {errors[0]:.2g}; Exudyn "
        f"{1e3 * race.theirs:.3g} ms, {pair.elements} elements, step {pair.step:g} s, error {errors[1]:.2g}"
    )
    return pair.what.figure(race.ratio, remark)


def reference(scene: str) -> Any:
    """Return the places at the end."""
    import numpy as np

    from benchmarks.beam_scenes import ENDS, SCENES, places
    from kanefe.checks.verification.references import load_references
    from kanefe.integrate.run import integrate

    if scene == "slewing":
        model = SCENES[scene][0](14)
        return places(scene, model, integrate(model, (0.0, ENDS[scene]), method="dop853", rtol=1e-9).coordinates[-1])
    values = load_references()["G01" if scene == "flying" else "G10"].values
    rows = values["ends" if scene == "flying" else "elbow and tip"]
    found = np.array(rows[values["T"].index(ENDS[scene])])
    return np.insert(found, [2, 4], 0.0) if scene == "flying" else found


def chain(rounds: int) -> Figure:
    """Compare steps of a chain of 32 hanging beams on hinges with those of 4."""
    from benchmarks import engine_scenes

    models = {count: chained(count) for count in (4, 32)}

    def step(count: int, steps: int) -> float:
        run_it = lambda: engine_scenes.run(models[count], steps, 1e-3, method="generalised-alpha")  # noqa: E731
        return seconds(run_it) / steps

    race = Race(lambda: step(32, 100), lambda: step(4, 800), rounds)
    return CHAIN.figure(race.ratio, f"{1e6 * race.ours:.3g} and {1e6 * race.theirs:.3g} us a step")


def chained(count: int) -> Any:
    """Return beams of six functions a strain that hang from each other on hinges, from a slant."""
    import kanefe as kf
    import kanefe_fem as fem

    beam = fem.exact_beam(1.0, fem.Rectangle(0.01, 0.02), fem.Material(E=1e8, nu=0.3, rho=1000.0), basis=6)
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    last = scene.add_flexible_body("0", beam, joint=kf.Revolute("y", position=0.5))
    for i in range(1, count):
        joint = kf.Revolute("yz"[i % 2], position=0.05)
        last = scene.add_flexible_body(str(i), beam, parent=last.interface("tip"), joint=joint)
    return scene.freeze()


if __name__ == "__main__":
    sys.exit(run(arguments(), measured))
