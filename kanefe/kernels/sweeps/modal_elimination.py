"""Elimination of the modes of a flexible body: a constant diagonal with a border of low rank.

In modes of unit mass, with the acceleration V of G (share of du), forces p on the modes, and for each interface that
carries something its motion ``X V + B x`` and what it carries, ``y = A (X V + B x) + f``:

    x + C^T V + B^T y = p,      so that      (1 + A B B^T) y = A (H V + B p) + f,      H = X - B C^T,

a system of six unknowns an interface, whatever the number of modes. G then feels

    (M - C C^T + H^T A' H) V + f_G + C p + H^T y_0,      A' = (1 + A B B^T)^-1 A,   y_0 = A' B p + (1 + A B B^T)^-1 f.

Nothing large is subtracted from something large: A' is the carried inertia in series with the compliance of the modes.
"""

import numpy as np

from kanefe.kernels.algebra.lu import factorise, solve, solve_columns
from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.bodies import BorderedBody, ModalBody
from kanefe.kernels.joints.handing import Felt, hand_force_inward, hand_inward
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.language import Values, inlined, kernel, vector_kernel
from kanefe.kernels.scene import Scene, Work, bodies_of, links_of
from kanefe.kernels.sweeps.elastic import combination, total, transposed_product
from kanefe.kernels.sweeps.unit_mass import from_unit_mass, to_unit_mass
from kanefe.kernels.tree import Frame, InterfaceFrame, InterfaceLink
from kanefe.kernels.values.tensors import (
    NO_INERTIA,
    NO_MATRIX,
    ZERO,
    Matrix,
    Symmetric,
    Vector,
    congruent,
    cross,
    dot,
    outer,
    square,
)


@kernel
def eliminate_modes(scene: Scene, work: Work, f: int, is_implicit: bool) -> None:
    """Take the modes of a body out of the articulated inertia of its link; scaled ones in an implicit sweep."""
    body, frames, flexible = bodies_of(scene, work)[f], work.frames, scene.flexible
    frame, count = frames[body.link], body.carried_count
    if body.k == 0:  # its interfaces are fixed in G
        for c in range(count):
            moved = frames[flexible.carrying[body.carried + c]]
            hand_inward(frame, moved.r, Felt(moved.M, moved.H, moved.J, moved.f, moved.n))
        return
    G = frame.R
    M, f_of_G = _modes_give_way(body.linear, body.p)
    J, n_of_G = _modes_give_way(body.angular, body.p)
    H = _coupling_gives_way(body)
    if count > 0:
        for c in range(count):
            i = flexible.carrying[body.carried + c]
            _gather(scene, work, body, c, i, is_implicit)
        _put_in_series(body)
        M, H, J, f_of_G, n_of_G = _with_carried(body, M, H, J, f_of_G, n_of_G)
    frame.M += congruent(G, M)
    frame.H += G @ H @ G.T
    frame.J += congruent(G, J)
    frame.f += G @ f_of_G
    frame.n += G @ n_of_G


@vector_kernel
def _modes_give_way(momenta: Values, p: np.ndarray) -> tuple[Symmetric, Vector]:
    """Return what the modes alone do to mass and force of G, or inertia and moment: the parts of -C C^T and C p."""
    inertia, force = NO_INERTIA, ZERO
    for i in range(len(p)):
        inertia -= square(momenta[i], momenta[i])
        force += p[i] * momenta[i]
    return inertia, force


@vector_kernel
def _coupling_gives_way(body: ModalBody) -> Matrix:
    """Return what they do to the coupling of both."""
    H, linear, angular = NO_MATRIX, body.linear, body.angular
    for i in range(len(linear)):
        H -= outer(linear[i], angular[i])
    return H


@inlined
def _gather(scene: Scene, work: Work, body: BorderedBody, c: int, i: int, is_implicit: bool) -> None:
    """Write B, H, A and f of an interface that carries something, in G: the one in row i is number c of its body."""
    flexible, modal, frame, own, G = (
        scene.flexible,
        work.modal,
        work.frames[i],
        InterfaceLink(links_of(scene)[i]),
        work.frames[body.link].R,
    )
    k, at, back = body.k, 6 * c, G.T
    basis, lever, inertia = body.basis[at : at + 6], body.lever[at : at + 6], body.inertia[at : at + 6]
    T = InterfaceFrame(frame).tangent
    if own.bent < 0:
        _place_basis(flexible.pool[own.basis : own.basis + 6 * k].reshape(6, k), T, basis)
    else:
        _place_basis(modal[own.bent : own.bent + 6 * k].reshape(6, k), T, basis)
    scale(body, basis, is_implicit)
    r = back @ frame.r
    for a in range(6):
        put_three(lever[a], 0, -combination(body.linear, basis[a]))
        put_three(lever[a], 3, -combination(body.angular, basis[a]))
        lever[a, a] += 1.0
    lever[0, 4] += r.z
    lever[0, 5] -= r.y
    lever[1, 3] -= r.z
    lever[1, 5] += r.x
    lever[2, 3] += r.y
    lever[2, 4] -= r.x
    _put_block(inertia, congruent(back, frame.M), back @ frame.H @ G, congruent(back, frame.J))
    put_three(body.force, at, back @ frame.f)
    put_three(body.force, at + 3, back @ frame.n)


@inlined
def _put_in_series(body: BorderedBody) -> None:
    """Write A' H, y_0 and the factors of 1 + A B B^T: what is carried, in series with the compliance of the modes."""
    basis, gram, column, lever, inertia = body.basis, body.gram, body.column, body.lever, body.inertia
    factors, series, held, force, p = body.factors, body.series, body.held, body.force, body.p
    n = len(held)
    for a in range(n):
        for b in range(a + 1):
            gram[a, b] = gram[b, a] = total(basis[a], basis[b])
        column[a] = total(basis[a], p)
    for first in range(0, n, 6):
        motion, levers = gram[first : first + 6], lever[first : first + 6]
        for a in range(first, first + 6):
            row = inertia[a]
            transposed_product(motion, 0, row, factors[a])
            transposed_product(levers, 0, row, series[a])
            factors[a, a] += 1.0
            held[a] = force[a] + total(row, column[first : first + 6])
    factorise(factors, body.pivots)
    solve(factors, body.pivots, held)
    solve_columns(factors, body.pivots, series)


@inlined
def _with_carried(
    body: BorderedBody, M: Symmetric, H: Matrix, J: Symmetric, f: Vector, n: Vector
) -> tuple[Symmetric, Matrix, Symmetric, Vector, Vector]:
    """Add what the carried interfaces do to inertia and force of G: H^T A' H and H^T y_0."""
    lever, series, held = body.lever, body.series, body.held
    for i in range(len(held)):
        linear, angular = three(lever[i], 0), three(lever[i], 3)
        by_a, by_alpha = three(series[i], 0), three(series[i], 3)
        M += square(linear, by_a)
        H += outer(linear, by_alpha)
        J += square(angular, by_alpha)
        f += held[i] * linear
        n += held[i] * angular
    return M, H, J, f, n


@vector_kernel
def _place_basis(raw: np.ndarray, T: Matrix, basis: np.ndarray) -> None:
    """Write the motion of an interface from the modes: translation, and the turn that the slopes make."""
    for i in range(raw.shape[1]):
        turn = T @ Vector(raw[3, i], raw[4, i], raw[5, i])
        basis[0, i], basis[1, i], basis[2, i] = raw[0, i], raw[1, i], raw[2, i]
        basis[3, i], basis[4, i], basis[5, i] = turn.x, turn.y, turn.z


@inlined
def _put_block(A: np.ndarray, M: Symmetric, H: Matrix, J: Symmetric) -> None:
    """Write a 6 x 6 matrix of three 3 x 3 ones."""
    m, back, j = M.full, H.T, J.full
    _put_column(A, 0, m.x, back.x)
    _put_column(A, 1, m.y, back.y)
    _put_column(A, 2, m.z, back.z)
    _put_column(A, 3, H.x, j.x)
    _put_column(A, 4, H.y, j.y)
    _put_column(A, 5, H.z, j.z)


@inlined
def _put_column(A: np.ndarray, i: int, a: Vector, b: Vector) -> None:
    """Write a column of six numbers."""
    A[0, i], A[1, i], A[2, i], A[3, i], A[4, i], A[5, i] = a.x, a.y, a.z, b.x, b.y, b.z


@kernel
def eliminate_modal_forces(scene: Scene, work: Work, f: int, is_implicit: bool) -> None:
    """Hand other forces on the modes, and on what the body carries, to its link: the border is there already."""
    body, frames, flexible = bodies_of(scene, work)[f], work.frames, scene.flexible
    k, count, frame = body.k, body.carried_count, frames[body.link]
    if k == 0:
        for c in range(count):
            moved = frames[flexible.carrying[body.carried + c]]
            hand_force_inward(frame, moved.r, moved.f, moved.n)
        return
    G, p, column = frame.R, body.p, body.column
    scale(body, p.reshape(1, k), is_implicit)
    for c in range(count):
        moved = frames[flexible.carrying[body.carried + c]]
        put_three(column, 6 * c, G.T @ moved.f)
        put_three(column, 6 * c + 3, G.T @ moved.n)
    push, turn = push_through_modes(body, p, column, column, body.held)
    frame.f += G @ push
    frame.n += G @ turn


@inlined
def push_through_modes(
    body: BorderedBody, p: np.ndarray, on: np.ndarray, moved: np.ndarray, held: np.ndarray
) -> tuple[Vector, Vector]:
    """Return what G feels of forces p on the modes and `on` on what they carry; write y_0 to `held`, B p to `moved`.

    Each of these is (n,); `moved` may be `on`, which is lost then.
    """
    basis, inertia, lever = body.basis, body.inertia, body.lever
    a, b = combination(body.linear, p), combination(body.angular, p)
    for i in range(len(held)):
        held[i] = on[i]
        moved[i] = total(basis[i], p)
    for i in range(len(held)):
        first = i - i % 6
        held[i] += total(inertia[i], moved[first : first + 6])
    solve(body.factors, body.pivots, held)
    for i in range(len(held)):
        a += held[i] * three(lever[i], 0)
        b += held[i] * three(lever[i], 3)
    return a, b


@kernel
def modal_accelerations(scene: Scene, work: Work, f: int, is_implicit: bool, du: np.ndarray) -> None:
    """Write ddeta of a body, and the share of du in the motion of its carrying interfaces."""
    body, frames, flexible = bodies_of(scene, work)[f], work.frames, scene.flexible
    k, count, speed, frame = body.k, body.carried_count, body.first_deta, frames[body.link]
    G, x = frame.R, body.x
    if k == 0:
        for c in range(count):
            _carry(frame, frames[flexible.carrying[body.carried + c]], ZERO, ZERO)
        return
    a, alpha = G.T @ frame.a, G.T @ frame.alpha
    _respond(body, a, alpha)
    if count > 0:
        basis, series, held = body.basis, body.series, body.held
        for i in range(6 * count):
            y = held[i] + dot(three(series[i], 0), a) + dot(three(series[i], 3), alpha)
            subtract(basis[i], y, x)
        for c in range(count):
            at = 6 * c
            shift = Vector(total(basis[at], x), total(basis[at + 1], x), total(basis[at + 2], x))
            turn = Vector(total(basis[at + 3], x), total(basis[at + 4], x), total(basis[at + 5], x))
            _carry(frame, frames[flexible.carrying[body.carried + c]], shift, turn)
    if body.is_exact:
        from_unit_mass(ExactBeam(body), x)
    elif is_implicit:
        scale_rows(x.reshape(1, k), body.scale)
    if body.transform < 0:
        for j in range(k):
            du[speed + j] = x[j]
    else:
        transposed_product(body.from_modes, 0, x, du[speed : speed + k])


@inlined
def _carry(frame: Frame, moved: Frame, shift: Vector, turn: Vector) -> None:
    """Write the share of du in the motion of an interface: with G, and in G from the modes."""
    moved.a = frame.a + cross(frame.alpha, moved.r) + frame.R @ shift
    moved.alpha = frame.alpha + frame.R @ turn


@vector_kernel
def _respond(body: ModalBody, a: Vector, alpha: Vector) -> None:
    """Write the accelerations of the modes with what they carry left out."""
    x, p, linear, angular = body.x, body.p, body.linear, body.angular
    for i in range(len(x)):
        x[i] = p[i] - dot(a, linear[i]) - dot(alpha, angular[i])


@inlined
def scale(body: BorderedBody, rows: np.ndarray, is_implicit: bool) -> None:
    """Replace forces on the coordinates of a body, or motions by them, by those of coordinates of unit mass."""
    if body.is_exact:
        to_unit_mass(ExactBeam(body), rows)
    elif is_implicit:
        scale_rows(rows, body.scale)


@vector_kernel
def scale_rows(rows: np.ndarray, scale: np.ndarray) -> None:
    """Multiply all rows by a scale of their columns."""
    for a in range(rows.shape[0]):
        for i in range(rows.shape[1]):
            rows[a, i] *= scale[i]


@vector_kernel
def subtract(row: np.ndarray, y: float, x: np.ndarray) -> None:
    """Subtract a multiple of a row."""
    for i in range(len(x)):
        x[i] -= y * row[i]
