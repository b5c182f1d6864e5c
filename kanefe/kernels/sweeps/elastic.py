"""Terms of a flexible body in its mesh frame G from constants (Eq. 29, 36, 38), in modes of unit mass and diagonal K.

With ``P_ab = int rho r_a psi_b`` only two parts of the mass moments are needed: the symmetric one, which gives inertia
and centrifugal forces, and the antisymmetric one, which couples rotations with the modes and gives Coriolis forces. So
a body with k modes costs nine products of a k x k matrix with eta and three with deta, whatever its mesh.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    congruent,
    cross,
    matrix,
    plus,
    rotated,
    rotated_back,
    six,
    symmetric_times,
    three,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, kernel, vector_kernel
from kanefe.kernels.layout import (
    COUNT,
    DAMPING,
    DETA,
    ETA,
    MODAL,
    OMEGA,
    POOL,
    POOL_FIRST,
    POOL_MASS,
    POOL_SECOND,
    POOL_STIFFNESS,
    QUADRATIC,
    QUADRATIC_WORK,
    TRANSFORM,
    WORK_COUPLING,
    WORK_DETA,
    WORK_ETA,
    WORK_FORCE,
    WORK_PRODUCTS,
    WORK_RATES,
    FlexibleTables,
    R,
    Y,
    Z,
)
from kanefe.kernels.sweeps.body_inertia import put_inertia, set_rigid


@vector_kernel
def transposed_product(A: np.ndarray, first: int, x: np.ndarray, out: np.ndarray) -> None:
    """Write ``out = A[:, first:]^T x``: rows of A are added up, four at a time so that `out` is read less often."""
    k, n = len(x), len(out)
    for i in range(n):
        out[i] = 0.0
    j = 0
    while j + 4 <= k:
        a, b, c, d = x[j], x[j + 1], x[j + 2], x[j + 3]
        ra, rb, rc, rd = A[j, first:], A[j + 1, first:], A[j + 2, first:], A[j + 3, first:]
        for i in range(n):
            out[i] += a * ra[i] + b * rb[i] + c * rc[i] + d * rd[i]
        j += 4
    while j < k:
        a, ra = x[j], A[j, first:]
        for i in range(n):
            out[i] += a * ra[i]
        j += 1


@vector_kernel
def total(a: np.ndarray, b: np.ndarray) -> float:
    """Return a . b."""
    s = b.dtype.type(0.0)
    for i in range(len(a)):
        s += a[i] * b[i]
    return s


@inlined
def span(body: np.ndarray, which: int) -> slice:
    """Return where k numbers of a body are in the modal work."""
    start = body[MODAL] + which * body[COUNT]
    return slice(start, start + body[COUNT])


@inlined
def coupling_span(body: np.ndarray) -> slice:
    """Return where C (6, k), the inertia between the motion of G and the modes, is in the modal work."""
    k = body[COUNT]
    start = body[MODAL] + WORK_COUPLING * k
    return slice(start, start + 6 * k)


@vector_kernel
def project(basis: np.ndarray, first: int, x: np.ndarray) -> Numbers:
    """Return three successive rows of a basis times x."""
    a = b = c = x.dtype.type(0.0)  # x has no entries where all interfaces are clamped and no mode is kept
    for i in range(len(x)):
        a += basis[first, i] * x[i]
        b += basis[first + 1, i] * x[i]
        c += basis[first + 2, i] * x[i]
    return a, b, c


@kernel
def modal_state(flexible: FlexibleTables, f: int, q: np.ndarray, u: np.ndarray, modal: np.ndarray) -> None:
    """Write eta and deta of a body in modes of unit mass."""
    body = flexible.bodies[f]
    k, at, speed = body[COUNT], body[ETA], body[DETA]
    eta, deta = modal[span(body, WORK_ETA)], modal[span(body, WORK_DETA)]
    if body[TRANSFORM] < 0:
        for j in range(k):
            eta[j] = q[at + j]
            deta[j] = u[speed + j]
    else:
        transform = flexible.pool[body[TRANSFORM] : body[TRANSFORM] + k * k].reshape(k, k)
        transposed_product(transform, 0, q[at : at + k], eta)
        transposed_product(transform, 0, u[speed : speed + k], deta)


@kernel
def set_flexible(flexible: FlexibleTables, f: int, i: int, work: np.ndarray, modal: np.ndarray) -> None:
    """Write inertia and force of a flexible body with du = 0, in N, and coupling and forces of its modes (Eq. 38)."""
    body, pool = flexible.bodies[f], flexible.pool
    G = matrix(work, i, R)
    w = rotated_back(G, vector(work, i, OMEGA))
    a, alpha = rotated_back(G, vector(work, i, Z)), rotated_back(G, vector(work, i, Y))
    k = body[COUNT]
    at = body[POOL]
    constants = pool[at:]
    shapes = at + POOL_STIFFNESS + k
    translation = pool[shapes : shapes + 3 * k].reshape(3, k)
    second_shapes = pool[shapes + 3 * k : shapes + 9 * k].reshape(6, k)
    rotation_shapes = pool[shapes + 9 * k : shapes + 12 * k].reshape(3, k)
    products = pool[shapes + 12 * k : shapes + 12 * k + 9 * k * k].reshape(k, 9 * k)
    eta, deta = modal[span(body, WORK_ETA)], modal[span(body, WORK_DETA)]
    p = modal[span(body, WORK_FORCE)]
    start = body[MODAL]
    of_eta = modal[start + WORK_PRODUCTS * k : start + (WORK_PRODUCTS + 9) * k]
    of_deta = modal[start + WORK_RATES * k : start + (WORK_RATES + 3) * k]
    coupling = modal[start + WORK_COUPLING * k : start + (WORK_COUPLING + 6) * k].reshape(6, k)
    transposed_product(products, 0, eta, of_eta)
    _couple(translation, rotation_shapes, of_eta, coupling)
    zero = 0.0 * G[0]
    first, pull, twist = three(constants, POOL_FIRST), (zero, zero, zero), (zero, zero, zero)
    if body[QUADRATIC] < 0:
        transposed_product(products, 6 * k, deta, of_deta)
    else:
        workspace = modal[body[QUADRATIC_WORK] : body[QUADRATIC_WORK] + 9 * k].reshape(9, k)
        at = body[QUADRATIC]
        quadratic = pool[at : at + 6 * k * k].reshape(k, 6 * k)
        first, pull, twist = _bend(quadratic, products, eta, deta, of_deta, first, workspace, coupling)

    # moments of the deformed body: int rho r_a r_b and int rho r_a du_b
    B = _second_moments(second_shapes, of_eta, eta, 2.0)
    B0 = six(constants, POOL_SECOND)
    B = (B[0] + B0[0], B[1] + B0[1], B[2] + B0[2], B[3] + B0[3], B[4] + B0[4], B[5] + B0[5])
    Q = _second_moments(second_shapes, of_eta, deta, 1.0)
    c, turn = plus(first, project(coupling, 0, eta)), project(coupling, 3, deta)
    dc = project(coupling, 0, deta)
    inertia = inertia_of(B)
    mass = constants[POOL_MASS]

    force = plus(times(mass, a), plus(cross(alpha, c), cross(w, plus(cross(w, c), times(2.0, dc)))))
    # 2 int rho r x (w x du) = 2 (tr Q w - Q^T w); Q has the symmetric part above and the antisymmetric part turn/2
    coriolis = plus(plus(times(2.0 * (Q[0] + Q[3] + Q[5]), w), times(-2.0, symmetric_times(Q, w))), cross(w, turn))
    gyroscopic = cross(w, symmetric_times(inertia, w))
    moment = plus(plus(cross(c, a), symmetric_times(inertia, alpha)), plus(gyroscopic, coriolis))
    force, moment = plus(force, pull), plus(moment, twist)
    _modal_forces(second_shapes, of_eta, of_deta, coupling, w, a, alpha, p)
    diagonal = constants[POOL_STIFFNESS:]
    for j in range(k):
        p[j] -= diagonal[j] * eta[j]
    if body[DAMPING] >= 0:
        _subtract_product(pool[body[DAMPING] : body[DAMPING] + k * k].reshape(k, k), deta, p)
    put_inertia(work, i, mass, rotated(G, c), congruent(G, inertia), rotated(G, force), rotated(G, moment))


@kernel
def _bend(
    quadratic: np.ndarray,
    products: np.ndarray,
    eta: np.ndarray,
    deta: np.ndarray,
    of_deta: np.ndarray,
    first: Numbers,
    workspace: np.ndarray,
    coupling: np.ndarray,
) -> tuple[Numbers, Numbers, Numbers]:
    """Add the second-order displacement to the coupling of translations; see `mass_moments.add_quadratic_terms`.

    Its second moments are part of `products` already. Returns the first moment, less what its derivative counts twice,
    and the forces ``deta^T G deta`` and ``deta^T N deta`` on the translation and rotation of G.
    """
    k = len(eta)
    flat = workspace.reshape(9 * k)
    transposed_product(quadratic, 0, eta, flat[: 3 * k])
    transposed_product(quadratic, 0, deta, flat[3 * k : 6 * k])
    transposed_product(quadratic, 3 * k, deta, of_deta)
    transposed_product(products, 6 * k, deta, flat[6 * k :])
    for c in range(3):
        for i in range(k):
            coupling[c, i] += workspace[c, i]
    return (
        plus(first, times(-0.5, project(workspace, 0, eta))),
        project(workspace, 3, deta),
        project(workspace, 6, deta),
    )


@inlined
def set_stiff(flexible: FlexibleTables, f: int, i: int, work: np.ndarray) -> None:
    """Write inertia and force of a body without modes."""
    constants = flexible.pool[flexible.bodies[f, POOL] :]
    set_rigid(
        work,
        i,
        constants[POOL_MASS],
        three(constants, POOL_FIRST),
        inertia_of(six(constants, POOL_SECOND)),
        (0.0, 0.0, 0.0),
    )


@inlined
def inertia_of(B: Numbers) -> Numbers:
    """Return the inertia tr(B) - B of second moments B."""
    trace = B[0] + B[3] + B[5]
    return trace - B[0], -B[1], -B[2], trace - B[3], -B[4], trace - B[5]


@vector_kernel
def _couple(translation: np.ndarray, rotation_shapes: np.ndarray, of_eta: np.ndarray, coupling: np.ndarray) -> None:
    k = translation.shape[1]
    for i in range(k):
        coupling[0, i] = translation[0, i]
        coupling[1, i] = translation[1, i]
        coupling[2, i] = translation[2, i]
        coupling[3, i] = rotation_shapes[0, i] + of_eta[6 * k + i]
        coupling[4, i] = rotation_shapes[1, i] + of_eta[7 * k + i]
        coupling[5, i] = rotation_shapes[2, i] + of_eta[8 * k + i]


@vector_kernel
def _second_moments(shapes: np.ndarray, of_eta: np.ndarray, x: np.ndarray, of_shapes: float) -> Numbers:
    """Return the symmetric part of x times weighted shapes and products: six sums over the modes."""
    k = len(x)
    b0 = b1 = b2 = b3 = b4 = b5 = x.dtype.type(0.0)
    for i in range(k):
        b0 += x[i] * (of_shapes * shapes[0, i] + of_eta[i])
        b1 += x[i] * (of_shapes * shapes[1, i] + of_eta[k + i])
        b2 += x[i] * (of_shapes * shapes[2, i] + of_eta[2 * k + i])
        b3 += x[i] * (of_shapes * shapes[3, i] + of_eta[3 * k + i])
        b4 += x[i] * (of_shapes * shapes[4, i] + of_eta[4 * k + i])
        b5 += x[i] * (of_shapes * shapes[5, i] + of_eta[5 * k + i])
    return b0, b1, b2, b3, b4, b5


@vector_kernel
def _modal_forces(
    shapes: np.ndarray,
    of_eta: np.ndarray,
    of_deta: np.ndarray,
    coupling: np.ndarray,
    w: Numbers,
    a: Numbers,
    alpha: Numbers,
    p: np.ndarray,
) -> None:
    """Write the inertia forces on the modes with du = 0: centrifugal, Coriolis, and of the acceleration of G."""
    k = len(p)
    xx, yy, zz = w[0] * w[0], w[1] * w[1], w[2] * w[2]
    c0, c3, c5 = yy + zz, xx + zz, xx + yy  # minus w~^2, off-diagonal entries counted twice
    c1, c2, c4 = -2.0 * w[0] * w[1], -2.0 * w[0] * w[2], -2.0 * w[1] * w[2]
    for i in range(k):
        centrifugal = (
            c0 * (shapes[0, i] + of_eta[i])
            + c1 * (shapes[1, i] + of_eta[k + i])
            + c2 * (shapes[2, i] + of_eta[2 * k + i])
            + c3 * (shapes[3, i] + of_eta[3 * k + i])
            + c4 * (shapes[4, i] + of_eta[4 * k + i])
            + c5 * (shapes[5, i] + of_eta[5 * k + i])
        )
        coriolis = 2.0 * (w[0] * of_deta[i] + w[1] * of_deta[k + i] + w[2] * of_deta[2 * k + i])
        carried = (
            a[0] * coupling[0, i]
            + a[1] * coupling[1, i]
            + a[2] * coupling[2, i]
            + alpha[0] * coupling[3, i]
            + alpha[1] * coupling[4, i]
            + alpha[2] * coupling[5, i]
        )
        p[i] = centrifugal - coriolis - carried


@inlined
def _subtract_product(A: np.ndarray, x: np.ndarray, p: np.ndarray) -> None:
    for i in range(len(x)):
        p[i] -= total(A[i], x)
