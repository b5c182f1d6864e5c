"""The plot of a path of equilibria."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from kanefe.views.plots import COLORS, Figure, _dress, _figure, saved_figure

MARKS = {"limit": ("o", "limit point"), "branch": ("s", "branch point"), "flutter": ("x", "flutter begins")}


def path_picture(
    values: np.ndarray,
    factors: np.ndarray,
    unstable: np.ndarray,
    marks: Sequence[tuple[str, float, float]],
    label: str,
    path: str | Path | None,
) -> Figure:
    """Return the picture that `EquilibriumPath.plot` describes, and write it to `path` if given.

    Parameters
    ----------
    values, factors : ndarray, shape (P,)
        Abscissa and ordinate.
    unstable : ndarray of int, shape (P,)
        Number of growing motions.
    marks : sequence of (kind, value, factor)
        Critical points.
    label : str
        Of the abscissa.
    """
    figure, (axes,) = _figure(1, 1, (7.0, 4.5))
    # a stretch between two points is that of its end, as a critical point has the state before it
    grows, curve = unstable[1:] > 0, np.column_stack((values, factors))
    ends = [0, *(np.flatnonzero(grows[1:] != grows[:-1]) + 1).tolist(), len(curve) - 1]
    for is_unstable, style, name in ((False, "-", "stable"), (True, "--", "unstable")):
        runs = [curve[i : k + 1] for i, k in pairwise(ends) if grows[i] == is_unstable]
        for run in runs:
            axes.plot(*run.T, style, color=COLORS[is_unstable], linewidth=1.4, label=name if run is runs[0] else "_")
    for kind, (marker, name) in MARKS.items():
        at = np.array([(value, factor) for one, value, factor in marks if one == kind])
        if len(at):
            axes.plot(*at.T, marker, color="0.2", fillstyle="none", markersize=7, label=name, zorder=3)
    _dress(axes, "load factor", "Equilibrium path", time=False)
    axes.set_xlabel(label)
    return saved_figure(figure, path)
