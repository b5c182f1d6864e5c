"""Inertia and force of a link come to its parent: by a shift alone, since all is in N."""

from typing import NamedTuple

from kanefe.kernels.language import Matrix, Record, Rows, Symmetric, Vector, cross, inlined, skew, symmetric
from kanefe.kernels.tree import Frame


class Carried(Record):
    """A wrench of a loop on its way inward, at a row of the scene.

    Attributes
    ----------
    f, n : Vector
        What the row needs from its parent, in N: joints on the way have given way to it.
    pull, couple : Vector
        Force and moment at the end of the way, before any did.
    lever : Vector
        To that end.
    """

    f: Vector
    n: Vector
    pull: Vector
    couple: Vector
    lever: Vector


class CarriedRows(Rows[Carried]):
    """Wrenches at all rows of the scene."""


class Felt(NamedTuple):
    """Inertia and force of a link about its origin, as its parent feels them."""

    M: Symmetric
    H: Matrix
    J: Symmetric
    f: Vector
    n: Vector


@inlined
def hand_inward(parent: Frame, r: Vector, felt: Felt) -> None:
    """Add inertia and force about a point at r from the parent's origin to the parent.

    H' = H - M r~,   J' = J - H^T r~ + r~ H'
    """
    M, H, J, f, n = felt
    shifted = H - M @ skew(r)
    parent.M += M
    parent.H += shifted
    parent.J += J + symmetric(skew(r) @ shifted - H.T @ skew(r))
    hand_force_inward(parent, r, f, n)


@inlined
def hand_force_inward(parent: Frame | Carried, r: Vector, f: Vector, n: Vector) -> None:
    """Add a force and a moment at r from the parent's origin to the parent."""
    parent.f += f
    parent.n += n + cross(r, f)
