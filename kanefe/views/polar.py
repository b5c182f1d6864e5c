"""Polar plots of a number over an angle and rings, such as headings and sea states."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kanefe.views.plots import Figure, blank_figure, saved_figure


class PolarMap(NamedTuple):
    """The data of one polar plot.

    Attributes
    ----------
    title : str
    angles : ndarray, shape (A,)
        Degrees, ascending; zero is up, positive angles are to the left.
    rings : tuple of str
        Labels of the R rings, from the middle outward.
    values : ndarray, shape (R, A)
        From 0 to 1; NaN where there is none.
    radius : str
        Quantity of the rings.
    """

    title: str
    angles: np.ndarray
    rings: tuple[str, ...]
    values: np.ndarray
    radius: str


PANEL, HEIGHT = 5.1, 5.6
"""Width and height of a panel, inches."""

PIECES = 12
"""Number of straight pieces in the arc of a sector."""


def polar_picture(maps: Sequence[PolarMap], path: str | Path | None) -> Figure:
    """Return a picture of some maps side by side, and write it to `path` if given."""
    width = PANEL * len(maps) + 1.2
    figure = blank_figure((width, HEIGHT))
    figure.set_layout_engine("none")  # matplotlib's cuts off titles of polar axes
    mesh = None
    for number, shown in enumerate(maps):
        place = ((0.65 + PANEL * number) / width, 0.85 / HEIGHT, 3.9 / width, 3.9 / HEIGHT)
        axes: Any = figure.add_axes(place, projection="polar")
        axes.set_theta_zero_location("N")
        axes.set_theta_direction(1)
        edges = np.arange(len(shown.rings) + 1) + 0.6  # a hole in the middle keeps the first ring readable
        for start, stop, values in _sectors(shown):
            arc = np.radians(np.linspace(start, stop, PIECES + 1))
            mesh = axes.pcolormesh(
                arc,
                edges,
                np.repeat(values[:, None], PIECES, axis=1),
                vmin=0.0,
                vmax=1.0,
                cmap="YlOrRd",
                shading="flat",
            )
            for ring in edges:
                axes.plot(arc, np.full(len(arc), ring), color="0.85", linewidth=0.8)
            for end in (arc[0], arc[-1]):
                axes.plot([end, end], edges[[0, -1]], color="0.85", linewidth=0.8)
        axes.set_ylim(0.0, len(shown.rings) + 0.6)
        plate = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
        axes.set_yticks(np.arange(len(shown.rings)) + 1.1, shown.rings, fontsize="small", bbox=plate)
        axes.set_xticks(np.radians(np.unique(shown.angles % 360.0)))
        axes.grid(visible=False)
        axes.set_title(shown.title, fontsize="medium", fontweight="bold", pad=14.0)
        if shown.radius:
            axes.set_xlabel(f"rings: {shown.radius}")
    if mesh is not None:
        beside = figure.add_axes((PANEL * len(maps) / width, 1.2 / HEIGHT, 0.18 / width, 3.2 / HEIGHT))
        figure.colorbar(mesh, cax=beside, label="probability")
    return saved_figure(figure, path)


def _sectors(shown: PolarMap) -> list[tuple[float, float, np.ndarray]]:
    """Return start, end (degrees) and values of a sector around each angle, half way to its neighbours."""
    angles = shown.angles
    if len(angles) == 1:
        return [(angles[0] - 15.0, angles[0] + 15.0, shown.values[:, 0])]
    gaps = np.diff(angles)
    around = angles[0] + 360.0 - angles[-1]
    is_closed = around <= 1.5 * gaps.max()
    first, last = (around, around) if is_closed else (gaps[0], gaps[-1])
    before, after = np.r_[first, gaps] / 2.0, np.r_[gaps, last] / 2.0
    return [(a - b, a + c, shown.values[:, j]) for j, (a, b, c) in enumerate(zip(angles, before, after, strict=True))]
