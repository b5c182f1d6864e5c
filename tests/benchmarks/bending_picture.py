"""The picture of bodies that bend: error over CPU time, over coordinates and over how far they bend."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

MARKERS = "osD^vP*Xdh"
OWN_COLOURS = ("#b0b0b0", "#8c8c8c", "#444444", "#e69f00", "#8c510a", "#f0d060", "#0072b2", "#009e73")
PEER_COLOURS = ("#d55e00", "#cc79a7")
COLOURS = OWN_COLOURS + PEER_COLOURS


def picture(
    slew: Sequence[Any],
    hang: Sequence[Any],
    bending: Mapping[str, Sequence[tuple[float, float]]],
    load: float,
    about: str,
    path: Path,
) -> None:
    """Draw the points of both scenes and the errors over bending, and write the picture."""
    from kanefe.views.plots import Figure, saved_figure

    figure = Figure(figsize=(13.0, 8.4), layout="constrained")
    panels = figure.subplots(2, 3)
    styles = {
        name: {"color": COLOURS[i], "marker": MARKERS[i], "linestyle": "--" if name.startswith("Exudyn") else "-"}
        for i, name in enumerate(dict.fromkeys(point.kind for point in slew))
    }
    scenes = {"link that slews by 90°": slew, f"elastica at P L²/EI = {load:g}": hang}
    for row, (title, points) in zip(panels, scenes.items(), strict=True):
        for axes, quantity, label in (
            (row[0], lambda p: 1e3 * p.seconds, "CPU time [ms]"),
            (row[1], lambda p: p.coordinates, "number of coordinates"),
        ):
            for name, style in styles.items():
                own = [p for p in points if p.kind == name and math.isfinite(p.error)]
                axes.loglog([quantity(p) for p in own], [p.error for p in own], label=name, markersize=5, **style)
            _dress(axes, title, label)
    bends = panels[0][2]
    for name, found in bending.items():
        kind, _, size = name.rpartition(", ")
        style = {"color": "black", "marker": "."} | styles.get(kind, {})
        good = [one for one in found if math.isfinite(one[1])]
        bends.loglog(*zip(*good, strict=True), markersize=4, **style)
        bends.annotate(size, good[-1], textcoords="offset points", xytext=(5, -3), fontsize=8, color=style["color"])
    _dress(bends, "link: modes, segments or functions", "largest turn of the tip against the root [rad]")
    bends.margins(x=0.1)
    handles, labels = panels[0][0].get_legend_handles_labels()
    panels[1][2].legend(handles, labels, loc="center", frameon=False, fontsize=10)
    panels[1][2].set_axis_off()
    figure.suptitle(f"Bodies that bend: largest error of the tip over the length\n{about}", fontsize=10)
    saved_figure(figure, path)


def _dress(axes: Any, title: str, label: str) -> None:
    axes.set_title(title, loc="left", fontsize=10, fontweight="bold")
    axes.set_xlabel(label, fontsize=9)
    axes.set_ylabel("error of the tip / length", fontsize=9)
    axes.grid(color="0.9")
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
