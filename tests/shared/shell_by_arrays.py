"""Stiffness of shells by arrays, as an oracle for the forms of `kanefe_fem.shells`: dense matrices of one cell each.

Written from the formulas of docs/theory/shells.md, and sharing only shape functions with the product: strains by
matrices at points, assumed strains by least squares there.
"""

from __future__ import annotations

import numpy as np

from kanefe.fe_model.shapes import quadrature, shape


def cross(n):
    """Return matrices that give theta x n."""
    x, y, z = np.moveaxis(n, -1, 0)
    zero = np.zeros_like(x)
    rows = ((zero, z, -y), (-z, zero, x), (y, -x, zero))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


class Points:
    """Strain matrices at points of cells: `B` (m, p, 9, 6 n): membrane 3, bending 3, shear 2, turn 1."""

    def __init__(self, x, director, kind, points, weights, along, thickness, height=None):
        element = shape(kind)
        N, G = element.values(points), element.gradients(points)
        J = np.einsum("pna,mni->mpia", G, x)
        e3 = np.cross(J[..., 0], J[..., 1])
        area = np.linalg.norm(e3, axis=2)
        e3 /= area[..., None]
        e1 = along[:, None] - np.einsum("mi,mpi->mp", along, e3)[..., None] * e3
        e1 /= np.linalg.norm(e1, axis=2, keepdims=True)
        P = np.stack((e1, np.cross(e3, e1)), axis=2)
        self.to_reference = np.linalg.inv(P @ J)
        g = np.einsum("pna,mpab->mpnb", G, self.to_reference)
        self.weights, self.area = weights * area, area
        self.t = thickness @ N.T
        n = np.einsum("pn,mni->mpi", N, director)
        dn = np.einsum("mpnb,mni->mpib", g, director)
        count = N.shape[1]
        slope = np.zeros((*area.shape, 3, 2, count, 6))  # u_i,b
        tip = np.zeros_like(slope)  # b_i,b
        level = np.zeros((*area.shape, 3, count, 6))  # b_i
        for i in range(3):
            slope[:, :, i, :, :, i] = np.swapaxes(g, 2, 3)
        tip[..., 3:] = np.einsum("mpij,mpnb->mpibnj", cross(n), g)
        tip[..., 3:] += np.einsum("mpbij,pn->mpibnj", cross(np.moveaxis(dn, 3, 2)), N)
        level[..., 3:] = np.einsum("mpij,pn->mpinj", cross(n), N)
        z = np.zeros_like(area) if height is None else height * self.t
        lifted = np.swapaxes(P, 2, 3) + z[..., None, None] * dn
        shifter = P @ lifted
        self.stretch, back = np.linalg.det(shifter), np.linalg.inv(shifter)
        raised = slope + z[..., None, None, None, None] * tip
        E = np.einsum("mpia,mpibnk->mpabnk", lifted, raised)
        E = np.einsum("mpac,mpabnk,mpbd->mpcdnk", back, E, back, optimize=True)
        k = np.einsum("mpai,mpibnk->mpabnk", P, tip) + np.einsum("mpia,mpibnk->mpabnk", dn, slope)
        shear = np.einsum("mpi,mpibnk->mpbnk", n, raised) + np.einsum("mpib,mpink->mpbnk", lifted, level)
        shear = np.einsum("mpab,mpank->mpbnk", back, shear)
        turn = 0.5 * (E[:, :, 1, 0] - E[:, :, 0, 1])
        turn[..., 3:] -= np.einsum("mpi,pn->mpni", e3, N)
        rows = [E[:, :, 0, 0], E[:, :, 1, 1], E[:, :, 0, 1] + E[:, :, 1, 0]]
        rows += [k[:, :, 0, 0], k[:, :, 1, 1], k[:, :, 0, 1] + k[:, :, 1, 0], shear[:, :, 0], shear[:, :, 1], turn]
        self.B = np.stack(rows, axis=2).reshape(*area.shape, 9, 6 * count)
        self.dn, self.J = dn, J
        self.second = np.einsum("mpia,mpib->mpab", J, np.einsum("pna,mni->mpia", G, director))


def energy(at, rows, modulus, power, share=1.0):
    """Return int t^power B^T modulus B of some rows, shape (m, 6 n, 6 n)."""
    B = at.B[:, :, rows]
    return np.einsum("mp,mpsd,st,mpte->mde", share * at.weights * at.t**power, B, modulus, B, optimize=True)


def stiffness(x, director, thickness, along, section, limits):
    """Return K (m, 54, 54) of quadrangles of nine nodes.

    Corners x and directors (m, 9, 3), thickness (m, 9), first axis (m, 3); `limits` of membrane, shear and turn.
    """

    def at_points(degree, height=None):
        return Points(x, director, "quad9", *quadrature("quad9", degree), along, thickness, height)

    at, at_few = at_points(5), at_points(3)
    area, typical = at.weights.sum(axis=1), thickness.mean(axis=1)
    rise = np.sqrt(np.einsum("mp,mpab->m", at.weights, at.second**2) / area)
    m = 1.0 / (1.0 + (rise / typical) ** 2 / limits["membrane"])[:, None]
    s, d = (np.minimum(1.0, limits[name] * typical**2 / area)[:, None] for name in ("shear", "turn"))
    A, B, D = (section.stiffness(power) for power in range(3))
    S, G = section.shear, np.array([[A[2, 2]]])
    e, k, g, w = slice(0, 3), slice(3, 6), slice(6, 8), slice(8, 9)
    K = energy(at, k, D, 3) + energy(at, g, S, 1, s) + energy(at, w, G, 1, d) + membrane(at, A, B, m)
    K += energy(at_few, g, S, 1, 1.0 - s) + energy(at_few, w, G, 1, 1.0 - d)
    _assume(at, e)
    if np.abs(B).max() > 0.0:
        _assume(at, k)
    K += membrane(at, A, B, 1.0 - m)
    for layer in section.layers:
        half = (layer.top - layer.bottom) / 2.0
        for end in (-1.0, 1.0):
            z = layer.bottom + half * (1.0 + end / np.sqrt(3.0))
            lifted, low = at_points(3, z), at_points(3)
            low.B[:, :, e] += (z * low.t)[..., None, None] * low.B[:, :, k]
            for rows, modulus in ((e, layer.plane), (g, section.shear_scale * layer.shear)):
                K += energy(lifted, rows, modulus, 1, half * lifted.stretch) - energy(low, rows, modulus, 1, half)
    return K


def membrane(at, A, B, share):
    """Return the energy of the membrane and of its coupling with bending."""
    K = energy(at, slice(0, 3), A, 1, share)
    half = np.einsum(
        "mp,mpsd,st,mpte->mde", share * at.weights * at.t**2, at.B[:, :, :3], B, at.B[:, :, 3:6], optimize=True
    )
    return K + half + np.swapaxes(half, 1, 2)


def _assume(at, rows):
    """Replace strains by their projections on bilinear and linear functions, along the edges of the cell."""
    points, weights = quadrature("quad9", 5)
    forward = np.linalg.inv(at.to_reference)
    along = np.einsum("mpst,mptd->mpsd", _change(forward), at.B[:, :, rows])
    x, y = points.T
    bilinear = np.stack((np.ones_like(x), x, y, x * y), axis=1)
    root = np.sqrt(weights)[:, None]
    for row, functions in enumerate((bilinear, bilinear, bilinear[:, :3])):
        fit = functions @ np.linalg.pinv(root * functions) * root.T
        along[:, :, row] = np.einsum("pq,mqd->mpd", fit, along[:, :, row])
    at.B[:, :, rows] = np.einsum("mpst,mptd->mpsd", _change(at.to_reference), along)


def _change(F):
    """Return the change of strains 11, 22, twice 12 to other axes, ``F^T e F``."""
    a, b, c, d = (F[..., i, j] for i in range(2) for j in range(2))
    rows = ((a * a, c * c, a * c), (b * b, d * d, b * d), (2 * a * b, 2 * c * d, a * d + b * c))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
