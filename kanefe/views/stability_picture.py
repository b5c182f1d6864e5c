"""Plots of stability over the speed of a scene and a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from kanefe.views.plots import Figure, _dress, _figure, saved_figure


def stability_picture(
    speeds: np.ndarray,
    values: np.ndarray,
    growth: np.ndarray,
    limits: Sequence[Sequence[float]],
    name: str,
    path: str | Path | None,
) -> Figure:
    """Return the picture that `StabilityMap.plot` describes, and write it to `path` if given.

    Parameters
    ----------
    speeds, values : ndarray, shape (S,) and (P,)
        rad/s, and of the parameter.
    growth : ndarray, shape (P, S)
        1/s.
    limits : sequence of sequences of float
        The speeds at which stability begins or ends, for each value, rad/s.
    name : str
        Of the parameter.
    path : path or None
    """
    figure, (axes,) = _figure(1, 1, (8.0, 4.5))
    for value, row in zip(values, growth, strict=True):
        for grows, mark, colour in ((False, "o", "C0"), (True, "x", "C3")):
            chosen = speeds[(row > 0.0) == grows]
            axes.plot(chosen, np.full(len(chosen), value), mark, color=colour, markersize=4)
    for label, marker, colour in (("decays", "o", "C0"), ("grows", "x", "C3")):
        axes.plot([], [], marker, color=colour, markersize=4, label=label)
    found = [(speed, value) for value, row in zip(values, limits, strict=True) for speed in row]
    if found:
        axes.plot(*np.array(found).T, "d", color="0.1", markersize=6, label="limit of stability")
    if len(values) > 1 and all(len(row) == len(limits[0]) for row in limits):
        for edge in np.array(limits).T:
            axes.plot(edge, values, color="0.1", linewidth=1.2)
    if len(values) > 2 and values.min() > 0.0 and values.max() > 30.0 * values.min():
        axes.set_yscale("log")
    _dress(axes, name, "Stability over the speed", time=False)
    axes.set_xlabel("speed [rad/s]")
    return saved_figure(figure, path)
