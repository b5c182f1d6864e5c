"""Mass of beams: a cloud of points that move with the sections.

The inertia comes from the displacement field, not from nodal accelerations, which are wrong in space for elements with
rotations: the angular acceleration of a slope is not the body's alpha. The field is a cloud of points that only
translate: four Gauss stations along each element (exact to degree 7; the integrand N^T N has degree 6), and at each
station points in the section with its exact second moments,

    (+-a, 0), (0, +-b) in local (y, z), a quarter of the mass each, a = sqrt(2 I_z / A), b = sqrt(2 I_y / A)

so that mass, first moments, inertia and rotary inertia of the sections are exact. For a section given by its mass they
are about its centre of mass, along the principal directions of its second moments.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.model import MassField
from kanefe_fem.beams import elements as be
from kanefe_fem.beams.beam_section import LineMass
from kanefe_fem.beams.properties import ElementProperties

AXIAL_STATIONS = 4


def mass_field(
    points: np.ndarray,
    table: np.ndarray,
    masses: Sequence[LineMass],
    properties: ElementProperties,
    axes: np.ndarray,
    dofs: np.ndarray,
    planar: bool,
    rotary_inertia: bool,
) -> MassField:
    """Return the cloud of translating points with the exact mass of a frame (see the top of this module).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Nodes in G in m.
    table : ndarray of int, shape (m, 2)
        Nodes of the elements.
    masses : sequence of m
        Masses of the sections.
    properties, axes, dofs
        Stiffnesses, A_GL and degrees of freedom of the elements.
    planar, rotary_inertia : bool
        As in `kanefe_fem.beams.body.beam_model`.
    """
    rho_A = np.array([mass.rho_A for mass in masses])
    offsets = section_points(masses, planar, rotary_inertia)
    stations, weights = be.gauss_stations(AXIAL_STATIONS)
    m, g, s = len(table), len(stations), offsets.shape[1]

    # u_p = u_c + theta x offset = L_p (u_c, theta), all in L
    lever = np.zeros((m, s, 3, 6))
    lever[..., [0, 1, 2], [0, 1, 2]] = 1.0
    lever[..., 1, 3], lever[..., 2, 3] = -offsets[..., 2], offsets[..., 1]
    if rotary_inertia:
        lever[..., 0, 4], lever[..., 0, 5] = offsets[..., 2], -offsets[..., 1]
    of_sections = be.interpolation(properties, stations)
    size = len(points) * (dofs.shape[1] // 2)
    N = _matrix_of_points(np.einsum("mpij,mgjk->mgpik", lever, of_sections), axes, dofs, size, planar)
    turn_L = np.repeat(of_sections[:, :, None, 3:], s, axis=2)
    if not rotary_inertia:
        turn_L[..., 1:, :] = 0.0  # the points do not follow bending rotations
    turns = _matrix_of_points(turn_L, axes, dofs, size, False)

    start, end = points[table[:, 0]], points[table[:, 1]]
    on_axis = start[:, None] + stations[None, :, None] * (end - start)[:, None]
    arms = np.repeat(np.einsum("mab,mpb->mpa", axes, offsets)[:, None], g, axis=1)
    shares = (rho_A * properties.length)[:, None] * weights
    shares = np.repeat(shares[:, :, None] / s, s, axis=2)
    return MassField(
        points=(on_axis[:, :, None] + arms).reshape(-1, 3),
        mass=sp.diags(shares.ravel(), format="csr"),
        interpolation=N,
        turns=turns,
        arms=arms.reshape(-1, 3),
    )


def _matrix_of_points(N_L: np.ndarray, axes: np.ndarray, dofs: np.ndarray, size: int, in_plane: bool) -> sp.csr_matrix:
    """Return the matrix of vectors at points in G, from (m, stations, points, 3) vectors in L over 12 element dofs."""
    N_G = np.einsum("mab,mgpbk,mkl->mgpal", axes, N_L, be.spatial_transformation(axes), optimize=True)
    if dofs.shape[1] == len(be.PLANAR_DOFS):
        N_G = N_G[..., be.PLANAR_DOFS]
    if in_plane:
        N_G[..., 2, :] = 0.0
    count = N_G.size // dofs.shape[1]
    columns = np.broadcast_to(dofs[:, None, None, None, :], N_G.shape).ravel()
    rows = np.repeat(np.arange(count), dofs.shape[1])
    N = sp.coo_matrix((N_G.ravel(), (rows, columns)), shape=(count, size)).tocsr()
    N.eliminate_zeros()
    return N


def section_points(masses: Sequence[LineMass], planar: bool, rotary_inertia: bool) -> np.ndarray:
    """Return the section's points of equal mass in L, shape (m, points, 3)."""
    rho_A, centre, second = (np.array(values) for values in zip(*masses, strict=True))
    if centre.any() and not rotary_inertia:
        raise ModelError("a section whose mass is off the axis turns with it. Remedy: rotary_inertia=True")
    if planar and centre[:, 1].any():
        raise ModelError("a section of a planar beam has its mass out of the plane. Remedy: centre_of_mass=(y, 0)")
    if planar and not rotary_inertia:
        return np.zeros((len(rho_A), 1, 3))
    offsets = np.zeros((len(rho_A), 2 if planar else 4, 3))
    offsets[:, :, 1:] = centre[:, None]
    if planar:
        offsets[:, :, 1] += np.sqrt(second[:, 0, 0] / rho_A)[:, None] * (1.0, -1.0)
        return offsets
    squares, directions = np.diagonal(second, axis1=1, axis2=2).copy(), np.tile(np.eye(2), (len(rho_A), 1, 1))
    oblique = np.flatnonzero(second[:, 0, 1])
    if oblique.size:
        squares[oblique], directions[oblique] = np.linalg.eigh(second[oblique])
    arms = np.sqrt(2.0 * np.maximum(squares, 0.0) / rho_A[:, None])[:, None] * directions  # as columns
    offsets[:, :, 1:] += np.stack([arms[..., 0], -arms[..., 0], arms[..., 1], -arms[..., 1]], axis=1)
    return offsets
