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
        u, theta = (self.ufl.as_vector([w[first + i] for i in range(3)]) for first in (0, 3))
        return u, self.ufl.cross(theta, self.fields.director)

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
            turn = turn - ufl.dot(ufl.as_vector([w[3 + i] for i in range(3)]), self.normal)
        return Strains(voigt(ufl, E), voigt(ufl, bending), shear, turn)

    def at(self, height: Any, w: Any) -> tuple[Any, Any, Any]:
        """Return strains in the surface and across it at a height in m, and the stretch of the area there.

        With the tangents ``g_i = a_i + z n,i``, since those of the interpolated director are not quite in the surface:
        so a rigid motion has no strain.
        """
        ufl = self.ufl
        u, b = self.parts(w)
        slope = self.along(u) + height * self.along(b)
        g = self.tangents.T + height * self.bent
        shifter = ufl.dot(self.tangents, g)
        back = ufl.inv(shifter)
        E = ufl.dot(ufl.dot(back.T, ufl.sym(ufl.dot(g.T, slope))), back)
        shear = ufl.dot(back.T, ufl.dot(slope.T, self.fields.director) + ufl.dot(g.T, b))
        return voigt(ufl, E), shear, ufl.det(shifter)

    def moments(self, w: Any, part: str) -> list[Any]:
        """Return the densities of the moments of strains along the edges of the reference cell.

        ``x,a . u,b`` and its like for part "membrane", ``x,a . b,b + n,a . u,b`` for part "bending": 11 and 22 times
        1, x, y and x y, twice 12 times 1, x and y, the fields of `kanefe_fem.shells.assumed`. Over the stretch, so
        that an integral over the cell is one over the reference cell.
        """
        ufl = self.ufl
        u, b = self.parts(w)
        slope = ufl.dot(ufl.grad(u), self.jacobian)
        X = ufl.dot(self.jacobian.T, slope)
        if part == "bending":
            X = ufl.dot(self.jacobian.T, ufl.dot(ufl.grad(b), self.jacobian))
            X = X + ufl.dot(ufl.dot(ufl.grad(self.fields.director), self.jacobian).T, slope)
        e = voigt(ufl, X / self.stretch)
        x, y = self.fields.reference[0], self.fields.reference[1]
        bilinear = [1.0, x, y, x * y]
        return [e[i] * f for i in (0, 1) for f in bilinear] + [e[2] * f for f in bilinear[:3]]


def voigt(ufl: Any, X: Any) -> Any:
    """Return 11, 22 and the sum of 12 and 21 of a matrix."""
    return ufl.as_vector([X[0, 0], X[1, 1], X[0, 1] + X[1, 0]])


def energy(surface: Surface, w: Any, v: Any, assumed: bool) -> dict[str, Any]:
    """Return the integrands of the stiffness by their rules of integration.

    Parameters
    ----------
    surface : Surface
    w, v : trial and test function
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
    x, y = surface.strains(w), surface.strains(v)
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


def through_thickness(surface: Surface, w: Any, v: Any, layer: Any) -> Any:
    """Return what a point of the thickness adds to the energy where the surface is curved.

    At the height z a length along the surface is ``I + z n,i`` times as long: strains are smaller or larger there, and
    so is the area. The energy of `energy` is subtracted.

    Parameters
    ----------
    layer : function of 11 components, constant in each cell
        Height and weight as fractions of the thickness, upper triangles of the plane and the shear stiffness (Pa).
    """
    fields, ufl = surface.fields, surface.ufl
    z, weight = fields.thickness * layer[0], fields.thickness * layer[1]
    Q, G = moduli(ufl, layer, 2, 3), moduli(ufl, layer, 8, 2)
    (e, g, stretch), (f, h, _) = surface.at(z, w), surface.at(z, v)
    x, y = surface.strains(w), surface.strains(v)
    flat = product(ufl, Q, x.membrane + z * x.bending, y.membrane + z * y.bending) + product(ufl, G, x.shear, y.shear)
    return weight * (stretch * (product(ufl, Q, e, f) + product(ufl, G, g, h)) - flat)


def stress_energy(surface: Surface, load: Any, w: Any, v: Any) -> Any:
    """Return the integrand of the geometric stiffness of a static displacement.

    ``N_ab u,a . v,b + M_ab (u,a . c,b + b,a . v,b)`` with the forces N and moments M of the load, b and c the motions
    of the directors of u and v.
    """
    fields, ufl = surface.fields, surface.ufl
    t = fields.thickness
    A, B, D = (moduli(ufl, fields.section, first, 3) for first in (0, 6, 12))
    x = surface.strains(load)
    force = t * ufl.dot(A, x.membrane) + t**2 * ufl.dot(B, x.bending)
    moment = t**2 * ufl.dot(B, x.membrane) + t**3 * ufl.dot(D, x.bending)
    N, M = (ufl.as_matrix([[f[0], f[2]], [f[2], f[1]]]) for f in (force, moment))
    (gu, gb), (gv, gc) = (tuple(surface.along(part) for part in surface.parts(f)) for f in (w, v))
    return ufl.inner(ufl.dot(gu, N), gv) + ufl.inner(ufl.dot(gu, M), gc) + ufl.inner(ufl.dot(gb, M), gv)


def moduli(ufl: Any, values: Any, first: int, size: int) -> Any:
    """Return a symmetric matrix from its upper triangle, in components of a function from number `first` on."""
    upper = [(i, j) for i in range(size) for j in range(i, size)]
    return ufl.as_matrix(
        [[values[first + upper.index((min(i, j), max(i, j)))] for j in range(size)] for i in range(size)]
    )


def product(ufl: Any, matrix: Any, x: Any, y: Any) -> Any:
    """Return ``y . matrix x``."""
    return ufl.dot(ufl.dot(matrix, x), y)
