"""Where a point of a contact is to the surface: depth, normal, place, and how fast it moves past it."""

from typing import NamedTuple

from kanefe.kernels.contact.contact_mesh import Away
from kanefe.kernels.contact.contact_places import AtState, Place, RestNumbers, end_of, point_of
from kanefe.kernels.contact.contact_shapes import ShapeKind, distance_in
from kanefe.kernels.force_elements.places import End, Ends
from kanefe.kernels.language import Vector, cross, dot, inlined, norm


class Limits(NamedTuple):
    """From where on numbers count in a search."""

    on_its_axis: float = 1e-9
    most_turns: int = 100
    same_normal: float = 1e-15
    """Sine of the angle between the axis of a ring and the normal below which the ring has no lowest point, largest
    number of iterations, and tolerance of the normal in the search for that point on curved ground, in which the normal
    at a point gives the next point. The error decreases by the radius of the ring over that of the ground, and its
    square enters the depth."""


LIMITS = Limits()


@inlined
def away_from(at: AtState, point: Vector) -> Away:
    """Return how far a place in N is from the surface, and the normal in N."""
    surface = Ends(at.ends)[0]
    return distance_in(surface.p, surface.A, at.numbers, int(at.own.shape), point)


@inlined
def located(at: AtState, i: int) -> Place:
    """Return the place of a point, ball or ring."""
    own, end = point_of(at, i), end_of(at, i)
    centre, ring = end.p + end.A @ own.point, own.ring
    found = away_from(at, centre)
    if ring > 0.0:
        axis, middle = end.A @ own.axis, centre
        for _ in range(1 if int(at.numbers[int(at.own.shape)]) == ShapeKind.PLANE else LIMITS.most_turns):
            down = dot(axis, found.normal) * axis - found.normal
            length = norm(down)
            if length.real <= LIMITS.on_its_axis:
                break
            before, centre = found.normal, middle + (ring / length) * down
            found = away_from(at, centre)
            turned = found.normal - before
            if dot(turned, turned).real <= LIMITS.same_normal * LIMITS.same_normal:
                break
    return Place(own.radius - found.gap, found.normal, centre - own.radius * found.normal, own.share + 0.0 * found.gap)


@inlined
def velocity(surface: End, end: End, point: Vector) -> Vector:
    """Return the velocity of what touches at a place, seen from what is touched."""
    return end.v + cross(end.w, point - end.p) - (surface.v + cross(surface.w, point - surface.p))


@inlined
def gone_since(rest: RestNumbers, surface: End, end: End) -> Vector:
    """Return how far a point of what touches has gone along with what is touched since a state of rest."""
    return end.p + end.A @ rest.material - surface.p - surface.A @ rest.mark


@inlined
def turned_since(rest: RestNumbers, surface: End, end: End) -> Vector:
    """Return how far what touches has turned past the surface since a state of rest, to first order."""
    R = surface.A.T @ end.A @ rest.turned.T
    return surface.A @ (0.5 * Vector(R.y.z - R.z.y, R.z.x - R.x.z, R.x.y - R.y.x))
