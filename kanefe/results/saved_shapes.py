"""Bodies of a result in its file: what is told of each, and the arrays of their masses and meshes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells, Elasticity
from kanefe.fe_model.ribs import Ribs
from kanefe.fe_model.shell_stack import ShellStack
from kanefe.results.body_shape import BodyShape
from kanefe.storage.hdf5 import Arrays, safe_name
from kanefe.tree.neighbours import Neighbours

if TYPE_CHECKING:
    from kanefe.bodies.exact.beam_line import BeamLine

LARGEST_BASIS = 2**29
"""Size of the dense basis of an unreduced body above which its result is not written, bytes."""

AS_THEY_ARE = ("name", "parent", "parent_interface", "joint", "mass", "is_orthonormal", "provenance")
"""Attributes of a body that the header of a file has unchanged."""

OF_SHELLS: dict[str, Any] = {"shell": ShellStack, "ribs": Ribs}
"""Parts of the elasticity of a body that are records of arrays, by their names."""

NAMES = ("driven_names", "coordinate_names", "speed_names", "interfaces", "components")
"""Attributes of a body that are tuples of names, which the header has too."""


def described(shape: BodyShape) -> dict[str, Any]:
    """Return what the header of a file tells of a body."""
    return {
        **{name: getattr(shape, name) for name in (*AS_THEY_ARE, *NAMES)},
        "neighbours": {name: found._asdict() for name, found in shape.neighbours.items()},
        "cells": [block.kind for block in shape.cells],
    }


def arrays_of_shapes(shapes: Sequence[BodyShape]) -> Arrays:
    """Return the arrays of bodies by their paths in a file, with units."""
    arrays: Arrays = {
        "masses/com": (np.array([shape.com for shape in shapes]).reshape(-1, 3), "m"),
        "masses/inertia": (np.array([shape.inertia for shape in shapes]).reshape(-1, 3, 3), "kg m2"),
    }
    for shape in shapes:
        if shape.is_flexible:
            arrays |= _arrays_of_mesh(shape)
    return arrays


def shape_of(entry: Mapping[str, Any], number: int, arrays: Mapping[str, np.ndarray]) -> BodyShape:
    """Return a body by its number and what the header tells of it."""
    folder = _folder(entry["name"])
    told: dict[str, Any] = {name: entry[name] for name in AS_THEY_ARE} | {name: tuple(entry[name]) for name in NAMES}
    return BodyShape(
        **told,
        com=arrays["masses/com"][number],
        inertia=arrays["masses/inertia"][number],
        nodes=arrays.get(f"{folder}/mesh/nodes", np.zeros((0, 3))),
        basis=arrays.get(f"{folder}/mesh/basis", np.zeros((0, 0))),
        cells=tuple(Cells(kind, arrays[f"{folder}/mesh/cells_{i}"]) for i, kind in enumerate(entry["cells"])),
        neighbours={
            name: Neighbours(tuple(found["unknown"]), tuple(found["known"]))
            for name, found in entry["neighbours"].items()
        },
        elasticity=_elasticity(within(f"{folder}/elasticity/", arrays)),
        stress_modes=arrays.get(f"{folder}/stress_modes"),
        line=_line(within(f"{folder}/line/", arrays)),
    )


def _folder(body: str) -> str:
    return f"bodies/{safe_name(body)}"


def _arrays_of_mesh(shape: BodyShape) -> Arrays:
    folder = _folder(shape.name)
    arrays: Arrays = {
        f"{folder}/mesh/nodes": (shape.nodes, "m"),
        f"{folder}/mesh/basis": (_dense_basis(shape), "m or rad by modal coordinate"),
    }
    arrays |= {f"{folder}/mesh/cells_{i}": (block.nodes, "1") for i, block in enumerate(shape.cells)}
    if shape.elasticity is not None:
        arrays |= {
            f"{folder}/elasticity/{f.name}": (value, "Pa of solids; N, N m2 of beams" if f.name == "table" else "1")
            for f in fields(shape.elasticity)
            if f.name not in OF_SHELLS and (value := getattr(shape.elasticity, f.name)) is not None
        }
        for part in OF_SHELLS:
            if (own := getattr(shape.elasticity, part)) is not None:
                arrays |= {f"{folder}/elasticity/{part}/{f.name}": (getattr(own, f.name), "SI") for f in fields(own)}
    if shape.stress_modes is not None:
        arrays[f"{folder}/stress_modes"] = (shape.stress_modes, "Pa by modal coordinate")
    if shape.line is not None:
        arrays |= {f"{folder}/line/{f.name}": (getattr(shape.line, f.name), "SI") for f in fields(shape.line)}
    return arrays


def _dense_basis(shape: BodyShape) -> np.ndarray:
    basis: Any = shape.basis
    if not sp.issparse(basis):
        return np.asarray(basis)
    size = 8 * basis.shape[0] * basis.shape[1]
    if size > LARGEST_BASIS:
        raise ModelError(
            f"the unreduced body {shape.name!r} would take {size / 2**30:.1f} GiB in the file. Remedy: keep what is "
            "wanted as arrays, such as result.nodal_displacements, or reduction=CraigBampton()"
        )
    return np.asarray(basis.toarray())


def within(folder: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the arrays of a folder by their names in it."""
    return {where.removeprefix(folder): array for where, array in arrays.items() if where.startswith(folder)}


def _elasticity(found: dict[str, np.ndarray]) -> Elasticity | None:
    own: dict[str, Any] = {name: value for name, value in found.items() if "/" not in name}
    for part, make in OF_SHELLS.items():
        if arrays := within(f"{part}/", found):
            own[part] = make(**arrays)
    return Elasticity(**own) if own else None


def _line(found: dict[str, np.ndarray]) -> BeamLine | None:
    if not found:
        return None
    from kanefe.bodies.exact.beam_line import BeamLine

    return BeamLine(**found)
