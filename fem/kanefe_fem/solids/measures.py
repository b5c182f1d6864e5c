"""Measures of the groups of a mesh for forms: integrals over groups of cells and of outer facets, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import row_numbers, shape
from kanefe_fem import _fenicsx
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.surfaces import check_surfaces
from kanefe_fem.solids.problem import SolidProblem

Measure = Callable[[str], Any]


def measures(problem: SolidProblem, mesh: Mesh) -> tuple[Measure, Measure]:
    """Return the measures of groups of cells and of groups of outer facets, as functions of their names.

    Parameters
    ----------
    problem : SolidProblem
    mesh : Mesh
        The mesh of the problem, in its own numbering.
    """
    ufl, domain = problem.fx.ufl, problem.mesh
    d = mesh.dimension
    counts = [sum(len(block.nodes) for block in blocks) for blocks in mesh.cells.values()]
    number = np.repeat(np.arange(len(counts)), counts)[np.asarray(domain.topology.original_cell_index)]
    by_cells = ufl.Measure("dx", domain=domain, subdomain_data=_fenicsx.tags(problem.fx, domain, d, number))
    of_cells = {name: (i,) for i, name in enumerate(mesh.cells)}
    tag_of, of_facets = _combinations(problem, mesh)
    by_facets = ufl.Measure("ds", domain=domain, subdomain_data=_fenicsx.tags(problem.fx, domain, d - 1, tag_of))

    def cells(name: str) -> Any:
        return by_cells(_known(mesh, name, of_cells, "cells"))

    def facets(name: str) -> Any:
        known = _known(mesh, name, of_facets, "facets")
        check_surfaces(mesh, [name])
        return by_facets(known)

    return cells, facets


def _known(mesh: Mesh, name: str, numbers: Mapping[str, tuple[int, ...]], what: str) -> Any:
    if name not in numbers:
        raise ModelError(
            f"a form integrates over {name!r}, and {mesh.source} has no such group of {what}. Remedy: one of those it "
            f"has ({', '.join(sorted(numbers)) or 'none'})"
        )
    found = numbers[name]
    return found if len(found) != 1 else found[0]


def _combinations(problem: SolidProblem, mesh: Mesh) -> tuple[np.ndarray, dict[str, tuple[int, ...]]]:
    """Return the number of each facet, one for each set of groups that it is in, and the numbers of each group.

    A facet may be in several groups, and has one number in UFL.
    """
    facets = _fenicsx.facet_corners(problem.mesh, problem.vector, problem.order_of_nodes)
    groups = {name: _corners(blocks) for name, blocks in mesh.facets.items() if name}
    members = np.zeros((len(facets), len(groups)), dtype=bool)
    for column, tables in enumerate(groups.values()):
        for width, table in tables.items():
            own = np.sort(facets[:, :width], axis=1) if width <= facets.shape[1] else np.zeros((0, width), int)
            keys = row_numbers(np.vstack((own, np.sort(table, axis=1))))
            members[:, column] |= np.isin(keys[: len(own)], keys[len(own) :])
    sets, numbers = np.unique(members, axis=0, return_inverse=True)
    of_group = {name: tuple(int(i) for i in np.flatnonzero(sets[:, c])) for c, name in enumerate(groups)}
    return numbers.ravel(), of_group


def _corners(blocks: tuple[Cells, ...]) -> dict[int, np.ndarray]:
    """Return the corners of facets, by how many these are."""
    found: dict[int, list[np.ndarray]] = {}
    for block in blocks:
        corners = shape(block.kind).corners
        found.setdefault(corners, []).append(block.nodes[:, :corners])
    return {width: np.concatenate(tables) for width, tables in found.items()}
