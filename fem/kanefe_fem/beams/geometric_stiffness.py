"""Geometric stiffness of beam elements, exact to second order for sections that stay rigid.

With the displacement u of the axis and the rotation vector theta of the section, the strains of a beam are (Reissner
1973; Simo 1985) ``Gamma = R^T (e_x + u') - e_x`` and ``kappa = axial(R^T R')``, ``R = exp(theta)``. Their parts of
second order,

    Gamma_2 = -theta x u' + 1/2 theta x (theta x e_x),        kappa_2 = -1/2 theta x theta'

do the work ``1/2 q^T K_g q`` with the forces n = (N, V_y, V_z) and moments m = (T, M_y, M_z) of a static state. All of
them are included: in a frame or a chain that bends in space V, M and T contribute to the stiffness like N, and the
rotations at the nodes are rotation vectors, so that the energy of a rigid rotation is correct. Torsion adds
``1/2 N (I_y + I_z)/A theta_x'^2``: the fibres of a twisted bar are helices, longer than its axis (Wagner).

Inside an element n and m follow from statics: the end forces ``K_e q`` minus the share of the load at the nodes, and
the load along the element, ``n' + p = 0`` and ``m' + e_x x n + mu = 0``. So V is included for Euler-Bernoulli too,
where it is a reaction, and the energy of a rigid rotation is exact: the work of n, m and the load on any motion that
vanishes at the nodes is zero. Without the load along the element, n would be constant and m linear, with an error of
second order in the length of an element.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from kanefe.frames import skews
from kanefe_fem.beams import elements as be
from kanefe_fem.beams.mass import AXIAL_STATIONS as STATIONS
from kanefe_fem.beams.properties import ElementProperties


@dataclass(frozen=True, eq=False)
class BeamStressStiffness:
    """The geometric stiffness of the stress of a static state, as a function of this state.

    Attributes
    ----------
    properties : ElementProperties
        m elements.
    polar_radius : ndarray, shape (m,)
        ``sqrt((I_y + I_z) / A)`` of the sections, m.
    axes : ndarray, shape (m, 3, 3)
        A_GL.
    dofs : ndarray of int, shape (m, 12), or (m, 6) if planar
    size : int
        N.
    arms : ndarray, shape (m, stations, points, 3)
        Positions of the points of the mass field in their sections, in G in m: the first ones of the field.
    rotary_inertia : bool
        Whether these points follow the bending rotation of their section.
    """

    properties: ElementProperties
    polar_radius: np.ndarray
    axes: np.ndarray
    dofs: np.ndarray
    size: int
    arms: np.ndarray
    rotary_inertia: bool

    def __call__(self, displacement: np.ndarray, load: np.ndarray | None = None) -> sp.csr_matrix:
        """Return K_g, shape (N, N), of a static displacement (N,) under forces (3 P,) on the points of the field."""
        transformation = be.spatial_transformation(self.axes)
        stiffness = be.rotate_element_matrix(be.spatial_stiffness(self.properties), transformation)
        width = self.dofs.shape[1]
        kept = list(range(12)) if width == 12 else be.PLANAR_DOFS
        q = np.asarray(displacement)[self.dofs]
        ends = np.einsum("mab,mbc,mc->ma", transformation, stiffness[:, :, kept], q, optimize=True)
        force, moment = self._along(load)
        matrix = element_geometric_stiffness(self.properties, self.polar_radius, ends, force, moment)
        values = be.rotate_element_matrix(matrix, transformation)[:, kept][:, :, kept].ravel()
        rows, columns = np.repeat(self.dofs, width, axis=1).ravel(), np.tile(self.dofs, width).ravel()
        return sp.coo_matrix((values, (rows, columns)), shape=(self.size, self.size)).tocsr()

    def _along(self, load: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """Return force and moment at the stations of the elements in L, each (m, stations, 3)."""
        if load is None:
            nothing = np.zeros((*self.arms.shape[:2], 3))
            return nothing, nothing
        forces = np.asarray(load)[: self.arms.size].reshape(self.arms.shape)
        force = np.einsum("mba,mgb->mga", self.axes, forces.sum(axis=2))
        moment = np.einsum("mba,mgb->mga", self.axes, np.cross(self.arms, forces).sum(axis=2))
        if not self.rotary_inertia:
            moment[..., 1:] = 0.0
        if self.dofs.shape[1] < 12:
            force[..., 2] = moment[..., 0] = moment[..., 1] = 0.0
        return force, moment


def element_geometric_stiffness(
    properties: ElementProperties,
    polar_radius: np.ndarray,
    end_forces: np.ndarray,
    force: np.ndarray,
    moment: np.ndarray,
) -> np.ndarray:
    """Return the geometric stiffness of elements in L, shape (m, 12, 12).

    Parameters
    ----------
    properties : ElementProperties
        m elements of either theory.
    polar_radius : ndarray, shape (m,)
        ``sqrt((I_y + I_z) / A)``, m.
    end_forces : ndarray, shape (m, 12)
        ``K_e q`` in L: forces and moments on both nodes, with the share of the load at the nodes.
    force, moment : ndarray, shape (m, STATIONS, 3)
        Load in N and N m at the Gauss stations of each element, in L.

    Examples
    --------
    The bending terms of a bar under tension N = 1 are 6/5 N/l and l N/10 (Przemieniecki 1968):

    >>> one = np.ones(1)
    >>> bar = ElementProperties(one, one, one, one, one, np.full(1, np.inf), np.full(1, np.inf))
    >>> tension = np.array([[-1.0, *5 * [0.0], 1.0, *5 * [0.0]]])
    >>> nothing = np.zeros((1, STATIONS, 3))
    >>> K = element_geometric_stiffness(bar, 0.0 * one, tension, nothing, nothing)[0]
    >>> bool(np.allclose(K[1, [1, 5, 7, 11]], [1.2, 0.1, -1.2, 0.1]))
    True
    """
    stations, weights = be.gauss_stations(STATIONS)  # exact: under a linear load the integrand has degree 6
    length = properties.length[:, None, None, None]
    polynomials = be.interpolation_polynomials(properties)
    powers = np.vander(stations, 4, increasing=True)
    slopes = np.column_stack([np.zeros_like(stations), powers[:, :3] * [1.0, 2.0, 3.0]])
    N = np.einsum("mijk,gk->mgij", polynomials, powers)
    dN = np.einsum("mijk,gk->mgij", polynomials, slopes) / length
    stretch, turn, turn_rate = dN[:, :, :3], N[:, :, 3:], dN[:, :, 3:]

    shared = np.einsum("mgij,mgi->mj", N, np.concatenate((force, moment), axis=2))
    n, m = _section_forces(properties.length, end_forces - shared, force, moment)
    e_x = np.array((1.0, 0.0, 0.0))
    along = 0.5 * (n[..., :, None] * e_x + e_x[:, None] * n[..., None, :]) - n[..., :1, None] * np.eye(3)
    # -n . (theta x u') = theta . n~ u', and so on
    coupling = np.einsum("mgia,mgij,mgjb->mgab", turn, skews(n), stretch, optimize=True)
    coupling += 0.5 * np.einsum("mgia,mgij,mgjb->mgab", turn, skews(m), turn_rate, optimize=True)
    density = coupling + coupling.transpose(0, 1, 3, 2)
    density += np.einsum("mgia,mgij,mgjb->mgab", turn, along, turn, optimize=True)
    helix = n[..., 0] * polar_radius[:, None] ** 2
    density += helix[..., None, None] * turn_rate[:, :, 0, :, None] * turn_rate[:, :, 0, None, :]
    return np.einsum("m,g,mgab->mab", properties.length, weights, density)


def _section_forces(
    length: np.ndarray, ends: np.ndarray, force: np.ndarray, moment: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return n and m at the stations, (m, STATIONS, 3), from the true end forces and the load between them."""
    stations, weights = be.gauss_stations(STATIONS)
    # integral from each station to the end of the polynomial through the values at all of them
    powers = np.vander(stations, increasing=True)
    exponents = np.arange(1, STATIONS + 1)
    remaining = ((1.0 - stations[:, None] ** exponents) / exponents) @ np.linalg.inv(powers)
    n = ends[:, None, 6:9] + np.einsum("gh,mhi->mgi", remaining, force / weights[:, None])
    lever = np.cross((1.0, 0.0, 0.0), n) * length[:, None, None]
    m = ends[:, None, 9:] + np.einsum("gh,mhi->mgi", remaining, lever + moment / weights[:, None])
    return n, m
