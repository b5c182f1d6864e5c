"""Conversion of mass moments to the inertia terms of Standard Input Data, and back.

With ``r = X + Phi q`` the standard's expansions are (Wallrapp 1994; Schwertassek & Wallrapp 1999, table 6.9)

    mdCM = int r,   J = -int r~ r~,   Ct = int Phi^T,   Cr = (int r~ Phi)^T,   Me = int Phi^T Phi      (all times rho)
    Gr_l = -2 int r~ Phi_l~,   Ge_l = -2 int Phi^T Phi_l~,   Oe Omega = int Phi^T w~ w~ r

with ``Omega = (wx^2, wy^2, wz^2, wx wy, wy wz, wx wz)``. Their parts of order 0 and 1 in q are linear in the moments
m, int X, B, S, D and M of `MassMoments` and determine all of them. Motion-induced stiffening, the second-order
displacement ``1/2 q^T H q``, adds its moments G = int rho H and N_ab = int rho X_a H_b to Ct, Cr and Oe of order 1.
"""

from __future__ import annotations

import warnings

import numpy as np

from kanefe.bodies.mass_moments import MassMoments
from kanefe.errors import ModelError, outside
from kanefe.imports.sid_file import SYMMETRIC, SidWarning, Taylor

PAIRS = ((0, 1), (1, 2), (0, 2))
"""Products in the last three columns of Oe: xy, yz, xz."""

AGREEMENT = 1e-4
"""Relative difference below which two equivalent terms of a file agree: files have six digits."""


def terms_of_moments(moments: MassMoments) -> dict[str, Taylor]:
    """Return mdCM, J, Ct, Cr, Me, Gr, Ge and Oe; the parts of order 1 include stiffening."""
    S, D, M = moments.shape_first, moments.shape_second, moments.shape_product
    count = S.shape[1]
    Me = moments.elastic_mass
    trace = np.einsum("aai->i", D)
    G = moments.quadratic_first if moments.quadratic_first is not None else np.zeros((3, count, count))
    N = moments.quadratic_second if moments.quadratic_second is not None else np.zeros((3, 3, count, count))
    first_order_J = 2.0 * np.eye(3)[:, :, None] * trace - D - D.transpose(1, 0, 2)
    Gr0 = -2.0 * (D.transpose(1, 0, 2) - np.eye(3)[:, :, None] * trace)  # row, column, mode l
    Gr1 = -2.0 * (M - np.eye(3)[:, :, None, None] * Me)  # row, column, mode l of q', mode j of q
    turning = _axial_parts(M.transpose(0, 1, 3, 2))  # (axis, k, l): int (Phi_l x Phi_k)
    Cr1 = turning + _axial_parts(N)
    return {
        "mdCM": Taylor(moments.first[:, None], S[:, None, :]),
        "J": Taylor(np.trace(moments.second) * np.eye(3) - moments.second, first_order_J, SYMMETRIC),
        "Ct": Taylor(S.T, G.transpose(1, 0, 2) if np.any(G) else None),
        "Cr": Taylor(_axial_parts(D).T, Cr1.transpose(1, 0, 2)),
        "Me": Taylor(Me, None, SYMMETRIC),
        "Gr": Taylor(_side_by_side(Gr0), np.stack([_side_by_side(Gr1[..., j]) for j in range(count)], axis=2)),
        "Ge": Taylor(2.0 * turning.transpose(1, 2, 0).reshape(count, 3 * count)),
        "Oe": Taylor(_centrifugal(D).T, _centrifugal(M + N).transpose(1, 0, 2)),
    }


def moments_of_terms(terms: dict[str, Taylor], mass: float) -> MassMoments:
    """Return the mass moments that the terms of a file determine.

    Raises
    ------
    ModelError
        If shapes are wrong or two terms that must agree do not.

    Warns
    -----
    SidWarning
        If Oe includes stiffening and there is no Gr of order 1 to separate it from inertia.
    """
    count = terms["Me"].m0.shape[0]
    terms = terms | {"J": _as_matrix(terms["J"])}
    _check_shapes(terms, count)
    Me, S = terms["Me"].m0, terms["Ct"].m0.T
    first, J = terms["mdCM"].m0[:, 0], terms["J"].m0
    _agree(terms["mdCM"].m1, S[:, None, :], "mdCM of order 1", "Ct of order 0")
    D, pairs = _shape_second(terms)
    M, centrifugal = _shape_product(terms, pairs)
    turning = _axial_parts(M.transpose(0, 1, 3, 2))
    rest_Cr = _first_order(terms["Cr"], count).transpose(1, 0, 2) - turning if terms["Cr"].m1 is not None else None
    rest_Oe = centrifugal - _centrifugal(M) if centrifugal is not None else None
    G = _first_order(terms["Ct"], count).transpose(1, 0, 2)
    length = float(np.sqrt(np.trace(J) / mass)) or 1.0
    noise = AGREEMENT * max(abs(Me).max(), np.finfo(float).tiny)
    parts = [G * length, *(r for r in (rest_Cr, rest_Oe) if r is not None)]
    moments = MassMoments(np.asarray(mass), first, 0.5 * np.trace(J) * np.eye(3) - J, S, D, M)
    if max(abs(part).max() for part in parts) <= noise:
        return moments
    N = np.zeros((3, 3, count, count))
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        half = np.zeros((count, count)) if rest_Cr is None else 0.5 * rest_Cr[a]
        N[b, c], N[c, b] = half, -half
    if rest_Oe is not None:
        N += _of_centrifugal(rest_Oe)
    symmetric = [0.5 * (x + np.swapaxes(x, -1, -2)) for x in (G, N)]
    return MassMoments(moments.mass, first, moments.second, S, D, M, *symmetric)


def _check_shapes(terms: dict[str, Taylor], count: int) -> None:
    """Raise a ModelError if a term does not have the shape of so many modes."""
    shapes = {
        "mdCM": (3, 1),
        "J": (3, 3),
        "Ct": (count, 3),
        "Cr": (count, 3),
        "Me": (count, count),
        "Gr": (3, 3 * count),
        "Ge": (count, 3 * count),
        "Oe": (count, 6),
    }
    for name, shape in shapes.items():
        if terms[name].m0.shape != shape:
            raise ModelError(
                f"{name} of the SID has shape {terms[name].m0.shape}, {count} modes need {shape}. Remedy: export the "
                "whole modal block again"
            )


def _axial_parts(A: np.ndarray) -> np.ndarray:
    """Return (A_yz - A_zy, A_zx - A_xz, A_xy - A_yx)."""
    return np.array([A[1, 2] - A[2, 1], A[2, 0] - A[0, 2], A[0, 1] - A[1, 0]])


def _centrifugal(A: np.ndarray) -> np.ndarray:
    """Return the factors of wx^2, wy^2, wz^2, wx wy, wy wz, wx wz in ``(w~ w~)_ba A_ab``."""
    diagonal = [A[a, a] for a in range(3)]
    squares = [diagonal[a] - diagonal[0] - diagonal[1] - diagonal[2] for a in range(3)]
    return np.array(squares + [A[a, b] + A[b, a] for a, b in PAIRS])


def _of_centrifugal(O: np.ndarray) -> np.ndarray:  # noqa: E741 - the name in the standard
    """Return the symmetric A_ab of `_centrifugal`, shape (3, 3, ...)."""
    A = np.zeros((3, 3, *O.shape[1:]))
    for a in range(3):
        A[a, a] = O[a] - 0.5 * (O[0] + O[1] + O[2])
    for column, (a, b) in enumerate(PAIRS):
        A[a, b] = A[b, a] = 0.5 * O[3 + column]
    return A


def _side_by_side(A: np.ndarray) -> np.ndarray:
    """Return the 3 x 3 matrices A[:, :, l] beside each other, (3, 3 k)."""
    return A.transpose(0, 2, 1).reshape(3, -1)


def _first_order(term: Taylor, count: int) -> np.ndarray:
    return np.zeros((*term.m0.shape, count)) if term.m1 is None else term.m1


def _agree(found: np.ndarray | None, expected: np.ndarray, what: str, other: str) -> None:
    if found is None:
        return
    scale = max(abs(found).max(initial=0.0), abs(expected).max(initial=0.0))
    if abs(found - expected).max(initial=0.0) > AGREEMENT * scale:
        raise ModelError(
            f"{what} and {other} of the SID contradict each other by {abs(found - expected).max() / scale:.2g} of "
            "their largest entry. Remedy: check the program that wrote it, and that all terms are about the same frame"
        )


def _as_matrix(J: Taylor) -> Taylor:
    """Return the moments of inertia as a matrix, where a writer has them as six numbers: xx, yy, zz, xy, xz, yz."""
    if J.m0.shape != (6, 1):
        return J
    entry_of = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])
    return Taylor(J.m0[entry_of, 0], None if J.m1 is None else J.m1[entry_of, 0], SYMMETRIC)


def _shape_second(terms: dict[str, Taylor]) -> tuple[np.ndarray, list[int]]:
    """Return D, and the columns in which Oe has xy, yz and xz: some writers list xy, xz, yz."""
    count = terms["Me"].m0.shape[0]
    Cr, Oe = terms["Cr"].m0.T, terms["Oe"].m0.T
    J1 = terms["J"].m1
    pairs = [3, 4, 5]
    if J1 is None:
        symmetric = _of_centrifugal(Oe)
    else:
        both = 0.5 * np.einsum("aai->i", J1) * np.eye(3)[:, :, None] - J1
        symmetric = 0.25 * (both + both.transpose(1, 0, 2))
        expected = _centrifugal(symmetric)
        swapped = [3, 5, 4]
        if abs(Oe[swapped] - expected[3:]).max(initial=0.0) < abs(Oe[pairs] - expected[3:]).max(initial=0.0):
            pairs = swapped
        _agree(Oe[[0, 1, 2, *pairs]], expected, "Oe of order 0", "J of order 1")
    D = symmetric.copy()
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        D[b, c] += 0.5 * Cr[a]
        D[c, b] -= 0.5 * Cr[a]
    Gr = terms["Gr"].m0
    if np.any(Gr):
        trace = np.einsum("aai->i", D)
        expected_Gr = _side_by_side(-2.0 * (D.transpose(1, 0, 2) - np.eye(3)[:, :, None] * trace))
        _agree(Gr, expected_Gr, "Gr of order 0", "J and Cr")
    return D.reshape(3, 3, count), pairs


def _shape_product(terms: dict[str, Taylor], pairs: list[int]) -> tuple[np.ndarray, np.ndarray | None]:
    """Return M, and Oe of order 1 as (6, k, k) with its columns in order."""
    Me, Ge = terms["Me"].m0, terms["Ge"].m0
    count = len(Me)
    turning = 0.5 * Ge.reshape(count, count, 3).transpose(2, 0, 1)  # (axis, k, l)
    Oe1 = terms["Oe"].m1
    centrifugal = None if Oe1 is None else Oe1.transpose(1, 0, 2)[[0, 1, 2, *pairs]]
    Gr1 = terms["Gr"].m1
    if Gr1 is not None and np.any(Gr1):
        blocks = Gr1.reshape(3, count, 3, count).transpose(0, 2, 1, 3)
        M = np.eye(3)[:, :, None, None] * Me - 0.5 * blocks
        _agree(turning, _axial_parts(M.transpose(0, 1, 3, 2)), "Ge", "Gr of order 1")
        return M, centrifugal
    noise = AGREEMENT * abs(Me).max(initial=0.0)
    if centrifugal is not None:
        M = _of_centrifugal(centrifugal)
        unstiffened = abs(np.einsum("aaij->ij", M) - Me).max(initial=0.0) <= noise
    if centrifugal is None or not unstiffened:
        warnings.warn(
            "the SID does not give the distribution of the modal mass over the directions ("
            + ("Oe has no order 1" if centrifugal is None else "Oe is stiffened")
            + ", and Gr has no order 1): terms of second order in J and Gr are approximate, those of first order exact",
            SidWarning,
            stacklevel=outside(),
        )
        M = np.eye(3)[:, :, None, None] * Me / 3.0
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        M[b, c] = 0.5 * (M[b, c] + M[b, c].T) - 0.5 * turning[a]
        M[c, b] = M[b, c].T
    return M, centrifugal
