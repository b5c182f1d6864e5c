"""Where the points of a contact are, whatever its kind: what is known of all of them together, and then of each."""

from collections import namedtuple
from typing import Any

from kanefe.kernels.contact.contact_boxes import BoxesMet, HalfBox, box_slot, boxes_meet
from kanefe.kernels.contact.contact_places import AtState, Kind, Place, end_of, point_of
from kanefe.kernels.contact.contact_shapes import Box
from kanefe.kernels.contact.convex_edges import Slots
from kanefe.kernels.contact.convex_places import PatchMet, patch_met, patch_place
from kanefe.kernels.contact.detection import located
from kanefe.kernels.contact.hull_shares import HullMet, hull_corner, hull_met
from kanefe.kernels.force_elements.places import Ends
from kanefe.kernels.language import inlined, kernel

Met = namedtuple("Met", "boxes corners patch")
"""Knowledge of all points of a contact, of that kind of it that the contact is."""


@inlined
def meet(at: AtState, slots: Any, ahead: Any, behind: Any) -> Met:
    """Return what is known of all points; there is room for slots, ahead and behind for derivatives alone."""
    kind, none = int(at.own.kind), 0.0 * Ends(at.ends)[0].p
    zero = none.x
    boxes, corners = BoxesMet(none, zero, -1, -1), HullMet(zero, zero)
    patch = PatchMet(zero, Slots(slots), Slots(ahead), Slots(behind))
    if kind == Kind.BOXES:
        boxes = boxes_meet(*both_boxes(at))
    elif kind == Kind.HULL:
        corners = hull_met(at)
    elif kind == Kind.CONVEX:
        patch = patch_met(at, slots, ahead, behind)
    return Met(boxes, corners, patch)


@inlined
def both_boxes(at: AtState) -> tuple[HalfBox, HalfBox]:
    """Return the boxes of a contact of two, first that which touches."""
    own = HalfBox(end_of(at, 0), point_of(at, 0).axis)
    return own, HalfBox(Ends(at.ends)[0], 0.5 * Box(at.numbers, int(at.own.shape)).size)


@inlined
def place_of(at: AtState, i: int, met: Met) -> Place:
    """Return where a point is."""
    kind = int(at.own.kind)
    if kind == Kind.HULL:
        return hull_corner(at, i, met.corners)
    if kind == Kind.CONVEX:
        return patch_place(at, i, met.patch)
    if kind == Kind.BOXES:
        own = point_of(at, i)
        depth, point = box_slot(met.boxes, -1 - int(own.ring), *both_boxes(at))
        return Place(depth, met.boxes.normal, point, own.share + 0.0 * depth)
    return located(at, i)


@kernel
def look(at: AtState, room: Any) -> Met:
    """Return what is known of all points, of real numbers: for code that is not called in each evaluation."""
    return meet(at, room, room, room)


@kernel
def look_up(at: AtState, i: int, met: Met) -> Place:
    """Return where a point is, likewise."""
    return place_of(at, i, met)
