"""Matrices of CalculiX, stored by a last step ``*FREQUENCY, SOLVER=MATRIXSTORAGE``: job.sti (K), job.mas (M), job.dof.

The body is to be free: no ``*BOUNDARY``. The deck says what the rows of job.dof are (`kanefe.imports.calculix_rows`).
Shells, beams and membranes are expanded to solids by CalculiX, with nodes that another step of the same deck shows::

    *STEP
    *FREQUENCY
    10
    *NODE OUTPUT, OUTPUT=3D
    U
    *END STEP
    *STEP
    *FREQUENCY, SOLVER=MATRIXSTORAGE
    *END STEP

Rules of files and rows: seen in runs of CalculiX 2.20.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, Unpack

import numpy as np
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.errors import FileError, ModelError, outside
from kanefe.fe_model.model import FiniteElementModel
from kanefe.imports.abaqus_input import Keyword
from kanefe.imports.abaqus_job import job_of
from kanefe.imports.calculix_cells import StoredCells, with_cells
from kanefe.imports.calculix_expanded import expanded_rows
from kanefe.imports.calculix_rows import StoredRows, is_expanded, rows_of_deck, type_of
from kanefe.imports.included import DeckWarning
from kanefe.imports.inner_modes import condensed, mass_field_with_modes
from kanefe.imports.labelled import LabelledMatrix, mirrored, model_of_labelled
from kanefe.imports.self_check import COUNTED_SIZE, Expected
from kanefe.imports.shared_null_vectors import held_null_vectors
from kanefe.imports.text import numbers, read_text
from kanefe.imports.units import Units

LOADED = ("STATIC", "DYNAMIC", "HEATTRANSFER", "COUPLEDTEMPERATURE-DISPLACEMENT")
"""Procedures that leave a state which a perturbation starts from."""


class _Stored(NamedTuple):
    """Matrices (N, N), and node and direction of their rows as job.dof names them (N, 2)."""

    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    freedoms: np.ndarray


@checked("deck", "matrices", "expected_mass", "expected_center", "expected_inertia", "trusted")
def read_calculix(
    deck: str | Path,
    matrices: str | Path | None = None,
    *,
    groups: Mapping[str, int | Sequence[int]] | None = None,
    units: Units = "m, kg, s",
    trusted: bool = False,
    **expected: Unpack[Expected],
) -> FiniteElementModel:
    """Return the model of the matrices that CalculiX stored, with nodes, sets, cells and moduli of its deck.

    Parameters
    ----------
    deck : path
        The input file (.inp) of the job: its node sets become groups, its elements cells; isotropic materials give
        stresses, but of elements with incompatible modes.
    matrices : path, optional
        Stiffness (.sti), beside which .mas and .dof are. Default: beside the deck, with its name.
    groups : dict of str to node labels, optional
        Candidates for interfaces in addition to the sets of the deck.
    units : str or (metres per unit of length, kilograms per unit of mass)
        Units of the deck: "m, kg, s", "mm, t, s", "in, lbf, s", ...
    trusted : bool
        Whether the deck may include files outside its folder.
    **expected
        See `read_abaqus`.

    Returns
    -------
    FiniteElementModel
        In m, kg, s. Incompatible modes (C3D8I) are condensed by statics, with the mass that they move; motions without
        stiffness and mass (bars one C3D20R thick) are held. Nodes of a ``*RIGID BODY`` or ``*COUPLING`` are left out,
        and their reference node turns. Of shells and beams the nodes are those of the solids that they become.

    Raises
    ------
    FileError
        If a file does not exist, is truncated, or a line of the deck is not as it should be.
    ModelError
        If the body is supported, a constraint takes single rows, the step is a perturbation of one before, nodes are
        stored in their own axes, shells meet at an angle, or the matrices fail the self-check.

    Warns
    -----
    DeckWarning
        If masses of the deck are not in the matrices.

    Examples
    --------
    >>> arm = kf.read_calculix("job.inp", units="mm, t, s")  # doctest: +SKIP
    >>> body = kf.flexible_body(arm, {"ROOT": "clamped", "TIP": "rigid"})  # doctest: +SKIP
    """
    path = Path(deck)
    job = job_of(path, trusted, "read_calculix", "and store the matrices of that deck")
    _check_step(path, job.blocks)
    stiff = path.with_suffix(".sti") if matrices is None else Path(matrices)
    stored = _stored(stiff)
    rows = (expanded_rows if is_expanded(job.parts) else rows_of_deck)(job, stored.freedoms, stiff)
    _tell_lost_masses(path, rows)
    found = condensed(stored.stiffness, stored.mass, rows.is_inner)
    nodal = rows.freedoms[~rows.is_inner]
    turns = bool((nodal[:, 1] > 3).any())
    reduced = any(type_of(some.block).endswith("R") for part in job.parts for some in part.elements)
    stiffness, count = found.stiffness, 0
    if reduced and len(nodal) <= COUNTED_SIZE:
        stiffness, count = held_null_vectors(stiffness, found.mass, nodal, rows.table)
    model = model_of_labelled(
        {
            "stiffness": LabelledMatrix(nodal, stiffness),
            "mass": LabelledMatrix(nodal, found.mass if turns else found.nodal_mass),
        },
        rows.table,
        groups=groups,
        units=units,
        expected=expected,
        source=f"CalculiX {stiff.name}",
    )
    if rows.is_inner.any() and not turns:
        field = mass_field_with_modes(model, stored.mass, rows.is_inner, found.follow, units)
        model = replace(model, mass=field.mass_matrix(), mass_field=field)
    told = {"condensed": int(rows.is_inner.sum()), "held_null_vectors": count}
    model = replace(model, provenance={**model.provenance, **told})
    labels = np.unique(nodal[:, 0])
    return with_cells(model, StoredCells(rows.cells, labels), job, units, exact=not rows.is_inner.any())


def _stored(path: Path) -> _Stored:
    """Return the matrices of a job: upper triangles with each diagonal entry, of one pattern."""
    names = path.with_suffix(".dof")
    pairs = [line.strip().split(".") for line in read_text(names, "rows of the matrices").splitlines() if line.strip()]
    if not all(len(pair) == 2 and pair[0].isdigit() and pair[1].isdigit() for pair in pairs):
        raise FileError(f"{names} does not name rows, as node.direction. Remedy: the files of one job")
    K, M = (_matrix(path.with_suffix(suffix), len(pairs), names) for suffix in (".sti", ".mas"))
    return _Stored(K, M, np.array(pairs, dtype=np.int64))


def _matrix(path: Path, size: int, names: Path) -> sp.csr_matrix:
    what = "stiffness" if path.suffix == ".sti" else "mass"
    values = numbers(read_text(path, f"{what} matrix"), path)
    if len(values) % 3:
        raise FileError(f"{path} is truncated: its lines should hold row, column, value. Remedy: run the job again")
    rows = values.reshape(-1, 3)
    i, j = rows[:, :2].T.astype(np.int64) - 1
    if i.min() < 0 or (i > j).any() or len(np.unique(i * (j.max() + 1) + j)) < len(i):
        raise FileError(f"{path} is no upper triangle with each entry once. Remedy: run the job again")
    if np.count_nonzero(i == j) != size or j.max() >= size:
        raise FileError(
            f"{path} has {np.count_nonzero(i == j)} diagonal entries, and {names} names {size} rows. Remedy: the files "
            "of one job that ran to its end"
        )
    return mirrored(sp.csr_matrix((rows[:, 2], (i, j)), (size, size)))


def _check_step(deck: Path, blocks: Sequence[Keyword]) -> None:
    """Refuse a step that stores other matrices than those of the unloaded body in global axes."""
    before: list[Keyword] = []
    step = None
    for block in blocks:
        if block.name == "STEP":
            step = block
        elif block.name == "FREQUENCY" and block.options.get("SOLVER", "").upper() == "MATRIXSTORAGE":
            is_local = block.options.get("GLOBAL", "").upper() == "NO"
            if is_local and any(other.name == "TRANSFORM" for other in blocks):
                raise ModelError(
                    f"{deck} has GLOBAL=NO, by which CalculiX 2.20 stores K in axes of nodes and M in global ones. "
                    "Remedy: store both without it"
                )
            if step is not None and "PERTURBATION" in step.options and before:
                raise ModelError(
                    f"{deck} stores K in a perturbation (line {step.at}) of *{before[-1].name} (line {before[-1].at}): "
                    "that is the whole tangent of the loaded body, with initial displacements and pressures, neither K "
                    "nor K with its geometric stiffness. Remedy: without PERTURBATION; preload and stiffening in kanefe"
                )
        elif step is not None and block.name in LOADED:
            before.append(block)


def _tell_lost_masses(deck: Path, rows: StoredRows) -> None:
    if rows.lost:
        named = ", ".join(str(label) for label in rows.lost[:5]) + (", ..." if len(rows.lost) > 5 else "")
        warnings.warn(
            f"{deck.name}: nodes {named} of *MASS are of no other element, so that CalculiX gives them no rows: their "
            "mass is not in the matrices. Remedy: add it as a body of the scene",
            DeckWarning,
            stacklevel=outside(),
        )
