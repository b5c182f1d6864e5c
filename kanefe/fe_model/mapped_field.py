"""Fields that are known at points: pressure maps of a flow program or of sensors, also over time.

Between the points a plane through the nearest ones is put, and what is left is shared by inverse squares of distances
(Shepard's method with a local gradient), so that linear fields are exact, and the values at the points are kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Self
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.arguments import checked, positive, told
from kanefe.errors import FileError, ModelError
from kanefe.frames import numbers
from kanefe.storage.scipy_later import scipy

NEAREST = 9
"""Number of points of which a value is made: those around a point of a grid, and itself."""

FLAT = 0.03
"""Spread of the nearest points in a direction, relative to the largest, below which they have no slope along it."""

REACH = 2.0
"""Largest distance of a place from the nearest point, in distances between the points, if none is given."""


ON_POINT = 1e-9
"""Distance from a point, relative to the size of all, below which a place is that point."""


@checked("reach")
@dataclass(frozen=True, eq=False)
class MappedField:
    """A field over places from its values at points.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        m, in the frame of the mesh.
    values : array_like, shape (n,) or (n, 3)
        Pressures in Pa, or vectors.
    reach : float, optional
        Largest distance of a place from the nearest point, m. Default: twice the median distance of the points from
        their nearest ones.

    Raises
    ------
    ModelError
        If arrays do not fit each other or are not finite; when it is asked, if a place is out of reach.

    Examples
    --------
    >>> corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    >>> suction = MappedField(corners, [100.0, 200.0, 200.0, 100.0])
    >>> suction(np.array([[0.25, 0.5, 0.0]]))
    array([125.])
    """

    points: np.ndarray
    values: np.ndarray
    reach: float | None = None

    def __post_init__(self) -> None:
        points, values = numbers(self.points), numbers(self.values)
        if points.ndim != 2 or points.shape[1:] != (3,) or not len(points) or not np.isfinite(points).all():
            raise ModelError(f"points of a MappedField must be finite, of shape (n, 3), not of shape {points.shape}")
        if values.shape not in ((len(points),), (len(points), 3)) or not np.isfinite(values).all():
            raise ModelError(
                f"values of a MappedField must be finite numbers, one or three for each of {len(points)} points, not "
                f"of shape {values.shape}"
            )
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "values", values)
        if self.reach is not None:
            positive(self.reach, "reach= of MappedField")

    @classmethod
    @checked("length", "value", "reach")
    def read(cls, path: str | Path, *, length: float = 1.0, value: float = 1.0, reach: float | None = None) -> Self:
        """Read a table of x, y, z and one or three values a line, by commas, semicolons or blanks; titles are skipped.

        Parameters
        ----------
        path : str or Path
        length, value : float
            Metres and pascals of the units of the table: 1e-3 and 1e6 if it is in mm and MPa.
        reach : float, optional
            As above, m.

        Raises
        ------
        FileError
            If it cannot be read; the message names the line.
        """
        rows: list[list[float]] = []
        try:
            lines = Path(path).read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise FileError(f"{path}: the table cannot be read: {error}") from error
        for number, line in enumerate(lines, 1):
            words = line.replace(",", " ").replace(";", " ").split()
            try:
                row = [float(word) for word in words]
            except ValueError:
                if rows:
                    raise FileError(f"{path}, line {number}: {line[:60]!r} is not a row of numbers") from None
                continue
            if row and (len(row) not in (4, 6) or (rows and len(row) != len(rows[0]))):
                raise FileError(
                    f"{path}, line {number}: {len(row)} numbers, and x, y, z and one or three values are meant"
                )
            rows += [row] if row else []
        if not rows:
            raise FileError(f"{path} has no row of numbers")
        table = np.array(rows)
        values = value * (table[:, 3] if table.shape[1] == 4 else table[:, 3:])
        return cls(length * table[:, :3], values, reach=reach)

    @checked
    def __call__(self, places: np.ndarray) -> np.ndarray:
        """Return the field at places (P, 3) in m."""
        near, weights = weights_at(self, places)
        return np.asarray(np.einsum("pk,pk...->p...", weights, self.values[near]))


@checked("reach")
@dataclass(frozen=True, eq=False)
class MappedHistory:
    """A field over places and time from its values at points and times, linear between these.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        m, in the frame of the mesh.
    times : array_like, shape (T,)
        s, rising. Before and after them it is the first and the last field.
    values : array_like, shape (T, n) or (T, n, 3)
        Pressures in Pa, or vectors.
    reach : float, optional
        As of `MappedField`.

    Raises
    ------
    ModelError
        As of `MappedField`.

    Examples
    --------
    >>> corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    >>> gust = MappedHistory(corners, [0.0, 1.0], [[0.0] * 4, [100.0, 200.0, 200.0, 100.0]])
    >>> gust(np.array([[0.25, 0.5, 0.0]]), 0.5)
    array([62.5])
    """

    points: np.ndarray
    times: np.ndarray
    values: np.ndarray
    reach: float | None = None

    def __post_init__(self) -> None:
        times, values = numbers(self.times), numbers(self.values)
        if times.ndim != 1 or len(times) < 2 or not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
            raise ModelError(f"times of a MappedHistory must be two or more, rising, not {told(self.times)}")
        if values.ndim < 2 or len(values) != len(times):
            raise ModelError(f"values of a MappedHistory need a row a time, ({len(times)}, n), not {values.shape}")
        for one in values:
            MappedField(self.points, one, self.reach)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)

    @checked
    def __call__(self, places: np.ndarray, t: float) -> np.ndarray:
        """Return the field at places (P, 3) in m and a time in s."""
        known = _WEIGHTS.get(self)
        if known is None or not np.array_equal(known[0], places):
            known = _WEIGHTS[self] = (places, *weights_at(MappedField(self.points, self.values[0], self.reach), places))
        _, near, weights = known
        after = int(np.clip(np.searchsorted(self.times, t), 1, len(self.times) - 1))
        share = np.clip((t - self.times[after - 1]) / (self.times[after] - self.times[after - 1]), 0.0, 1.0)
        values = (1.0 - share) * self.values[after - 1] + share * self.values[after]
        return np.asarray(np.einsum("pk,pk...->p...", weights, values[near]))


def weights_at(field: MappedField, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (P, k) of which the values at places (P, 3) are made, and their weights (P, k)."""
    if places.ndim != 2 or places.shape[1] != 3 or not np.isfinite(places).all():
        raise ModelError(f"places of a field must be finite, of shape (P, 3) in m, not of shape {places.shape}")
    tree = scipy.spatial.cKDTree(field.points)
    k = min(NEAREST, len(field.points))
    distance, near = (x.reshape(len(places), -1) for x in tree.query(places, k=k))
    reach = field.reach
    if reach is None and len(field.points) > 1:
        reach = REACH * float(np.median(tree.query(field.points, k=2)[0][:, 1]))
    if reach is not None and (distance[:, 0] > reach).any():
        worst = int(distance[:, 0].argmax())
        at = ", ".join(f"{x:.6g}" for x in places[worst])
        raise ModelError(
            f"the place ({at}) m is {distance[worst, 0]:.3g} m from the nearest point of a MappedField, which "
            f"reaches {reach:.3g} m. Remedy: points there, reach=, or points in m in the frame of the mesh "
            "(MappedField.read(..., length=1e-3) of a table in mm)"
        )
    away = field.points[near] - places[:, None]
    centred = away - away.mean(axis=1, keepdims=True)
    share = np.maximum(distance, ON_POINT * np.abs(field.points).max() or 1.0) ** -2.0
    share /= share.sum(axis=1, keepdims=True)
    slopes = np.linalg.pinv(centred, rcond=FLAT)  # (P, 3, k): the gradient from values
    return near, share - np.einsum("pk,pki,pij->pj", share, away, slopes)


_WEIGHTS: WeakKeyDictionary[MappedHistory, tuple[np.ndarray, np.ndarray, np.ndarray]] = WeakKeyDictionary()
"""Places that were asked for last, points beside them and their weights."""
