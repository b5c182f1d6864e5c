"""The peer's curves: how each scene is built there, what its best settings are, and how its runs are judged."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clocks import check_agreement
from benchmarks.goals import median
from benchmarks.peer_process import NoPeers, Peers
from benchmarks.work_precision import rigid_chain, spinning_arm, steel_bar
from benchmarks.work_precision.curves import Limits
from benchmarks.work_precision.references import Reference
from benchmarks.work_precision.runs import LOST, WANTED_SECONDS, Point
from benchmarks.work_precision.scene import BenchScene, Setting
from kanefe.equations.model import Model
from kanefe.fe_model.model import FiniteElementModel
from kanefe_fem.verification import spin_up

PEER = "Exudyn"
SERVER = Path(__file__).with_name("peer_exudyn.py")
PACKAGES, IMPORTS = ("exudyn", "numpy", "scipy"), "import exudyn.FEM, numpy, scipy.sparse.linalg"

GENERALISED_ALPHA = "generalised-alpha"
FINE = 2.0**-0.5
"""Ratio of successive steps. With a curve this fine the peer is at most that much slower than its best."""

STEPS = tuple(0.32 * FINE**i for i in range(30))
TOLERANCES = tuple(10.0 ** (-0.5 * i) for i in range(4, 23))

SAME_FREQUENCIES, SAME_PEAK, SAME_PLACE = 1e-6, 5e-3, 5e-6
"""Largest differences between the two sides: of the frequencies, relative to the largest; of the peak of S2, relative;
of the position in S3 and S4 at the end of the peer's finest run, m."""

LIMIT_STEPS = (5e-4, 2.5e-4)
"""Steps from which the limit of S3 is extrapolated, s."""

BEAM_ELEMENTS = (4, 8)
BEAM_REFERENCE_STEP = 5e-4


class PeerScene:
    """A scene as the peer has it.

    Parameters
    ----------
    name : str
        Of the scene there.
    settings : list of Setting
        Its runs, from coarse to fine.
    error : callable
        Answer of a run -> error in the unit of the scene.
    label : str
        What is added to the name of a method in tables.
    every : float, optional
        Time between samples, s, where the error is one of samples.
    """

    def __init__(
        self,
        name: str,
        settings: list[Setting],
        error: Callable[[dict[str, Any]], float],
        label: str = "",
        every: float | None = None,
    ) -> None:
        self.name, self.settings, self.error, self.label, self.every = name, settings, error, label, every


def peer_scenes(peers: Peers, scene: BenchScene, exact: Reference) -> list[PeerScene]:
    """Build a scene with the peer and return its variants; none if the peer's side was not written.

    Raises
    ------
    Disagreement
        If the two sides are not the same physics.
    """
    kind = scene.name.partition("-")[0]
    makers: dict[str, Callable[[Peers, BenchScene, Reference], list[PeerScene]]] = {
        "S1": _chain,
        "S2": _beams,
        "S3": _hinged,
        "S4": _tumbling,
    }
    return makers[kind](peers, scene, exact) if kind in makers else []


def peer_curve(
    peers: Peers, variant: PeerScene, scene: BenchScene, exact: Reference, limits: Limits
) -> Iterator[Point]:
    """Yield the points of the peer, from coarse to fine; a method that takes too long is left there."""
    ended: set[str] = set()
    for setting in variant.settings[:: 2 if limits.quick else 1]:
        if setting.method in ended:
            continue
        found = peer_point(peers, variant, scene, setting, limits.runs)
        yield found
        if found.seconds > limits.longest or found.error < 3.0 * exact.agreement:
            ended.add(setting.method)


def peer_point(peers: Peers, variant: PeerScene, scene: BenchScene, setting: Setting, runs: int) -> Point:
    """Return error and median time of a run of the peer."""
    method = f"{setting.method}{variant.label}"
    made = partial(
        Point,
        scene=scene.name,
        side=PEER,
        method=method,
        setting=setting.size,
        rtol=setting.rtol,
        step=setting.step,
        chosen=method,
        counts={},
    )
    try:
        judged = peer_run(peers, variant, scene, setting, variant.every)
        error = variant.error(judged)
        times: list[float] = []
        while len(times) < runs and (not times or sum(times) < WANTED_SECONDS):
            times.append(peer_run(peers, variant, scene, setting)["seconds"])
    except NoPeers as failure:
        return made(error=np.nan, seconds=np.nan, remark=str(failure).partition("\n")[0])
    return made(error=error if error < LOST else np.nan, seconds=median(times))


def peer_run(
    peers: Peers, variant: PeerScene, scene: BenchScene, setting: Setting, every: float | None = None
) -> dict[str, Any]:
    """Return the peer's answer for one run.

    Raises
    ------
    NoPeers
        If the run fails there.
    """
    size = {"rtol": setting.rtol} if setting.step is None else {"step": setting.step}
    return peers.ask("solve", name=variant.name, method=setting.method, end=scene.end, every=every, **size)


def of_steps(method: str, coarsest: float, finest: float) -> list[Setting]:
    """Return the settings of a method between two steps (s), the coarsest first."""
    return [Setting(method, step=h) for h in STEPS if finest <= h <= coarsest * 1.0001]


def _chain(peers: Peers, scene: BenchScene, exact: Reference) -> list[PeerScene]:
    links, start = scene.parameters["links"], scene.parameters["start"]
    peers.ask("build_chain", name=scene.name, links=links, gravity=list(rigid_chain.GRAVITY), q=start)
    model = scene.build()

    def error(answer: dict[str, Any]) -> float:
        return scene.error(rigid_chain.tip(model, scene.end, np.array(answer["end"]))[None], exact.values)

    settings = of_steps("rk4", 0.08, 1e-4)
    settings += [Setting("dopri5", rtol=rtol) for rtol in TOLERANCES]
    variant = PeerScene(scene.name, settings, error)
    finest = peer_run(peers, variant, scene, Setting("rk4", step=2.5e-4))
    check_agreement(scene.name, [*rigid_chain.tip(model, scene.end, np.array(finest["end"]))], [*exact.values[-1]])
    return [variant]


def beam_scene(peers: Peers, scene: BenchScene, elements: int) -> PeerScene:
    """Build the arm of S2 as geometrically exact beams; its error is not yet defined."""
    beam = {
        "length": spin_up.LENGTH,
        "EA": spin_up.EA,
        "GA": spin_up.GA,
        "EI": spin_up.EI,
        "line_mass": spin_up.LINE_MASS,
        "line_inertia": spin_up.LINE_INERTIA,
        "start_time": spin_up.START_TIME,
        "final_rate": spin_up.FINAL_RATE,
    }
    name = f"{scene.name} {elements}"
    peers.ask("build_beam", name=name, elements=elements, beam=beam)
    settings = of_steps(GENERALISED_ALPHA, 0.32, 2e-3)
    label, every = f", {elements} exact beams", scene.end / scene.outputs
    return PeerScene(name, settings, lambda answer: np.nan, label, every)


def _beams(peers: Peers, scene: BenchScene, exact: Reference) -> list[PeerScene]:
    found = []
    for elements in BEAM_ELEMENTS:
        variant = beam_scene(peers, scene, elements)
        fine = peer_run(peers, variant, scene, Setting(GENERALISED_ALPHA, step=BEAM_REFERENCE_STEP), variant.every)
        peak = spinning_arm.peak(sampled(fine, scene))
        check_agreement(f"peak of {variant.name}", [peak], [spinning_arm.PEAK], 2.0 * SAME_PEAK)
        # a beam of few elements is another model: its error in time is that from its own fine run
        variant.error = _from_own(scene, sampled(fine, scene))
        found.append(variant)
    return found


def _from_own(scene: BenchScene, own: np.ndarray) -> Callable[[dict[str, Any]], float]:
    return lambda answer: scene.error(sampled(answer, scene), own)


def sampled(answer: dict[str, Any], scene: BenchScene) -> np.ndarray:
    """Return the samples of a run at the output times of a scene, by cubics between those that the peer took."""
    from scipy.interpolate import CubicSpline

    rows = np.array(answer["samples"])
    _, first = np.unique(rows[:, 0], return_index=True)
    return np.asarray(CubicSpline(rows[first, 0], rows[first, 1:])(scene.times))


def _hinged(peers: Peers, scene: BenchScene, exact: Reference) -> list[PeerScene]:
    modes = int(scene.parameters["modes"])
    told = _with_matrices(
        steel_bar.HINGED_CELLS,
        lambda file: peers.ask(
            "build_hinged",
            name=scene.name,
            file=file,
            modes=modes,
            ratio=steel_bar.RATIO,
            gravity=list(steel_bar.GRAVITY),
            corner=list(steel_bar.CORNER),
        ),
    )
    _check_body(scene, scene.build(), told)
    variant = PeerScene(scene.name, of_steps(GENERALISED_ALPHA, 0.08, 5e-4), lambda answer: np.nan)
    coarse, fine = (
        np.array(peer_run(peers, variant, scene, Setting(GENERALISED_ALPHA, step=h))["end"]) for h in LIMIT_STEPS
    )
    # of order 2; its weight acts at the undeformed centre of mass, which moves its limit by 3e-6 m (a force on every
    # node does not, and makes a step five times dearer): its error in time is that from its own limit
    limit = (4.0 * fine - coarse) / 3.0
    check_agreement(scene.name, [*limit], [*exact.values[-1]], SAME_PLACE)
    variant.error = lambda answer: scene.error(np.array(answer["end"])[None], limit[None])
    return [variant]


def free_scene(peers: Peers, scene: BenchScene) -> PeerScene:
    """Build the bar of S4; its error is not yet defined.

    Raises
    ------
    Disagreement
        If the two bodies differ.
    """
    velocity, omega = steel_bar.free_start()
    told = _with_matrices(
        steel_bar.FREE_CELLS,
        lambda file: peers.ask(
            "build_free",
            name=scene.name,
            file=file,
            modes=steel_bar.FREE_MODES,
            velocity=velocity,
            omega=omega,
            corner=list(steel_bar.CORNER),
        ),
    )
    _check_body(scene, scene.build(), told)
    # its methods with error control follow the highest mode and take longer than these
    settings = of_steps(GENERALISED_ALPHA, 2e-2, 5e-5) + of_steps("rk4", 1.2e-4, 2e-5)
    return PeerScene(scene.name, settings, lambda answer: np.nan)


def _tumbling(peers: Peers, scene: BenchScene, exact: Reference) -> list[PeerScene]:
    variant = free_scene(peers, scene)
    fine = peer_run(peers, variant, scene, Setting("rk4", step=2e-5))
    check_agreement(scene.name, fine["end"], [*exact.values[-1]], SAME_PLACE)
    variant.error = lambda answer: scene.error(np.array(answer["end"])[None], exact.values[-1:])
    return [variant]


def _check_body(scene: BenchScene, model: Model, told: dict[str, Any]) -> None:
    body = model.flexible_terms("bar").body
    check_agreement(f"mass of {scene.name}", [told["mass"]], [body.mass], SAME_FREQUENCIES)
    check_agreement(f"frequencies of {scene.name}", told["hertz"], list(body.frequencies), SAME_FREQUENCIES)


def _with_matrices(cells: tuple[int, int, int], ask: Callable[[str], dict[str, Any]]) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "bar.npz"
        save_matrices(steel_bar.bar_model(cells), file)
        return ask(str(file))


def save_matrices(model: FiniteElementModel, path: Path) -> None:
    """Write nodes, M and K of a model for the peer."""
    arrays = {"nodes": model.nodes}
    for name, matrix in (("mass", model.mass.tocsr()), ("stiffness", model.stiffness.tocsr())):
        arrays |= {f"{name}_{part}": getattr(matrix, part) for part in ("data", "indices", "indptr")}
    np.savez(path, **arrays)
