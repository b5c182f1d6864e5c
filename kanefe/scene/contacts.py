"""Methods of `System` that add surfaces and contacts."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.frames import Orientation, Vector
from kanefe.scene.loads import LoadMethods
from kanefe.scene.scene import ContactPatch, Frame, three

if TYPE_CHECKING:
    from kanefe.contact.geometry.convex import Convex
    from kanefe.contact.geometry.shape import Probe, SurfaceShape
    from kanefe.contact.rigid.rigid import Rigid
    from kanefe.contact.surface import Surface
    from kanefe.kernels.contact.laws.friction_law import FrictionLaw
    from kanefe.kernels.contact.laws.normal_law import NormalLaw

ALONG = 1e-9
"""Part of a surface velocity along the normal of a plane that is permitted as round-off of a rotated normal, relative
to it."""

MOST_LEFT_OUT = 0.1
"""Largest local compliance of a body missing in its modes, relative to the deflection of a contact law, without a
warning."""


class ContactMethods(LoadMethods):
    """The part of `System` that adds surfaces and contacts."""

    @checked("name")
    def add_surface(
        self,
        name: str,
        parent: Frame,
        shape: SurfaceShape,
        *,
        at: Sequence[float] = (0.0, 0.0, 0.0),
        orientation: Orientation = (1.0, 0.0, 0.0, 0.0),
    ) -> Surface:
        """Add a surface to a frame, for contacts.

        Parameters
        ----------
        name : str
            Unique among surfaces.
        parent : Frame
            The ground, a body, driven or not, an interface of a flexible body, or a frame of one.
        shape : SurfaceShape
            One of `kanefe.shapes`.
        at : array_like, shape (3,)
            Origin of the shape, from that of the parent in its axes, m.
        orientation : array_like, shape (4,) or (3, 3), or Rotation of scipy
            Orientation of the shape's axes, seen from the parent.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
        >>> ball = scene.add_rigid_body("ball", 1.0, 4e-4, joint=kf.Free(position=(0, 0, 0.5)))
        >>> skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
        >>> scene.add_contact("drop", skin, floor, normal=kf.HuntCrossley(1e5, damping=0.3), friction=kf.Coulomb(0.4))
        >>> result = scene.simulate((0.0, 0.5))
        >>> result.events["drop touch"].round(4)
        array([0.2856])
        """
        from kanefe.contact.geometry.shape import SurfaceShape
        from kanefe.contact.surface import Surface

        label = f"surface {name!r}"
        self._check_open(label)
        if not isinstance(name, str) or not name:
            raise ModelError(f"the name of a surface must be a text, not {name!r}")
        if name in self._surfaces:
            raise ModelError(f"the scene already has a surface called {name!r}. Remedy: another name")
        if not isinstance(shape, SurfaceShape):
            raise ModelError(f"the shape of {label} must be one of kanefe.shapes, such as Plane('z'), not {shape!r}")
        frame = self._check_frame(parent, f"the parent of {label}")
        self._marker(frame, f"the parent of {label}", needs_rotation=True)
        self._surfaces[name] = Surface(name, frame.frame(at, orientation), shape)
        return self._surfaces[name]

    def _surfaces_on_markers(self) -> list[Surface]:
        """Return the surfaces with markers instead of frames, for the model; those of a copy are on its own bodies."""
        return [
            surface._replace(
                frame=self._marker(replace(surface.frame, system=self), f"the parent of surface {surface.name!r}")
            )
            for surface in self._surfaces.values()
        ]

    @checked("name")
    def add_contact(
        self,
        name: str,
        one: Surface | ContactPatch | Frame | Sequence[Frame],
        other: Surface,
        *,
        normal: NormalLaw | Rigid,
        friction: FrictionLaw | None = None,
        surface_velocity: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Add a contact with normal force and friction between two surfaces, or points and a surface.

        The result has its forces in ``result.contact(name)``, and the times at which it touches, lifts, slips and
        sticks in ``result.events["<name> touch"]`` and so on. It touches with its first point and lifts with its last.
        ``result.contact_points(name)`` has the forces of each point; events of points are requested by
        ``simulate(..., events="<name> lift of point *")``.

        Parameters
        ----------
        name : str
            Unique among springs, bushings, contacts and other loads between frames.
        one : Surface, ContactPatch, Frame or sequence of Frame
            Touching side: a surface, or points, which are a patch of a flexible body (`FlexibleMember.patch`) or frames
            (bodies, nodes, interfaces, frames of them).
        other : Surface
            Touched side. Two surfaces are exchanged if only the other one can touch. Two convex shapes
            (`shapes.Convex`, capsules, cylinders, boxes) meet where their faces, edges and corners do. On height fields
            and meshes they are represented by points at distances of a quarter of their size, or less on finer ground;
            ``shape.sampled(spacing)`` sets the distance.
        normal : NormalLaw or Rigid
            `HuntCrossley`, `Hertz`, `KelvinVoigt` or `Restitution`, with the stiffness of all points together. Or
            `Rigid`: a unilateral constraint with instantaneous impacts and Coulomb's set-valued friction.
        friction : Coulomb or another law, optional
        surface_velocity : array_like, shape (3,)
            Velocity of the surface of `other` along itself, as of a belt, in its axes, m/s.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it. Penetration at the start is found at freeze.
        """
        from kanefe.contact.contact import Contact
        from kanefe.contact.convex_contact import ConvexContact
        from kanefe.contact.hull_contact import HullContact
        from kanefe.contact.rigid.rigid import check_normal
        from kanefe.contact.rigid.rigid_contact import RigidContact
        from kanefe.contact.wanted_contact import WantedContact
        from kanefe.kernels.contact.laws.friction_law import friction_law

        label = self._new_load(name, "contact")
        check_normal(normal, label)
        rough = friction_law(friction, label)
        _check_touched(one, other, label)
        frames, other, probes, convex, hull = self._touching(one, other, label)
        _warn_of_valleys(other.shape, [probe for _, probe in probes], label)
        if any(frame.number == other.frame.number and frame.interface_frame is None for frame in frames):
            raise ModelError(f"{label}: {frames[0].label} cannot touch itself. Remedy: surfaces of two bodies")
        for given in (*frames, other.frame):
            self._check_frame(given, f"a side of {label}")
        belt = three(surface_velocity, f"surface_velocity of {label}")
        if belt.any() and rough is None:
            raise ModelError(f"{label} has a surface velocity, but no friction that it could act by")
        _check_belt(belt, other.shape, label)
        ends = other.frame, *frames
        wanted = WantedContact(name, label, ends, other.shape, probes, convex, hull, normal, rough, belt)
        load = RigidContact.of(wanted) or ConvexContact.of(wanted) or HullContact.of(wanted) or Contact.made(wanted)
        if isinstance(one, ContactPatch):
            _warn_of_stiff_modes(one, load.straight, label)
        self.add(load)

    @checked("ignore")
    def add_contacts(
        self,
        among: Sequence[Surface],
        *,
        normal: NormalLaw | Rigid,
        friction: FrictionLaw | None = None,
        ignore: Sequence[tuple[Surface, Surface]] = (),
    ) -> list[str]:
        """Add a contact for each pair of surfaces on two bodies; return their names, "<one> on <other>".

        Parameters
        ----------
        among : sequence of Surface
        normal, friction : NormalLaw or Rigid, FrictionLaw
            Laws of all pairs. Rigid contacts of more than a dozen pairs become one contact, called "contacts among
            <first> and others": for balls and points of free bodies, and surfaces of the ground. Runs use time stepping
            over their impacts.
        ignore : sequence of pairs of Surface
            Pairs without a contact.

        Raises
        ------
        ModelError
            If something is not a surface, a pair to ignore is not among them, or there is no pair that could touch.
        """
        from kanefe.contact.surface import Surface

        for what, several in (("surfaces", among), ("pairs to ignore", ignore)):
            if not isinstance(several, (list, tuple)):
                raise ModelError(f"add_contacts needs a list of {what}, not {several!r}. Remedy: [one, other, ...]")
        for given in among:
            if not isinstance(given, Surface):
                raise ModelError(f"add_contacts needs surfaces, not {given!r}. Remedy: add_surface")
        for pair in ignore:
            if (
                not isinstance(pair, Sequence)
                or len(pair) != 2
                or not all(isinstance(given, Surface) and given in among for given in pair)
            ):
                raise ModelError(f"ignore of add_contacts takes pairs of the surfaces among which it is, not {pair!r}")
        from kanefe.contact.rigid.granular_contacts import granular_contacts_of, is_granular
        from kanefe.kernels.contact.laws.friction_law import friction_law

        left_out = {frozenset((a.name, b.name)) for a, b in ignore}
        pairs = [
            (a, b)
            for a, b in combinations(among, 2)
            if a.frame.number != b.frame.number and frozenset((a.name, b.name)) not in left_out
        ]
        if not pairs:
            listed = ", ".join(repr(given.name) for given in among) or "none"
            raise ModelError(
                f"add_contacts finds no two surfaces on two bodies that may touch among those given: {listed}. Remedy: "
                "surfaces of two bodies or more, fewer pairs in ignore, or no call where nothing can touch"
            )
        if is_granular(normal, len(pairs)):
            name = f"contacts among {among[0].name} and others"
            self._new_load(name, "contact")
            self.add(granular_contacts_of(name, among, normal, friction_law(friction, name), ignore))
            return [name]
        names = []
        for a, b in pairs:
            names.append(f"{a.name} on {b.name}")
            self.add_contact(names[-1], a, b, normal=normal, friction=friction)
        return names

    def _touching(
        self, one: Surface | ContactPatch | Frame | Sequence[Frame], other: Surface, label: str
    ) -> tuple[tuple[Frame, ...], Surface, tuple[tuple[int, Probe], ...], SurfaceShape | None, Convex | None]:
        """Return touching frames, touched surface, contact points with the number of their end, and two shapes.

        The first is the touching one of two convex shapes, whose places of contact are found at each state, the second
        a hull that touches with its corners; else None.
        """
        from kanefe.contact.geometry.convex import Convex
        from kanefe.contact.geometry.shape import Probe
        from kanefe.contact.surface import Surface, is_uneven, paired, probes_on

        if isinstance(one, Surface):
            touching, touched, met = paired(one, other, label)
            # contact points are known beforehand, or found at each state
            convex = touching.shape if probes_on(touching.shape, touched.shape) is None else None
            by_corners = convex is None and not is_uneven(touched.shape)
            hull = touching.shape if by_corners and isinstance(touching.shape, Convex) else None
            return (touching.frame,), touched, tuple((1, probe) for probe in met), convex, hull
        listed = one if isinstance(one, Sequence) else (one,)
        frames = one.frames if isinstance(one, ContactPatch) else tuple(listed)
        if not frames or not all(isinstance(frame, Frame) for frame in frames):
            raise ModelError(f"{label} needs something that touches, a surface, a patch or frames, not {one!r}")
        if isinstance(one, ContactPatch) and one.balls:
            count = Counter(ball.point for ball in one.balls)
            balls = [(ball.point, Probe(ball.centre, ball.radius, one.shares[ball.point])) for ball in one.balls]
            return frames, other, tuple((i + 1, p._replace(share=p.share / count[i])) for i, p in balls), None, None
        shares = one.shares if isinstance(one, ContactPatch) else (1.0 / len(frames),) * len(frames)
        probes = tuple((i + 1, Probe(np.zeros(3), share=share)) for i, share in enumerate(shares))
        return frames, other, probes, None, None


def _warn_of_stiff_modes(patch: ContactPatch, stiffness: float | None, label: str) -> None:
    """Warn if modes lack the local compliance of the points of a patch, relative to that of the law."""
    if stiffness is None:
        return
    softening = patch.left_out * stiffness * max(patch.shares)
    if softening > MOST_LEFT_OUT:
        warnings.warn(
            f"{label}: the modes of {patch.frames[0].name!r} lack a local compliance of {patch.left_out:.2g} m/N at a "
            f"point of the patch, {softening:.2g} times the compliance of the contact law. Remedy: a "
            f"PatchCase of the same place and most={len(patch.frames)} among the loads of its reduction",
            AccuracyWarning,
            stacklevel=outside(),
        )


def _check_touched(one: object, other: object, label: str) -> None:
    """Raise a ModelError if one side cannot touch the other."""
    from kanefe.contact.geometry.look import Look
    from kanefe.contact.surface import Surface

    if isinstance(other, ContactPatch):
        raise ModelError(
            f"{label}: facets of flexible bodies, here {other.frames[0].label}, are not touched. Remedy: a surface "
            "on an interface of it, add_surface(name, body.interface(...), shape); its points touch others"
        )
    for side in (one, other):
        if isinstance(side, Surface) and isinstance(side.shape, Look):
            raise ModelError(
                f"{label}: surface {side.name!r} is a look, which nothing touches. Remedy: shapes.Mesh or another "
                "shape for contacts"
            )
    if not isinstance(other, Surface):
        raise ModelError(f"{label} needs a surface that is touched, not {other!r}. Remedy: add_surface")


def _warn_of_valleys(shape: SurfaceShape, probes: Sequence[Probe], label: str) -> None:
    """Warn of balls and rings that can touch a height field at two points, in valleys narrower than they are."""
    from kanefe.contact.geometry.height_field import HeightField

    largest = max(probe.lever for probe in probes)
    if isinstance(shape, HeightField) and largest > shape.narrowest:
        warnings.warn(
            f"{label}: valleys of the height field have a radius of {shape.narrowest:.2g} m, in which a shape with a "
            f"radius of {largest:.2g} m touches two points, of which one is computed. Remedy: smoother heights, or "
            "points of its shape, shape.sampled(spacing)",
            AccuracyWarning,
            stacklevel=outside(),
        )


def _check_belt(belt: Vector, shape: SurfaceShape, label: str) -> None:
    """Raise a ModelError if the surface velocity of a plane has a component along its normal."""
    from kanefe.contact.shapes import Plane

    if not isinstance(shape, Plane):
        return
    across = float(belt @ shape.normal)
    if abs(across) > ALONG * float(np.linalg.norm(belt)):
        raise ModelError(
            f"{label}: {across:.3g} m/s of its surface velocity are along the normal of the plane, which does not "
            "move. Remedy: a velocity along the plane, in its axes; for a plane that moves, a driven joint under its "
            "surface"
        )
