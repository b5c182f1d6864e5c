"""Card of modes: a table, and the eigenvalues in the complex plane."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.views.cards.card import card, table

MOST = 20
"""Largest number of modes that are listed."""

LEAST = 1e-6
"""Largest real part, relative to the imaginary parts, that is drawn as zero."""

WIDE, TALL, EDGE = 240, 190, 26
"""Width and height of the picture, and the free margin around it, pixels."""


def modes_card(eigenvalues: np.ndarray, grows: np.ndarray, rows: Sequence[Sequence[str]]) -> str:
    """Return the card of the modes of a scene.

    Parameters
    ----------
    eigenvalues : ndarray of complex, shape (modes,)
        1/s.
    grows : ndarray of bool, shape (modes,)
        Whether each is unstable.
    rows : sequence of (str, str, str, str)
        Number, frequency, damping, and the moving parts.
    """
    shown = list(rows[:MOST])
    if len(rows) > MOST:
        shown.append(("...", f"{len(rows) - MOST} more", "", ""))
    header = ("mode", "frequency", "damping", "moves (share of kinetic energy)")
    return card(f"{len(rows)} modes", _plane(eigenvalues, grows), table(shown, header))


def _plane(values: np.ndarray, grows: np.ndarray) -> str:
    """Return a picture of the eigenvalues in the complex plane; unstable ones are red."""
    imaginary = float(np.abs(values.imag).max(initial=0.0)) or 1.0
    real = max(float(np.abs(values.real).max(initial=0.0)), LEAST * imaginary)
    right = float(values.real.max(initial=0.0)) > LEAST * imaginary
    share, bottom = 0.5 if right else 1.0, TALL - EDGE
    zero = EDGE + share * (WIDE - 2 * EDGE)
    spots = []
    for value, is_red in zip(values, grows, strict=True):
        x = zero + share * (WIDE - 2 * EDGE) * value.real / real
        y = bottom - (TALL - 2 * EDGE) * value.imag / imaginary
        spots.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{"#c0392b" if is_red else "#2c5fa8"}"/>')
    return (
        f'<svg width="{WIDE}" height="{TALL}" style="font:11px system-ui,sans-serif" role="img" '
        f'aria-label="eigenvalues"><path d="M{EDGE} {bottom}H{WIDE - EDGE + 8}M{zero} {bottom}V{EDGE - 10}" '
        f'stroke="#9aa5b1" fill="none"/><text x="{EDGE}" y="{TALL - 8}" fill="#52606d">Re, 1/s: {-real:.3g} to '
        f'{real if right else 0:.3g}</text><text x="{EDGE}" y="{EDGE - 12}" fill="#52606d">Im, rad/s: 0 to '
        f"{imaginary:.4g}</text>{''.join(spots)}</svg>"
    )
