"""Added mass of a fluid around a body by potential flow: Laplace's equation on a mesh of the fluid.

The velocity ``grad phi`` of a fluid at rest far away, without density changes and friction, follows the body's surface:

    div grad phi = 0,   d phi/dn = w . n  on the wet surface,   T = 1/2 rho int grad phi . grad phi dx

With the shape functions of the mesh, ``L phi = B w`` for the velocities w of the nodes of the wet surface, and the
added mass is ``A = rho B^T L^-1 B`` (Zienkiewicz & Taylor, The Finite Element Method, vol. 1, ch. 19). Where the mesh
of the fluid ends, the flow is that of a dipole at a centre, ``d phi/dn = -(d - 1) phi/r`` in d dimensions: exact for a
sphere, and for other bodies that keep their volume in the limit of a large mesh. A free surface that has no time to
form waves has ``phi = 0``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.sparse as sp
import scipy.spatial

from kanefe.arguments import checked, positive
from kanefe.errors import ModelError
from kanefe.fe_model.factorise import Factorise
from kanefe.fe_model.model import FiniteElementModel
from kanefe.frames import shaped_numbers
from kanefe_fem import _fenicsx
from kanefe_fem.materials.voigt import check_density
from kanefe_fem.mesh.checks import in_plane, is_straight
from kanefe_fem.mesh.mesh import Mesh, to_order
from kanefe_fem.mesh.surfaces import check_surfaces
from kanefe_fem.mesh_files import read_to_assemble
from kanefe_fem.solids.measures import measures
from kanefe_fem.solids.problem import SolidProblem, solid_problem

MOST_WET = 2000
"""Number of wet nodes above which the added mass, full between all of them, would take more than half a gigabyte."""

AT_ONCE = 200
"""Number of right-hand sides that are solved together."""

DEGREE = 6
"""Degree of the quadratures: exact for two quadratic functions on straight simplices and boxes, with a normal."""

SAME = 1e-6
"""Distance of wet nodes from those of the body, relative to its size, below which they are the same."""


@checked("mesh", "wet", "free", "far", "cells")
@dataclass(frozen=True, eq=False)
class PotentialFlow:
    """Fluid around a body, whose added mass is that of its potential flow; for `Forms`.

    Parameters
    ----------
    mesh : Mesh, str or Path
        Mesh of the fluid, in m. Its nodes on the wet surface must be those of the body: mesh both together, and
        choose by ``cells``.
    wet : str
        Group of facets where the fluid follows the body.
    density : float
        kg/m3.
    far : sequence of str
        Groups of facets where the mesh ends in open water.
    free : sequence of str
        Groups of facets of a free surface. All other facets are walls or planes of symmetry.
    center : array_like, shape (3,)
        About the middle of the body, for `far`, m.
    cells : str or sequence of str, optional
        Groups of cells that are fluid. Default: all.
    thickness : float, optional
        Of a plane body, m.

    Raises
    ------
    ModelError
        If no facets are far or free, so that the fluid could not give way.

    Examples
    --------
    >>> from kanefe_fem.solids.own_forms import Forms
    >>> water = PotentialFlow("hull.msh", "skin", 1000.0, far=["outside"], cells="water")   # doctest: +SKIP
    >>> forms = Forms(added_mass=water)                                                     # doctest: +SKIP
    """

    mesh: Mesh | str | Path
    wet: str
    density: float = 1000.0
    far: Sequence[str] = ()
    free: Sequence[str] = ()
    center: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0)
    cells: str | Sequence[str] | None = None
    thickness: float = 1.0

    def __post_init__(self) -> None:
        check_density("density of the fluid", self.density)
        positive(self.thickness, "thickness of a potential flow")
        center = shaped_numbers(self.center, (3,), "the center of a potential flow")
        object.__setattr__(self, "center", tuple(center.tolist()))
        if isinstance(self.far, str) or isinstance(self.free, str) or not (self.far or self.free):
            raise ModelError(
                "a fluid that is closed in cannot give way to a body. Remedy: far=[...] or free=[...], names of groups "
                "of facets of its mesh where the water is open"
            )


def added_mass_of_flow(flow: PotentialFlow, model: FiniteElementModel, factorise: Factorise) -> sp.csr_matrix:
    """Return the added mass of a body's degrees of freedom, shape (N, N) in kg.

    Raises
    ------
    ModelError, MeshError
        If the wet nodes are not nodes of the body, or are too many.
    """
    mesh = _read(flow)
    fx = _fenicsx.load()
    with _fenicsx.quiet(), _fenicsx.compiling(fx):
        problem = solid_problem(fx, np.asarray(mesh.nodes), mesh.connectivity, mesh.kind, is_straight(mesh))
        L, B, wet = _matrices(flow, problem, mesh)
    on_body = _nodes_of_body(flow, model, np.asarray(mesh.nodes)[problem.order_of_nodes[wet]])
    d = problem.element.dimension
    width, size = len(model.components), len(wet)
    inverse = np.empty((size, size))
    factors = factorise(sp.csc_matrix(L))
    for first in range(0, size, AT_ONCE):
        chosen = wet[first : first + AT_ONCE]
        unit = np.zeros((L.shape[0], len(chosen)))
        unit[chosen, range(len(chosen))] = 1.0
        inverse[:, first : first + AT_ONCE] = factors.solve(unit)[wet]
    blocks = [[flow.density * flow.thickness * (b.T @ (inverse @ a.toarray())) for a in B] for b in B]
    whole = np.moveaxis(np.array(blocks), (0, 1, 2, 3), (1, 3, 0, 2)).reshape(size * d, size * d)
    rows = (on_body[:, None] * width + np.arange(d)).ravel()
    place = sp.csr_matrix((np.ones(len(rows)), (np.arange(len(rows)), rows)), (len(rows), model.size))
    return sp.csr_matrix(place.T @ sp.csr_matrix(whole) @ place)


def _read(flow: PotentialFlow) -> Mesh:
    mesh = to_order(read_to_assemble(flow.mesh, 2, flow.cells), 2)
    if mesh.dimension == 2:
        mesh = in_plane(mesh)
    if mesh.kind not in _fenicsx.SHAPES or len(mesh.kinds) > 1:
        raise ModelError(
            f"{mesh.source}: the cells of the fluid are {', '.join(mesh.kinds)}. Remedy: cells of one shape among "
            f"{', '.join(_fenicsx.SHAPES)}"
        )
    check_surfaces(mesh, [flow.wet, *flow.far, *flow.free])
    return mesh


def _matrices(
    flow: PotentialFlow, problem: SolidProblem, mesh: Mesh
) -> tuple[sp.csr_matrix, list[sp.csr_matrix], np.ndarray]:
    """Return L, the matrices ``int n_i p q`` of the wet nodes for each direction i, and the wet nodes."""
    fx, ufl = problem.fx, problem.fx.ufl
    p, q = ufl.TrialFunction(problem.scalar), ufl.TestFunction(problem.scalar)
    n, d = ufl.FacetNormal(problem.mesh), problem.element.dimension
    _, ds = measures(problem, mesh)
    arm = ufl.SpatialCoordinate(problem.mesh) - ufl.as_vector([float(c) for c in tuple(flow.center)[:d]])
    form = ufl.inner(ufl.grad(p), ufl.grad(q)) * problem.measure(DEGREE)
    for name in flow.far:
        form += (d - 1) * ufl.dot(arm, n) / ufl.dot(arm, arm) * p * q * ds(name)(degree=DEGREE)
    L = problem.scalar_matrix(fx.fem.form(form))
    whole = [problem.scalar_matrix(fx.fem.form(n[i] * p * q * ds(flow.wet)(degree=DEGREE))) for i in range(d)]
    wet = np.flatnonzero(sum(abs(b).diagonal() for b in whole) > 0.0)
    if len(wet) > MOST_WET:
        raise ModelError(
            f"the surface {flow.wet!r} has {len(wet)} nodes, and the added mass is full between all of them. "
            f"Remedy: a coarser mesh, with at most {MOST_WET}"
        )
    place = np.full(len(problem.order_of_nodes), -1)
    place[problem.order_of_nodes] = np.arange(len(place))
    open_nodes = [block.nodes.ravel() for name in flow.free for block in mesh.facets[name]]
    held = place[np.unique(np.concatenate(open_nodes))] if open_nodes else np.zeros(0, dtype=int)
    keep = np.ones(L.shape[0])
    keep[held] = 0.0
    L = sp.diags(keep) @ L @ sp.diags(keep) + sp.diags(1.0 - keep)  # phi = 0 at a free surface
    whole = [sp.diags(keep) @ b for b in whole]
    return sp.csr_matrix(L), [sp.csr_matrix(b)[wet][:, wet] for b in whole], wet


def _nodes_of_body(flow: PotentialFlow, model: FiniteElementModel, points: np.ndarray) -> np.ndarray:
    """Return the node of the body at each wet node of the fluid."""
    size = float(np.ptp(model.nodes, axis=0).max()) or 1.0
    distance, node = scipy.spatial.cKDTree(model.nodes).query(points)
    if distance.max() > SAME * size:
        raise ModelError(
            f"{np.count_nonzero(distance > SAME * size)} of {len(points)} nodes of the wet surface {flow.wet!r} "
            f"are not nodes of the body (up to {distance.max():.2g} m off). Remedy: mesh body and fluid together, "
            "and an order of 2 of the body"
        )
    return np.asarray(node)
