"""Models from matrices whose rows are identified by node label and number of the degree of freedom (1 to 6).

Exporting programs identify degrees of freedom in this way. They may leave out empty rows, write one triangle, skip
labels, and use local axes at nodes; here this is converted to the regular nodes x components of a `FiniteElementModel`
in the axes of G and in m, kg, s.

Rotations without stiffness, as of the nodes of solids beside beams and shells, follow their neighbourhood
(`kanefe.imports.following`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS, FiniteElementModel, MassField
from kanefe.frames import numbers
from kanefe.imports.following import with_following_rotations
from kanefe.imports.from_matrices import BesideMatrices, model_from_matrices
from kanefe.imports.nodal_inertia import NodalInertia, inertia_of_nodes
from kanefe.imports.node_table import NodeTable
from kanefe.imports.rigid_parts import LabelledField
from kanefe.imports.self_check import Expected
from kanefe.imports.units import Units, in_si, scales

GENERALISED = 0
"""Degree of freedom number of a label that is not a node, but a generalised coordinate of a superelement."""

GENERALISED_BY_NODE = 20
"""Offset of the degree of freedom numbers of a node that carries generalised coordinates instead of components."""

OTHER_FREEDOMS = {7: "warping", 8: "pressure", 9: "potential", 11: "temperature"}
"""Meaning of the degree of freedom numbers that are not motions of a node."""

SUPPORT = 1e20
"""Diagonal entry, relative to the median, above which it indicates a support in an exported matrix."""


@dataclass(frozen=True, eq=False)
class LabelledMatrix:
    """A symmetric matrix between named degrees of freedom.

    Attributes
    ----------
    freedoms : ndarray of int, shape (N, 2)
        Node label and number (1..6: x, y, z, rx, ry, rz; 0 or at least 20: a generalised coordinate) of every row;
        each pair once.
    matrix : csr_matrix, shape (N, N)
    """

    freedoms: np.ndarray
    matrix: sp.csr_matrix

    @classmethod
    def of_entries(cls, rows: np.ndarray, columns: np.ndarray, values: np.ndarray) -> LabelledMatrix:
        """Return the matrix of entries between (label, number) pairs, shape (e, 2) each, of one or both triangles.

        Raises
        ------
        ModelError
            If an entry is there twice.
        """
        codes, places = np.unique(_codes(np.concatenate((rows, columns)).astype(np.int64)), return_inverse=True)
        freedoms = np.column_stack(np.divmod(codes, 64))
        i, j = places[: len(rows)], places[len(rows) :]
        twice = repeated_entry(i, j)
        if twice is not None:
            raise ModelError(
                f"the entry of {rows[twice].astype(int).tolist()} and {columns[twice].astype(int).tolist()} (node and "
                f"freedom) is there twice, again as entry {twice + 1}. Remedy: export it again"
            )
        matrix = sp.csr_matrix((values, (i, j)), (len(freedoms), len(freedoms)))
        return cls(freedoms, mirrored(matrix))


def repeated_entry(rows: np.ndarray, columns: np.ndarray) -> int | None:
    """Return the first entry whose row and column are those of one before it, None if there is none."""
    codes = rows.astype(np.int64) * (int(columns.max(initial=0)) + 1) + columns
    _, first = np.unique(codes, return_index=True)
    if len(first) == len(codes):
        return None
    is_first = np.zeros(len(codes), dtype=bool)
    is_first[first] = True
    return int(np.flatnonzero(~is_first)[0])


def mirrored(matrix: sp.spmatrix) -> sp.csr_matrix:
    """Return the full symmetric matrix: entries without a mirror image are mirrored.

    Files contain both triangles, or one in the order of their program, which need not be a triangle here.
    """
    given = sp.csr_matrix(matrix, dtype=float)
    pattern = sp.csr_matrix((np.ones(given.nnz), given.indices, given.indptr), given.shape)
    other = given.T.tocsr()
    return (given + other - other.multiply(pattern)).tocsr()


def model_of_labelled(
    matrices: Mapping[str, LabelledMatrix],
    nodes: NodeTable,
    *,
    groups: Mapping[str, int | Sequence[int]] | None,
    units: Units,
    expected: Expected,
    source: str,
    field: LabelledField | None = None,
) -> FiniteElementModel:
    """Return the checked model of labelled matrices.

    Parameters
    ----------
    matrices : dict of LabelledMatrix
        "mass", "stiffness" and perhaps "damping".
    nodes : NodeTable
        It must contain the nodes of the matrices.
    groups : dict of str to labels, optional
        In addition to the sets of the table.
    units : str or (float, float)
        Units of the matrices and nodes.
    expected : Expected
        In SI units.
    source : str
        For provenance and messages.
    field : LabelledField, optional
        Mass points of a superelement, for exact inertia.

    Raises
    ------
    ModelError
        If a degree of freedom is not a motion of a node, a node has no position or no translations, the matrices
        include a support, or the self-check fails.
    """
    lacking = {"mass", "stiffness"} - set(matrices)
    if lacking:
        raise ModelError(f"{source} holds no {' and no '.join(sorted(lacking))} matrix. Remedy: export both")
    for what, labelled in matrices.items():
        _check_freedoms(f"the {what} matrix of {source}", labelled)
    freedoms = np.unique(np.concatenate([m.freedoms for m in matrices.values()]), axis=0)
    is_modal = is_generalised(freedoms[:, 1])
    modal, freedoms = _codes(freedoms[is_modal]), freedoms[~is_modal]
    labels = np.unique(freedoms[:, 0])
    if not len(labels):
        raise ModelError(
            f"the matrices of {source} have generalised coordinates only. Remedy: export those of nodes too"
        )
    points = nodes.points[nodes.places(labels, f"the matrices of {source}")] * scales(units)[0]
    place = _placement(matrices, nodes, labels, np.unique(freedoms[:, 1]), modal)
    components = tuple(COMPONENTS[n - 1] for n in place.numbers[place.kept])
    placed = {what: in_si(place.of_matrix(m), components, units, len(modal)) for what, m in matrices.items()}
    follows = with_following_rotations(points, components, placed, labels)
    beside: BesideMatrices = {**expected}
    if field is not None:
        beside["mass_field"] = _mass_field(field, place, components, units, follows.carried)
    elif follows.directions.shape[0] and not len(modal):
        beside["mass_field"] = _inertia_before(placed, points, components, follows.carried)
    model = model_from_matrices(
        follows.matrices["mass"],
        follows.matrices["stiffness"],
        points,
        components=components,
        damping=follows.matrices.get("damping"),
        groups=_groups(nodes, groups, labels),
        generalised=len(modal),
        source=source,
        **beside,
    )
    return replace(
        model,
        following=follows.directions if follows.directions.shape[0] else None,
        provenance={**model.provenance, "units": str(units), "following_rotations": follows.directions.shape[0]},
    )


def _inertia_before(
    matrices: Mapping[str, sp.csr_matrix], points: np.ndarray, components: tuple[str, ...], carried: sp.csr_matrix
) -> NodalInertia:
    """Return the inertia of matrices before turns were made to follow: they are those of elements."""
    own = inertia_of_nodes(matrices["stiffness"], matrices["mass"], points, components)
    return own._replace(field=_moved(own.field, carried))


class _Placement(NamedTuple):
    """Where labelled rows are among those of a model: of all nodes, then of generalised coordinates.

    Attributes
    ----------
    labels, numbers, modal : ndarray of int
        Nodes, their numbers, and codes of generalised coordinates.
    turn : csr_matrix or None
        From components in the axes of the nodes to those of G.
    kept : ndarray of int
        Which of the numbers the model has.
    """

    labels: np.ndarray
    numbers: np.ndarray
    modal: np.ndarray
    turn: sp.csr_matrix | None
    kept: np.ndarray

    def of_rows(self, freedoms: np.ndarray) -> sp.csr_matrix:
        """Return the matrix that takes forces on labelled rows to those on the rows of the model."""
        spread = _spread(freedoms, self.labels, self.numbers, self.modal)
        turned = spread if self.turn is None else self.turn @ spread
        nodal = len(self.labels) * len(self.numbers)
        rows = (np.arange(len(self.labels))[:, None] * len(self.numbers) + self.kept).ravel()
        return turned.tocsr()[np.append(rows, np.arange(nodal, turned.shape[0]))]

    def of_matrix(self, labelled: LabelledMatrix) -> sp.csr_matrix:
        """Return a labelled matrix over the rows of the model."""
        to_model = self.of_rows(labelled.freedoms)
        return (to_model @ labelled.matrix @ to_model.T).tocsr()


def _placement(
    matrices: Mapping[str, LabelledMatrix], nodes: NodeTable, labels: np.ndarray, numbers: np.ndarray, modal: np.ndarray
) -> _Placement:
    """Return where the rows of matrices are, without rotations that have neither stiffness nor mass at any node."""
    if nodes.axes is not None and np.any(numbers > 3):
        numbers = np.union1d(numbers, (4, 5, 6))
    if nodes.axes is not None or len(modal):
        numbers = np.union1d(numbers, (1, 2, 3))
    turn = None
    if nodes.axes is not None:
        turn = _turned(nodes.axes[nodes.places(labels, "")], numbers, len(modal))
    every = _Placement(labels, numbers, modal, turn, np.arange(len(numbers)))
    if numbers[-1] <= len(TRANSLATIONS):
        return every
    nodal = len(labels) * len(numbers)
    used = np.zeros(len(numbers), dtype=bool)
    for what in ("mass", "stiffness"):
        sizes = np.asarray(abs(every.of_matrix(matrices[what])).sum(axis=1)).ravel()
        used |= (sizes[:nodal].reshape(-1, len(numbers)) > 0.0).any(axis=0)
    used |= numbers <= len(TRANSLATIONS)
    return every._replace(kept=np.flatnonzero(used))


def _mass_field(
    field: LabelledField, place: _Placement, components: tuple[str, ...], units: Units, carried: sp.csr_matrix
) -> MassField:
    """Return a mass field over the coordinates of the model, in SI."""
    length, mass = scales(units)
    of_node = [1.0 if c in TRANSLATIONS else length for c in components]
    scale = np.append(np.tile(of_node, len(place.labels)), np.ones(len(place.modal)))
    to_model = place.of_rows(field.freedoms).T @ sp.diags(scale) @ carried
    own = field.field
    arms = None if own.arms is None else own.arms * length
    return _moved(replace(own, points=own.points * length, mass=(own.mass * mass).tocsr(), arms=arms), to_model, length)


def _moved(field: MassField, motions: sp.csr_matrix, length: float = 1.0) -> MassField:
    """Return the field of other coordinates, whose motions are given; rotations per unit of length are those per m."""
    turns = None if field.turns is None else (field.turns @ motions / length).tocsr()
    return replace(field, interpolation=(field.interpolation @ motions).tocsr(), turns=turns)


def _groups(
    nodes: NodeTable, given: Mapping[str, int | Sequence[int]] | None, labels: np.ndarray
) -> dict[str, list[int]]:
    """Return the sets of the table and the groups that are given, by the numbers of their nodes."""
    known = set(labels.tolist())
    found: dict[str, np.ndarray | list[int]] = {
        name: [n for n in members if int(n) in known] for name, members in nodes.sets.items()
    }
    given = {} if given is None else given
    if not isinstance(given, Mapping):
        raise ModelError(f"groups must be a dict of names to labels of nodes, not {given!r}")
    for name, listed in given.items():
        members = np.atleast_1d(np.asarray(listed))
        if members.dtype.kind not in "iu" or not len(members) or not set(members.tolist()) <= known:
            raise ModelError(
                f"group {name!r} must be labels of nodes that the matrices have. Remedy: labels from {labels[0]} to "
                f"{labels[-1]}, not {members[:5].tolist()}"
            )
        found[name] = members
    return {name: np.searchsorted(labels, members).tolist() for name, members in found.items() if len(members)}


def is_generalised(numbers: np.ndarray) -> np.ndarray:
    """Return a mask of the degree of freedom numbers of generalised coordinates."""
    return np.asarray((numbers == GENERALISED) | (numbers >= GENERALISED_BY_NODE))


def given_freedoms(rows: np.ndarray | Sequence[tuple[int, int]], name: str, point: str) -> np.ndarray:
    """Return rows of label and number from the user, checked, shape (N, 2).

    Raises
    ------
    ModelError
        If they are not whole numbers, or a row is given twice; `name` is the argument, `point` the meaning of labels.
    """
    found = numbers(rows)
    if found.ndim == 2 and np.array_equal(found, np.round(found)):
        found = found.astype(np.int64)
    if found.ndim != 2 or found.shape[1] != 2 or found.dtype.kind not in "iu":
        raise ModelError(f"{name} must be rows of whole numbers ({point}, number)")
    if len(np.unique(found, axis=0)) < len(found):
        raise ModelError(f"{name} names a row twice. Remedy: each ({point}, number) once")
    return found


def with_generalised(labelled: LabelledMatrix, labels: Sequence[int]) -> LabelledMatrix:
    """Return the matrix with the degrees of freedom of labels that are not nodes as generalised coordinates.

    Raises
    ------
    ModelError
        If one of the labels has no row.
    """
    given = numbers(labels)
    if given.size and (given.ndim != 1 or np.any(given % 1.0 != 0.0)):
        raise ModelError(f"generalised must be labels, whole numbers, not {labels!r}")
    chosen = np.unique(given.astype(np.int64))
    unknown = np.setdiff1d(chosen, labelled.freedoms[:, 0])
    if len(unknown):
        raise ModelError(
            f"generalised names {unknown[:5].tolist()}, which have no row in the matrices. Remedy: labels of points "
            "that carry generalised coordinates"
        )
    freedoms = labelled.freedoms.copy()
    theirs = np.isin(freedoms[:, 0], chosen) & ~is_generalised(freedoms[:, 1])
    freedoms[theirs, 1] += GENERALISED_BY_NODE
    return LabelledMatrix(freedoms, labelled.matrix)


def _codes(freedoms: np.ndarray) -> np.ndarray:
    """Return one number for each pair of label and number, in the same order."""
    return np.asarray(freedoms[:, 0] * 64 + freedoms[:, 1])


def _check_freedoms(what: str, labelled: LabelledMatrix) -> None:
    labels, numbers = labelled.freedoms.T
    if np.any(labels <= 0):
        raise ModelError(
            f"{what} has {len(np.unique(labels[labels <= 0]))} internal node(s) (labels below 1), such as those of "
            "Lagrange multipliers and of hybrid or incompatible elements. Remedy: export without contact, connectors "
            "and hybrid elements"
        )
    wrong = ~is_generalised(numbers) & ((numbers < 1) | (numbers > 6))
    if np.any(wrong):
        number = int(numbers[wrong][0])
        meaning = OTHER_FREEDOMS.get(number, "no motion of a node")
        raise ModelError(
            f"{what} has degree of freedom {number} ({meaning}) at node {labels[wrong][0]}. Remedy: export a "
            "structural model with translations (1, 2, 3) and rotations (4, 5, 6) only, and generalised coordinates (0)"
        )
    diagonal = np.abs(labelled.matrix.diagonal())
    typical = np.median(diagonal[diagonal > 0]) if np.any(diagonal > 0) else 0.0
    held = diagonal > SUPPORT * typical
    if np.any(held):
        label, number = labelled.freedoms[held][0]
        raise ModelError(
            f"{what} holds {np.count_nonzero(held)} degree(s) of freedom by huge entries, first {number} of "
            f"node {label}. Remedy: export without boundary conditions: interfaces are fixed in kanefe"
        )


def _spread(freedoms: np.ndarray, labels: np.ndarray, numbers: np.ndarray, modal: np.ndarray) -> sp.csr_matrix:
    """Return the places of labelled rows: of every number at every node, then of every generalised coordinate."""
    nodal = len(labels) * len(numbers)
    rows = np.searchsorted(labels, freedoms[:, 0]) * len(numbers)
    rows += np.searchsorted(numbers, freedoms[:, 1])
    is_modal = is_generalised(freedoms[:, 1])
    rows[is_modal] = nodal + np.searchsorted(modal, _codes(freedoms[is_modal]))
    return sp.csr_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))), (nodal + len(modal), len(rows)))


def _turned(axes: np.ndarray, numbers: np.ndarray, generalised: int) -> sp.csr_matrix:
    """Return the block diagonal matrix that maps components in the axes of the nodes to those in G."""
    blocks = 2 if numbers[-1] > 3 else 1
    of_nodes = [sp.csr_matrix(A) for A in axes for _ in range(blocks)]
    return sp.block_diag([*of_nodes, sp.identity(generalised)], format="csr")
