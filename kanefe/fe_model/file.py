"""Files of full-order models: arrays, mapped like those of a body; functions are left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.model import FiniteElementModel
from kanefe.storage.object_file import FileKind, read_object, write_object


@dataclass(frozen=True, eq=False)
class ModelRecord:
    """The content of the file of a model.

    Attributes
    ----------
    model : FiniteElementModel
        Without its functions of the geometric stiffness and the stresses. If `copies` is not zero, its mass is the
        scalar mass, which the file already has as that of the mass field.
    copies : int
        Number of components of a node that have the scalar mass: ``M = Ms (x) I``. Zero: M itself is kept.
    """

    model: FiniteElementModel
    copies: int


# version 1 named classes by their modules
KIND = FileKind("kanefe finite-element model", 2, ModelRecord, "model", "model", "the cache")


def save_model(model: FiniteElementModel, path: str | Path) -> None:
    """Write a model to `path` atomically; its functions are left out.

    Raises
    ------
    FileError
        If the folder cannot be written, or the disk is full.
    """
    scalar, copies = _scalar_mass(model)
    write_object(path, ModelRecord(replace(model, mass=scalar, stress_stiffness=None, stresses=None), copies), KIND)


def load_model(path: str | Path) -> FiniteElementModel:
    """Read a model that `save_model` wrote; its large arrays stay in the file until they are used.

    Raises
    ------
    FileError
        If the file is missing, truncated, or of another format or version.
    """
    record: ModelRecord = read_object(path, KIND)
    model = record.model
    return replace(model, mass=_block_mass(model.mass, record.copies)) if record.copies else model


def _scalar_mass(model: FiniteElementModel) -> tuple[sp.csr_matrix, int]:
    """Return the scalar mass and the number of components that have it, or M itself and 0."""
    copies = len(model.components)
    if model.mass_field is None or copies * model.mass_field.mass.shape[0] != model.size:
        return model.mass, 0
    scalar = model.mass_field.mass
    whole = _block_mass(scalar, copies)
    same = all(np.array_equal(getattr(whole, p), getattr(model.mass, p)) for p in ("indptr", "indices", "data"))
    return (scalar, copies) if same else (model.mass, 0)


def _block_mass(scalar: sp.csr_matrix, copies: int) -> sp.csr_matrix:
    return sp.kron(scalar, sp.identity(copies, format="csr"), format="csr")
