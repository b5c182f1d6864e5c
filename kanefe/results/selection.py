"""Requested output times and nodes of a result, checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.results.body_shape import BodyShape

Frames = int | slice | Sequence[int] | np.ndarray
"""Output times by number: one, a slice, or several."""


def frame_index(frames: Frames | None, count: int) -> Any:
    """Return an index of some of `count` output times; a ModelError names the valid numbers."""
    if frames is None:
        return slice(None)
    if isinstance(frames, slice):
        return frames
    index = np.asarray(frames) if np.all(np.isfinite(numbers(frames))) else np.array(np.nan)
    if index.dtype.kind not in "iu" or index.ndim > 1 or np.any((index < -count) | (index >= count)):
        raise ModelError(
            f"frames={frames!r} must be numbers of output times, 0 to {count - 1}. "
            "Remedy: np.searchsorted(result.times, t) gives the number of a time"
        )
    return index if index.ndim else int(index)


def node_numbers(shape: BodyShape, nodes: Sequence[int] | np.ndarray | None) -> np.ndarray:
    """Return the numbers of some nodes of a body, all by default; a ModelError names the valid ones."""
    if nodes is None:
        return np.arange(len(shape.nodes))
    numbers = np.asarray(nodes)
    if numbers.ndim != 1 or numbers.dtype.kind not in "iu" or np.any((numbers < 0) | (numbers >= len(shape.nodes))):
        raise ModelError(f"nodes={nodes!r} must be node numbers of {shape.name!r}, 0 to {len(shape.nodes) - 1}")
    return numbers


def spread_frames(times: np.ndarray, fps: float | None, every: int | None, most: int) -> np.ndarray:
    """Return the numbers of the output times that an animation shows.

    Parameters
    ----------
    times : ndarray, shape (T,)
        s.
    fps : float or None
        Frames per second of the run's time; the nearest output times are taken.
    every : int or None
        Number of output times per frame.
    most : int
        Largest number of frames if neither is given.
    """
    if fps is not None and every is not None:
        raise ModelError("give fps= or every=, not both")
    if fps is not None:
        if not (numbers(fps).shape == () and 0.0 < numbers(fps) < math.inf):
            raise ModelError(f"fps must be above zero, not {fps!r}")
        wanted = times[0] + np.arange(math.floor((times[-1] - times[0]) * fps * (1 + 1e-12)) + 1) / fps
        after = np.clip(np.searchsorted(times, wanted), 1, len(times) - 1)
        nearest = np.where(wanted - times[after - 1] <= times[after] - wanted, after - 1, after)
        return np.unique(nearest)
    if every is None:
        every = max(1, math.ceil((len(times) - 1) / (most - 1)))
    if isinstance(every, bool) or not (isinstance(every, (int, np.integer)) and 1 <= every < 2**63):
        raise ModelError(f"every must be a whole number of at least 1, not {every!r}")
    return np.arange(0, len(times), int(every))
