"""The plot of a path of equilibria."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kanefe.views.plots import COLORS, Figure, _dress, _figure, saved_figure

MARKS = {"limit": ("o", "limit point"), "branch": ("s", "branch point"), "flutter": ("x", "flutter begins")}


class PathCurve(NamedTuple):
    """The data of one path: abscissas and factors (P,), number of growing motions (P,), and its critical points."""

    values: np.ndarray
    factors: np.ndarray
    unstable: np.ndarray
    marks: Sequence[tuple[str, float, float]]


def path_picture(curves: Sequence[PathCurve], label: str, path: str | Path | None) -> Figure:
    """Return the picture that `EquilibriumPath.plot` describes, and write it to `path` if given."""
    figure, (axes,) = _figure(1, 1, (7.0, 4.5))
    named: set[str] = set()

    def once(name: str) -> str:
        shown = "_" if name in named else name
        named.add(name)
        return shown

    for values, factors, unstable, marks in curves:
        # a stretch between two points is that of its end, as a critical point has the state before it
        grows, curve = unstable[1:] > 0, np.column_stack((values, factors))
        ends = [0, *(np.flatnonzero(grows[1:] != grows[:-1]) + 1).tolist(), len(curve) - 1]
        for i, k in pairwise(ends):
            name, style = ("unstable", "--") if grows[i] else ("stable", "-")
            run = curve[i : k + 1].T
            axes.plot(*run, style, color=COLORS[int(grows[i])], linewidth=1.4, label=once(name))
        for kind, value, factor in marks:
            marker, name = MARKS[kind]
            axes.plot(value, factor, marker, color="0.2", fillstyle="none", markersize=7, label=once(name), zorder=3)
    _dress(axes, "load factor", "Equilibrium path", time=False)
    axes.set_xlabel(label)
    return saved_figure(figure, path)
