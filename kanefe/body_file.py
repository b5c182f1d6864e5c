"""One file for one flexible body: numpy's .npz with a header that names format and version."""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import FileError
from kanefe.finite_element_model import Cells
from kanefe.flexible import FlexibleBody, InterfaceFrame
from kanefe.load_pattern import ARRAYS, LoadPattern
from kanefe.mass_moments import MassMoments
from kanefe.nodal_moments import NodalMoments

FORMAT = "kanefe flexible body"
VERSION = 2


def save_body(body: FlexibleBody, path: str | Path) -> None:
    """Write a body to `path`, which then holds either the whole new body or what it held before.

    Raises
    ------
    FileError
        If the folder cannot be written, or the disk is full.
    """
    header = {
        "format": FORMAT,
        "version": VERSION,
        "components": body.components,
        "free_count": body.free_count,
        "moments": type(body.moments).__name__,
        "cells": [block.kind for block in body.cells],
        "interfaces": [
            {"name": f.name, "fixed_components": f.fixed_components, "fixed_columns": f.fixed_columns}
            for f in body.interfaces
        ],
        "load_patterns": [
            {"name": p.name, "kind": p.kind, "has_pressure": p.has_pressure, "measure": p.measure}
            for p in body.load_patterns
        ],
        "units": body.units,
        "provenance": dict(body.provenance),
    }
    arrays = {
        "nodes": body.nodes,
        "basis": body.basis,
        "stiffness": body.stiffness,
        "damping": body.damping,
        "inertia_points": body.inertia_points,
        "inertia_basis": body.inertia_basis,
        "inertia_mass_data": body.inertia_mass.data,
        "inertia_mass_indices": body.inertia_mass.indices,
        "inertia_mass_indptr": body.inertia_mass.indptr,
    }
    arrays |= {f"moments_{name}": array for name, array in body.moments.arrays().items()}
    arrays |= {f"cells_{i}": block.nodes for i, block in enumerate(body.cells)}
    for i, frame in enumerate(body.interfaces):
        arrays |= {f"interface_{i}_position": frame.position, f"interface_{i}_motion": frame.motion}
    for i, pattern in enumerate(body.load_patterns):
        arrays |= {f"load_pattern_{i}_{name}": array for name, array in pattern.arrays().items()}
    write_whole(path, lambda file: np.savez_compressed(file, header=np.array(json.dumps(header)), **arrays))


def load_body(path: str | Path) -> FlexibleBody:
    """Read a body that `save_body` wrote.

    Raises
    ------
    FileError
        If the file is not there, truncated, or of another format or version.
    """
    path = Path(path)
    if not path.is_file():
        raise FileError(f"there is no file {path}. Remedy: check the path, or make the body again and save it")
    try:
        with np.load(path, allow_pickle=False) as file:
            header = json.loads(str(file["header"]))
            _check_header(header, path)
            return _body(header, {name: file[name] for name in file.files})
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{path} is truncated or is no saved body ({error}). Remedy: save the body again") from error


def _body(header: dict[str, Any], arrays: dict[str, np.ndarray]) -> FlexibleBody:
    """Return the body of a file's header and arrays."""
    kind: Any = {"MassMoments": MassMoments, "NodalMoments": NodalMoments}[header["moments"]]
    moments = {n.removeprefix("moments_"): a for n, a in arrays.items() if n.startswith("moments_")}
    size = len(arrays["inertia_mass_indptr"]) - 1
    return FlexibleBody(
        nodes=arrays["nodes"],
        components=tuple(header["components"]),
        basis=arrays["basis"],
        free_count=header["free_count"],
        stiffness=arrays["stiffness"],
        damping=arrays["damping"],
        moments=kind(**moments),
        interfaces=tuple(
            InterfaceFrame(
                f["name"],
                arrays[f"interface_{i}_position"],
                arrays[f"interface_{i}_motion"],
                tuple(f["fixed_components"]),
                tuple(f["fixed_columns"]),
            )
            for i, f in enumerate(header["interfaces"])
        ),
        inertia_points=arrays["inertia_points"],
        inertia_mass=sp.csr_matrix(
            (arrays["inertia_mass_data"], arrays["inertia_mass_indices"], arrays["inertia_mass_indptr"]), (size, size)
        ),
        inertia_basis=arrays["inertia_basis"],
        cells=tuple(Cells(name, arrays[f"cells_{i}"]) for i, name in enumerate(header["cells"])),
        load_patterns=tuple(
            LoadPattern(
                p["name"],
                p["kind"],
                p["has_pressure"],
                p["measure"],
                **{name: arrays[f"load_pattern_{i}_{name}"] for name in ARRAYS if f"load_pattern_{i}_{name}" in arrays},
            )
            for i, p in enumerate(header["load_patterns"])
        ),
        units=header["units"],
        provenance=header["provenance"],
    )


def _check_header(header: dict[str, Any], path: Path) -> None:
    if header.get("format") != FORMAT:
        raise FileError(f"{path} is no saved flexible body. Remedy: give the file that FlexibleBody.save wrote")
    if header.get("version") != VERSION:
        raise FileError(
            f"{path} has format version {header.get('version')}, this kanefe reads version {VERSION}. "
            "Remedy: make the body again with this version"
        )


def ready_path(path: str | Path) -> Path:
    """Return `path` with its folder made.

    Raises
    ------
    FileError
        If the folder cannot be made.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"cannot write {path}: {error.strerror}. Remedy: choose a folder that can be made") from error
    return path


def write_whole(path: str | Path, write: Any) -> None:
    """Call ``write(file)`` on a temporary file beside `path` and put it in place only when it is complete.

    The folder is made where it is missing.

    Raises
    ------
    FileError
        If the folder cannot be written, or the disk is full; `path` is as it was before.
    """
    path = ready_path(path)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    except OSError as error:
        raise FileError(
            f"cannot write {path}: {error.strerror}. Remedy: choose a folder that can be written"
        ) from error
    try:
        with os.fdopen(handle, "wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(name, 0o666 & ~umask)  # mkstemp makes files that only their owner can read
        os.replace(name, path)
    except OSError as error:
        raise FileError(
            f"cannot write {path}: {error.strerror or error}. What was there before is untouched. "
            "Remedy: free some space or choose another folder"
        ) from error
    finally:
        Path(name).unlink(missing_ok=True)
