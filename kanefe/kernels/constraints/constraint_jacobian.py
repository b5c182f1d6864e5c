"""A row of J: the generalised forces of a wrench on the way from its row to N, and the largest they could be."""

from typing import Any

import numpy as np

from kanefe.kernels.joints.by_kind import partials
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.language import Vector, cross, dot, inlined, kernel
from kanefe.kernels.scene import Scene, Work, bodies_of, links_of
from kanefe.kernels.tree import InterfaceFrame, InterfaceLink, Kind


@kernel
def walk_inward(
    scene: Scene, work: Work, i: int, wrench: tuple[Vector, Vector], J: np.ndarray, reach: np.ndarray
) -> None:
    """Add the generalised forces of force and moment on a row, and the largest they could be, on the way to N.

    Those along free and spherical links are in N: their length is what matters.
    """
    links, frames, f, n = links_of(scene), work.frames, wrench[0], wrench[1]
    f_size, n_size = _size(f), _size(n)
    while i >= 0:
        link, frame, speed = links[i], frames[i], links[i].speed
        if link.kind == Kind.INTERFACE:
            body, G = bodies_of(scene, work)[link.flexible], frames[link.parent].R
            a, b = G.T @ f, InterfaceFrame(frame).tangent.T @ (G.T @ n)
            at, bent, k, first = InterfaceLink(link).basis, InterfaceLink(link).bent, body.k, body.first_deta
            own, could = J[first : first + k], reach[first : first + k]
            if bent < 0:
                _add_modes(scene.flexible.pool[at : at + 6 * k].reshape(6, k), (a, b), f_size, n_size, own, could)
            else:
                _add_modes(work.modal[bent : bent + 6 * k].reshape(6, k), (a, b), f_size, n_size, own, could)
        elif link.kind == Kind.SPHERICAL or link.kind == Kind.FREE:
            if link.kind == Kind.FREE:
                _add_three(f, f_size, J[speed:], reach[speed:])
                speed += 3
            _add_three(n, n_size, J[speed:], reach[speed:])
        elif link.kind != Kind.FIXED:
            v, w = partials(link, frame)
            J[speed] += dot(v, f) + dot(w, n)
            reach[speed] += _size(v) * f_size + _size(w) * n_size
        n = n + cross(frame.r, f)
        n_size += _size(frame.r) * f_size
        i = link.parent


@inlined
def _size(a: Vector) -> float:
    """Return the length of a vector; where its real part is zero, the square of a complex step is negative."""
    return np.sqrt(abs(dot(a, a).real))  # type: ignore[no-any-return]


@inlined
def _add_three(a: Vector, size: float, J: np.ndarray, reach: np.ndarray) -> None:
    put_three(J, 0, three(J, 0) + a)
    for c in range(3):
        reach[c] += size


@kernel
def _add_modes(
    basis: np.ndarray, wrench: tuple[Vector, Vector], f_size: float, n_size: float, J: np.ndarray, reach: np.ndarray
) -> None:
    """Add the generalised forces of a wrench in G on the modes of a body, and the largest they could be."""
    for j in range(len(J)):
        shift, turn = Vector(basis[0, j], basis[1, j], basis[2, j]), Vector(basis[3, j], basis[4, j], basis[5, j])
        J[j] += dot(shift, wrench[0]) + dot(turn, wrench[1])
        reach[j] += _size(shift) * f_size + _size(turn) * n_size


@inlined
def row_scale(J: np.ndarray, reach: np.ndarray, extents: np.ndarray) -> Any:
    """Return the square of how much of its reach a row has, between 0 and 1, over displacements of the scene's size."""
    own = full = 0.0
    for i in range(len(extents)):
        moved, reached = extents[i] * J[i].real, extents[i] * reach[i].real
        own += moved * moved
        full += reached * reached
    return 0.0 * J[0] + (own / full if full > 0.0 else 0.0)
