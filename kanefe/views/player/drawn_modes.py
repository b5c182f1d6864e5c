"""The modes by which a flexible body is drawn: its own, or if these are too many the principal ones of its motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, Protocol

import numpy as np

from kanefe.results.body_shape import BodyShape
from kanefe.results.reader import Reader
from kanefe.views.player.skins import Skin

MOST_OWN = 100
"""Number of coordinates up to which a body is drawn by its own modes; beyond, by the principal modes of its motion."""

MOST_PRINCIPAL = 48
"""Largest number of principal modes."""

UNSEEN = 1e-4
"""Largest displacement and stress of modes that are left out, relative to the largest values."""

AT_ONCE = 4_000_000
"""Largest number of values that are computed at once."""


class StressField(Protocol):
    """The stress of a flexible body, linear in its coordinates, as ``kanefe_fem.recover(result, name)`` returns it."""

    @property
    def name(self) -> str:
        """The body."""
        ...

    @property
    def result(self) -> Reader:
        """The run."""
        ...

    def stress_of(self, eta: np.ndarray, /) -> np.ndarray:
        """Return the stress at the nodes (r, n, 6), xx, yy, zz, yz, xz, xy, Pa, of coordinates (r, k).

        For m beams, the stress of p fibres around their sections, at both ends of each, (r, m 2 p, 6); for a shell that
        at its bottom and then at its top, at each of its places, (r, 2 P, 6), then those of the skin of solids and of
        the fibres of beams in one mesh with it.
        """
        ...

    def mesh_error_of(self, eta: np.ndarray, /) -> float:
        """Return the estimated error of the largest stress of coordinates (k,) by the mesh, relative; NaN: unknown."""
        ...


class DrawnModes(NamedTuple):
    """A motion as a sum, ``x = X + sum_i a_i(t) shapes_i``.

    Attributes
    ----------
    amplitudes : ndarray, shape (S, r)
        At the times shown.
    shapes : ndarray, shape (r, p, 3)
        Displacements of the points of the skin, m.
    stresses : ndarray, shape (r, p, 6), or None
        Stresses of the points, Pa; NaN where there is none.
    """

    amplitudes: np.ndarray
    shapes: np.ndarray
    stresses: np.ndarray | None


def drawn_modes(shape: BodyShape, skin: Skin, eta: np.ndarray, stress: StressField | None) -> DrawnModes:
    """Return the modes by which a body is drawn.

    Parameters
    ----------
    shape : BodyShape
    skin : Skin
    eta : ndarray, shape (S, k)
        Modal coordinates at the times shown.
    stress : StressField or None
    """
    if shape.line is not None:
        return _drawn_far(shape, skin, eta, stress)
    if eta.shape[1] > MOST_OWN:
        amplitudes, mixed = _principal(shape, skin, eta)
        rows = mixed @ eta
    else:
        amplitudes, rows = eta, np.eye(eta.shape[1])
    return _kept(amplitudes, skin.motion(shape, rows), None if stress is None else _stresses(skin, stress, rows))


def _stresses(skin: Skin, stress: StressField, rows: np.ndarray) -> np.ndarray:
    found = stress.stress_of(rows)
    if skin.arms is None:
        return found[:, skin.nodes]
    if skin.pieces == 1:
        return found
    start, end = np.moveaxis(found.reshape(len(rows), -1, 1, 2, skin.fibres, 6), 3, 0)
    share = (np.arange(skin.pieces)[:, None] + np.arange(2))[:, :, None, None] / skin.pieces  # along each element
    return np.asarray((1.0 - share) * start[:, :, :, None] + share * end[:, :, :, None]).reshape(len(rows), -1, 6)


def _drawn_far(shape: BodyShape, skin: Skin, eta: np.ndarray, stress: StressField | None) -> DrawnModes:
    """Return the principal modes of a motion that is not linear in the coordinates, and the stress by these."""
    amplitudes, mixed = _principal(shape, skin, eta)
    shapes = np.concatenate(
        [np.tensordot(mixed, part.motion(shape, eta), axes=1) for part in _parts(skin, eta)], axis=1
    )
    if stress is None:
        return _kept(amplitudes, shapes, None)
    stresses = _stresses(skin, stress, np.eye(eta.shape[1]))
    return _kept(
        np.concatenate((amplitudes, eta), axis=1),
        np.concatenate((shapes, np.zeros((eta.shape[1], *shapes.shape[1:])))),
        np.concatenate((np.zeros((len(shapes), *stresses.shape[1:])), stresses)),
    )


def _kept(amplitudes: np.ndarray, shapes: np.ndarray, stresses: np.ndarray | None) -> DrawnModes:
    """Return the modes that can be seen."""
    kept = _seen(amplitudes, shapes)
    if stresses is not None:
        kept |= _seen(amplitudes, np.nan_to_num(stresses))
    return DrawnModes(amplitudes[:, kept], shapes[kept], None if stresses is None else stresses[kept])


def largest_values(modes: DrawnModes) -> tuple[float, float, int]:
    """Return the largest displacement (m) and von Mises stress (Pa) at the times shown, and the row of the latter."""
    count = max(1, modes.shapes.shape[1])
    at_once = max(1, AT_ONCE // (9 * count))
    moved, pressed, row = 0.0, 0.0, 0
    for start in range(0, len(modes.amplitudes), at_once):
        part = modes.amplitudes[start : start + at_once]
        if not part.shape[1]:
            break
        offsets = np.tensordot(part, modes.shapes, axes=1)
        moved = max(moved, float(np.sqrt((offsets**2).sum(axis=-1).max(initial=0.0))))
        if modes.stresses is not None:
            found = von_mises(np.tensordot(part, np.nan_to_num(modes.stresses), axes=1))
            if (most := float(found.max(initial=0.0))) > pressed:
                pressed, row = most, start + int(found.max(axis=1).argmax())
    return moved, pressed, row


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Return von Mises' stress of (..., 6), xx, yy, zz, yz, xz, xy."""
    xx, yy, zz, yz, xz, xy = np.moveaxis(stress, -1, 0)
    shear = yz**2 + xz**2 + xy**2
    return np.asarray(np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * shear))


def _seen(amplitudes: np.ndarray, fields: np.ndarray) -> np.ndarray:
    """Return a mask (r,) of the modes without which the field would change visibly (`UNSEEN`)."""
    sizes = np.abs(fields).max(axis=tuple(range(1, fields.ndim)), initial=0.0)
    largest = np.abs(amplitudes).max(axis=0, initial=0.0) * sizes
    order = np.argsort(largest)
    left_out = order[np.cumsum(largest[order]) <= UNSEEN * largest.max(initial=0.0)]
    kept = np.ones(len(fields), dtype=bool)
    kept[left_out] = False
    return kept & (largest > 0.0)


def _principal(shape: BodyShape, skin: Skin, eta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return amplitudes (S, r) and the shares of all instants in their modes (r, S), from their inner products."""
    products = np.zeros((len(eta), len(eta)))
    for part in _parts(skin, eta):
        moved = part.motion(shape, eta).reshape(len(eta), -1)
        products += moved @ moved.T
    values, vectors = np.linalg.eigh(products)
    values, vectors = values[::-1], vectors[:, ::-1]
    kept = np.flatnonzero(values > UNSEEN**2 * max(values[0], 0.0))[:MOST_PRINCIPAL]
    sizes = np.sqrt(values[kept])
    return vectors[:, kept] * sizes, (vectors[:, kept] / sizes).T


def _parts(skin: Skin, eta: np.ndarray) -> Iterator[Skin]:
    """Yield the points of a skin, so many at once that their motion at all instants has room."""
    at_once = max(1, AT_ONCE // (3 * max(1, len(eta))))
    for start in range(0, len(skin.points), at_once):
        yield skin.part(slice(start, start + at_once))
