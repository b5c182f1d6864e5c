"""Finite elements of the user: any object with nodes, mass and stiffness becomes a full-order model.

    class Mine:
        nodes = ...        # (n, 3), m
        stiffness = ...    # (N, N)
        mass = ...         # (N, N)

    model = kanefe.model_from_elements(Mine())

Everything else is optional. All arrays and functions are in the numbering of the object, which `unknowns` tells.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol, Unpack

import numpy as np
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.damping import real_matrix
from kanefe.fe_model.geometric_stiffness import check_geometric_stiffness
from kanefe.fe_model.model import TRANSLATIONS, Cells, FiniteElementModel, MassField, NodeGroup
from kanefe.fe_model.skin import facet_group, skin
from kanefe.frames import numbers
from kanefe.imports.from_matrices import BesideMatrices, Matrix, model_from_matrices
from kanefe.imports.self_check import Expected

AS_THEY_ARE = ("components", "groups", "cells")
"""Optional attributes that do not depend on the numbering of the unknowns."""

OPTIONAL = (*AS_THEY_ARE, "unknowns", "damping", "added_mass", "mass_field", "stress_stiffness", "stresses")


class FiniteElements(Protocol):
    """Finite elements of a body that is not supported, for `model_from_elements`; N unknowns.

    Attributes
    ----------
    nodes : ndarray, shape (n, 3)
        Reference coordinates, m.
    stiffness : sparse matrix or ndarray, shape (N, N)
        K, N/m.
    mass : sparse matrix or ndarray, shape (N, N), or None
        M, kg. None: that of `mass_field`.
    unknowns : ndarray of int, shape (n, c), optional
        Number of the unknown of each component of each node. Default: those of the first node, then of the second, ...
    components : sequence of str, optional
        The c components of every node among "x", "y", "z", "rx", "ry", "rz". Default: x, y and z.
    groups : dict of str to node numbers, optional
        Candidates for interfaces, and for contacts. With `cells`, a group of whole facets of the skin is weighted by
        their areas.
    cells : sequence of kanefe.Cells, optional
        For pictures, contacts, and the skin by which places choose nodes.
    damping : as stiffness, optional
        C, N s/m.
    added_mass : as stiffness, optional
        Of a fluid around the body, kg; see `FiniteElementModel`.
    mass_field : kanefe.MassField, optional
        Shape functions at mass points, by which the inertia of nodes that rotate is exact. Elements whose M is the same
        scalar matrix for all translations (Lagrange's) need none.
    stress_stiffness : callable, optional
        ``stress_stiffness(displacement, load)`` returns the geometric stiffness (N, N) of a static displacement (N,),
        for stiffening; `load` are the forces (3 P,) at the points of the mass field, or None.
    stresses : callable, optional
        ``stresses(displacements)`` returns the stress at the nodes (n, 6, m) in Pa, components xx, yy, zz, yz, xz, xy,
        from displacements (N, m), for `kanefe_fem.recover`.
    """

    nodes: Any
    stiffness: Any
    mass: Any


class Checks(Expected, total=False):
    """Keywords of `model_from_elements`."""

    source: str


@checked("expected_mass", "expected_center", "expected_inertia", "source")
def model_from_elements(elements: FiniteElements, **more: Unpack[Checks]) -> FiniteElementModel:
    """Return the full-order model of finite elements of your own, checked as those of other programs are.

    Parameters
    ----------
    elements : FiniteElements
        Any object with these attributes.
    **more
        source, a name for messages; expected_mass, expected_center, expected_inertia and factorise, as for
        `model_from_matrices`.

    Raises
    ------
    ModelError
        If an attribute is missing or not valid, or the matrices are not those of a free body.

    Examples
    --------
    Two masses of 1 kg and a bar of 100 N/m between them, whose unknowns are first both x, then both y:

    >>> from types import SimpleNamespace
    >>> K = 100.0 * np.kron([[1, 0], [0, 0]], [[1, -1], [-1, 1]])
    >>> bar = SimpleNamespace(nodes=[[-0.5, 0, 0], [0.5, 0, 0]], stiffness=K, mass=np.eye(4), components=("x", "y"),
    ...                       unknowns=[[0, 2], [1, 3]], groups={"end": 1})
    >>> model_from_elements(bar).groups["end"].position
    array([0.5, 0. , 0. ])
    """
    for name in ("nodes", "stiffness", "mass"):
        if not hasattr(elements, name):
            raise ModelError(
                f"{type(elements).__name__} has no attribute {name!r}. Remedy: an object with nodes (n, 3), stiffness "
                "(N, N) and mass (N, N), or mass=None with a mass_field"
            )
    given = {name: found for name in OPTIONAL if (found := getattr(elements, name, None)) is not None}
    nodes = numbers(elements.nodes)
    count, width = len(nodes) if nodes.ndim else 0, len(given.get("components", TRANSLATIONS))
    rows = _unknowns(given.pop("unknowns", None), count, width)
    source = more.pop("source", type(elements).__name__)

    def ordered(matrix: Matrix) -> Matrix:
        return matrix if rows is None else _in_order(matrix, rows)

    beside: dict[str, Any] = {name: given[name] for name in AS_THEY_ARE if name in given}
    beside |= {name: ordered(given[name]) for name in ("damping", "added_mass") if name in given}
    for name, turned in (("mass_field", _field), ("stress_stiffness", _stiffness), ("stresses", _stresses)):
        if name in given:
            beside[name] = given[name] if rows is None else turned(given[name], rows)
    mass = None if elements.mass is None else ordered(elements.mass)
    options: BesideMatrices = {**beside, **more}  # type: ignore[typeddict-item]
    model = model_from_matrices(mass, ordered(elements.stiffness), nodes, source=source, **options)
    check_geometric_stiffness(model)
    return replace(model, groups={name: _weighted(model, group) for name, group in model.groups.items()})


def _weighted(model: FiniteElementModel, group: NodeGroup) -> NodeGroup:
    """Return a group of whole facets of the skin with their areas, and any other as it is."""
    inside = np.zeros(len(model.nodes), dtype=bool)
    inside[group.nodes] = True
    facets = [Cells(block.kind, block.nodes[inside[block.nodes].all(axis=1)]) for block in skin(model.cells)]
    covered = np.unique(np.concatenate([block.nodes.ravel() for block in facets])) if facets else np.zeros(0)
    return facet_group(model.nodes, facets) if np.array_equal(covered, group.nodes) else group


def _unknowns(given: Any, count: int, width: int) -> np.ndarray | None:
    """Return the number of the unknown of each row of the model; None: the same."""
    if given is None:
        return None
    table = np.asarray(given)
    if (
        table.shape != (count, width)
        or table.dtype.kind not in "iu"
        or not np.array_equal(np.sort(table.ravel()), np.arange(count * width))
    ):
        raise ModelError(
            f"unknowns of shape {table.shape} are not the numbers 0 to {count * width - 1}, each once, of {width} "
            f"component(s) of {count} nodes. Remedy: shape ({count}, {width}); unknowns inside elements are to be "
            "condensed, or transformed to those of nodes"
        )
    return table.ravel()


def _in_order(matrix: Any, rows: np.ndarray) -> sp.csr_matrix:
    """Return a matrix in the order of the model; one of another size as it is, which the model refuses."""
    own = real_matrix(matrix)
    return own[rows][:, rows] if own.shape == (len(rows), len(rows)) else own


def _field(field: Any, rows: np.ndarray) -> Any:
    """Return a mass field in the order of the model; what is none, or of another size, as it is."""

    def ordered(functions: Any) -> sp.csr_matrix:
        own = real_matrix(functions)
        return own[:, rows] if own.shape[1] == len(rows) else own

    if not isinstance(field, MassField):
        return field
    turns = None if field.turns is None else ordered(field.turns)
    return replace(field, interpolation=ordered(field.interpolation), turns=turns)


def _stiffness(function: Callable[..., Any], rows: np.ndarray) -> Callable[..., sp.csr_matrix]:
    def stress_stiffness(displacement: np.ndarray, load: np.ndarray | None = None) -> sp.csr_matrix:
        own = np.empty(len(rows))
        own[rows] = displacement
        return _in_order(function(own, load), rows)

    return stress_stiffness


def _stresses(function: Callable[..., Any], rows: np.ndarray) -> Callable[..., np.ndarray]:
    def stresses(displacements: np.ndarray) -> np.ndarray:
        own = np.empty(displacements.shape)
        own[rows] = displacements
        return np.asarray(function(own))

    return stresses
