"""Pictures of error against CPU time: a panel for each scene."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

from benchmarks.work_precision.runs import OURS, Point
from benchmarks.work_precision.scene import BenchScene

AUTO = "auto"
COLUMNS = 2
MARKERS = "osD^vP*X"
PEER_COLOR = "0.45"
MORE_COLORS = ("#8c510a", "#7a3b9a", "#9a9a00", "#c51b7d", "#01665e")
"""Colours of further methods, beyond the common colours of all pictures."""


def work_precision_picture(
    scenes: Sequence[BenchScene], points: Mapping[str, Sequence[Point]], about: str, path: Path
) -> None:
    """Draw every curve of every scene and write the picture.

    Time runs to the right and error falls downwards, so that the better curve is the one to the lower left.
    """
    from kanefe.views.plots import COLORS, Figure, saved_figure

    names = list(dict.fromkeys(p.method for s in scenes for p in points[s.name] if p.side == OURS and p.method != AUTO))
    peers = list(dict.fromkeys(p.method for s in scenes for p in points[s.name] if p.side != OURS))
    colors = dict(zip(names, cycle((*COLORS, *MORE_COLORS)), strict=False))
    rows = math.ceil(len(scenes) / COLUMNS)
    figure = Figure(figsize=(9.0, 3.1 * rows + 1.1), layout="constrained")
    panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    handles: dict[str, Any] = {}
    for panel, scene in zip(panels, scenes, strict=False):
        found = points[scene.name]
        for i, name in enumerate(names):
            line = _curve(
                panel,
                [p for p in found if p.side == OURS and p.method == name],
                color=colors[name],
                marker=MARKERS[i % len(MARKERS)],
            )
            _keep(handles, name, line)
        for name, of, width in ((f"{AUTO}, over tolerances", "rtol", 4.5), (f"{AUTO}, over fixed steps", "step", 2.5)):
            auto = [p for p in found if p.method == AUTO and getattr(p, of) is not None]
            line = _curve(
                panel,
                auto,
                color="black",
                marker="",
                linewidth=width,
                alpha=0.22 if of == "rtol" else 0.6,
                linestyle="-" if of == "rtol" else ":",
            )
            _keep(handles, name, line)
        for i, name in enumerate(peers):
            side = next(p.side for s in scenes for p in points[s.name] if p.method == name and p.side != OURS)
            line = _curve(
                panel,
                [p for p in found if p.side != OURS and p.method == name],
                color=PEER_COLOR,
                marker=MARKERS[i % len(MARKERS)],
                linestyle="--",
                markerfacecolor="white",
            )
            _keep(handles, f"{side}: {name}", line)
        _dress(panel, scene.title, f"error of {_short(scene.quantity)} [{scene.unit}]")
    for panel in panels[len(scenes) :]:
        panel.set_visible(False)
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, frameon=False, fontsize=9)
    figure.suptitle(f"Error against CPU time of one core: lower left is better\n{about}", fontsize=10)
    saved_figure(figure, path)


def bodies_picture(scenes: Sequence[tuple[str, str, Mapping[str, Sequence[Any]]]], about: str, path: Path) -> None:
    """Draw the errors of meshes, orders and numbers of modes against the time that body and run take.

    Parameters
    ----------
    scenes : sequence of (title, ylabel, curves)
        A curve is a sequence of trials with `seconds`, `error` and `label`, by its name.
    about : str
    path : Path
    """
    from kanefe.views.plots import COLORS, Figure, saved_figure

    figure = Figure(figsize=(9.0, 4.3), layout="constrained")
    panels = figure.subplots(1, len(scenes), squeeze=False).ravel()
    for panel, (title, ylabel, curves) in zip(panels, scenes, strict=True):
        for i, (name, trials) in enumerate(curves.items()):
            line = [(t.seconds, t.error) for t in trials if t.error > 0.0]
            panel.loglog(*zip(*line, strict=True), color=COLORS[i], marker=MARKERS[i], label=name, markersize=5)
            # numbers of modes lie close: the first and the last tell the rest
            for trial in trials if not trials[0].label.isdigit() else (trials[0], trials[-1]):
                if trial.error > 0.0:
                    panel.annotate(
                        trial.label,
                        (trial.seconds, trial.error),
                        textcoords="offset points",
                        xytext=(6, 4),
                        fontsize=7.5,
                        color=COLORS[i],
                    )
        _dress(panel, title, ylabel, "CPU time of body and run [s]")
        panel.legend(frameon=False, fontsize=8.5, loc="best")
        panel.margins(x=0.16, y=0.1)
    figure.suptitle(f"What meshes and modes cost and bring\n{about}", fontsize=10)
    saved_figure(figure, path)


def _curve(panel: Any, points: Sequence[Point], **style: Any) -> Any:
    good = [p for p in points if p.is_good and p.error > 0.0]
    if not good:
        return None
    look = {"linewidth": 1.4, "markersize": 4.0, **style}
    (line,) = panel.loglog([p.seconds for p in good], [p.error for p in good], **look)
    return line


def _keep(handles: dict[str, Any], name: str, line: Any) -> None:
    if line is not None:
        handles.setdefault(name, line)


def _dress(panel: Any, title: str, ylabel: str, xlabel: str = "CPU time [s]") -> None:
    panel.set_title(title, loc="left", fontsize=9.5, fontweight="bold")
    panel.set_ylabel(ylabel, fontsize=9)
    panel.set_xlabel(xlabel, fontsize=9)
    panel.tick_params(labelsize=8.5)
    panel.grid(color="0.9", linewidth=0.8)
    panel.set_axisbelow(True)
    panel.spines[["top", "right"]].set_visible(False)


def _short(quantity: str) -> str:
    """Return a quantity without the times at which it is taken."""
    return quantity.partition(",")[0]
