"""The equilibria along a path, and its critical points: what `equilibrium_path` returns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.linear.equilibrium.rest import Equilibrium
from kanefe.linear.imbalance import imbalance_of
from kanefe.linear.modes.mode_shapes import Shapes
from kanefe.linear.paths.arc_length import PathLost, Stop
from kanefe.linear.paths.crossings import Crossing, Kind
from kanefe.linear.paths.loaded_scene import LoadedScene
from kanefe.linear.paths.path_settings import Settings, settings_of
from kanefe.linear.paths.path_warnings import warn_of_path
from kanefe.linear.paths.traced import Traced, branch_start, traced
from kanefe.linear.paths.zeros import DIGITS, crossing_of_factor
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.state import rested_states

if TYPE_CHECKING:
    from kanefe.views.plots import Figure

WORDS = {"limit": "limit point", "branch": "branch point", "flutter": "flutter begins"}


@dataclass(frozen=True, eq=False)
class CriticalPoint(Shapes):
    """A point of a path at which a stiffness vanishes or flutter begins; ``print`` shows it.

    Attributes
    ----------
    kind : {"limit", "branch", "flutter"}
    number : int
        Of the point on the path.
    factor : float
        Of the loads.
    tangents : ndarray, shape (free, k)
        Shapes of the motions without stiffness; the largest displacement is one rad or one scene length. k is zero for
        flutter, and above one where several stiffnesses vanish at once.
    """

    kind: Kind
    number: int
    factor: float
    shapes: Matrix
    small: SmallMotions

    @property
    def _small(self) -> SmallMotions:
        return self.small

    @property
    def tangents(self) -> np.ndarray:
        """Shapes as tangents of the tree (free, k), real: what `Model.advance` takes."""
        return self.shapes

    def __str__(self) -> str:
        count = self.shapes.shape[1]
        moves = "; ".join(self.describe(i) or "many bodies" for i in range(count))
        return f"{WORDS[self.kind]} at factor {self.factor:.8g}" + (f": {moves}" if count else "")


class EquilibriumPath:
    """Equilibria of a scene over the factor of its loads, in the order of the path; ``print`` shows a table.

    Attributes
    ----------
    factors : ndarray, shape (P,)
        Factors of the raised loads.
    coordinates : dict of str to ndarray, each (P,)
        Coordinates q by name.
    unstable : ndarray of int, shape (P,)
        Number of growing motions; 0: stable.
    critical_points : tuple of CriticalPoint
        They are points of the path as well.
    ended : str
        Where and why the path ended.
    is_whole : bool
        Whether it ended because the factor left its range, or it closed.
    """

    def __init__(self, loaded: LoadedScene, kept: tuple[str, ...], settings: Settings, found: Traced) -> None:
        self.loaded, self.kept, self._settings, self._stops = loaded, kept, settings, found.stops
        self.ended, self.is_whole, self._found = found.ended, found.is_whole, found.found
        self._traced = found
        self.factors: Vector = np.array([stop.factor for stop in found.stops])
        self.unstable = np.array([stop.balance.unstable for stop in found.stops])
        for number, crossing in found.found:
            self.unstable[number] = crossing.before

    def __len__(self) -> int:
        return len(self._stops)

    def __iter__(self) -> Iterator[Equilibrium]:
        return (self.point(i) for i in range(len(self)))

    @cached_property
    def coordinates(self) -> dict[str, Vector]:
        """Coordinates q by name, each (P,)."""
        q = np.array([stop.q for stop in self._stops])
        return dict(zip(self.loaded.model.coordinate_names(), q.T, strict=True))

    @cached_property
    def critical_points(self) -> tuple[CriticalPoint, ...]:
        """Limit points, branch points and onsets of flutter, in the order of the path."""
        return tuple(self._critical(number, crossing) for number, crossing in self._found)

    @property
    def limit_points(self) -> tuple[CriticalPoint, ...]:
        """Where the factor turns: the scene snaps through if the loads rise on."""
        return tuple(point for point in self.critical_points if point.kind == "limit")

    @property
    def branch_points(self) -> tuple[CriticalPoint, ...]:
        """Where other paths cross this one."""
        return tuple(point for point in self.critical_points if point.kind == "branch")

    @property
    def flutter_points(self) -> tuple[CriticalPoint, ...]:
        """Where oscillations begin or cease to grow, under loads without potential."""
        return tuple(point for point in self.critical_points if point.kind == "flutter")

    @checked
    def point(self, number: int) -> Equilibrium:
        """Return a point of the path as an equilibrium, which has all outputs of a result; -1 is the last one.

        Raises
        ------
        ModelError
            If there is no such point.
        """
        count = len(self)
        if not -count <= number < count:
            raise ModelError(f"the path has no point of number {number}. Remedy: 0 to {count - 1}")
        return self._equilibrium(self._stops[number])

    @checked
    def at(self, factor: float, crossing: int = 0) -> Equilibrium:
        """Return the equilibrium at a factor of the loads, solved for.

        Parameters
        ----------
        factor : float
        crossing : int
            Which one, in the order of the path, if it passes the factor several times.

        Raises
        ------
        ModelError
            If the path does not pass the factor so often.
        SimulationError
            If the equilibrium is not found: another path is near.
        """
        gaps = self.factors - factor
        gaps[np.abs(gaps) <= DIGITS * float(np.abs(self.factors).max())] = 0.0  # where the path was led to a factor
        passed = [i for i in range(len(self) - 1) if gaps[i] * gaps[i + 1] <= 0.0 and not (i and gaps[i] == 0.0)]
        if not -len(passed) <= crossing < len(passed):
            low, high = self.factors.min(), self.factors.max()
            raise ModelError(
                f"the path passes factor {factor:g} {len(passed)} times, and crossing {crossing} is asked for. "
                f"Remedy: a factor from {low:.6g} to {high:.6g}, and crossings from 0"
            )
        i = passed[crossing]
        if gaps[i] == 0.0:  # where the path begins
            return self._equilibrium(self._stops[i])
        if gaps[i + 1] == 0.0:
            return self._equilibrium(self._stops[i + 1])
        try:
            found = crossing_of_factor(self.loaded, self._stops[i], self._stops[i + 1], factor)
        except PathLost as lost:
            raise SimulationError(
                f"the path has no equilibrium at factor {factor:g} between its points {i} and {i + 1}: {lost}. Remedy: "
                "a path with a shorter longest="
            ) from lost
        return self._equilibrium(found)

    @checked
    def read(self, quantity: str, name: str = "", interface: str | None = None, of: str | None = None) -> np.ndarray:
        """Return any quantity of the points by its name, first axis P: see `Reader.read`."""
        return np.array([point.read(quantity, name, interface, of) for point in self])

    @checked
    def position(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the positions of a body, marker or interface in N along the path, shape (P, 3), m.

        Examples
        --------
        ``deflection = path.position("arch", "crown")[:, 1]``
        """
        return self.read("position", name, interface)

    @checked
    def branch(
        self,
        at: int = 0,
        side: int = 1,
        mode: int = 0,
        *,
        to: float | None = None,
        down_to: float | None = None,
        longest: float | None = None,
        points: int | None = None,
    ) -> EquilibriumPath:
        """Follow the path that crosses this one at a branch point.

        Parameters
        ----------
        at : int
            Number among `branch_points`.
        side : {1, -1}
            Along the shape of the branch point, or against it.
        mode : int
            Which shape, if several stiffnesses vanish at once.
        to, down_to, longest, points
            As for `equilibrium_path`; default: as for this path.

        Raises
        ------
        ModelError
            If there is no such branch point, or an argument is not valid.
        """
        there = self.branch_points
        if not -len(there) <= at < len(there):
            how = ": what makes it unstable is flutter, which leads to no equilibrium" if self.flutter_points else ""
            raise ModelError(f"the path has {len(there)} branch points, and at={at} is none of them{how}")
        if side not in (1, -1):
            raise ModelError(f"the side of a branch must be 1 or -1, not {side!r}")
        there[at]._check(mode)
        given = dict(zip(Settings._fields, (to, down_to, longest, points), strict=True))
        settings = settings_of(**{**self._settings._asdict(), **{k: v for k, v in given.items() if v is not None}})
        stop = next(crossing.stop for number, crossing in self._found if number == there[at].number)
        start = branch_start(self.loaded, stop, there[at].tangents[:, mode], side)
        found = traced(self.loaded, start, settings.bounds, settings.longest, settings.points, on_branch=True)
        path = EquilibriumPath(self.loaded, self.kept, settings, found)
        path.unstable[0] = path.unstable[min(1, len(path) - 1)]
        path._warn()
        return path

    @checked
    def plot(
        self,
        path: str | Path | None = None,
        *,
        of: str = "",
        axis: str = "",
        branches: Sequence[EquilibriumPath] = (),
    ) -> Figure:
        """Draw the load factor over a displacement: stable solid, unstable dashed, with the critical points.

        Parameters
        ----------
        path : path, optional
            Of the picture; its suffix is the format.
        of : str
            A coordinate by name, or a body, marker or ``"body/interface"`` whose position is drawn; default: the
            coordinate that moves most.
        axis : {"x", "y", "z"}, optional
            Of the position; default: the one along which it moves most.
        branches : sequence of EquilibriumPath
            Other paths that are drawn as well.

        Raises
        ------
        ModelError, MissingDependency
            If a name is not valid, or matplotlib is not installed.
        """
        from kanefe.views.path_picture import PathCurve, path_picture

        of, axis = self._most(of, axis)
        curves = []
        for one in (self, *branches):
            values = one.coordinates[of] if not axis else one._positions(of)[:, "xyz".index(axis)]
            marks = [(point.kind, values[point.number], point.factor) for point in one.critical_points]
            curves.append(PathCurve(values, one.factors, one.unstable, marks))
        return path_picture(curves, f"{of} {axis} [m]" if axis else of, path)

    def __str__(self) -> str:
        kept = f"; kept: {', '.join(self.kept)}" if self.kept else ""
        ranges = f"factors {self.factors.min():.6g} to {self.factors.max():.6g}"
        states = "all stable" if not self.unstable.any() else f"{int((self.unstable == 0).sum())} stable"
        lines = [
            f"equilibrium path of {len(self)} points, {states}; raised: {', '.join(self.loaded.raised)}{kept}",
            f"  {ranges}; ended {self.ended}",
            *(f"  {point}" for point in self.critical_points),
        ]
        if not self.branch_points and not self.limit_points:
            lines.append("  no limit point and no branch point")
        return "\n".join(lines)

    def _warn(self) -> None:
        warn_of_path(self.loaded, self._traced, self.point)

    def _critical(self, number: int, crossing: Crossing) -> CriticalPoint:
        balance = crossing.stop.balance
        shapes = balance.softest(crossing.count)
        weighted = self.loaded.weights[:, None] * shapes
        largest = weighted[np.abs(weighted).argmax(axis=0), np.arange(shapes.shape[1])] if crossing.count else 1.0
        return CriticalPoint(crossing.kind, number, balance.factor, shapes / largest, balance.small)

    def _equilibrium(self, stop: Stop) -> Equilibrium:
        small, t = stop.balance.small, self.loaded.t
        model = small.model
        z = rested_states(model, t, np.concatenate((stop.q, small.u, model.initial_states)))
        imbalance = imbalance_of(small)
        return Equilibrium(model, t, np.concatenate((stop.q, small.u, z)), imbalance, 0, model, small)

    def _most(self, of: str, axis: str) -> tuple[str, str]:
        """Return what a plot is drawn over: a coordinate without an axis, or the place of a body with one."""
        q = self.coordinates
        if axis not in {"", "x", "y", "z"}:
            raise ModelError(f"the axis of a plot must be x, y or z, not {axis!r}")
        if not of:
            sizes = np.abs(np.linalg.pinv(self._stops[0].balance.small.coordinate_map).T @ self.loaded.weights)
            return max(zip(q, sizes, strict=True), key=lambda pair: float(np.ptp(q[pair[0]])) * float(pair[1]))[0], ""
        if of in q:
            return of, ""
        return of, axis or "xyz"[int(np.ptp(self._positions(of), axis=0).argmax())]

    def _positions(self, of: str) -> np.ndarray:
        body, _, interface = of.partition("/")
        return self.position(body, interface or None)
