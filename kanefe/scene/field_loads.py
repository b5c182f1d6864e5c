"""Methods of `System` that add loads on surfaces and lines of flexible bodies: tractions, pressures, line loads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.arguments import checked, told
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.loads.functions import Constant, callback, multiplied
from kanefe.scene.readings import with_reads
from kanefe.scene.scene import BodyEntry, FlexibleMember, Frame, Scene, three
from kanefe.scene.segments import SegmentedMember

if TYPE_CHECKING:
    from kanefe.fe_model.load_pattern import LoadPattern
    from kanefe.fe_model.place_field import Over
    from kanefe.loads.by_place import ByPlace

VectorLoad = Callable[..., Any] | Sequence[float]


class FieldLoadMethods(Scene):
    """The part of `System` that adds distributed loads."""

    @checked("surface", "follows")
    def add_traction(
        self,
        member: FlexibleMember | SegmentedMember,
        surface: str,
        traction: VectorLoad | float,
        *,
        follows: bool = False,
        over: Over | None = None,
    ) -> None:
        """Apply a traction to a surface of a flexible body, uniform or varying by place.

        It acts on the material points of the surface, per undeformed area, at their deformed positions.

        Parameters
        ----------
        member : FlexibleMember or SegmentedMember
        surface : str
            A surface of the body: ``solid_body(..., surfaces=["top"])``.
        traction : (3,) or callable t, or (t, state), -> (3,)
            Pa. One number if `over` has three.
        follows : bool
            True: components of the body's mesh frame G (of each segment); False: of N.
        over : callable or array_like, optional
            By what it varies, a factor of the traction: see `add_pressure`. With three components a place, in the axes
            that `follows` chooses, a field of vectors.

        Raises
        ------
        ModelError
            If the body is rigid or has no such surface, the message lists those it has; if `over` is not valid.

        Examples
        --------
        >>> scene.add_traction(arm, "top", (0.0, 0.0, -1e3))                  # doctest: +SKIP
        """
        label = f"the traction on {surface!r} of {_name(member)}"
        if isinstance(member, SegmentedMember):
            for part in member.carrying(surface, label):
                own = _of_segment(member, part, over, label)
                self.add_traction(part, surface, traction, follows=follows, over=own)
            return
        entry, pattern = self._loaded(member, surface, label)
        if pattern.kind == "line":
            raise ModelError(f"{label}: that is a line. Remedy: add_line_load, in N/m")
        self._add_vectors(entry, pattern, traction, label, follows, over)

    @checked("line", "follows")
    def add_line_load(
        self,
        member: FlexibleMember | SegmentedMember,
        line: str,
        load: VectorLoad | float,
        *,
        follows: bool = False,
        over: Over | None = None,
    ) -> None:
        """Apply a load per length to a line of beams or an edge of a shell, uniform or varying by place.

        Parameters
        ----------
        member : FlexibleMember or SegmentedMember
        line : str
            A line of the beam model: "span" is all of it (see `kanefe_fem.beam_model`), and the only one of an exact
            beam.
        load : (3,) or callable t, or (t, state), -> (3,)
            N/m of the undeformed axis. Of an exact beam, a function in Python is called for each of its Gauss points,
            one of `kanefe.compiled` in compiled code.
        follows : bool
            True: components of the body's mesh frame G (of each segment, and turning with the sections of an exact
            beam); False: of N.
        over : callable or array_like, optional
            By what the load on a line of a shell varies: see `add_traction`.

        Raises
        ------
        ModelError
            If the body is rigid or has no such line, the message lists those it has; if `over` is not valid.

        Examples
        --------
        >>> scene.add_line_load(wing, "span", (0.0, 0.0, 120.0), follows=True)    # doctest: +SKIP
        """
        label = f"the line load on {line!r} of {_name(member)}"
        if isinstance(member, SegmentedMember):
            for part in member.carrying(line, label):
                own = _of_segment(member, part, over, label)
                self.add_line_load(part, line, load, follows=follows, over=own)
            return
        if isinstance(member, FlexibleMember) and member.body.bends_far and over is None:
            self._add_to_sections(member, line, load, follows, label)
            return
        entry, pattern = self._loaded(member, line, label)
        if pattern.kind != "line":
            raise ModelError(f"{label}: that is a surface. Remedy: add_traction, in Pa")
        self._add_vectors(entry, pattern, load, label, follows, over)

    @checked("surface", "follows")
    def add_pressure(
        self,
        member: FlexibleMember | SegmentedMember,
        surface: str,
        pressure: Callable[..., Any] | float,
        *,
        follows: bool = False,
        over: Over | None = None,
    ) -> None:
        """Apply a pressure to the outer side of a surface of a flexible body, uniform or varying by place.

        It turns with the mesh frame G. Where it does not follow the surface, it acts on the undeformed one: the turn
        and growth of the surface and the displacement of its points by the deformation are neglected.

        Parameters
        ----------
        member : FlexibleMember or SegmentedMember
        surface : str
            A surface of the body: ``solid_body(..., surfaces=["top"])``.
        pressure : float or callable t, or (t, state), -> float
            Pa, positive if it pushes inward.
        follows : bool
            True: it acts on the deformed surface, to first order in the coordinates of the body. With stiffening
            "full" the stress of the pressure stiffens the body, or buckles it. Where the surface has a free edge, such
            a load has no potential; the balance of energy books its work.
        over : callable or array_like, optional
            By what it varies, a factor of the pressure: a function of places (n, 3) in m, undeformed in the mesh frame
            G (of the whole, if it is cut) -> (n,), or values at the nodes of the body (n,). It is integrated once, when
            it is added. Sums of such products are several loads. A function of places and time ``f(x, t)``, with a
            number as pressure, is called in Python in each evaluation.

        Raises
        ------
        ModelError
            If the body is rigid or has no such surface, or it is a line; if `follows`, and the body is not reduced or
            its maker does not know how the surface deforms; if `over` is not valid.

        Examples
        --------
        >>> scene.add_pressure(arm, "top", lambda t: 1e5 * min(t, 1.0))       # doctest: +SKIP
        >>> scene.add_pressure(tube, "outside", 2e5, follows=True)            # doctest: +SKIP
        >>> scene.add_pressure(wall, "wet", 9810.0, over=lambda x: 3.0 - x[:, 2])      # doctest: +SKIP
        """
        from kanefe.loads.field_load import FieldLoad

        label = f"the pressure on {surface!r} of {_name(member)}"
        if isinstance(member, SegmentedMember):
            for part in member.carrying(surface, label):
                own = _of_segment(member, part, over, label)
                self.add_pressure(part, surface, pressure, follows=follows, over=own)
            return
        entry, pattern = self._loaded(member, surface, label)
        if not pattern.has_pressure:
            raise ModelError(f"{label}: a {pattern.kind} without an outside has no pressure. Remedy: a load by vector")
        if follows and pattern.pressure_change is None:
            raise ModelError(
                f"{label} cannot follow its surface: the body is unreduced, or made from matrices without "
                "NodalPattern(pressure_change=...). Remedy: a reduction, shell_body or solid_body, or follows=False"
            )
        function, takes = _scalar(self._entries, pressure, label)
        if over is None:
            entry.field_loads.append(FieldLoad(label, function, pattern, True, follows, takes))
        else:
            entry.field_loads += _by_place(entry, pattern, over, label).pressure(function, takes, follows)

    def _add_vectors(
        self, entry: BodyEntry, pattern: LoadPattern, load: Any, label: str, follows: bool, over: Over | None
    ) -> None:
        """Add a load of three components on a surface or line, or of one number on a field of vectors."""
        from kanefe.loads.field_load import FieldLoad

        if over is None:
            function, takes = _vector(self._entries, load, label)
            entry.field_loads.append(FieldLoad(label, function, pattern, False, follows, takes))
            return
        given = _by_place(entry, pattern, over, label)
        function, takes = (_scalar if given.values == 3 else _vector)(self._entries, load, label)
        entry.field_loads += given.traction(function, takes, follows)

    def _add_to_sections(self, member: FlexibleMember, line: str, load: Any, follows: bool, label: str) -> None:
        """Add a load per length as forces on the Gauss points of an exact beam, by whose sums it integrates."""
        from kanefe.bodies.exact.beam import ExactBeam
        from kanefe.loads.point_load import PointLoad

        self._check_open(label)
        self._check_frame(member, f"the body of {label}")
        body = member.body
        if not isinstance(body, ExactBeam) or line != "span":
            raise ModelError(f"{label}: an exact beam has the line 'span' alone. Remedy: add_force at its interfaces")
        function, takes = _vector(self._entries, load, label)
        lengths = np.outer(body.line.lengths, body.line.weights)
        for node, length in zip(body.line.gauss_nodes.ravel(), lengths.ravel(), strict=True):
            own = multiplied(function, length * np.eye(3))
            force = PointLoad(f"{label}, node {node}", own, False, np.zeros(3), follows, takes)
            self._entries[member.number].loads.append((force, body.node_frame(int(node))))

    def _loaded(self, member: object, name: str, label: str) -> tuple[BodyEntry, LoadPattern]:
        self._check_open(label)
        frame = self._check_frame(member, f"the body of {label}")
        if not isinstance(frame, FlexibleMember):
            raise ModelError(
                f"{label}: {frame.label} is not a flexible body, and only the mesh of one has surfaces and lines. "
                "Remedy: give the flexible body itself, or use add_force"
            )
        if frame.body.bends_far:
            raise ModelError(
                f"{label}: an exact beam has no surfaces, and loads on it do not vary by over=. Remedy: "
                "add_line_load(..., 'span', ...), in N/m, or forces on its nodes"
            )
        try:
            return self._entries[frame.number], frame.body.load_pattern(name)
        except ModelError as error:
            raise ModelError(f"{label}: {error}") from error


def _name(member: object) -> str:
    return repr(member.name) if isinstance(member, Frame) else told(member)


def _by_place(entry: BodyEntry, pattern: LoadPattern, over: Over, label: str) -> ByPlace:
    from kanefe.loads.by_place import ByPlace

    if entry.flexible is None:
        raise ModelError(f"{label}: the body is not flexible")
    return ByPlace(entry.flexible, entry.name, pattern, over, label)


def _of_segment(member: SegmentedMember, part: FlexibleMember, over: Over | None, label: str) -> Over | None:
    """Return by what a load on a segment varies, given that of the whole."""
    if over is None:
        return None
    from kanefe.fe_model.place_field import checked_field, takes_time

    segment = member.body.segments[member.members.index(part)]
    if not callable(over):
        return np.asarray(checked_field(over, member.body.nodes, label)[0])[segment.nodes]
    if takes_time(over, label):
        return lambda x, t: over(x + segment.origin, t)
    return lambda x: over(x + segment.origin)


def _vector(entries: Sequence[BodyEntry], load: VectorLoad, label: str) -> tuple[Callable[..., Any], bool]:
    """Return a function, and whether it takes the state."""
    given = with_reads(entries, load, label)
    return callback(given, label) if callable(given) else (Constant(three(given, label)), False)


def _scalar(
    entries: Sequence[BodyEntry], load: Callable[..., Any] | float, label: str
) -> tuple[Callable[..., Any], bool]:
    """Return the same of a pressure."""
    if callable(load):
        return callback(with_reads(entries, load, label), label)
    constant = numbers(load)
    if constant.shape != () or not np.isfinite(constant):
        raise ModelError(f"{label} must be one finite number or a function of time, not {load!r}")
    return Constant(constant), False
