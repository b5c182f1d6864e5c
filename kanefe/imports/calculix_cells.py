"""Cells and moduli of a deck of CalculiX for views and stresses of the body of its matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kanefe.fe_model.model import Cells, Elasticity, FiniteElementModel
from kanefe.fe_model.moduli import isotropic
from kanefe.fe_model.shapes import shape
from kanefe.imports.abaqus_input import Keyword
from kanefe.imports.abaqus_job import Job
from kanefe.imports.abaqus_sets import key_of
from kanefe.imports.calculix_rows import CellBlock
from kanefe.imports.node_table import rows_of
from kanefe.imports.units import Units, scales

_SECTIONS = ("SOLIDSECTION", "SHELLSECTION", "MEMBRANESECTION", "BEAMSECTION")


class StoredCells(NamedTuple):
    """Cells of a deck, and the ascending labels of the nodes that have rows."""

    blocks: list[CellBlock]
    labels: np.ndarray


def with_cells(
    model: FiniteElementModel, cells: StoredCells, job: Job, units: Units, exact: bool
) -> FiniteElementModel:
    """Return a model with the solids whose nodes all have rows, and their moduli if all are isotropic.

    Parameters
    ----------
    model : FiniteElementModel
    cells : StoredCells
    job : Job
    units : Units
    exact : bool
        Whether displacements of nodes give the strains: not in elements with incompatible modes.
    """
    kept: list[CellBlock] = []
    for block in cells.blocks:
        rows = rows_of(block.nodes, cells.labels)
        whole = (rows >= 0).all(axis=1)
        if shape(block.kind).dimension == 3 and whole.any():
            kept.append(CellBlock(block.kind, block.elements[whole], rows[whole]))
    elasticity = _elasticity(kept, job, units) if exact and kept else None
    found = tuple(Cells(block.kind, block.nodes) for block in kept)
    return replace(model, cells=found, elasticity=elasticity)


def _elasticity(cells: Sequence[CellBlock], job: Job, units: Units) -> Elasticity | None:
    """Return the moduli of cells in Pa; None if one is not isotropic, or of a section that is not known."""
    length, mass = scales(units)
    constants = _materials(job.blocks)
    sets = {key: named for part in job.parts for key, named in part.element_sets.by_key.items()}
    elements = np.concatenate([block.elements for block in cells])
    of_cell = np.full(len(elements), -1)
    table: list[np.ndarray] = []
    for block in job.blocks:
        found = constants.get(key_of(block.options.get("MATERIAL", "")))
        named = sets.get(key_of(block.options.get("ELSET", "")))
        if block.name in _SECTIONS and found is not None and named is not None:
            for piece in named.pieces:
                of_cell[np.isin(elements, piece.labels)] = len(table)
            E, nu = found[0] * mass / length, found[1]
            table.append(isotropic(E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), E / (2.0 * (1.0 + nu))))
    if (of_cell < 0).any():
        return None
    return Elasticity(np.array(table), of_cell)


def _materials(blocks: Sequence[Keyword]) -> dict[str, tuple[float, float]]:
    """Return Young's modulus and Poisson's ratio of isotropic materials, at their first temperature, by name."""
    found: dict[str, tuple[float, float]] = {}
    name = ""
    for block in blocks:
        if block.name == "MATERIAL":
            name = key_of(block.options.get("NAME", ""))
        elif block.name == "ELASTIC" and block.options.get("TYPE", "ISO").upper().startswith("ISO"):
            at, fields = next(block.rows(), (block.at, []))
            values = [block.number(text, at) for text in fields[:2]]
            if len(values) == 2 and values[0] > 0.0 and -1.0 < values[1] < 0.5:
                found[name] = (values[0], values[1])
    return found
