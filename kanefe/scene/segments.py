"""The method of `System` that adds segmented bodies, and what it returns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import Orientation
from kanefe.joints import Fixed, Joint
from kanefe.scene.bodies import BodyMethods
from kanefe.scene.scene import FlexibleMember, Frame

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.bodies.segmented import SegmentedBody


@dataclass(frozen=True, eq=False, repr=False)
class SegmentedMember(Frame):
    """A segmented body of a system.

    Attributes
    ----------
    body : SegmentedBody
    members : tuple of FlexibleMember
        Its segments, along the centre line.
    """

    body: SegmentedBody = field(kw_only=True)
    members: tuple[FlexibleMember, ...] = field(kw_only=True)

    def interface(self, name: str) -> Frame:
        """Return the frame of an interface of the whole, to carry a body, a load or the end of a spring."""
        return self.members[self.body.segment_of(name)].interface(name)

    def node(self, number: int) -> Frame:
        """Return a frame that moves with a node of the whole, to carry a load or the end of a spring."""
        segment, local = self.body.place_of_node(number)
        return self.members[segment].node(local)

    def carrying(self, name: str, label: str) -> tuple[FlexibleMember, ...]:
        """Return the segments that have a surface or line for loads; a ModelError names the load by its label."""
        found = tuple(m for m in self.members if any(pattern.name == name for pattern in m.body.load_patterns))
        if not found:
            known = sorted({pattern.name for m in self.members for pattern in m.body.load_patterns})
            raise ModelError(
                f"{label}: no segment has a surface or line for loads called {name!r}. They have: "
                f"{', '.join(known) or 'none'}. Cut faces are inside the body and carry no loads"
            )
        return found


class SegmentMethods(BodyMethods):
    """The part of `System` that adds segmented bodies."""

    @checked("name")
    def add_segmented_body(
        self,
        name: str,
        body: SegmentedBody,
        *,
        parent: Frame | None = None,
        joint: Joint | None = None,
        at: Sequence[float] = (0.0, 0.0, 0.0),
        orientation: Orientation = (1.0, 0.0, 0.0, 0.0),
        gravity: bool = True,
    ) -> SegmentedMember:
        """Add a body that is cut into segments, rigidly joined at the cuts, and return it.

        Its segments are the flexible bodies "NAME 1", "NAME 2", ... along the centre line. Results have positions,
        deflections, modal coordinates and stresses of the whole by its own name.

        Parameters
        ----------
        name : str
            Unique in the scene.
        body : SegmentedBody
            From `kanefe_fem.segmented`.
        parent, joint, at, orientation, gravity
            As for a flexible body; G of the whole is that of the segment with the fixed interface.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it.

        Examples
        --------
        ``blade = scene.add_segmented_body("blade", kanefe_fem.segmented(beam, {"root": "clamped"}, segments=12))``
        """
        from kanefe.bodies.segmented import CUT, SegmentedBody

        if not isinstance(body, SegmentedBody):
            raise ModelError(
                f"segmented body {name!r} must be a SegmentedBody, not {type(body).__name__}. "
                "Remedy: kanefe_fem.segmented(...); a flexible body is added by add_flexible_body"
            )
        count, base = len(body.segments), body.base
        names = [f"{name} {number + 1}" for number in range(count)]
        taken = {entry.name for entry in self._entries} & {name, *names}
        if taken:
            raise ModelError(f"the scene already has a body called {min(taken)!r}. Remedy: another name than {name!r}")
        members: dict[int, FlexibleMember] = {}
        for number in sorted(range(count), key=lambda i: abs(i - base)):
            segment = body.segments[number].body
            if number == base:
                place = {"parent": parent, "joint": joint, "at": at, "orientation": orientation}
                members[number] = self.add_flexible_body(names[number], segment, gravity=gravity, **place)  # type: ignore[arg-type]
                continue
            inner = number - 1 if number > base else number + 1
            face = members[inner].interface(f"{CUT}{max(number, inner)}")
            members[number] = self.add_flexible_body(
                names[number], segment, parent=face, joint=Fixed(), gravity=gravity
            )
        self._segmented[name] = body
        return self.segmented_body(name)

    @checked
    def segmented_body(self, name: str) -> SegmentedMember:
        """Return a segmented body of the scene by its name, as returned when it was added.

        Raises
        ------
        ModelError
            If there is none of that name; the message lists those there are.
        """
        if name not in self._segmented:
            known = ", ".join(self._segmented) or "none"
            raise ModelError(f"the scene has no segmented body called {name!r}. It has: {known}")
        body = self._segmented[name]
        numbers = {entry.name: number for number, entry in enumerate(self._entries)}
        members = []
        for i, segment in enumerate(body.segments, 1):
            members.append(FlexibleMember(self, numbers[f"{name} {i}"], f"{name} {i}", body=segment.body))
        return SegmentedMember(self, members[body.base].number, name, body=body, members=tuple(members))

    @checked
    def with_bodies(self, bodies: Mapping[str, FlexibleBody | SegmentedBody]) -> Self:
        """Return an open copy of the scene with other flexible bodies in the places of some of its own.

        What is at an interface is at that of the same name of the other body, what is at a node at that in the same
        place; distributed loads are on the surfaces and lines of the same names. Deformations at the start are
        transferred, and so is a `start=` of the old scene in `simulate`.

        Parameters
        ----------
        bodies : dict of str to FlexibleBody or SegmentedBody
            By the names in the scene; usually ``body.rebuilt(...)``.

        Raises
        ------
        ModelError
            If there is no such body, or the other one lacks an interface, a surface or a node; the message names it.

        Examples
        --------
        >>> import kanefe as kf
        >>> from kanefe_fem import Material, Rectangle, beam_body, straight_beam
        >>> rod = straight_beam(1.0, Rectangle(0.02, 0.02), Material(E=210e9, nu=0.3, rho=7850.0))
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> member = scene.add_flexible_body("rod", beam_body(rod, {"root": "clamped"}, kf.CraigBampton(modes=2)))
        >>> finer = scene.with_bodies({"rod": member.body.rebuilt(kf.CraigBampton(modes=8), refined=1)})
        >>> finer.body("rod").body.free_count
        8
        """
        from kanefe.scene.replaced_bodies import replace_bodies

        other = self.copy()
        replace_bodies(other, bodies)
        return other
