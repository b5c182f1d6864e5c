"""Where two convex shapes of a contact touch, found at each state.

For complex numbers, derivatives of places, normals, depths and shares are differences of real ones along the imaginary
part of the pose; what the laws make of them is exact.
"""

from collections import namedtuple
from typing import Any

from kanefe.kernels.contact.contact_places import AtState, Place
from kanefe.kernels.contact.convex_edges import Slots
from kanefe.kernels.contact.convex_patch import put_slots
from kanefe.kernels.contact.convex_shapes import ConvexShape, Posed
from kanefe.kernels.force_elements.places import Ends
from kanefe.kernels.language import Matrix, Record, Vector, inlined, kernel

DIFFERENCE = 1e-5
"""Change of the pose by which derivatives are found, rad, and relative to the size of the shapes."""


class PairNumbers(Record):
    """The numbers of two shapes: a kind that is none, where the other one begins, from here; then those of the own."""

    kind: float
    other: float


PAIR = PairNumbers.number_count

PatchMet = namedtuple("PatchMet", "factor slots ahead behind")
"""Places where shapes touch, and ahead and behind; what the difference of both is multiplied by."""

Pose = namedtuple("Pose", "R x")
"""How what touches is turned and moved in the axes of what is touched, or how that changes."""


@inlined
def real_part(x: Vector) -> Vector:
    """Return a vector of real numbers."""
    return Vector(x.x.real, x.y.real, x.z.real)


@inlined
def imaginary_part(x: Vector) -> Vector:
    """Return the derivatives that complex numbers carry."""
    return Vector(x.x.imag, x.y.imag, x.z.imag)


@inlined
def by_columns(x: Vector, y: Vector, z: Vector) -> Matrix:
    """Return the matrix of three columns."""
    return Matrix(x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z)


@inlined
def largest_of(x: Vector) -> Any:
    """Return the number of a vector that has the largest imaginary part."""
    a, b, c = abs(x.x.imag), abs(x.y.imag), abs(x.z.imag)
    return x.x if a >= b and a >= c else x.y if b >= c else x.z


@inlined
def larger_of(a: Any, b: Any) -> Any:
    """Return the number that has the larger imaginary part."""
    return b if abs(b.imag) > abs(a.imag) else a


@kernel
def put_at(at: AtState, pose: Pose, change: Pose, step: float, room: Any) -> None:
    """Write where the shapes of a contact touch some steps along a change of their pose."""
    first = int(at.own.shape)
    other = ConvexShape(at.numbers, first + int(PairNumbers(at.numbers, first).other))
    own = Posed(ConvexShape(at.numbers, first + PAIR), pose.R + step * change.R, pose.x + step * change.x)
    put_slots(own, other, int(at.own.count), room)


@kernel
def patch_met(at: AtState, slots: Any, ahead: Any, behind: Any) -> PatchMet:
    """Write where the shapes touch, ahead and behind a small change of the pose too, if there is one."""
    A_s, end = Ends(at.ends)[0].A, Ends(at.ends)[1]
    R, x = A_s.T @ end.A, A_s.T @ (end.p - Ends(at.ends)[0].p)
    pose = Pose(by_columns(real_part(R.x), real_part(R.y), real_part(R.z)), real_part(x))
    turns = by_columns(imaginary_part(R.x), imaginary_part(R.y), imaginary_part(R.z))
    change = Pose(turns, imaginary_part(x))
    put_at(at, pose, change, 0.0, slots)
    first = int(at.own.shape)
    other = ConvexShape(at.numbers, first + int(PairNumbers(at.numbers, first).other))
    size = ConvexShape(at.numbers, first + PAIR).size + other.size
    changed = larger_of(larger_of(largest_of(R.x), largest_of(R.y)), largest_of(R.z))
    changed = larger_of(changed, (1.0 / size) * largest_of(x))
    if changed.imag == 0.0:
        return PatchMet(changed - changed.real, Slots(slots), Slots(ahead), Slots(behind))
    step = DIFFERENCE / abs(changed.imag)
    put_at(at, pose, change, step, ahead)
    put_at(at, pose, change, -step, behind)
    factor = (changed - changed.real) / (2.0 * step * changed.imag)
    return PatchMet(factor, Slots(slots), Slots(ahead), Slots(behind))


@inlined
def patch_place(at: AtState, i: int, met: PatchMet) -> Place:
    """Return a place where shapes touch."""
    here, surface, factor = met.slots[i], Ends(at.ends)[0], met.factor
    if factor.imag == 0.0:
        point = surface.p + surface.A @ here.place
        return Place(here.depth + factor, surface.A @ here.normal, point, here.share + factor)
    ahead, behind = met.ahead[i], met.behind[i]
    normal = here.normal + factor * (ahead.normal - behind.normal)
    place = here.place + factor * (ahead.place - behind.place)
    depth, share = ahead.depth - behind.depth, ahead.share - behind.share
    point = surface.p + surface.A @ place
    return Place(here.depth + factor * depth, surface.A @ normal, point, here.share + factor * share)
