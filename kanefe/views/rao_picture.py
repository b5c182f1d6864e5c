"""The plot of a ship's motions in waves, which shows wrong phases."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kanefe.environment.dispersion import wave_number
from kanefe.environment.rao.rao import NAMES, MotionRao
from kanefe.environment.rao.rao_checks import surface_motion
from kanefe.views.plots import COLORS, _dress, _figure, saved_figure
from kanefe.views.plots import Figure as Figure

MOST_HEADINGS = 7
"""Largest number of curves in each diagram, evenly chosen."""


def draw_rao(rao: MotionRao, speed: float, path: str | Path | None) -> Figure:
    """Return the picture that `kanefe.Ship.plot_rao` describes, and write it to `path` if given."""
    count = min(MOST_HEADINGS, len(rao.headings_deg))
    chosen = np.unique(np.round(np.linspace(0, len(rao.headings_deg) - 1, count)).astype(int))
    omega, number = rao.frequencies, wave_number(rao.frequencies, rao.depth)
    figure, axes = _figure(6, 2, (11.0, 15.0))
    for color, i in enumerate(chosen):
        heading = float(rao.headings_deg[i])
        values = rao.at(omega, heading, speed) / np.where(np.arange(6) < 3, 1.0, number[:, None])
        surface = surface_motion(heading, float(number[0]))
        for k in range(6):
            size, phase = axes[2 * k], axes[2 * k + 1]
            size.plot(omega, abs(values[:, k]), color=COLORS[color], linewidth=1.4, label=f"{heading:g}")
            # without motion there is no phase
            moves = abs(values[:, k]) > 1e-3 * max(
                abs(rao.values[0, :, :, k] / (number if k > 2 else 1.0)).max(), 1e-12
            )
            phase.plot(
                omega[moves], _unbroken(values[moves, k]), ".-", color=COLORS[color], linewidth=0.8, markersize=3
            )
            if abs(surface[k]) > 1e-6 * abs(surface).max() and k != 5:
                of_surface = surface[k] / (number[0] if k > 2 else 1.0)
                size.plot(omega[0], abs(of_surface), "o", color=COLORS[color], fillstyle="none")
                phase.plot(omega[0], np.degrees(np.angle(of_surface)), "o", color=COLORS[color], fillstyle="none")
    for k, name in enumerate(NAMES):
        unit = "m/m" if k < 3 else "rad per slope"
        _dress(axes[2 * k], f"[{unit}]", f"{name}: amplitude")
        _dress(axes[2 * k + 1], "[degrees]", f"{name}: phase before the crest")
        axes[2 * k + 1].set_ylim(-190.0, 190.0)
        axes[2 * k + 1].set_yticks((-180, -90, 0, 90, 180))
        for part in axes[2 * k : 2 * k + 2]:
            part.set_xlabel("wave frequency [rad/s]" if k == 5 else "")
            if legend := part.get_legend():
                legend.remove()
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, title="heading (0: head, 90: from port)", loc="outside lower center", ncols=count)
    figure.suptitle(f"{rao.name} at {speed:g} m/s; circles: the surface of long waves")
    return saved_figure(figure, path)


def _unbroken(values: np.ndarray) -> np.ndarray:
    """Return phases in degrees, with NaN at jumps of 360 degrees."""
    phases = np.degrees(np.angle(values))
    return np.where(abs(np.diff(phases, append=phases[-1:])) > 180.0, np.nan, phases)
