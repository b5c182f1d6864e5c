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
from functools import cached_property

import numpy as np

from kanefe.bodies.slopes import exponential_coefficients
from kanefe.frames import Matrix, Vector, skews
from kanefe.storage.pickled import PickledByFields

THREE_POINTS = 0.5 + np.sqrt(15.0) / 10.0 * np.array((-1.0, 0.0, 1.0)), np.array((5.0, 8.0, 5.0)) / 18.0
"""Gauss points and weights of the unit interval for the curvature over a part of a step, of sixth order."""

ALONG = np.array((1.0, 0.0, 0.0))
"""Direction of the axis in the axes of an undeformed section."""


@dataclass(frozen=True, eq=False, repr=False)
class BeamLine(PickledByFields):
    """Strain fields of a beam of C cells, with P Gauss points in each, in k coordinates.

    Attributes
    ----------
    axes : ndarray, shape (3, 3)
        Of the root section, at the origin of G: x along the beam.
    strain_of : ndarray of int, shape (k,)
        In rising order: which strain a coordinate is of, 0 to 5: stretch, shear along y and z, twist (1/m), curvature
        about y and z.
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
    stiffness : ndarray, shape (C, P, 6, 6)
        Forces (N) and moments (N m) of the Gauss points from the strains, in axes of the section.
    last : ndarray of bool, shape (k,)
        The last two functions of each strain, if they are of rising degree; else none.
    """

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
    stiffness: np.ndarray
    last: np.ndarray

    def __repr__(self) -> str:
        cells, points = self.masses.shape
        return f"BeamLine({self.lengths.sum():.4g} m, {self.count} coordinates, {cells} cells of {points} Gauss points)"

    @property
    def count(self) -> int:
        """Number k of coordinates."""
        return len(self.strain_of)

    @property
    def is_in_plane(self) -> bool:
        """Whether the beam bends in the x-y plane of G alone."""
        moves = set(self.strain_of.tolist()) <= {0, 1, 5} and not self.turn_rest[..., :2].any()
        return moves and abs(float(self.axes[2, 2])) == 1.0

    @cached_property
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

    @property
    def stations(self) -> np.ndarray:
        """Arc lengths of the stations, (n,), m."""
        starts = np.cumsum(self.lengths) - self.lengths
        within = starts[:, None] + self.lengths[:, None] * np.append(self.points, 1.0)
        return np.append(0.0, within.ravel())

    def strains(self, eta: Matrix) -> np.ndarray:
        """Return the strains of the Gauss points, beyond those at rest, (T, C, P, 6), at many states eta (T, k)."""
        return np.asarray(np.tensordot(eta, self.values[..., None] * np.eye(6)[self.strain_of], axes=(1, 2)))

    def through(self, x: np.ndarray) -> Matrix:
        """Return the values at places x (s,) of a cell over its length from those at its Gauss points, (s, P)."""
        P = len(self.points)
        at, own = (np.polynomial.legendre.legvander(2.0 * of - 1.0, P - 1) for of in (x, self.points))
        return np.asarray((at * (2 * np.arange(P) + 1)) @ (own * self.weights[:, None]).T)

    def end_node(self, cell: int) -> int:
        """Return which station is the end of a cell; -1: the root."""
        return (cell + 1) * (len(self.points) + 1)

    @cached_property
    def _columns(self) -> tuple[np.ndarray, np.ndarray]:
        """Twist and curvature in all steps (C, P + 1, 3, 3, k); stretch and shear at Gauss points (C, P, 3, k)."""
        C, P, k = self.values.shape
        about, along = np.zeros((C, P + 1, 3, 3, k)), np.zeros((C, P, 3, k))
        for j, strain in enumerate(self.strain_of):
            if strain < 3:
                along[:, :, strain, j] = self.values[:, :, j]
            else:
                about[:, :, :, strain - 3, j] = self.turn_values[:, :, :, j]
        return about, along

    @property
    def marks(self) -> np.ndarray:
        """Ends of the steps from station to station of a cell, over its length, (P + 2,)."""
        return np.concatenate(([0.0], self.points, [1.0]))

    def turn_vectors(self, eta: Matrix) -> np.ndarray:
        """Return the vectors of the Magnus expansions of all steps at many states eta (T, k), (T, C, P + 1, 3, 3)."""
        return np.asarray(self.turn_rest + np.tensordot(eta, self._columns[0], axes=(1, -1)))

    def turns_within(self, eta: Matrix, step: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return the turns of parts of steps of every cell, (T, C, s, 3, 3), at many states eta (T, k).

        The curvature at rest within a step is the quadratic function that its Magnus expansion has.

        Parameters
        ----------
        step : ndarray of int, shape (s,)
            Of a cell.
        low, high : ndarray, shape (s,)
            Ends of the part, over the length of the cell.
        """
        part, marks = high - low, self.marks
        length = np.diff(marks)[step]
        share = (part / length)[:, None]
        a1, a2, a3 = np.moveaxis(self.turn_rest[:, step], -2, 0)
        u = ((0.5 * (low + high) - marks[step]) / length - 0.5)[:, None]  # middle of the part, from that of the step
        rest = np.array((share * (a1 + u * a2 + u**2 * a3), share**2 * (a2 + 2.0 * u * a3), share**3 * a3))
        within = self.through((low + THREE_POINTS[0][:, None] * part).ravel()) @ self.strains(eta)[..., 3:]
        bent = np.moveaxis(within.reshape(len(eta), len(self.lengths), 3, len(part), 3), 2, 0)
        a = rest[:, None] + magnus_vectors(1.0, *THREE_POINTS, bent) * (self.lengths[:, None] * part)[..., None]
        return turns_of_vectors(magnus(np.moveaxis(a, 0, -2))[0])

    def places(self, eta: Matrix) -> tuple[np.ndarray, np.ndarray]:
        """Return axes (T, n, 3, 3) and places (T, n, 3), m, of all stations in G at many states eta (T, k)."""
        return self.placed(eta, turns_of_vectors(magnus(self.turn_vectors(eta))[0]))

    def placed(self, eta: Matrix, turns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the same from the turns of all steps, (T, C, P + 1, 3, 3)."""
        (C, P, _), T = self.values.shape, len(eta)
        A, p = np.empty((T, self.node_count, 3, 3)), np.empty((T, self.node_count, 3))
        A[:, 0], p[:, 0] = self.axes, 0.0
        for n, turn in enumerate(np.moveaxis(turns.reshape(T, C * (P + 1), 3, 3), 1, 0)):
            A[:, n + 1] = A[:, n] @ turn
        t = np.squeeze(A[:, self.gauss_nodes] @ (ALONG + self.strains(eta)[..., :3])[..., None], -1)
        for c, h in enumerate(self.lengths):
            start = c * (P + 1)
            p[:, start + 1 : start + P + 2] = p[:, start, None] + h * (self.integration @ t[:, c])
        return A, p

    def within(self, eta: Matrix, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return axes (T, C, s, 3, 3) and places (T, C, s, 3), m, in G at x (s,) of every cell over its length."""
        marks = self.marks
        step = np.clip(np.searchsorted(marks, x, side="right") - 1, 0, len(self.points))
        A, p = self.places(eta)
        first = (len(self.points) + 1) * np.arange(len(self.lengths))
        along = np.squeeze(A[:, self.gauss_nodes] @ (ALONG + self.strains(eta)[..., :3])[..., None], -1)
        moved = self.lengths[:, None, None] * (integrals_to(x, self.points, self.weights) @ along)
        return A[:, first[:, None] + step] @ self.turns_within(eta, step, marks[step], x), p[:, first, None] + moved

    @cached_property
    def at_rest(self) -> tuple[np.ndarray, np.ndarray]:
        """Axes (n, 3, 3) and places (n, 3), m, of all stations of the undeformed beam in G."""
        A, p = self.places(np.zeros((1, self.count)))
        return A[0], p[0]

    def motion(self, eta: Vector, deta: Vector) -> SectionMotions:
        """Return the motion of all stations seen from G (Eq. 22, 24-26 for sections that turn far).

        That of the last state is kept, for all who ask for it.
        """
        state = eta.tobytes() + deta.tobytes()
        last: tuple[bytes, SectionMotions] | None = self.__dict__.get("_last")
        if last is None or last[0] != state:
            last = state, self._moved(eta, deta)
            self.__dict__["_last"] = last
        return last[1]

    def _moved(self, eta: Vector, deta: Vector) -> SectionMotions:
        C, P, k = self.values.shape
        found = SectionMotions.room(self.node_count, k)
        about, along = self._columns
        omega, rate, second, D = turn_of_step(self.turn_rest + about @ eta, about @ deta)
        E, T, remainder = rotations(omega, rate)
        spins, twists = (np.squeeze(T @ x[..., None], -1) for x in (rate, second))
        turns = T @ np.einsum("cgmab,cgmbk->cgak", D, about)
        flat = [x.reshape(C * (P + 1), *x.shape[2:]) for x in (E, spins, twists + remainder, turns)]
        found.A[0] = self.axes
        for n, turn in enumerate(flat[0]):
            found.A[n + 1] = found.A[n] @ turn
        before = found.A[:-1]
        spin, twist = (np.squeeze(before @ x[..., None], -1) for x in flat[1:3])
        np.cumsum(spin, axis=0, out=found.w[1:])
        np.cumsum(before @ flat[3], axis=0, out=found.W[1:])
        np.cumsum(twist + _cross(found.w[:-1], spin), axis=0, out=found.y[1:])

        gauss = self.gauss_nodes
        A, w, y = found.A[gauss], found.w[gauss], found.y[gauss]
        t = A @ (ALONG + along @ eta)[..., None]
        stretch, t = np.squeeze(A @ (along @ deta)[..., None], -1), t[..., 0]
        swing = _cross(w, t)
        pull = _cross(y, t) + _cross(w, swing + 2.0 * stretch)
        slope = A @ along - skews(t) @ found.W[gauss]
        for of, integrand in ((found.p, t), (found.v, swing + stretch), (found.z, pull), (found.V, slope)):
            for c, h in enumerate(self.lengths):
                start = c * (P + 1)
                of[start + 1 : start + P + 2] = of[start] + h * np.tensordot(self.integration, integrand[c], axes=1)
        for part in (found.A, found.p, found.v, found.w, found.V, found.W, found.z, found.y):
            part.flags.writeable = False
        return found


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
        return cls(
            np.zeros((n, 3, 3)), *(np.zeros((n, *shape)) for shape in ((3,), (3,), (3,), (3, k), (3, k), (3,), (3,)))
        )


def rotations(omega: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the rotations of rotation vectors (..., 3), their tangents T of ``w = T rate``, and ``dT/dt rate``."""
    angle = np.sqrt(np.sum(omega * omega, axis=-1))
    coefficients = np.array([exponential_coefficients(float(x)) for x in angle.ravel()])
    a, b, da, db = (x.reshape(angle.shape)[..., None] for x in coefficients.T)
    t, x = skews(omega), _cross(omega, rate)
    square, along = t @ t, np.sum(omega * rate, axis=-1, keepdims=True)
    T = np.eye(3) + a[..., None] * t + b[..., None] * square
    return turns_of_vectors(omega), T, da * along * x + db * along * _cross(omega, x) + b * _cross(rate, x)


def turn_of_step(a: np.ndarray, da: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the rotation vector omega (..., 3) of steps, its two rates, and its derivatives by the vectors a.

    Parameters
    ----------
    a, da : ndarray, shape (..., 3, 3)
        Curvature times length, and its first and second differences, as rows; and their rates, which are constant.

    Returns
    -------
    omega, rate, second : ndarray, shape (..., 3)
    D : ndarray, shape (..., 3, 3, 3)
        The first of the last three says by which vector.
    """
    a1, a2, _ = np.moveaxis(a, -2, 0)
    d1, d2, d3 = np.moveaxis(da, -2, 0)
    omega, e, f, g = magnus(a)

    dc1 = _cross(d2, a1) + _cross(a2, d1)
    de = 2.0 * d3 + dc1
    dc2 = (_cross(de, a1) + _cross(e, d1)) / -60.0
    df, dg = dc1 - 20.0 * d1 - d3, d2 + dc2
    rate = d1 + d3 / 12.0 + (_cross(dg, f) + _cross(g, df)) / 240.0

    ddc1 = 2.0 * _cross(d2, d1)
    ddc2 = (_cross(ddc1, a1) + 2.0 * _cross(de, d1)) / -60.0
    second = (_cross(ddc2, f) + 2.0 * _cross(dg, df) + _cross(g, ddc1)) / 240.0

    one = np.eye(3)
    A1, A2, E, F, G = (skews(x) for x in (a1, a2, e, f, g))
    none = np.zeros_like(A1)
    D = []
    for m, (of_c1, own_e) in enumerate(((A2, none), (-A1, none), (none, 2.0 * one))):
        of_c2 = (-A1 @ (own_e + of_c1) + (E if m == 0 else none)) / -60.0
        of_f, of_g = of_c1 + (-20.0, 0.0, -1.0)[m] * one, of_c2 + (0.0, 1.0, 0.0)[m] * one
        D.append((1.0, 0.0, 1.0 / 12.0)[m] * one + (G @ of_f - F @ of_g) / 240.0)
    return omega, rate, second, np.stack(D, axis=-3)


def magnus(a: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the rotation vector omega (..., 3) of steps from their vectors a (..., 3, 3), and its parts e, f, g."""
    a1, a2, a3 = np.moveaxis(a, -2, 0)
    # brackets of a product from the right: [x, y] = y x x
    c1 = _cross(a2, a1)
    e = 2.0 * a3 + c1
    f, g = c1 - 20.0 * a1 - a3, a2 + _cross(e, a1) / -60.0
    return a1 + a3 / 12.0 + _cross(g, f) / 240.0, e, f, g


def turns_of_vectors(omega: np.ndarray) -> np.ndarray:
    """Return the matrices of rotation vectors (..., 3): ``1 + sin a / a omega~ + (1 - cos a) / a2 omega~2``."""
    turns = np.linalg.norm(omega, axis=-1)[..., None, None] / np.pi
    K = skews(omega)
    return np.asarray(np.eye(3) + np.sinc(turns) * K + 0.5 * np.sinc(0.5 * turns) ** 2 * (K @ K))


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the cross products of vectors (..., 3); numpy's own takes several times as long on few of them."""
    found = np.empty(np.broadcast_shapes(a.shape, b.shape))
    found[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    found[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    found[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return found


def magnus_vectors(h: float, points: np.ndarray, weights: np.ndarray, curvatures: np.ndarray) -> np.ndarray:
    """Return the three vectors of the Magnus expansion from values at Gauss points of the unit interval, (3, ...).

    They are those of the moments over the step (Blanes et al. 2009, eq. 253), so that angles in a plane, which are the
    integrals of the curvature, are exact.
    """
    x = points - 0.5
    whole, slope, bow = (h * np.tensordot(weights * x**i, curvatures, axes=1) for i in range(3))
    return np.array((2.25 * whole - 15.0 * bow, 12.0 * slope, 180.0 * bow - 15.0 * whole))


def integration_matrix(points: np.ndarray, weights: np.ndarray) -> Matrix:
    """Return integrals from 0 to each Gauss point, and to 1, of the polynomial through values there, (P + 1, P)."""
    return np.vstack((integrals_to(points, points, weights), weights))


def integrals_to(at: np.ndarray, points: np.ndarray, weights: np.ndarray) -> Matrix:
    """Return integrals from 0 to places (s,) in (0, 1) of the polynomial through values at Gauss points, (s, P)."""
    P, x = len(points), 2.0 * at - 1.0
    # through Legendre polynomials, whose coefficients the Gauss points give: int_-1^x P_n = (P_n+1 - P_n-1) / (2 n + 1)
    polynomials = np.polynomial.legendre.legvander(x, P)
    own = np.polynomial.legendre.legvander(2.0 * points - 1.0, P - 1)
    coefficients = own * weights[:, None] * (2 * np.arange(P) + 1)
    integrals = np.empty((len(x), P))
    integrals[:, 0] = x + 1.0
    for n in range(1, P):
        integrals[:, n] = (polynomials[:, n + 1] - polynomials[:, n - 1]) / (2 * n + 1)
    return np.asarray(0.5 * integrals @ coefficients.T)
