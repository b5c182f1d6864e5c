"""Terms of a flexible body in its mesh frame G from constants (Eq. 29, 36, 38), in modes of unit mass and diagonal K.

With ``P_ab = int rho r_a psi_b`` only two parts of the mass moments are needed: the symmetric one, which gives inertia
and centrifugal forces, and the antisymmetric one, which couples rotations with the modes and gives Coriolis forces. So
a body with k modes costs nine products of a k x k matrix with eta and three with deta, whatever its mesh.
"""

from typing import Any

import numpy as np

from kanefe.kernels.bodies import ModalBody
from kanefe.kernels.language import Values, inlined, kernel, vector_kernel
from kanefe.kernels.sweeps.body_inertia import put_inertia, put_rigid
from kanefe.kernels.tree import Frame
from kanefe.kernels.values.tensors import (
    NO_INERTIA,
    ZERO,
    Symmetric,
    Vector,
    congruent,
    contract,
    cross,
    diagonal,
    dot,
    square,
)


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


@vector_kernel
def project(basis: np.ndarray, first: int, x: np.ndarray) -> tuple[Any, Any, Any]:
    """Return three successive rows of a basis times x."""
    a = b = c = x.dtype.type(0.0)  # x has no entries where all interfaces are clamped and no mode is kept
    for i in range(len(x)):
        a += basis[first, i] * x[i]
        b += basis[first + 1, i] * x[i]
        c += basis[first + 2, i] * x[i]
    return a, b, c


@inlined
def combined(basis: np.ndarray, first: int, x: np.ndarray) -> Vector:
    """Return three successive rows of a basis times x."""
    a, b, c = project(basis, first, x)
    return Vector(a, b, c)


@vector_kernel
def combination(many: Values, x: np.ndarray) -> Vector:
    """Return the sum of vectors times numbers."""
    found = ZERO
    for i in range(len(x)):
        found += x[i] * many[i]
    return found


@kernel
def modal_state(body: ModalBody, q: np.ndarray, u: np.ndarray) -> None:
    """Write eta and deta of a body in modes of unit mass."""
    k, at, speed, eta, deta = body.k, body.first_eta, body.first_deta, body.eta, body.deta
    if body.transform < 0:
        for j in range(k):
            eta[j], deta[j] = q[at + j], u[speed + j]
    else:
        transposed_product(body.to_modes, 0, q[at : at + k], eta)
        transposed_product(body.to_modes, 0, u[speed : speed + k], deta)


@kernel
def add_along_mode(body: ModalBody, i: int, force: Any, p: np.ndarray) -> None:
    """Add a force along a coordinate of a body, or a row that it has there, to those of modes of unit mass."""
    if body.transform < 0:
        p[i] += force
    else:
        for j in range(body.k):
            p[j] += body.from_modes[j, i] * force


@kernel
def set_flexible(body: ModalBody, frame: Frame) -> None:
    """Write inertia and force of a flexible body with du = 0, in N, and coupling and forces of its modes (Eq. 38)."""
    G, k, eta, deta, products = frame.R, body.k, body.eta, body.deta, body.products
    w, a, alpha = G.T @ frame.w, G.T @ frame.Z, G.T @ frame.Y
    transposed_product(products, 0, eta, body.even.numbers)
    transposed_product(products, 6 * k, eta, body.odd.numbers)
    _couple(body)
    first, pull, twist = body.first, ZERO, ZERO
    if body.bends_twice < 0:
        transposed_product(products, 6 * k, deta, body.odd_rates.numbers)
    else:
        lag, pull, twist = _bend(body)
        first = first - lag
    B = body.second + _second_moments(body.shapes, body.even, eta, 2.0)  # int rho r r^T
    Q = _second_moments(
        body.shapes, body.even, deta, 1.0
    )  # symmetric part of int rho r du^T, the other one is turn / 2
    c = first + combination(body.linear, eta)
    dc, turn = combination(body.linear, deta), combination(body.angular, deta)
    J, mass = inertia_of(B), body.mass
    force = mass * a + cross(alpha, c) + cross(w, cross(w, c) + 2.0 * dc) + pull
    coriolis = 2.0 * (Q.trace * w - Q @ w) + cross(w, turn)  # 2 int rho r x (w x du) = 2 (tr Q w - Q^T w)
    moment = cross(c, a) + J @ alpha + cross(w, J @ w) + coriolis + twist
    _modal_forces(body, w, a, alpha)
    p, stiffness = body.p, body.stiffness
    for j in range(k):
        p[j] -= stiffness[j] * eta[j]
    if body.damped >= 0:
        _subtract_product(body.damping, deta, p)
    put_inertia(frame, mass, G @ c, congruent(G, J), G @ force, G @ moment)


@kernel
def _bend(body: ModalBody) -> tuple[Vector, Vector, Vector]:
    """Add the second-order displacement to the coupling of translations; see `mass_moments.add_quadratic_terms`.

    Its second moments are part of `products` already. Returns what the derivative of the first moment counts twice, and
    the forces ``deta^T G deta`` and ``deta^T N deta`` on the translation and rotation of G.
    """
    k, eta, deta, bent, linear = body.k, body.eta, body.deta, body.bent, body.linear.numbers
    flat = bent.reshape(9 * k)
    transposed_product(body.quadratic, 0, eta, flat[: 3 * k])
    transposed_product(body.quadratic, 0, deta, flat[3 * k : 6 * k])
    transposed_product(body.quadratic, 3 * k, deta, body.odd_rates.numbers)
    transposed_product(body.products, 6 * k, deta, flat[6 * k :])
    for i in range(3 * k):
        linear[i] += flat[i]
    return 0.5 * combined(bent, 0, eta), combined(bent, 3, deta), combined(bent, 6, deta)


@inlined
def _subtract_product(A: np.ndarray, x: np.ndarray, p: np.ndarray) -> None:
    for i in range(len(x)):
        p[i] -= total(A[i], x)


@inlined
def set_stiff(body: ModalBody, frame: Frame) -> None:
    """Write inertia and force of a body without modes."""
    put_rigid(frame, body.mass, body.first, inertia_of(body.second), ZERO)


@inlined
def inertia_of(B: Symmetric) -> Symmetric:
    """Return the inertia tr(B) - B of second moments B."""
    return diagonal(B.trace) - B


@vector_kernel
def _couple(body: ModalBody) -> None:
    """Write the inertia between the motion of G and the modes."""
    linear, angular = body.linear, body.angular
    translation, rotation, odd = body.translation, body.rotation, body.odd
    for i in range(len(odd)):
        linear[i] = translation[i]
        angular[i] = rotation[i] + odd[i]


@vector_kernel
def _second_moments(shapes: Values, even: Values, x: np.ndarray, of_shapes: float) -> Symmetric:
    """Return the symmetric part of x times weighted shapes and products: six sums over the modes."""
    found = NO_INERTIA
    for i in range(len(x)):
        found += x[i] * (of_shapes * shapes[i] + even[i])
    return found


@vector_kernel
def _modal_forces(body: ModalBody, w: Vector, a: Vector, alpha: Vector) -> None:
    """Write the inertia forces on the modes with du = 0: centrifugal, Coriolis, and of the acceleration of G."""
    p, shapes, even, odd_rates, linear, angular = (
        body.p,
        body.shapes,
        body.even,
        body.odd_rates,
        body.linear,
        body.angular,
    )
    centrifugal, coriolis = diagonal(dot(w, w)) - square(w, w), 2.0 * w
    for i in range(len(p)):
        p[i] = (
            contract(centrifugal, shapes[i] + even[i])
            - dot(coriolis, odd_rates[i])
            - dot(a, linear[i])
            - dot(alpha, angular[i])
        )
