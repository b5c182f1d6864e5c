"""Statics of a body tied at its interfaces: one factorisation serves constraint modes, normal modes and load cases.

Tied coordinates are the interior degrees of freedom followed by the components of the interface frames. K of the
interior, with all interfaces held, is factored once; interfaces that are free are solved for by the Schur complement.
A body without a fixed interface floats: its loads are balanced by the inertia of its rigid motion (inertia relief).
Where the stiffness is singular, the message names the nodes of the mechanism or loose part.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from kanefe.errors import ModelError, SingularStiffness
from kanefe.fe_model.factorise import Factorisation, Factorise, NothingInside, factor_interior
from kanefe.fe_model.model import ROTATIONS, FiniteElementModel
from kanefe.fe_model.progress import stage
from kanefe.fe_model.residuals import largest_residual
from kanefe.fe_model.ties import InterfaceTies
from kanefe.frames import Vector
from kanefe.storage.unfinished import keep, kept


class StaticProblem:
    """K and M of a body in tied coordinates, and static solutions.

    Parameters
    ----------
    model : FiniteElementModel
    ties : InterfaceTies
    rigid_count : int
        Number of rigid motions that the fixed interfaces leave: all (6, or 3 in a plane) of a floating body, else none.
    factorise : Factorise
        Also used for the other matrices of a reduction. If it has a function `by_motion` of the motion of the nodes
        from the coordinates of K, (N, n), that one returns the `Factorise` of this K.

    Attributes
    ----------
    stiffness, mass : csr_matrix, shape (tied, tied)
    interior, boundary : ndarray of int
        Tied coordinates of the interior and of the interface components.
    fixed, released : ndarray of int
        Those of the boundary that are fixed in G, and the others.
    residuals : dict of str to float
        The largest of the solutions that were checked, by their name: see `kanefe.fe_model.residuals`.
    """

    def __init__(self, model: FiniteElementModel, ties: InterfaceTies, rigid_count: int, factorise: Factorise) -> None:
        self.model, self.ties, self.rigid_count = model, ties, rigid_count
        self.factorise = factorise
        self.residuals: dict[str, float] = {}
        self.stiffness, self.mass = ties.project(model.stiffness), ties.project(model.mass)
        self.interior = np.arange(ties.interior_count)
        self.boundary = np.arange(ties.interior_count, self.size)
        self.fixed = ties.fixed
        self.released = np.setdiff1d(self.boundary, self.fixed)

    def note_residual(self, name: str, residual: float) -> None:
        """Note the residual of solutions, the largest of all of a name."""
        self.residuals[name] = max(residual, self.residuals.get(name, 0.0))

    @property
    def size(self) -> int:
        """Number of tied coordinates."""
        return int(self.stiffness.shape[0])

    @property
    def interior_stiffness(self) -> sp.csc_matrix:
        """K of the interior; not stored, since only its factors are needed."""
        return self.stiffness[: self.ties.interior_count, : self.ties.interior_count].T  # symmetric: nothing is moved

    @cached_property
    def interior_mass(self) -> sp.csc_matrix:
        """M of the interior."""
        return self.mass[: self.ties.interior_count, : self.ties.interior_count].T

    @cached_property
    def largest_masses(self) -> Vector:
        """Mass that a unit of each tied coordinate moves at most, kg and kg m2: what has next to none of it has none.

        Rotations are compared with translations over the size of the body, so that its units and size do not count;
        generalised coordinates with their own.
        """
        model = self.model
        size = float(np.ptp(model.nodes, axis=0).max()) or 1.0
        squares = np.tile(np.where(np.isin(model.components, ROTATIONS), size**2, 1.0), len(model.nodes))
        inner = self.ties.transformation[: model.nodal_size, : self.ties.interior_count]
        frames = [component for tie in self.ties.ties for component in tie.components]
        lengths = np.concatenate((inner.power(2).T @ squares, np.where(np.array(frames) < 3, 1.0, size**2)))
        masses, moving = self.mass.diagonal(), lengths > 0.0
        found = (masses[moving] / lengths[moving]).max(initial=0.0) * lengths
        found[~moving] = masses[~moving]
        return np.where(found > 0.0, found, found.max(initial=0.0) or 1.0)

    @cached_property
    def held_interior(self) -> np.ndarray:
        """Interior coordinates that are not held for the factorisation of K: all, if there is an interface.

        Without one, as many are held as the body has rigid motions, so that just these are prevented: a load in
        balance has no reaction there.
        """
        if len(self.boundary):
            return self.interior
        return np.setdiff1d(self.interior, _pivots(np.hstack((self.rigid_modes, self.massless_motions))))

    @cached_property
    def factors(self) -> Factorisation:
        """Factors of K of the `held_interior`, made at the first use."""
        if not len(self.interior) and len(self.released):
            return NothingInside()
        K, moving = self.interior_stiffness, self.held_interior
        K = K if len(moving) == K.shape[0] else K[moving][:, moving].tocsc()
        with stage("factor the stiffness"):
            try:
                return factor_interior(K, self._factorise_of(moving))
            except SingularStiffness as error:
                motion = self.ties.transformation[:, moving]
                raise SingularStiffness(f"{error}{moving_nodes(self.model, motion, K, self.factorise)}") from error

    def _factorise_of(self, moving: np.ndarray) -> Factorise:
        """Return the function that factors K of some coordinates, which may use how these move the nodes."""
        by_motion = getattr(self.factorise, "by_motion", None)
        return self.factorise if by_motion is None else by_motion(self.ties.transformation[:, moving])

    @cached_property
    def constraint_modes(self) -> np.ndarray:
        """Static shapes of unit motion of each interface component, all others held, shape (tied, boundary)."""
        return self._constraints[0]

    @cached_property
    def _constraints(self) -> tuple[np.ndarray, np.ndarray]:
        """The constraint modes, and K times them."""
        modes = np.zeros((self.size, len(self.boundary)))
        if not len(self.boundary):
            return modes, modes
        factors = self.factors
        with stage("constraint modes"):
            inner = self.ties.interior_count
            loads = -self.stiffness[:inner, inner:].toarray()
            name = f"{len(self.boundary)} constraint modes of {inner}"
            found = kept(name)
            modes[:inner] = factors.solve(loads) if found is None else found["modes"]
            keep(name, modes=modes[:inner])
            modes[self.boundary] = np.eye(len(self.boundary))
            modes[:inner] += self._left_of_rigid(modes)
            forces = self.stiffness @ modes
            reached = forces[:inner] + loads
            self.note_residual("constraint modes", largest_residual("constraint mode", reached, loads))
        return modes, forces

    def _left_of_rigid(self, modes: np.ndarray) -> np.ndarray:
        """Return what the interior of constraint modes lacks so that a floating body moves rigidly with its frames.

        This is known exactly; otherwise the errors of a solver remain where rigid motions are taken out.
        """
        if not self.rigid_count:
            return np.zeros((1, 1))
        inner = self.ties.interior_count
        rigid = self.ties.coordinates(self.model.unit_rigid_modes()[0])
        rigid /= np.linalg.norm(rigid[inner:], axis=0)
        return np.asarray((rigid[:inner] - modes[:inner] @ rigid[inner:]) @ np.linalg.pinv(rigid[inner:]))

    @property
    def rigid_modes(self) -> np.ndarray:
        """M-orthonormal rigid motions of a floating body in tied coordinates, shape (tied, r); r <= rigid_count."""
        return self._rigid_by_mass[0]

    @property
    def massless_motions(self) -> np.ndarray:
        """Rigid motions without mass, such as the turn of a bar of lumped masses about itself, (tied, rigid_count - r).

        They are unit columns.
        """
        return self._rigid_by_mass[1]

    @cached_property
    def gauge(self) -> np.ndarray:
        """Tied coordinates that are held so that `massless_motions` are prevented, as many as there are of these."""
        return _pivots(self.massless_motions)

    @cached_property
    def _rigid_by_mass(self) -> tuple[np.ndarray, np.ndarray]:
        if not self.rigid_count:
            return np.zeros((self.size, 0)), np.zeros((self.size, 0))
        about = self.model.nodes.mean(axis=0)
        motions = self.ties.coordinates(self.model.rigid_modes(about=about))
        weights = np.sqrt(self.largest_masses)[:, None]
        size = np.linalg.norm(weights * motions, axis=0)
        kept = size > 1e-12 * size.max()
        motions = motions[:, kept] / size[kept]
        gram = motions.T @ (self.mass @ motions)
        scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), NO_MASS * np.diag(gram).max()))
        squares, vectors = scipy.linalg.eigh(gram * np.outer(scale, scale))
        kept = squares > 1e-10
        massive = motions @ (scale[:, None] * vectors[:, kept] / np.sqrt(squares[kept]))
        directions = scale[:, None] * vectors[:, ~kept]
        others = motions @ (directions / np.linalg.norm(directions, axis=0))
        # nodes on a line do not define the rotation about it: zero
        others = others[:, np.linalg.norm(weights * others, axis=0) > 1e-6]
        return np.asarray(massive), np.asarray(others / np.linalg.norm(others, axis=0))

    def relieved(self, f: np.ndarray) -> np.ndarray:
        """Return loads (tied, m) of a floating body balanced by the inertia of its rigid motion; others unchanged."""
        R = self.rigid_modes
        return f - self.mass @ (R @ (R.T @ f)) if R.shape[1] else f

    def solve(self, f: np.ndarray) -> np.ndarray:
        """Return the static displacements of load cases.

        Parameters
        ----------
        f : ndarray, shape (tied, m)
            Forces on the tied coordinates, N and N m.

        Returns
        -------
        ndarray, shape (tied, m)
            With the fixed components held and the released ones free. For a floating body: under the loads balanced by
            inertia, and M-orthogonal to its rigid motions.
        """
        if not self.rigid_count:
            return self._solve_held(f)
        R, f = self.rigid_modes, self.relieved(f)
        u = self._solve_held(f) if len(self.boundary) else self._solve_free(f)
        return np.asarray(u - R @ (R.T @ (self.mass @ u)))

    def checked_solution(self, f: np.ndarray, what: str) -> np.ndarray:
        """Return `solve` of load cases, with the residual noted; `what` names one of them in the plural with an s."""
        u = self.solve(f)
        moving = np.delete(np.arange(self.size), self.fixed)
        reached, asked = (self.stiffness @ u)[moving], self.relieved(f)[moving]

        def solve(left: np.ndarray) -> np.ndarray:
            forces = np.zeros((self.size, left.shape[1]))
            forces[moving] = left
            return np.asarray(self.solve(forces)[moving])

        self.note_residual(f"{what}s", largest_residual(what, reached, asked, moved=(u[moving], solve)))
        return u

    @cached_property
    def _schur_inverse(self) -> np.ndarray:
        """(Pseudo-)inverse of the stiffness of the released components, shape (released, released)."""
        modes, forces = (part[:, self.released - self.ties.interior_count] for part in self._constraints)
        S = modes.T @ forces
        if not len(S):
            return S
        scale = np.sqrt(np.abs(np.diag(S)))  # translations and rotations differ by squares of lengths
        scale = 1.0 / np.where(scale > 0.0, scale, 1.0)
        squares, vectors = scipy.linalg.eigh(0.5 * (S + S.T) * np.outer(scale, scale))
        vectors = scale[:, None] * vectors
        kept = np.arange(len(squares)) >= self.rigid_count  # ascending: the rigid motions come first
        if squares[kept].min(initial=np.inf) <= 1e-14 * squares.max():
            raise ModelError(
                "the interfaces can move without any force: the body is a mechanism. Remedy: check the mesh for loose "
                "parts or hinges, or fix more components of an interface"
            )
        return np.asarray((vectors[:, kept] / squares[kept]) @ vectors[:, kept].T)

    def _solve_held(self, f: np.ndarray) -> np.ndarray:
        """Solve with the released components free."""
        modes = self.constraint_modes[:, self.released - self.ties.interior_count]
        u = np.zeros(f.shape)
        u[self.interior] = self.factors.solve(f[self.interior])
        return np.asarray(u + modes @ (self._schur_inverse @ (modes.T @ f)))

    def _solve_free(self, f: np.ndarray) -> np.ndarray:
        """Solve for loads in balance on a body without interfaces."""
        u = np.zeros(f.shape)
        u[self.held_interior] = self.factors.solve(f[self.held_interior])
        return u


NO_MASS = 1e-18
"""Mass of a coordinate or a rigid motion, relative to the largest, below which it counts as zero."""

SHIFT = 1e-9
"""Fraction of its diagonal that is added to a singular K so that it can be factored."""

SOFT = 1e-7
"""Stiffness along a motion, relative to the diagonal of K, below which it counts as zero."""

NAMED = 4
"""Largest number of nodes listed in a message."""


def _pivots(motions: np.ndarray) -> np.ndarray:
    """Return rows, as many as there are columns, that determine the amplitudes of independent motions."""
    if not motions.shape[1]:
        return np.zeros(0, dtype=int)
    _, _, order = scipy.linalg.qr(motions.T, mode="economic", pivoting=True)
    return np.asarray(order[: motions.shape[1]])


def moving_nodes(model: FiniteElementModel, motion: sp.csr_matrix, K: sp.csc_matrix, factorise: Factorise) -> str:
    """Return a sentence on the nodes that move without force, or an empty string if none is found.

    Parameters
    ----------
    model : FiniteElementModel
    motion : csr_matrix, shape (N, n)
        Motion of the model's degrees of freedom from the coordinates of K.
    K : csc_matrix, shape (n, n)
        Singular stiffness.
    factorise : Factorise
    """
    weights = np.abs(K.diagonal())
    weights[weights <= SHIFT * weights.max(initial=0.0)] = weights.mean() or 1.0
    try:
        factors = factorise((K + sp.diags(SHIFT * weights)).tocsc())
    except (ModelError, RuntimeError):
        return ""
    x = np.random.default_rng(0).standard_normal(K.shape[0])
    for _ in range(5):  # inverse iteration, in which stiff motions grow less by the factor SHIFT each time
        x = factors.solve(weights * x)
        x /= np.sqrt(x @ (weights * x))
    if not x @ (K @ x) < SOFT:
        return ""
    moved = np.linalg.norm((motion @ x)[: model.nodal_size].reshape(len(model.nodes), -1), axis=1)
    order = np.argsort(-moved, kind="stable")
    count = int(np.count_nonzero(moved > 0.5 * moved.max()))
    places = (
        f"{node} at ({', '.join(f'{c:.4g}' for c in model.nodes[node])}) m" for node in order[: min(count, NAMED)]
    )
    which = "it is" if count == 1 else f"{count} nodes, among them" if count > NAMED else "they are"
    return f". What moves without force: {which} node {', node '.join(places)}"
