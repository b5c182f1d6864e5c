"""Plots of linear analyses: Campbell diagrams and frequency responses."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kanefe.views.plots import COLORS, STYLES, Figure, _dress, _figure, saved_figure

STILL = 1e-6
"""Frequency relative to the highest below which a mode counts as non-oscillating, without a damping ratio."""


class CampbellCurves(NamedTuple):
    """The data of a Campbell diagram.

    Attributes
    ----------
    speeds : ndarray, shape (S,)
        rad/s.
    eigenvalues : ndarray, shape (S, modes)
    frequencies, damping_ratios : ndarray, shape (S, modes)
        Hz, and dimensionless.
    grows : ndarray of bool, shape (S, modes)
    labels : list of str
        Of the modes.
    orders : ndarray
        Multiples of the speed that are drawn as lines.
    critical : list of (float, float)
        Speeds (rad/s) at which the frequency of a mode is a multiple of the speed, and the multiple.
    """

    speeds: np.ndarray
    eigenvalues: np.ndarray
    frequencies: np.ndarray
    damping_ratios: np.ndarray
    grows: np.ndarray
    labels: list[str]
    orders: np.ndarray
    critical: list[tuple[float, float]]


def campbell_picture(campbell: CampbellCurves, path: str | Path | None) -> Figure:
    """Return the picture that `Campbell.plot` describes, and write it to `path` if given."""
    turns = np.abs(np.nan_to_num(campbell.eigenvalues.imag))
    oscillates = turns > STILL * turns.max(initial=0.0)
    ratios = 100.0 * np.abs(np.where(oscillates, campbell.damping_ratios, 0.0))
    is_damped = bool(ratios.max(initial=0.0) > 1e-6)  # undamped modes have round-off only
    figure, panels = _figure(2 if is_damped else 1, 1, (8.0, 7.0 if is_damped else 4.5))
    upper, lower = panels[0], panels[-1]
    highest = 1.05 * float(np.nan_to_num(campbell.frequencies).max(initial=0.0)) or 1.0
    for j, label in enumerate(campbell.labels):
        color, style = COLORS[j % len(COLORS)], STYLES[j // len(COLORS) % len(STYLES)]
        upper.plot(*_frequency_curve(campbell, j), style, color=color, linewidth=1.4, label=label)
        grows = campbell.grows[:, j]
        mark: dict[str, Any] = {"marker": "x", "linestyle": "", "color": color, "markersize": 5}
        upper.plot(campbell.speeds[grows], campbell.frequencies[grows, j], **mark)
        if is_damped:
            # a divergence and a non-oscillating mode have no damping ratio to draw
            shown = np.where(oscillates[:, j], 100.0 * campbell.damping_ratios[:, j], np.nan)
            lower.plot(campbell.speeds, shown, style, color=color, linewidth=1.4)
            lower.plot(campbell.speeds[grows], shown[grows], **mark)
    if campbell.grows.any():
        upper.plot([], [], marker="x", linestyle="", color="0.3", label="unstable")
    for number, (speed, order) in enumerate(campbell.critical):
        at = order * abs(speed) / (2.0 * np.pi)
        name = "_" if number else "critical speed"
        upper.plot(speed, at, "o", color="0.2", fillstyle="none", markersize=7, label=name, clip_on=False, zorder=3)
    for order in campbell.orders[campbell.orders > 0.0]:
        ends = np.unique((campbell.speeds[0], np.clip(0.0, *campbell.speeds[[0, -1]]), campbell.speeds[-1]))
        upper.plot(ends, order * np.abs(ends) / (2.0 * np.pi), color="0.6", linewidth=0.8, zorder=0)
        reach = 2.0 * np.pi * highest / float(order)
        end = float(np.clip(campbell.speeds[np.abs(campbell.speeds).argmax()], -reach, reach))
        side = "right" if end > 0.0 else "left"
        at = order * abs(end) / (2.0 * np.pi)
        upper.annotate(f"{order:g}x", (end, at), color="0.4", fontsize="small", ha=side, va="bottom")
    upper.set_ylim(0.0, highest)
    _dress(upper, "frequency [Hz]", "Campbell diagram", time=False)
    if is_damped:
        _dress(lower, "damping ratio [%]", "", time=False)
    lower.set_xlabel("speed [rad/s]")
    return saved_figure(figure, path)


def _frequency_curve(campbell: CampbellCurves, mode: int) -> tuple[np.ndarray, np.ndarray]:
    """Return speeds and frequencies (Hz) of a mode, with the zeros of the frequency of a whirl."""
    speeds, turns = campbell.speeds, campbell.eigenvalues[:, mode].imag
    before = np.flatnonzero(turns[:-1] * turns[1:] < 0.0)
    share = turns[before] / (turns[before] - turns[before + 1])
    zeros = speeds[before] + share * np.diff(speeds)[before]
    at = np.insert(speeds, before + 1, zeros)
    return at, np.insert(np.abs(turns), before + 1, 0.0) / (2.0 * np.pi)


class ResponseCurves(NamedTuple):
    """The data of a frequency response: frequencies (F,) in Hz, magnitude and phase (F, outputs, inputs), and names."""

    frequencies: np.ndarray
    magnitude: np.ndarray
    phase: np.ndarray
    output_names: tuple[str, ...]
    input_names: tuple[str, ...]


def frequency_response_picture(response: ResponseCurves, path: str | Path | None) -> Figure:
    """Return the picture that `FrequencyResponse.plot` describes, and write it to `path` if given."""
    figure, (upper, lower) = _figure(2, 1, (8.0, 6.5))
    at, input_count = response.frequencies, len(response.input_names)
    for i, output in enumerate(response.output_names):
        for j, given in enumerate(response.input_names):
            number = i * input_count + j
            color, style = COLORS[number % len(COLORS)], STYLES[number // len(COLORS) % len(STYLES)]
            label = f"{output} / {given}"
            upper.plot(at, response.magnitude[:, i, j], style, color=color, linewidth=1.4, label=label)
            lower.plot(at, np.degrees(response.phase[:, i, j]), style, color=color, linewidth=1.4)
    _dress(upper, "magnitude", "Frequency response", time=False)
    _dress(lower, "phase [degrees]", "", time=False)
    upper.set_yscale("log")
    if response.frequencies.min() > 0.0 and response.frequencies.max() > 5.0 * response.frequencies.min():
        upper.set_xscale("log")
    lower.set_xlabel("frequency [Hz]")
    return saved_figure(figure, path)
