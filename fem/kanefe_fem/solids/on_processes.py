"""Assembly of a solid on a mesh that is spread over several processes; the counterpart of `kanefe_fem.solids.problem`.

The leader reads and checks the mesh, dolfinx spreads its cells, and each process assembles its own rows. Nodes are
numbered as in one process, by spaces on the whole mesh of the leader without matrices, so that the body is the same.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.model import StressStiffness
from kanefe.fe_model.shapes import kind_of_order, shape
from kanefe_fem import _fenicsx
from kanefe_fem.materials.damping import Losses
from kanefe_fem.materials.moduli import Moduli
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.processes.matrices import SharedRows, TeamMatrix, Told
from kanefe_fem.processes.team import Team
from kanefe_fem.solids import forms as solid_forms
from kanefe_fem.solids.problem import SolidProblem, form_of_stress, solid_problem, stiffness_and_mass


class _GivenCells(NamedTuple):
    """The mesh and its material, as the leader has them: the arguments of `assemble`."""

    nodes: np.ndarray
    connectivity: np.ndarray
    moduli: Moduli
    density: np.ndarray


@dataclass(eq=False)
class _Part:
    """What a process keeps: spaces and moduli, the density, and the form of `stress_stiffness` once it is made."""

    problem: SolidProblem
    density: Any
    of_stress: tuple[Any, Any] | None = None


@dataclass(frozen=True, eq=False)
class SharedAssembly:
    """Matrices in the numbering of one process; see `kanefe_fem.solids.problem.Assembly`.

    Attributes
    ----------
    stiffness : TeamMatrix, shape (n d, n d)
    mass : csr_matrix, shape (n, n)
        Scalar mass matrix, on the leader.
    vector_mass : TeamMatrix, shape (n d, n d)
    order_of_nodes : ndarray of int, shape (n,)
    part : int
        The `_Part` in `Team.kept`.
    nodes_of : list of ndarray of int
        Nodes of each process, in its own order: its own ones first, then those of others that its cells have.
    scalar_order : ndarray of int, shape (n,)
        Node of each row of matrices of the scalar space.
    seconds : dict
    versions : dict
    """

    stiffness: TeamMatrix
    mass: sp.csr_matrix
    vector_mass: TeamMatrix
    order_of_nodes: np.ndarray
    part: int
    nodes_of: list[np.ndarray]
    scalar_order: np.ndarray
    seconds: dict[str, float]
    versions: dict[str, str]

    @property
    def stress_stiffness(self) -> StressStiffness:
        """Function of the geometric stiffness of a static displacement."""
        team = self.stiffness.shared.team
        dimension = self.stiffness.shape[0] // len(self.order_of_nodes)

        def geometric_stiffness(displacement: np.ndarray, load: np.ndarray | None = None) -> sp.csr_matrix:
            by_node = displacement.reshape(-1, dimension)
            parts = team.run(_scalar_stress, self.part, own=[by_node[nodes] for nodes in self.nodes_of])
            return sp.kron(_joined(parts, self.scalar_order), sp.identity(dimension), format="csr")

        return geometric_stiffness


def assemble(
    team: Team,
    nodes: np.ndarray,
    connectivity: np.ndarray,
    kind: str,
    *,
    straight: bool,
    moduli: Moduli,
    density: np.ndarray,
    groups: Mapping[str, np.ndarray],
) -> SharedAssembly:
    """Assemble stiffness and mass on all processes of a team.

    Parameters
    ----------
    team : Team
    nodes, connectivity, kind, straight, moduli, density
        Those of `kanefe_fem.solids.problem.assemble`.
    groups : dict of str to ndarray of int
        Nodes of groups of facets, for messages.

    Raises
    ------
    MeshError
        If a node is not on just one process.
    """
    clock = [time.perf_counter()]
    team.run(_loaded)
    fx = _fenicsx.load()
    with _fenicsx.quiet(), _fenicsx.compiling(fx):
        order = solid_problem(fx, nodes, connectivity, kind, straight).order_of_nodes
    clock.append(time.perf_counter())
    given = _GivenCells(nodes, connectivity, moduli, density)
    part, numbers = team.run(_spread, kind, straight, connectivity.shape[1], own=given)
    clock.append(time.perf_counter())
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    nodes_of, owned, scalar_owned = ([place[one] for one in parts] for parts in numbers)
    check_owned(owned, nodes[order], {name: place[one] for name, one in groups.items()})
    number, mass_rows = team.run(_matrices, part)
    scalar_order = np.concatenate(scalar_owned)
    d = shape(kind).dimension
    rows = tuple((d * one[:, None] + np.arange(d)).ravel() for one in owned)
    stiffness = TeamMatrix.of(SharedRows(team, number, rows), Told())
    mass = _joined(mass_rows, scalar_order)
    vector_mass = stiffness.like(sp.kron(mass, sp.identity(d), format="csr"))
    clock.append(time.perf_counter())
    stages = ("number the nodes", "spread the mesh", "assemble")
    return SharedAssembly(
        stiffness=stiffness,
        mass=mass,
        vector_mass=vector_mass,
        order_of_nodes=order,
        part=part,
        nodes_of=nodes_of,
        scalar_order=scalar_order,
        seconds=dict(zip(stages, np.diff(clock).tolist(), strict=True)),
        versions=fx.versions,
    )


def check_owned(owned: Sequence[np.ndarray], nodes: np.ndarray, groups: Mapping[str, np.ndarray]) -> None:
    """Raise a MeshError if a node is not on just one process; it names the groups with such nodes.

    Parameters
    ----------
    owned : sequence of ndarray of int
        Nodes of each process.
    nodes : ndarray, shape (n, 3)
    groups : dict of str to ndarray of int
        Nodes of groups of facets.
    """
    wrong = np.flatnonzero(np.bincount(np.concatenate(owned), minlength=len(nodes)) != 1)
    if len(wrong):
        names = ", ".join(repr(name) for name, one in groups.items() if np.isin(one, wrong).any())
        where = ", ".join(f"{x:.4g}" for x in nodes[wrong[0]])
        raise MeshError(
            f"{len(wrong)} nodes are on no process or on several, among them node {wrong[0]} at ({where}) m"
            f"{f', and nodes of {names}' if names else ''}. Remedy: fewer processes, or none"
        )


def nodes_of_facets(mesh: Mesh) -> dict[str, np.ndarray]:
    """Return the nodes of each group of facets."""
    return {
        name: np.unique(np.concatenate([block.nodes.ravel() for block in blocks]))
        for name, blocks in mesh.facets.items()
    }


def refuse_assembly(mesh: Mesh, losses: Sequence[Losses]) -> None:
    """Raise an error for cells that dolfinx does not assemble, and for damping of materials."""
    if mesh.kind not in _fenicsx.SHAPES or len(mesh.kinds) > 1:
        raise MeshError(
            f"{mesh.source} has cells of {' and '.join(mesh.kinds)}, which are assembled by one process only. Remedy: "
            f"cells of one of these shapes ({', '.join(_fenicsx.SHAPES)}), or leave out comm="
        )
    if any(own.are_there for own in losses):
        raise ModelError(
            "on several processes this is not possible: damping of materials, which has matrices of its own. Remedy: "
            "damping=kf.ModalDamping(...) of the body instead, or leave comm= out"
        )


def refuse_one_process(of_model: Mapping[str, Any], of_body: Mapping[str, Any]) -> None:
    """Raise a ModelError for what only one process does, with the reason."""
    refused = {
        "reduction=None keeps all of K, in one process": of_body["reduction"] is None,
        "preload= changes K after it was assembled": of_model["preload"] is not None,
        "forms= adds matrices of its own": of_model["forms"] is not None,
        "lumped= adds entries to K and M": bool(of_model["lumped"]),
    }
    for reason, is_asked in refused.items():
        if is_asked:
            raise ModelError(f"on several processes this is not possible: {reason}. Remedy: leave it or comm= out")


def _loaded(team: Team, own: None) -> None:
    """Import FEniCSx on all processes at once: PETSc waits for the others when it starts."""
    _fenicsx.load()


def _spread(
    team: Team, own: _GivenCells | None, kind: str, straight: bool, width: int
) -> tuple[int, list[list[np.ndarray]]]:
    """Spread the mesh; keep the `_Part`, and return nodes of each process: all, its own, and those of scalar rows."""
    fx = SimpleNamespace(**{**vars(_fenicsx.load()), "comm": team.comm})
    nodes, table = (np.zeros((0, 3)), np.zeros((0, width), np.int64)) if own is None else (own.nodes, own.connectivity)
    element = shape(kind)
    geometry = shape(kind_of_order(kind, 1)) if straight else element
    with _fenicsx.quiet(), _fenicsx.compiling(fx):
        mesh = _fenicsx.create_mesh(fx, nodes, table, geometry)
        original = team.collect(np.asarray(mesh.topology.original_cell_index))
        cells = team.deal(None if own is None else [table[one] for one in original])
        vector = _fenicsx.lagrange_space(fx, mesh, element, element.dimension)
        scalar = _fenicsx.lagrange_space(fx, mesh, element, 0)
        numbering, of_scalar = (_fenicsx.node_of_dof(fx, one, cells, element) for one in (vector, scalar))
        if own is not None:
            _fenicsx.check_numbering(vector, nodes, numbering)
        table_of = None if own is None else [*solid_forms.values_of(own.moduli, np.arange(len(table))), own.density]
        values = [
            team.deal(None if table_of is None else [table_of[i][one] for one in original])
            for i in range(team.comm.bcast(None if table_of is None else len(table_of)))
        ]
        functions = [_fenicsx.cell_function(fx, mesh, one) for one in values]
    fields_of = solid_forms.MaterialFields(tuple(functions[:-1]))
    problem = SolidProblem(fx, mesh, vector, scalar, fields_of, element, geometry, numbering, None)
    part = team.keep(_Part(problem, functions[-1]))
    local = (numbering, numbering[: _owned(vector)], of_scalar[: _owned(scalar)])
    return part, [team.collect(one) for one in local]


def _owned(space: Any) -> int:
    return int(space.dofmap.index_map.size_local)


def _matrices(team: Team, own: None, part: int) -> tuple[int, list[Any]]:
    """Assemble; keep the stiffness, and return the rows of the scalar mass."""
    held: _Part = team.kept[part]
    problem, fx = held.problem, held.problem.fx
    with _fenicsx.quiet(), _fenicsx.compiling(fx):
        forms = stiffness_and_mass(problem, held.density)
        kept = [_fenicsx.assemble_rows(fx, [fx.fem.form(form)]) for form in forms]
    return team.keep(kept[0]), _collected(team, kept[1])


def _collected(team: Team, matrix: Any) -> list[Any]:
    """Return the rows of each process, of a matrix of dolfinx, as (starts, columns, values)."""
    arrays = [np.array(one) for one in matrix.getValuesCSR()]
    matrix.destroy()
    return list(zip(*(team.collect(one) for one in arrays), strict=True))


def _joined(parts: list[Any], order: np.ndarray) -> sp.csr_matrix:
    """Return the scalar matrix of all nodes, from the rows of each process."""
    blocks = [sp.csr_matrix((v, c, s), (len(s) - 1, len(order))) for s, c, v in parts]
    whole = sp.vstack(blocks, format="csr")
    back = np.argsort(order)
    found = whole[back][:, back]
    found.sort_indices()
    return found


def _scalar_stress(team: Team, own: list[np.ndarray] | None, part: int) -> list[Any]:
    """Return the rows of ``int grad(p) . s grad(q)`` of the stress of a displacement, given by nodes of processes."""
    held: _Part = team.kept[part]
    u = team.deal(own)
    with _fenicsx.quiet(), _fenicsx.compiling(held.problem.fx):
        held.of_stress = held.of_stress or form_of_stress(held.problem)
        loaded, form = held.of_stress
        loaded.x.array[:] = u.ravel()
        matrix = _fenicsx.assemble_rows(held.problem.fx, [form])
    return _collected(team, matrix)
