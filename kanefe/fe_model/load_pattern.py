"""Load patterns: the effect on a body of a load spread over a surface or a line, from integrals computed once.

The displacement of the points of a surface is linear in the coordinates, ``r = X + Psi eta``, and the load is given per
undeformed area. So a uniform traction t (components in G) on the surface does the work of

    force  A t,    moment about G's origin  (X_1 + S eta) x t,    elastic forces  S^T t

with ``A = int dA``, ``X_1 = int X dA`` and ``S = int Psi dA``: three constants, whatever the mesh. The constants of a
pressure p are those of the undeformed surface, ``-int n dA``, ``-int X x n dA`` and ``-int Psi^T n dA``. Their change
with the deformation is of first order in eta: the turn and growth of the surface and the displacement of its points
together, since the resultant on a closed surface stays zero only with all or none of them. A pressure that follows the
surface has it, ``p (f + K eta)``; others leave it out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.loaded_face import LoadedFace
from kanefe.fe_model.place_field import Over, PlaceField, checked_field
from kanefe.fe_model.pressure_change import PressureChange
from kanefe.storage.scipy_later import sp

PatternKind = Literal["surface", "line"]

_OF_PRESSURE = ("pressure_force", "pressure_moment", "pressure_elastic", "pressure_change")

ARRAYS = ("first", "shape_first", *_OF_PRESSURE, "quadratic_first")
"""Names of the arrays of a `LoadPattern`, in order."""


@dataclass(frozen=True, eq=False)
class NodalPattern:
    """Consistent nodal forces of unit loads on a surface or a line of a full-order model with N degrees of freedom.

    Attributes
    ----------
    kind : "surface" or "line"
    measure : float
        Area in m2, or length in m.
    first : ndarray, shape (3,)
        X_1, the first moment of the area or length about G's origin, m3 or m2.
    traction : ndarray, shape (N, 3)
        Forces on the degrees of freedom of unit tractions along x, y and z of G, in N per Pa (N per N/m of a line).
    pressure : ndarray, shape (N,), or None
        Forces of a unit pressure on the outer side, N/Pa. None for a line, which has no side.
    pressure_force, pressure_moment : ndarray, shape (3,)
        Resultant of a unit pressure, and its moment about G's origin: N/Pa and N m/Pa. Zero for a line.
    cells : ndarray of int, or None
        Numbers of the elements of a line of beams. None: not known, or a surface.
    pressure_change : PressureChange or None
        Change of `pressure_force`, `pressure_moment` and `pressure` with the displacements (m, rad): see
        `kanefe.fe_model.pressure_change`. None: not known, so that no pressure can follow the surface.
    face : LoadedFace or None
        Where it acts, for loads that vary by place. None: not known.
    """

    kind: PatternKind
    measure: float
    first: np.ndarray
    traction: np.ndarray
    pressure: np.ndarray | None
    pressure_force: np.ndarray
    pressure_moment: np.ndarray
    cells: np.ndarray | None = None
    pressure_change: PressureChange | None = None
    face: LoadedFace | None = None

    @classmethod
    def of_face(cls, face: LoadedFace, over: PlaceField | None = None, kind: PatternKind = "surface") -> NodalPattern:
        """Return the pattern of a face, of a load that is uniform, or varies by a shape, which is part of it."""
        shares, forces, across = face.sums(over)
        change = face.pressure_change(forces, across) if kind == "surface" else None
        return cls(
            kind=kind,
            measure=float(shares.sum()),
            first=shares @ face.points,
            traction=np.asarray(face.motion.T @ np.kron(shares[:, None], np.eye(3))),
            pressure=None if change is None else change.on_components,
            pressure_force=np.zeros(3) if change is None else forces.sum(axis=0),
            pressure_moment=np.zeros(3) if change is None else np.cross(face.points, forces).sum(axis=0),
            pressure_change=change,
            face=face,
        )

    @classmethod
    def of_nodes(
        cls,
        nodes: np.ndarray,
        components: tuple[str, ...],
        shares: np.ndarray,
        pressure: np.ndarray | None = None,
        kind: PatternKind = "surface",
        pressure_change: PressureChange | None = None,
    ) -> NodalPattern:
        """Return the pattern of Lagrange elements; nodal rotations (if any) do not affect their displacement field.

        Parameters
        ----------
        nodes : ndarray, shape (n, 3)
            Reference coordinates in m.
        components : tuple of str
            Degrees of freedom of every node.
        shares : ndarray, shape (n,)
            ``int N_i dA``, the share of each node in the area (m2) or length (m); zero off the surface.
        pressure : ndarray, shape (n, 3), optional
            ``-int N_i n dA`` with the outward normal n, the force on each node of a unit pressure, N/Pa.
        pressure_change : PressureChange, optional
            Its change with the displacements.

        Examples
        --------
        A unit square of one element, loaded from above:

        >>> corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
        >>> quarter = np.full(4, 0.25)
        >>> top = NodalPattern.of_nodes(corners, ("x", "y", "z"), quarter, -np.outer(quarter, (0, 0, 1)))
        >>> top.measure, top.pressure_force.tolist(), top.pressure_moment.tolist()
        (1.0, [0.0, 0.0, -1.0], [-0.5, 0.5, 0.0])
        """
        points, weights = np.asarray(nodes, dtype=float), np.asarray(shares, dtype=float)
        select = np.array([[float(component == axis) for axis in "xyz"] for component in components])
        resultant, moment, rows = np.zeros(3), np.zeros(3), None
        if pressure is not None:
            forces = np.asarray(pressure, dtype=float)
            resultant, moment = forces.sum(axis=0), np.cross(points, forces).sum(axis=0)
            rows = (forces @ select.T).reshape(-1)
        return cls(
            kind=kind,
            measure=float(weights.sum()),
            first=weights @ points,
            traction=np.kron(weights[:, None], select),
            pressure=rows,
            pressure_force=resultant,
            pressure_moment=moment,
            pressure_change=pressure_change,
        )

    def moved_by(self, motion: sp.csr_matrix) -> NodalPattern:
        """Return the pattern over other coordinates, by which the components of this one move, (N, others)."""
        return replace(
            self,
            traction=motion.T @ self.traction,
            pressure=None if self.pressure is None else motion.T @ self.pressure,
            pressure_change=None if self.pressure_change is None else self.pressure_change.moved_by(motion),
            face=None if self.face is None else self.face.moved_by(motion),
        )

    def projected(self, name: str, basis: np.ndarray) -> LoadPattern:
        """Return the pattern of a body with the basis Psi, shape (N, K); a sparse one has no change."""
        count, change = basis.shape[1], self.pressure_change
        return LoadPattern(
            name=name,
            kind=self.kind,
            has_pressure=self.pressure is not None,
            measure=self.measure,
            first=np.array(self.first, dtype=float),
            shape_first=self.traction.T @ basis,
            pressure_force=np.array(self.pressure_force, dtype=float),
            pressure_moment=np.array(self.pressure_moment, dtype=float),
            pressure_elastic=np.zeros(count) if self.pressure is None else self.pressure @ basis,
            pressure_change=None if change is None or sp.issparse(basis) else change.over(basis),
            face=self.face,
        )


@dataclass(frozen=True, eq=False)
class LoadPattern:
    """A surface or line of a flexible body with K coordinates that can carry a distributed load.

    Attributes
    ----------
    name : str
    kind : "surface" or "line"
    has_pressure : bool
        Whether a pressure can act on it: not on a line, whose pressure arrays are zero.
    measure : float
        A: area in m2, or length in m.
    first : ndarray, shape (3,)
        X_1 = int X dA about G's origin, in components of G, m3 or m2.
    shape_first : ndarray, shape (3, K)
        S_a,i = int Psi_a,i dA.
    pressure_force, pressure_moment : ndarray, shape (3,)
        -int n dA and -int X x n dA of the undeformed surface, in components of G, N/Pa and N m/Pa.
    pressure_elastic : ndarray, shape (K,)
        -int Psi_i . n dA.
    quadratic_first : ndarray, shape (3, K, K), or None
        int H_a dA of the second-order displacement ``1/2 eta^T H_a eta``: stiffening by a traction.
    pressure_change : ndarray, shape (6 + K, K), or None
        Change of `pressure_force`, `pressure_moment` and `pressure_elastic` with the coordinates; with stiffening
        "full", the last part has what the stress of a unit pressure does to the stiffness too. None: not known.
    face : LoadedFace or None
        Where it acts, for loads that vary by place. None: not known.
    """

    name: str
    kind: PatternKind
    has_pressure: bool
    measure: float
    first: np.ndarray
    shape_first: np.ndarray
    pressure_force: np.ndarray
    pressure_moment: np.ndarray
    pressure_elastic: np.ndarray
    quadratic_first: np.ndarray | None = None
    pressure_change: np.ndarray | None = None
    face: LoadedFace | None = None

    def __str__(self) -> str:
        """Return area, and resultants of unit loads."""
        unit, what = ("m", "N/m") if self.kind == "line" else ("m2", "Pa")
        middle = self.first / self.measure if self.measure else self.first
        told = [f"{self.kind} {self.name!r}, {self.measure:.6g} {unit} about {told_vector(middle)} m"]
        if self.has_pressure:
            force, moment = told_vector(self.pressure_force), told_vector(self.pressure_moment)
            told.append(f"1 {what} of pressure: {force} N and {moment} N m about the origin of the mesh frame")
        return "; ".join(told)

    def shaped(
        self, over: Over, nodes: np.ndarray, basis: np.ndarray, label: str = "", component: int | None = None
    ) -> LoadPattern:
        """Return the pattern of a load that varies by a shape, on a body with these nodes (n, 3) and basis Psi (N, K).

        Of three components one is taken. The label of the load is for messages.
        """
        label = label or repr(self.name)
        if self.face is None:
            raise ModelError(
                f"{label} varies by place, and where its facets are is not known: the body is made from matrices, or "
                "it is a line of beams. Remedy: shell_body or solid_body, or a NodalPattern of that load"
            )
        given, count = checked_field(over, nodes, label)
        if count != (1 if component is None else 3):
            raise ModelError(f"over= of {label} gives {count} numbers a place, where one is meant")
        field = PlaceField(given, label, component)
        found = NodalPattern.of_face(self.face, field, self.kind).projected(f"{self.name} (by place)", basis)
        return found

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays by name, for a file."""
        return {name: getattr(self, name) for name in ARRAYS if getattr(self, name) is not None}

    def of_traction(self, traction: np.ndarray, eta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the forces of a uniform traction on translation and rotation of G and on the coordinates.

        Parameters
        ----------
        traction : ndarray, shape (3,)
            Pa (N/m for a line), components in G.
        eta : ndarray, shape (k,)
            The leading coordinates of the body; as many elastic forces are returned.

        Returns
        -------
        force, moment : ndarray, shape (3,)
            N and N m about G's origin, in components of G.
        elastic : ndarray, shape (k,)
        """
        count = len(eta)
        S = self.shape_first[:, :count]
        place = self.first + S @ eta
        if self.quadratic_first is not None:
            bent = self.quadratic_first[:, :count, :count] @ eta
            place, S = place + 0.5 * (bent @ eta), S + bent
        return self.measure * traction, np.cross(place, traction), S.T @ traction

    def of_pressure(
        self, pressure: float, eta: np.ndarray, follows: bool = False
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the forces of a uniform pressure in Pa, as `of_traction`; of one that `follows` the surface."""
        force, moment, elastic = self.pressure_force, self.pressure_moment, self.pressure_elastic[: len(eta)]
        if follows and self.pressure_change is not None:
            change = self.pressure_change[: 6 + len(eta), : len(eta)] @ eta
            force, moment, elastic = force + change[:3], moment + change[3:6], elastic + change[6:]
        return pressure * force, pressure * moment, pressure * elastic


def told_vector(vector: np.ndarray) -> str:
    """Return a vector for a text, without round-off."""
    size = np.abs(vector).max()
    return f"({', '.join(f'{x:.6g}' if abs(x) > 1e-12 * size else '0' for x in vector)})"
