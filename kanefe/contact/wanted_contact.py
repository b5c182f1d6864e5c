"""What a scene wants of a contact, for the kinds of contact to say whether they take it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from kanefe.frames import Vector

if TYPE_CHECKING:
    from kanefe.contact.geometry.convex import Convex
    from kanefe.contact.geometry.shape import Probe, SurfaceShape
    from kanefe.kernels.contact.laws.friction_law import FrictionLaw


class WantedContact(NamedTuple):
    """A contact as a scene wants it.

    Attributes
    ----------
    name, label : str
        The label is that of messages.
    ends : tuple of Frame
        That of the surface, then those of the probes.
    shape : SurfaceShape
        Of the surface.
    probes : tuple of (int, Probe)
        Each with the number of its end.
    convex : SurfaceShape or None
        What touches, of two convex shapes whose places of contact are found at each state.
    hull : Convex or None
        What touches with its corners, whose shares of the stiffness follow its faces.
    normal : NormalLaw or Rigid
    friction : FrictionLaw or None
    belt : ndarray, shape (3,)
        Velocity of the surface in its own axes, m/s.
    """

    name: str
    label: str
    ends: tuple[Any, ...]
    shape: SurfaceShape
    probes: tuple[tuple[int, Probe], ...]
    convex: SurfaceShape | None
    hull: Convex | None
    normal: Any
    friction: FrictionLaw | None
    belt: Vector
