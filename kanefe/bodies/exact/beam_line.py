"""A beam as strain fields: their functions at the stations of the quadrature, and the motion of sections from them.

The frame of a section at the arc length s has the axes A(s) and the place p(s) in G, with

    A' = A kappa~,    p' = A t,    kappa = kappa_0 + B q,    t = e_x + B q

(Simo 1985; the parametrisation by strains is that of Boyer et al., IEEE Trans. Robotics 37 (2021), and Renda et al.,
IEEE RA-L 5 (2020)). The coordinates q are those of the strains alone: a beam that moves as a rigid body has none.

A beam is divided into cells, between whose ends everything is smooth, with Gauss points in each. From station to
station the axes turn by ``exp(omega~)``, omega from a Magnus expansion of sixth order (Blanes, Casas, Oteo & Ros 2009,
eq. 258, for a product from the right); places are integrals of ``A t`` by the Gauss points. Velocities and
accelerations are the derivatives of this map, not approximations of their own, so that energy is kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.bodies.slopes import SLOPE_MEASURES
from kanefe.frames import Matrix, Vector, cross, skew
from kanefe.storage.pickled import PickledByFields

MAGNUS_POINTS = 0.5 + np.sqrt(15.0) / 10.0 * np.array((-1.0, 0.0, 1.0))
"""Places between two stations, over their distance, where the Magnus expansion takes the curvature (Gauss, order 6)."""


ALONG = np.array((1.0, 0.0, 0.0))
"""Direction of the axis in the axes of an undeformed section."""


@dataclass(frozen=True, eq=False)
class BeamLine(PickledByFields):
    """Strain fields of a beam of C cells, with P Gauss points in each, in k coordinates.

    Attributes
    ----------
    place, axes : ndarray, shapes (3,), (3, 3)
        Root section in G: place (m) and axes, x along the beam.
    strain_of : ndarray of int, shape (k,)
        In rising order: which strain a coordinate is of, 0 to 5: stretch, shear along y and z, twist (1/m), curvature about y and z.
    lengths : ndarray, shape (C,)
        Of the cells, m.
    points, weights : ndarray, shape (P,)
        Gauss points and weights of the unit interval.
    turn_rest : ndarray, shape (C, P + 1, 3, 3)
        The three vectors of the Magnus expansion of each step from station to station at q = 0.
    turn_values : ndarray, shape (C, P + 1, 3, k)
        How a coordinate of twist or curvature changes its component, `strain_of` - 3, of each of them.
    values : ndarray, shape (C, P, k)
        Functions at the Gauss points.
    masses : ndarray, shape (C, P)
        Mass of the Gauss points, kg.
    centres : ndarray, shape (C, P, 3)
        Their centres of mass in axes of the section, m.
    inertias : ndarray, shape (C, P, 3, 3)
        About these centres, in axes of the section, kg m2.
    """

    place: np.ndarray
    axes: np.ndarray
    strain_of: np.ndarray
    lengths: np.ndarray
    points: np.ndarray
    weights: np.ndarray
    turn_rest: np.ndarray
    turn_values: np.ndarray
    values: np.ndarray
    masses: np.ndarray
    centres: np.ndarray
    inertias: np.ndarray

    @property
    def count(self) -> int:
        """Number k of coordinates."""
        return len(self.strain_of)

    @property
    def integration(self) -> Matrix:
        """Integrals up to the Gauss points and, in the last row, over the whole unit interval, (P + 1, P)."""
        return integration_matrix(self.points, self.weights)

    @property
    def node_count(self) -> int:
        """Number of stations: the root, and of each cell the Gauss points and the end."""
        return 1 + len(self.lengths) * (len(self.points) + 1)

    @property
    def gauss_nodes(self) -> np.ndarray:
        """Which stations are Gauss points, (C, P)."""
        P = len(self.points)
        return 1 + (P + 1) * np.arange(len(self.lengths))[:, None] + np.arange(P)

    def end_node(self, cell: int) -> int:
        """Return which station is the end of a cell; -1: the root."""
        return (cell + 1) * (len(self.points) + 1)

    def motion(self, eta: Vector, deta: Vector) -> SectionMotions:
        """Return the motion of all stations seen from G (Eq. 22, 24-26 for sections that turn far)."""
        C, P, k = len(self.lengths), len(self.points), self.count
        found = SectionMotions.room(self.node_count, k)
        found.A[0], found.p[0] = self.axes, self.place
        along, about = self.strain_of < 3, self.strain_of >= 3
        Q = self.integration
        node = 0
        for c in range(C):
            start = node
            slopes = np.zeros((P, 3)), np.zeros((P, 3)), np.zeros((P, 3)), np.zeros((P, 3, k))
            for g in range(P + 1):
                self._turn(found, node, c, g, about, eta, deta)
                node += 1
                if g == P:
                    break
                A, w, y = found.A[node], found.w[node], found.y[node]
                columns = np.zeros((3, k))
                columns[self.strain_of[along], np.flatnonzero(along)] = self.values[c, g, along]
                t = A @ (ALONG + columns @ eta)
                stretch = A @ (columns @ deta)
                slopes[0][g] = t
                slopes[1][g] = cross(w, t) + stretch
                slopes[2][g] = cross(y, t) + cross(w, cross(w, t) + 2.0 * stretch)
                slopes[3][g] = A @ columns - skew(t) @ found.W[node]
            h, stations = self.lengths[c], slice(start + 1, start + P + 2)
            for of, integrand in zip((found.p, found.v, found.z, found.V), slopes, strict=True):
                of[stations] = of[start] + h * np.tensordot(Q, integrand, axes=1)
        return found

    def _turn(
        self, found: SectionMotions, node: int, c: int, g: int, about: np.ndarray, eta: Vector, deta: Vector
    ) -> None:
        """Write the axes of the next station, and how they turn."""
        k, measure = self.count, SLOPE_MEASURES["rotation-vector"]
        columns = np.zeros((3, 3, k))
        for m in range(3):
            columns[m, self.strain_of[about] - 3, np.flatnonzero(about)] = self.turn_values[c, g, m, about]
        omega, domega, ddomega, D = turn_of_step(self.turn_rest[c, g] + columns @ eta, columns @ deta)
        A, w = found.A[node], found.w[node]
        T = measure.tangent(omega)
        spin = A @ (T @ domega)
        found.A[node + 1] = A @ measure.rotation(omega)
        found.W[node + 1] = found.W[node] + A @ T @ np.einsum("mab,mbk->ak", D, columns)
        found.w[node + 1] = w + spin
        found.y[node + 1] = found.y[node] + cross(w, spin) + A @ (T @ ddomega + measure.remainder(omega, domega))


@dataclass(slots=True)
class SectionMotions:
    """Motion of n sections seen from G, in components of G.

    Attributes
    ----------
    A, p : ndarray, shapes (n, 3, 3), (n, 3)
        Axes and places, m.
    v, w : ndarray, shape (n, 3)
        Velocities (m/s) and angular velocities.
    V, W : ndarray, shape (n, 3, k)
        Their derivatives by the rates of the coordinates.
    z, y : ndarray, shape (n, 3)
        Accelerations while the coordinates have none.
    """

    A: np.ndarray
    p: np.ndarray
    v: np.ndarray
    w: np.ndarray
    V: np.ndarray
    W: np.ndarray
    z: np.ndarray
    y: np.ndarray

    @classmethod
    def room(cls, n: int, k: int) -> SectionMotions:
        """Return the motion of n sections, all zero."""
        return cls(np.zeros((n, 3, 3)), *(np.zeros((n, *shape)) for shape in ((3,), (3,), (3,), (3, k), (3, k), (3,), (3,))))


def turn_of_step(a: Matrix, da: Matrix) -> tuple[Vector, Vector, Vector, Matrix]:
    """Return the rotation vector omega of a step, its two rates, and its derivatives by the vectors a, (3, 3, 3).

    Parameters
    ----------
    a, da : ndarray, shape (3, 3)
        Curvature times length, and its first and second differences, as rows; and their rates, which are constant.
    """
    a1, a2, a3 = a
    d1, d2, d3 = da
    # brackets of a product from the right: [x, y] = y x x
    c1 = cross(a2, a1)
    e = 2.0 * a3 + c1
    c2 = cross(e, a1) / -60.0
    f, g = c1 - 20.0 * a1 - a3, a2 + c2
    omega = a1 + a3 / 12.0 + cross(g, f) / 240.0

    dc1 = cross(d2, a1) + cross(a2, d1)
    de = 2.0 * d3 + dc1
    dc2 = (cross(de, a1) + cross(e, d1)) / -60.0
    df, dg = dc1 - 20.0 * d1 - d3, d2 + dc2
    rate = d1 + d3 / 12.0 + (cross(dg, f) + cross(g, df)) / 240.0

    ddc1 = 2.0 * cross(d2, d1)
    ddc2 = (cross(ddc1, a1) + 2.0 * cross(de, d1)) / -60.0
    second = (cross(ddc2, f) + 2.0 * cross(dg, df) + cross(g, ddc1)) / 240.0

    one, zero = np.eye(3), np.zeros((3, 3))
    D = np.zeros((3, 3, 3))
    for m, (of_c1, own_e) in enumerate(((skew(a2), zero), (-skew(a1), zero), (zero, 2.0 * one))):
        of_e = own_e + of_c1
        of_c2 = (-skew(a1) @ of_e + (skew(e) if m == 0 else zero)) / -60.0
        of_f = of_c1 + (-20.0 * one, zero, -one)[m]
        of_g = of_c2 + (one if m == 1 else zero)
        D[m] = (one, zero, one / 12.0)[m] + (-skew(f) @ of_g + skew(g) @ of_f) / 240.0
    return omega, rate, second, D


def magnus_vectors(h: float, curvatures: np.ndarray) -> np.ndarray:
    """Return the three vectors of the Magnus expansion from values at `MAGNUS_POINTS`, (3, ...)."""
    first, middle, last = curvatures
    return np.array((h * middle, np.sqrt(15.0) / 3.0 * h * (last - first), 10.0 / 3.0 * h * (last - 2.0 * middle + first)))


def integration_matrix(points: np.ndarray, weights: np.ndarray) -> Matrix:
    """Return integrals from 0 to each Gauss point, and to 1, of the polynomial through values there, (P + 1, P)."""
    P = len(points)
    x = 2.0 * points - 1.0
    # through Legendre polynomials, whose coefficients the Gauss points give: int_-1^x P_n = (P_n+1 - P_n-1) / (2 n + 1)
    polynomials = np.polynomial.legendre.legvander(x, P)
    coefficients = polynomials[:, :P] * weights[:, None] * (2 * np.arange(P) + 1)
    integrals = np.empty((P, P))
    integrals[:, 0] = x + 1.0
    for n in range(1, P):
        integrals[:, n] = (polynomials[:, n + 1] - polynomials[:, n - 1]) / (2 * n + 1)
    return np.vstack((0.5 * integrals @ coefficients.T, weights))
