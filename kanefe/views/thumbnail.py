"""Small shaded pictures of surfaces of triangles, drawn by numpy without a graphics library.

Each triangle is covered with points as dense as the pixels; in each pixel the nearest one is drawn.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

SIZE = (300, 190)
"""Size of the picture, pixels; empty rows are cut off."""

BORDER = 4
"""Number of empty rows that are kept."""

FINE = 2
"""Points of the drawing per pixel, along each side."""

MARGIN = 0.92
LOOK = np.array((0.75, -1.2, 0.65))
"""Direction from the scene to the viewer if z is up."""

LIGHT = np.array((0.35, 0.5, 1.0))
"""Direction from the scene to the light, along the axes of the picture."""

INK = np.array((42.0, 52.0, 64.0))
MOST_POINTS = 3_000_000


class Piece(NamedTuple):
    """A surface with one colour.

    Attributes
    ----------
    points : ndarray, shape (p, 3)
        In N, m.
    triangles : ndarray of int, shape (m, 3)
    creases : ndarray of int, shape (e, 2)
        Edges that are drawn as lines.
    colour : tuple of float
        Red, green, blue, each from 0 to 255.
    shades : ndarray, shape (p,), or None
        Brightness of the points, from 0 to 1; None: 1.
    """

    points: np.ndarray
    triangles: np.ndarray
    creases: np.ndarray
    colour: Sequence[float]
    shades: np.ndarray | None = None


def thumbnail(
    pieces: Sequence[Piece], up: Sequence[float] = (0.0, 0.0, 1.0), around: np.ndarray | None = None
) -> bytes:
    """Return a picture (.png with transparent background) of some surfaces.

    Parameters
    ----------
    pieces : sequence of Piece
    up : sequence of float
        The axis that points up, (3,).
    around : ndarray, shape (n, 3), optional
        Points that the picture is fitted to, m; default: all.
    """
    axes = _axes(np.asarray(up, dtype=float))
    seen = [piece.points @ axes for piece in pieces]  # right, up, towards the viewer
    every = np.vstack([points for points in seen if len(points)]) if around is None else around @ axes
    low, high = every.min(axis=0), every.max(axis=0)
    wide, tall = SIZE[0] * FINE, SIZE[1] * FINE
    extent = np.maximum(high - low, 1e-12 * max(float((high - low).max()), 1e-300))
    scale = MARGIN * min(wide / extent[0], tall / extent[1])
    middle = 0.5 * (low + high)
    shift = np.array((0.5 * wide, 0.5 * tall, 0.0))
    drawn = [
        samples
        for piece, points in zip(pieces, seen, strict=True)
        for samples in _samples(piece, scale * (points - middle) + shift, np.array((wide, tall)))
    ]
    inside = [((places >= 0.0) & (places < (wide, tall))).all(axis=1) for places, _, _ in drawn]
    if not any(map(np.any, inside)):  # nothing is within the points to fit
        return thumbnail(pieces, up)
    kept = ([array[rows] for array in arrays] for rows, arrays in zip(inside, drawn, strict=True))
    places, depths, colours = (np.concatenate(arrays) for arrays in zip(*kept, strict=True))
    pixels = (tall - 1 - places[:, 1].astype(int)) * wide + places[:, 0].astype(int)
    order = np.argsort(depths, kind="stable")  # what is written last is nearest
    nearest = np.full(tall * wide, -1)
    nearest[pixels[order]] = order
    drawn_at = np.flatnonzero(nearest >= 0)
    image = np.zeros((tall * wide, 4))
    image[drawn_at, :3] = colours[nearest[drawn_at]]
    image[drawn_at, 3] = 255.0
    small = _smaller(image.reshape(tall, wide, 4))
    used = np.flatnonzero(small[..., 3].any(axis=1))
    return png(small[max(used[0] - BORDER, 0) : used[-1] + BORDER + 1])


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
    """Return the axes of the picture as columns: right, up, towards the viewer."""
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


def _samples(piece: Piece, points: np.ndarray, limits: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return places (s, 2), depths (s,) and colours (s, 3) of points on a surface and its edges, in pixels."""
    found = []
    shades = np.ones(len(points)) if piece.shades is None else piece.shades
    corners = _in_view(np.column_stack((points, shades))[piece.triangles], limits)
    a, b, c = (corners[:, i, :3] for i in range(3))
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
        one, two, three = corners[owner, :, 3].T
        light = bright[owner] * (one + s * (two - one) + t * (three - two))
        found.append((spots[:, :2], spots[:, 2], light[:, None] * np.asarray(piece.colour, dtype=float)))
    pairs = points[piece.creases]
    start, end = pairs[_touches(pairs, limits)].swapaxes(0, 1)
    if len(start):
        steps = np.ceil(np.linalg.norm((end - start)[:, :2], axis=1)).astype(int) + 1
        owner = np.repeat(np.arange(len(start)), steps + 1)
        share = (np.arange(len(owner)) - np.repeat(np.cumsum(steps + 1) - steps - 1, steps + 1)) / steps[owner]
        spots = start[owner] + share[:, None] * (end - start)[owner]
        colour = 0.5 * (INK + 0.6 * np.asarray(piece.colour, dtype=float))
        found.append((spots[:, :2], spots[:, 2] + 1.5, np.tile(colour, (len(spots), 1))))
    return found


def _touches(places: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Return which lines or triangles (m, corners, ...) may touch the picture, (m,) of bool."""
    flat = places[..., :2]
    return np.asarray(((flat.max(axis=1) >= 0.0) & (flat.min(axis=1) <= limits)).all(axis=1))


def _in_view(corners: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Return the triangles (m, 3, 4) that the picture may show a part of, divided where they are larger than it."""
    while True:
        corners = corners[_touches(corners, limits)]
        is_large = np.ptp(corners[..., :2], axis=1).max(axis=1, initial=0.0) > limits.max()
        if not is_large.any():
            return corners
        a, b, c = corners[is_large].swapaxes(0, 1)
        d, e, f = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        cut = [np.stack(three, axis=1) for three in ((a, d, f), (d, b, e), (f, e, c), (d, e, f))]
        corners = np.concatenate((corners[~is_large], *cut))


def _smaller(image: np.ndarray) -> np.ndarray:
    """Return the mean of each square of points, with colours weighted by opacity."""
    rows, columns, _ = image.shape
    weighed = np.concatenate((image[..., :3] * image[..., 3:] / 255.0, image[..., 3:]), axis=-1)
    mean = weighed.reshape(rows // FINE, FINE, columns // FINE, FINE, 4).mean(axis=(1, 3))
    mean[..., :3] *= 255.0 / np.maximum(mean[..., 3:], 1e-9)
    return np.clip(np.round(mean), 0.0, 255.0)
