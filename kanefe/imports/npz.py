"""Matrices, nodes and groups in one .npz file, for any program with Python.

Layout, version 1, in m, kg, s (written by numpy.savez of these arrays):

    format                        "kanefe matrices 1"
    nodes (n, 3), components      coordinates; names among "x", "y", "z", "rx", "ry", "rz"
    stiffness, mass, damping,     dense (N, N), or as scipy.sparse.csr_matrix: stiffness_data, _indices, _indptr
    added_mass
    group_NAME                    node numbers from 0
    cells_KIND                    node numbers (m, nodes a cell) in VTK order, KIND by meshio's name
    following (f, N)              as a csr_matrix: unit directions of rotations that only follow their neighbours
    field_points (P, 3),          mass field, where nodes rotate: see kanefe.MassField; field_mass (P, P),
    field_arms (P, 3)             field_interpolation and field_turns (3 P, N) as csr_matrix

`damping`, `added_mass`, groups, cells, `following` and the mass field may be missing.
"""

from __future__ import annotations

import struct
import zipfile
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Unpack

import numpy as np
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.errors import FileError, ModelError
from kanefe.fe_model.model import ROTATIONS, Cells, FiniteElementModel, MassField
from kanefe.imports.from_matrices import model_from_matrices
from kanefe.imports.self_check import Expected
from kanefe.storage.array_file import check_directory
from kanefe.storage.files import regular_file, write_whole

NOT_READ = (
    *(OSError, ValueError, KeyError, TypeError, EOFError, MemoryError),
    *(zipfile.BadZipFile, zlib.error, struct.error),
)
"""Errors of files that are damaged, or not of these arrays."""

FORMAT = "kanefe matrices 1"

FIELD = ("mass", "interpolation", "turns")
"""Names of the matrices of a mass field."""


@checked
def write_matrices(model: FiniteElementModel, path: str | Path) -> None:
    """Write nodes, matrices, groups and cells of a full-order model to one .npz file.

    Raises
    ------
    ModelError
        If materials have a loss factor or a Prony series, which the file has no place for.
    FileError
        If the folder cannot be written, or the disk is full.
    """
    if model.viscoelastic or model.structural is not None:
        raise ModelError(
            "a file of matrices has a damping matrix, and no place for a Prony series or a loss factor. Remedy: "
            "materials without, and damping= of the body"
        )
    arrays: dict[str, np.ndarray] = {
        "format": np.array(FORMAT),
        "nodes": model.nodes,
        "components": np.array(model.components),
    }
    if model.generalised:
        arrays["generalised"] = np.array(model.generalised)
    for what in ("stiffness", "mass", "damping", "added_mass", "following"):
        arrays |= _parts(what, getattr(model, what))
    field = model.mass_field
    if field is not None and not model.generalised and set(model.components) & set(ROTATIONS):
        arrays["field_points"] = field.points
        for what in FIELD:
            arrays |= _parts(f"field_{what}", getattr(field, what))
        if field.arms is not None:
            arrays["field_arms"] = field.arms
    arrays |= {f"group_{name}": np.asarray(group.nodes) for name, group in model.groups.items()}
    for block in model.cells:
        name = f"cells_{block.kind}"
        arrays[name] = np.vstack((arrays[name], block.nodes)) if name in arrays else block.nodes
    write_whole(path, lambda file: np.savez(file, **arrays))


def _parts(name: str, matrix: sp.spmatrix | None) -> dict[str, np.ndarray]:
    """Return the arrays of a matrix; none if there is no matrix."""
    if matrix is None:
        return {}
    csr = sp.csr_matrix(matrix)
    return {f"{name}_data": csr.data, f"{name}_indices": csr.indices, f"{name}_indptr": csr.indptr}


@checked
def read_matrices(
    path: str | Path,
    **expected: Unpack[Expected],
) -> FiniteElementModel:
    """Return the model of a file from `write_matrices`, or from numpy in the same layout.

    Parameters
    ----------
    path : path
    **expected
        See `read_abaqus`.

    Raises
    ------
    FileError
        If the file does not exist, is truncated, or of another format or version.
    ModelError
        If the self-check of `kanefe.model_from_matrices` fails.

    Examples
    --------
    >>> kf.write_matrices(model, "arm.npz")  # doctest: +SKIP
    >>> same = kf.read_matrices("arm.npz", expected_mass=2.1)  # doctest: +SKIP
    """
    path = regular_file(path, "for the matrices")
    try:
        with path.open("rb") as stream, zipfile.ZipFile(stream) as members:
            check_directory(stream, members)
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        stated = str(arrays["format"])
        if stated == FORMAT:
            matrices = {what: _matrix(arrays, what) for what in ("stiffness", "mass", "damping", "added_mass")}
            generalised = int(arrays.get("generalised", 0))
            nodes, components = arrays["nodes"], tuple(str(c) for c in arrays["components"])
            following = _following(arrays, len(nodes), components, generalised)
            field = _field(arrays, len(nodes) * len(components))
    except NOT_READ as error:
        raise FileError(
            f"{path} is truncated or not a file of matrices ({error}). Remedy: write it again with write_matrices"
        ) from error
    if stated != FORMAT:
        raise FileError(f"{path} has format {stated!r}, this kanefe reads {FORMAT!r}. Remedy: write it again")
    if matrices["stiffness"] is None or matrices["mass"] is None:
        raise FileError(f"{path} must hold both stiffness and mass. Remedy: write it again with write_matrices")
    model = model_from_matrices(
        matrices["mass"],
        matrices["stiffness"],
        nodes,
        components=components,
        damping=matrices["damping"],
        added_mass=matrices["added_mass"],
        mass_field=field,
        generalised=generalised,
        groups={n.removeprefix("group_"): a.tolist() for n, a in arrays.items() if n.startswith("group_")},
        cells=[Cells(n.removeprefix("cells_"), a) for n, a in arrays.items() if n.startswith("cells_")],
        source=f"npz {path.name}",
        **expected,
    )
    return model if following is None else replace(model, following=following)


def _matrix(arrays: dict[str, np.ndarray], what: str, width: int | None = None) -> sp.csr_matrix | None:
    """Return a matrix of the file, square or of a given number of columns, or None."""
    if what in arrays:
        return sp.csr_matrix(arrays[what])
    if f"{what}_data" not in arrays:
        return None
    size = len(arrays[f"{what}_indptr"]) - 1
    parts = tuple(arrays[f"{what}_{part}"] for part in ("data", "indices", "indptr"))
    return sp.csr_matrix(parts, (size, size if width is None else width))


def _field(arrays: dict[str, np.ndarray], size: int) -> MassField | None:
    """Return the mass field of the file, or None; a ValueError if it is not whole."""
    if "field_points" not in arrays:
        return None
    points = arrays["field_points"]
    mass, interpolation, turns = (
        _matrix(arrays, f"field_{what}", width) for what, width in zip(FIELD, (None, size, size), strict=True)
    )
    if mass is None or interpolation is None:
        raise ValueError("the mass field has no masses, or no shape functions")
    return MassField(points, mass, interpolation, turns, arrays.get("field_arms"))


def _following(
    arrays: dict[str, np.ndarray], count: int, components: tuple[str, ...], generalised: int
) -> sp.csr_matrix | None:
    """Return the directions of rotations that follow, or None; a ValueError if they are none."""
    found = _matrix(arrays, "following", count * len(components) + generalised)
    if found is not None:
        turning = np.append(np.tile(np.isin(components, ROTATIONS), count), np.zeros(generalised, dtype=bool))
        lengths = np.sqrt(np.asarray(found.power(2).sum(axis=1)).ravel())
        if found.shape[1] != len(turning) or abs(found[:, ~turning]).sum() or abs(lengths - 1.0).max(initial=0) > 1e-9:
            raise ValueError("what follows are no directions of rotations")
    return found
