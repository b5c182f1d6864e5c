"""Small shaded pictures of surfaces of triangles, drawn by numpy: notebooks show them without a graphics library.

Each triangle is covered with points close enough for the pixels; of those in one pixel the nearest is seen.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

SIZE = (300, 190)
"""Pixels; rows in which nothing is are cut off."""

BORDER = 4
"""Of those rows, how many stay."""

FINE = 2
"""Points of the drawing in a pixel, along each side."""

MARGIN = 0.92
LOOK = np.array((0.75, -1.2, 0.65))
"""From the scene towards the eye, where z is up."""

LIGHT = np.array((0.35, 0.5, 1.0))
"""From the scene towards the light, along the axes of the picture."""

INK = np.array((42.0, 52.0, 64.0))
MOST_POINTS = 3_000_000


class Piece(NamedTuple):
    """A surface of one colour.

    Attributes
    ----------
    points : ndarray, shape (p, 3)
        In N, m.
    triangles : ndarray of int, shape (m, 3)
    creases : ndarray of int, shape (e, 2)
        Edges that are drawn as lines.
    colour : tuple of float
        Red, green, blue, of 255.
    """

    points: np.ndarray
    triangles: np.ndarray
    creases: np.ndarray
    colour: Sequence[float]


def thumbnail(pieces: Sequence[Piece], up: Sequence[float] = (0.0, 0.0, 1.0)) -> bytes:
    """Return a picture (.png, transparent where nothing is) of some surfaces together."""
    axes = _axes(np.asarray(up, dtype=float))
    seen = [piece.points @ axes for piece in pieces]  # right, up, towards the eye
    every = np.vstack([points for points in seen if len(points)])
    low, high = every.min(axis=0), every.max(axis=0)
    wide, tall = SIZE[0] * FINE, SIZE[1] * FINE
    extent = np.maximum(high - low, 1e-12 * max(float((high - low).max()), 1e-300))
    scale = MARGIN * min(wide / extent[0], tall / extent[1])
    middle = 0.5 * (low + high)
    shift = np.array((0.5 * wide, 0.5 * tall, 0.0))
    drawn = [
        samples
        for piece, points in zip(pieces, seen, strict=True)
        for samples in _samples(piece, scale * (points - middle) + shift)
    ]
    places, depths, colours = (np.concatenate(arrays) for arrays in zip(*drawn, strict=True))
    pixels = (tall - 1 - places[:, 1].astype(int)) * wide + places[:, 0].astype(int)
    order = np.argsort(depths, kind="stable")  # what is written last is nearest
    nearest = np.full(tall * wide, -1)
    nearest[pixels[order]] = order
    drawn_at = np.flatnonzero(nearest >= 0)
    image = np.zeros((tall * wide, 4))
    image[drawn_at, :3] = colours[nearest[drawn_at]]
    image[drawn_at, 3] = 255.0
    small = _smaller(image.reshape(tall, wide, 4))
    kept = np.flatnonzero(small[..., 3].any(axis=1))
    return png(small[max(kept[0] - BORDER, 0) : kept[-1] + BORDER + 1])


def png(image: np.ndarray) -> bytes:
    r"""Return an image (rows, columns, 4), red, green, blue and opacity of 255, as the bytes of a .png file.

    Examples
    --------
    >>> png(np.zeros((2, 3, 4), dtype=np.uint8))[:4]
    b'\x89PNG'
    """
    rows, columns, _ = image.shape
    lines = np.hstack((np.zeros((rows, 1), dtype=np.uint8), image.astype(np.uint8).reshape(rows, -1)))

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", columns, rows, 8, 6, 0, 0, 0)
    packed = zlib.compress(lines.tobytes(), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


def _axes(up: np.ndarray) -> np.ndarray:
    """Return the axes of the picture as columns: right, up, towards the eye."""
    if abs(up[1]) > 0.5:  # a scene in the plane of x and y
        eye = np.array((0.35, 0.3, 1.0))
    elif abs(up[0]) > 0.5:
        eye = LOOK[[2, 0, 1]]
    else:
        eye = LOOK
    eye = eye / np.linalg.norm(eye)
    right = np.cross(up, eye)
    right /= np.linalg.norm(right)
    return np.column_stack((right, np.cross(eye, right), eye))


def _samples(piece: Piece, points: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return places (s, 2), depths (s,) and colours (s, 3) of points on a surface and its edges, in pixels."""
    found = []
    a, b, c = (points[piece.triangles[:, i]] for i in range(3))
    if len(a):
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
        normals *= np.where(normals[:, 2] < 0.0, -1.0, 1.0)[:, None]  # both sides are lit
        bright = 0.45 + 0.55 * np.maximum(normals @ (LIGHT / np.linalg.norm(LIGHT)), 0.0)
        sides = [np.linalg.norm((q - p)[:, :2], axis=1) for p, q in ((a, b), (b, c), (c, a))]
        steps = np.maximum(np.ceil(1.3 * np.max(sides, axis=0)), 1.0).astype(int)
        steps = np.minimum(steps, int(np.sqrt(2.0 * MOST_POINTS / len(steps))) + 1)
        counts = (steps + 1) * (steps + 2) // 2
        owner = np.repeat(np.arange(len(a)), counts)
        number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        row = ((np.sqrt(8.0 * number + 1.0) - 1.0) / 2.0).astype(int)
        s = row / steps[owner]
        t = (number - row * (row + 1) // 2) / steps[owner]
        spots = a[owner] + s[:, None] * (b - a)[owner] + t[:, None] * (c - b)[owner]
        found.append((spots[:, :2], spots[:, 2], bright[owner, None] * np.asarray(piece.colour, dtype=float)))
    if len(piece.creases):
        start, end = (points[piece.creases[:, i]] for i in (0, 1))
        steps = np.ceil(np.linalg.norm((end - start)[:, :2], axis=1)).astype(int) + 1
        owner = np.repeat(np.arange(len(start)), steps + 1)
        share = (np.arange(len(owner)) - np.repeat(np.cumsum(steps + 1) - steps - 1, steps + 1)) / steps[owner]
        spots = start[owner] + share[:, None] * (end - start)[owner]
        colour = 0.5 * (INK + 0.6 * np.asarray(piece.colour, dtype=float))
        found.append((spots[:, :2], spots[:, 2] + 1.5, np.tile(colour, (len(spots), 1))))
    return found


def _smaller(image: np.ndarray) -> np.ndarray:
    """Return the mean of each square of points, colours weighed by opacity."""
    rows, columns, _ = image.shape
    weighed = np.concatenate((image[..., :3] * image[..., 3:] / 255.0, image[..., 3:]), axis=-1)
    mean = weighed.reshape(rows // FINE, FINE, columns // FINE, FINE, 4).mean(axis=(1, 3))
    mean[..., :3] *= 255.0 / np.maximum(mean[..., 3:], 1e-9)
    return np.clip(np.round(mean), 0.0, 255.0)
