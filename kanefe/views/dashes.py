"""Dashed lines."""

from __future__ import annotations

from itertools import pairwise

import numpy as np


def dashes(points: np.ndarray, length: float) -> np.ndarray:
    """Return the ends (d, 2, 3) of dashes along a line over points (n, 3); about `length` (m) long, as the gaps."""
    found = []
    for a, b in pairwise(points):
        count = max(1, round(0.5 * float(np.linalg.norm(b - a)) / length))
        shares = (np.arange(count)[:, None] + np.array((0.25, 0.75))) / count
        found.append(a + shares[:, :, None] * (b - a))
    return np.concatenate(found)
