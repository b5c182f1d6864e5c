"""The four benchmarks, each from its options to tables, files and pictures.

Tables and files of what a benchmark found.
"""

from __future__ import annotations

import csv
import io
import json
import platform
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.clocks import FEW_ROUNDS, ROUNDS, Disagreement
from benchmarks.goals import write_json
from benchmarks.peer_process import NoPeers, Peers, peer_python
from benchmarks.work_precision.catalogue import SCENES, chosen_scenes
from benchmarks.work_precision.curves import Limits, curve
from benchmarks.work_precision.options import Options
from benchmarks.work_precision.references import reference
from benchmarks.work_precision.runs import COUNTS, Point
from benchmarks.work_precision.scene import BenchScene
from benchmarks.work_precision.settings import AUTO, chosen_methods, settings_of, steps_of
from kanefe import __version__
from kanefe.errors import KanefeError, MissingDependency
from kanefe.storage.digest import installed_versions
from kanefe.storage.files import write_whole


def measured(options: Options, all_cores: set[int]) -> int:
    """Run the benchmark that was asked for and return its exit code."""
    if options.bodies:
        return _bodies(options)
    if options.skips:
        return _skips(options)
    if options.figures:
        return _figures(options, all_cores)
    return _work_precision(options)


def about() -> str:
    """Return machine, version and date as one line."""
    told = surroundings()
    return f"kanefe {told['kanefe']}, one core of {told['machine']}, {told['date']}"


def _work_precision(options: Options) -> int:
    from benchmarks.work_precision.peer_curves import IMPORTS, PACKAGES, SERVER

    limits, methods = Limits(options.quick), chosen_methods(options.methods)
    scenes: list[BenchScene] = []
    points: dict[str, list[Point]] = {}
    told: list[dict[str, Any]] = []
    print(about(), flush=True)
    with ExitStack() as stack:
        peers = None
        if options.peer:
            peers = stack.enter_context(Peers(peer_python(options.environment, PACKAGES, IMPORTS), SERVER))
            print(f"peer: exudyn {peers.ask('versions')['exudyn']}", flush=True)
        for name in chosen_scenes(options.scenes):
            print(f"measuring {name}", file=sys.stderr, flush=True)
            try:
                scene = SCENES[name]()
                found, row = _scene_points(scene, methods, limits, peers)
            except (MissingDependency, Disagreement) as failure:
                print(f"\n{name} is left out: {failure}", flush=True)
                if options.scenes:
                    return 2
                continue
            scenes.append(scene)
            points[name] = found
            told.append(row)
            print(f"\n{scene.title}: error of {scene.quantity} [{scene.unit}]")
            print(f"reference: {'; '.join(row['reference'])}; they differ by {row['agreement']:.1e}")
            print(points_table(found), flush=True)
    every = [p for found in points.values() for p in found]
    if options.json:
        write_points(every, told, options.json)
    if options.csv:
        write_csv(every, options.csv)
    if options.png and scenes:
        from benchmarks.work_precision.pictures import work_precision_picture

        work_precision_picture(scenes, points, about(), options.png)
    return 0


def _scene_points(
    scene: BenchScene, methods: list[str], limits: Limits, peers: Peers | None
) -> tuple[list[Point], dict[str, Any]]:
    from benchmarks.work_precision.peer_curves import peer_curve, peer_scenes

    exact = reference(scene, scene.build())
    curves = [settings_of(scene, method, limits.quick) for method in methods]
    if AUTO in methods:
        curves.append(steps_of(scene, AUTO, limits.quick))
    found = [p for settings in curves for p in curve(scene, settings, exact, limits)]
    row = {
        "name": scene.name,
        "title": scene.title,
        "quantity": scene.quantity,
        "unit": scene.unit,
        "reference": list(exact.methods),
        "agreement": exact.agreement,
    }
    if peers is not None:
        try:
            variants = peer_scenes(peers, scene, exact)
            found += [p for variant in variants for p in peer_curve(peers, variant, scene, exact, limits)]
        except (NoPeers, Disagreement) as failure:
            print(f"{scene.name} without the peer: {failure}", file=sys.stderr, flush=True)
            row["peer"] = str(failure).partition("\n")[0]
    return found, row


def _bodies(options: Options) -> int:
    from benchmarks.work_precision.bodies import TITLES, TRIALS, Trial
    from benchmarks.work_precision.pictures import bodies_picture

    rows: list[Trial] = []
    panels = []
    print(about(), flush=True)
    for name in chosen_scenes(options.scenes) if options.scenes else list(TRIALS):
        scene = SCENES[name]()
        curves: dict[str, list[Trial]] = {}
        print(f"\n{name}: error of {scene.quantity} [m] against a finer body; CPU s of body, of run", flush=True)
        for trial in TRIALS[name](options.quick):
            rows.append(trial)
            curves.setdefault(trial.curve, []).append(trial)
            print(
                f"  {trial.curve:35} {trial.label:>8}  {trial.nodes:6d} nodes  {trial.coordinates:3d} coordinates  "
                f"{trial.error:.1e}  {trial.body_seconds:7.3f}  {trial.run_seconds:7.3f}",
                flush=True,
            )
        panels.append((TITLES[name], f"error of {scene.quantity.partition(',')[0]} [m]", curves))
    if options.json:
        write_rows([asdict(row) for row in rows], options.json)
    if options.png:
        bodies_picture(panels, about(), options.png)
    return 0


def _skips(options: Options) -> int:
    from benchmarks.work_precision.skipped import SKIPS, skips_table

    print(about(), flush=True)
    rows = []
    for name, measure in SKIPS.items():
        print(f"measuring {name}", file=sys.stderr, flush=True)
        try:
            rows.append(measure(FEW_ROUNDS if options.quick else ROUNDS))
        except KanefeError as failure:
            print(f"{name} is left out: {failure}", flush=True)
    print(skips_table(rows))
    if options.json:
        write_rows([row.told() for row in rows], options.json)
    return 0 if all(row.agrees for row in rows) else 1


def _figures(options: Options, all_cores: set[int]) -> int:
    from benchmarks.goals import Figure, Goal, table
    from benchmarks.work_precision.figures import GROUPS
    from benchmarks.work_precision.machine import Machine
    from benchmarks.work_precision.peer_curves import IMPORTS, PACKAGES, SERVER

    figures: list[Figure] = []
    print(about(), flush=True)
    with ExitStack() as stack:
        peers, trouble = None, ""
        try:
            peers = stack.enter_context(Peers(peer_python(options.environment, PACKAGES, IMPORTS), SERVER))
        except NoPeers as failure:
            trouble = str(failure).partition("\n")[0]
            print(failure, file=sys.stderr, flush=True)
        machine = Machine(peers, trouble, Limits(options.quick), all_cores, options.tests)

        def measure(group: Callable[[Machine], list[Figure]], goals: list[Goal]) -> list[Figure]:
            print(f"measuring {group.__name__.replace('_', ' ')}", file=sys.stderr, flush=True)
            try:
                return group(machine)
            except (NoPeers, Disagreement, KanefeError) as failure:
                print(failure, file=sys.stderr, flush=True)
                return [goal.skipped(str(failure).partition("\n")[0]) for goal in goals]

        for group, goals in GROUPS.items():
            if options.only in group.__name__:
                figures += measure(group, goals)
    print(table(figures))
    if options.json:
        write_json(figures, options.json)
    return 0 if all(figure.met for figure in figures) else 1


COLUMNS = ("scene", "side", "method", "chosen", "rtol", "step", "error", "seconds", *COUNTS, "remark")


def surroundings() -> dict[str, Any]:
    """Return machine, versions and date: a time means little without them."""
    return {
        "kanefe": __version__,
        "python": platform.python_version(),
        "machine": _processor(),
        "system": platform.platform(terse=True),
        "date": time.strftime("%Y-%m-%d"),
        **installed_versions("numpy", "scipy", "numba"),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def points_table(points: Sequence[Point]) -> str:
    """Return the runs of one scene as a table for a terminal."""
    rows: list[tuple[str, ...]] = [("side", "method", "", "error", "CPU ms", "steps", "rejected", "evaluations", "")]
    for p in points:
        chosen = f"{p.method} ({p.chosen})" if p.chosen != p.method else p.method
        numbers = [f"{p.error:.2e}", f"{1e3 * p.seconds:.3g}"] if p.is_good else ["failed", ""]
        counts = [str(p.counts.get(name, "")) for name in ("steps", "rejected", "evaluations")]
        rows.append((p.side, chosen, p.setting, *numbers, *counts, p.remark[:80]))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in rows)


def write_points(points: Sequence[Point], scenes: Sequence[dict[str, Any]], path: Path) -> None:
    """Write the runs with their scenes, references and surroundings as JSON."""
    rows = [{key: _finite(value) for key, value in asdict(p).items()} for p in points]
    _write_text(path, json.dumps({"about": surroundings(), "scenes": list(scenes), "runs": rows}, indent=1) + "\n")


def write_rows(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """Write rows with their surroundings as JSON."""
    kept = [{key: _finite(value) for key, value in row.items()} for row in rows]
    _write_text(path, json.dumps({"about": surroundings(), "rows": kept}, indent=1) + "\n")


def write_csv(points: Sequence[Point], path: Path) -> None:
    """Write the runs as a table with a comma between columns; what is not known is empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for p in points:
        known = {**asdict(p), **p.counts}
        writer.writerow(["" if _finite(known.get(name)) is None else known[name] for name in COLUMNS])
    _write_text(path, text.getvalue())


def _finite(value: Any) -> Any:
    """Return a value as JSON can have it: no NaN."""
    return None if isinstance(value, float) and not abs(value) < float("inf") else value


def _write_text(path: Path, text: str) -> None:
    write_whole(path, lambda file: file.write(text.encode("utf-8")))
