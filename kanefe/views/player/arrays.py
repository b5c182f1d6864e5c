"""Arrays for the browser: one block of bytes, and the place of each array in it."""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np

ALIGNED = 8
"""Alignment of arrays in bytes, which a browser's views of a buffer require."""

LEVEL = 6


class Arrays:
    """Arrays one after the other; equal arrays are stored once."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._length = 0
        self._known: dict[tuple[bytes, str, tuple[int, ...]], dict[str, Any]] = {}

    def add(self, array: np.ndarray) -> dict[str, Any]:
        """Add an array of float32, float64, int16, uint8 or uint32; return its place: "at", "type", "shape"."""
        data = np.ascontiguousarray(array)
        raw = data.astype(data.dtype.newbyteorder("<"), copy=False).tobytes()
        key = (raw, data.dtype.name, data.shape)
        if key not in self._known:
            self._known[key] = {"at": self._length, "type": data.dtype.name, "shape": list(data.shape)}
            padding = bytes(-len(raw) % ALIGNED)
            self._parts += [raw, padding]
            self._length += len(raw) + len(padding)
        return self._known[key]

    def encoded(self) -> str:
        """Return all arrays, deflated, in base64."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), LEVEL)).decode("ascii")


def quantised(shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return shapes (r, ...) as int16, and the factors (r,) that restore them, to within half a factor each.

    Examples
    --------
    >>> numbers, factors = quantised(np.array([[1.0, -2.0], [0.0, 0.0]]))
    >>> (numbers * factors[:, None]).round(4).tolist()
    [[1.0, -2.0], [0.0, 0.0]]
    """
    largest = np.abs(shapes).max(axis=tuple(range(1, shapes.ndim)), initial=0.0)
    factors = np.where(largest > 0.0, largest, 1.0) / 32767.0
    scaled = shapes / factors.reshape(-1, *(1,) * (shapes.ndim - 1))
    return np.round(scaled).astype(np.int16), factors.astype(np.float32)
