"""A shear-flexible shell as UFL forms: strains of the surface, energy, and what the thickness adds.

Displacement ``u + z b`` with ``b = theta x n``: n is the director, theta the rotation of the node. With orthonormal
tangents a_1, a_2 of the surface and its normal e3,

    ``e_ij = sym(a_i . u,j)``, ``k_ij = sym(a_i . b,j + n,i . u,j)``, ``g_i = a_i . b + n . u,i``

are the membrane, bending and shear strains (Naghdi's theory; Chapelle and Bathe, The Finite Element Analysis of
Shells, 2nd ed., ch. 4). The rotation about the normal has no strain; it is tied to the turn of the surface,
``(a_2 . u,1 - a_1 . u,2) / 2 - theta . e3``, by the modulus of shear in the plane.

Every function takes the namespace `fx` of `kanefe_fem._fenicsx.load`, the fields of `ShellFields` and functions with
six components.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple


@dataclass(frozen=True, eq=False)
class ShellFields:
    """Data of a shell on the cells of one shape, as functions of the mesh.

    Attributes
    ----------
    director : function of 3 components, of second order in each cell
    thickness : function of second order in each cell
        m.
    along : function of 3 components, constant in each cell
        Direction whose part in the surface is a_1.
    section : function of 21 components, constant in each cell
        Upper triangles of A1, B1, D1 and S1 of `kanefe_fem.shells.sections`, Pa.
    membrane, shear, turn : functions constant in each cell
        Share of these energies that is integrated in full.
    reference : function of 2 components, of first order in each cell
        Coordinates of the reference cell, from -1 to 1; of quadrangles only.
    """

    director: Any
    thickness: Any
    along: Any
    section: Any
    membrane: Any
    shear: Any
    turn: Any
    reference: Any


class Strains(NamedTuple):
    """Strains of a displacement in the axes a_1, a_2.

    Attributes
    ----------
    membrane, bending : vector of 3
        11, 22 and twice 12; rad/m for bending.
    shear : vector of 2
    turn : scalar
        Turn of the surface in itself less the rotation about its normal, rad.
    """

    membrane: Any
    bending: Any
    shear: Any
    turn: Any


class StrainsAtHeight(NamedTuple):
    """Strains at a height, in the axes a_1, a_2.

    Attributes
    ----------
    strain : vector of 3
        11, 22 and twice 12.
    shear : vector of 2
    stretch : scalar
        Area there over that of the surface.
    """

    strain: Any
    shear: Any
    stretch: Any


class Surface:
    """Tangents of the surface and derivatives along them."""

    def __init__(self, fx: Any, mesh: Any, fields: ShellFields) -> None:
        ufl = self.ufl = fx.ufl
        self.jacobian = ufl.Jacobian(mesh)
        across = ufl.cross(*(ufl.as_vector([self.jacobian[i, a] for i in range(3)]) for a in range(2)))
        self.stretch = ufl.sqrt(ufl.dot(across, across))
        self.normal = across / self.stretch
        first = fields.along - ufl.dot(fields.along, self.normal) * self.normal
        first = first / ufl.sqrt(ufl.dot(first, first))
        second = ufl.cross(self.normal, first)
        self.tangents = ufl.as_matrix([[axis[i] for i in range(3)] for axis in (first, second)])
        self.fields = fields
        self.bent = self.along(fields.director)

    def along(self, f: Any) -> Any:
        """Return the derivatives of a vector along a_1 and a_2, as columns."""
        return self.ufl.dot(self.ufl.grad(f), self.tangents.T)

    def parts(self, w: Any) -> tuple[Any, Any]:
        """Return the displacement u and the motion b of the tip of the director, None of a function of u alone."""
        if len(w) == 3:
            return w, None
        u = self.ufl.as_vector([w[i] for i in range(3)])
        return u, self.ufl.cross(rotation(self.ufl, w), self.fields.director)

    def strains(self, w: Any) -> Strains:
        """Return the strains of a function of six components, or of three, the displacement."""
        ufl = self.ufl
        u, b = self.parts(w)
        slope = self.along(u)
        E = ufl.dot(self.tangents, slope)
        bending, shear = ufl.dot(self.bent.T, slope), ufl.dot(slope.T, self.fields.director)
        turn = 0.5 * (E[1, 0] - E[0, 1])
        if b is not None:
            bending, shear = bending + ufl.dot(self.tangents, self.along(b)), shear + ufl.dot(self.tangents, b)
            turn = turn - ufl.dot(rotation(ufl, w), self.normal)
        return Strains(voigt(ufl, E), voigt(ufl, bending), shear, turn)

    def second(self, w: Any, v: Any) -> Strains:
        """Return twice the strains of second order of two motions, symmetric in both.

        A director turns to ``n + b + b2`` with ``b2 = 1/2 theta x (theta x n)``, so that

            ``e = sym(u,i . u,j) / 2``, ``k = sym(u,i . b,j + a_i . b2,j)``, ``g = u,i . b + a_i . b2``

        and the turn is the skew part of ``a_i . R^T x,j``, with the R of theta.
        """
        ufl = self.ufl
        (u, b), (y, c) = self.parts(w), self.parts(v)
        p, q, theta, phi = self.along(u), self.along(y), rotation(ufl, w), rotation(ufl, v)
        d = self.second_motion(w, v)
        bending = ufl.dot(p.T, self.along(c)) + ufl.dot(q.T, self.along(b)) + ufl.dot(self.tangents, self.along(d))
        shear = ufl.dot(p.T, c) + ufl.dot(q.T, b) + ufl.dot(self.tangents, d)
        back = [[ufl.dot(self.tangents[i, :], turned(ufl, theta, q, phi, p, j)) for j in (0, 1)] for i in (0, 1)]
        return Strains(voigt(ufl, ufl.dot(p.T, q)), voigt(ufl, bending), shear, 0.5 * (back[0][1] - back[1][0]))

    def second_motion(self, w: Any, v: Any) -> Any:
        """Return twice the motion of second order of the director, symmetric in both motions."""
        ufl, n = self.ufl, self.fields.director
        theta, phi = rotation(ufl, w), rotation(ufl, v)
        twice = ufl.cross(theta, ufl.cross(phi, n)) + ufl.cross(phi, ufl.cross(theta, n))
        return 0.5 * twice

    def at(self, height: Any, w: Any) -> StrainsAtHeight:
        """Return strains at a height in m, and the stretch of the area there.

        With the tangents ``g_i = a_i + z n,i``, since those of the interpolated director are not quite in the surface:
        so a rigid motion has no strain.
        """
        ufl = self.ufl
        u, b = self.parts(w)
        slope = self.along(u) + height * self.along(b)
        g = self.tangents.T + height * self.bent
        shear = ufl.dot(slope.T, self.fields.director) + ufl.dot(g.T, b)
        return self._in_layer(g, ufl.sym(ufl.dot(g.T, slope)), shear)

    def second_at(self, height: Any, w: Any, v: Any) -> StrainsAtHeight:
        """Return twice the strains of second order of two motions at a height, in m, as `second` does."""
        ufl = self.ufl
        (u, b), (y, c) = self.parts(w), self.parts(v)
        p, q = self.along(u) + height * self.along(b), self.along(y) + height * self.along(c)
        d, g = self.second_motion(w, v), self.tangents.T + height * self.bent
        E = ufl.sym(ufl.dot(p.T, q) + height * ufl.dot(g.T, self.along(d)))
        shear = ufl.dot(p.T, c) + ufl.dot(q.T, b) + ufl.dot(g.T, d)
        shear = shear + height * ufl.dot(self.along(d).T, self.fields.director)
        return self._in_layer(g, E, shear)

    def _in_layer(self, g: Any, strain: Any, shear: Any) -> StrainsAtHeight:
        """Return strains along tangents g in the axes a_1, a_2."""
        ufl = self.ufl
        shifter = ufl.dot(self.tangents, g)
        back = ufl.inv(shifter)
        E = ufl.dot(ufl.dot(back.T, strain), back)
        return StrainsAtHeight(voigt(ufl, E), ufl.dot(back.T, shear), ufl.det(shifter))

    def moments(self, w: Any, part: str) -> list[Any]:
        """Return the densities of the moments of strains along the edges of the reference cell.

        ``x,a . u,b`` and its like for part "membrane", ``x,a . b,b + n,a . u,b`` for part "bending": 11 and 22 times
        1, x, y and x y, twice 12 times 1, x and y, the fields of `kanefe_fem.shells.assumed`. Over the stretch, so
        that an integral over the cell is one over the reference cell.
        """
        ufl = self.ufl
        u, b = self.parts(w)
        slope = self._along_edges(u)
        X = ufl.dot(self.jacobian.T, slope)
        if part == "bending":
            X = ufl.dot(self.jacobian.T, self._along_edges(b))
            X = X + ufl.dot(self._along_edges(self.fields.director).T, slope)
        return self._moments_of(X)

    def second_moments(self, w: Any, v: Any, part: str) -> list[Any]:
        """Return the densities of the same moments of the strains of `second`."""
        ufl = self.ufl
        (u, b), (y, c) = self.parts(w), self.parts(v)
        p, q = self._along_edges(u), self._along_edges(y)
        X = ufl.dot(p.T, q)
        if part == "bending":
            X = ufl.dot(p.T, self._along_edges(c)) + ufl.dot(q.T, self._along_edges(b))
            X = X + ufl.dot(self.jacobian.T, self._along_edges(self.second_motion(w, v)))
        return self._moments_of(X)

    def _along_edges(self, f: Any) -> Any:
        """Return the derivatives of a vector along the edges of the reference cell, as columns."""
        return self.ufl.dot(self.ufl.grad(f), self.jacobian)

    def _moments_of(self, X: Any) -> list[Any]:
        e = voigt(self.ufl, X / self.stretch)
        x, y = self.fields.reference[0], self.fields.reference[1]
        bilinear = [1.0, x, y, x * y]
        return [e[i] * f for i in (0, 1) for f in bilinear] + [e[2] * f for f in bilinear[:3]]


def rotation(ufl: Any, w: Any) -> Any:
    """Return the rotation of a function of six components."""
    return ufl.as_vector([w[3 + i] for i in range(3)])


def turned(ufl: Any, theta: Any, q: Any, phi: Any, p: Any, column: int) -> Any:
    """Return ``theta x q + phi x p`` of columns of slopes."""
    return ufl.cross(theta, q[:, column]) + ufl.cross(phi, p[:, column])


def voigt(ufl: Any, X: Any) -> Any:
    """Return 11, 22 and the sum of 12 and 21 of a matrix."""
    return ufl.as_vector([X[0, 0], X[1, 1], X[0, 1] + X[1, 0]])


def energy(surface: Surface, x: Strains, y: Strains, assumed: bool) -> dict[str, Any]:
    """Return the integrands of the work of the forces of some strains on others, by their rules of integration.

    Parameters
    ----------
    surface : Surface
    x, y : Strains
        Those that make the forces, and those on which they work: of a trial and a test function for the stiffness; of a
        load and of second order for the geometric stiffness.
    assumed : bool
        Whether the share of the membrane that is not integrated in full comes from assumed strains.

    Returns
    -------
    dict
        "full": bending, and the shares of membrane, coupling, shear and turn; "few": the rest, but shear; "fewest":
        the rest of shear.
    """
    fields, ufl = surface.fields, surface.ufl
    t = fields.thickness
    A, B, D, S = (moduli(ufl, fields.section, first, size) for first, size in ((0, 3), (6, 3), (12, 3), (18, 2)))
    membrane = t * product(ufl, A, x.membrane, y.membrane)
    membrane += t**2 * (product(ufl, B, x.bending, y.membrane) + product(ufl, B, x.membrane, y.bending))
    shear = t * product(ufl, S, x.shear, y.shear)
    turn = t * A[2, 2] * x.turn * y.turn
    full = t**3 * product(ufl, D, x.bending, y.bending)
    full += fields.membrane * membrane + fields.shear * shear + fields.turn * turn
    few = (1.0 - fields.turn) * turn
    if not assumed:
        few += (1.0 - fields.membrane) * membrane
    return {"full": full, "few": few, "fewest": (1.0 - fields.shear) * shear}


def through_thickness(
    surface: Surface, flat: tuple[Strains, Strains], curved: tuple[StrainsAtHeight, StrainsAtHeight], layer: Any
) -> Any:
    """Return what a point of the thickness adds to the work of `energy` where the surface is curved.

    At the height z a length along the surface is ``I + z n,i`` times as long: strains are smaller or larger there, and
    so is the area. The work of `energy` is subtracted.

    Parameters
    ----------
    surface : Surface
    flat, curved : tuple of two
        Strains that make the forces and strains on which they work, as in `energy`, and those at the height.
    layer : function of 11 components, constant in each cell
        Height and weight as fractions of the thickness, upper triangles of the plane and the shear stiffness (Pa).
    """
    fields, ufl = surface.fields, surface.ufl
    z, weight = fields.thickness * layer[0], fields.thickness * layer[1]
    Q, G = moduli(ufl, layer, 2, 3), moduli(ufl, layer, 8, 2)
    (x, y), (e, f) = flat, curved
    less = product(ufl, Q, x.membrane + z * x.bending, y.membrane + z * y.bending) + product(ufl, G, x.shear, y.shear)
    return weight * (e.stretch * (product(ufl, Q, e.strain, f.strain) + product(ufl, G, e.shear, f.shear)) - less)


def moduli(ufl: Any, values: Any, first: int, size: int) -> Any:
    """Return a symmetric matrix from its upper triangle, in components of a function from number `first` on."""
    upper = [(i, j) for i in range(size) for j in range(i, size)]
    return ufl.as_matrix(
        [[values[first + upper.index((min(i, j), max(i, j)))] for j in range(size)] for i in range(size)]
    )


def product(ufl: Any, matrix: Any, x: Any, y: Any) -> Any:
    """Return ``y . matrix x``."""
    return ufl.dot(ufl.dot(matrix, x), y)
