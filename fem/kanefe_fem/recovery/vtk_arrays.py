"""Stresses and strains at one time, as arrays of a file for ParaView."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe_fem.recovery.scalars import COMPONENTS, FAILURES
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.strain_fields import StrainFields


def vtk_arrays(
    fields: StrainFields, eta: np.ndarray, quantities: Sequence[str], material: int | None
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return arrays of nodes and of cells by their titles, for modal coordinates (1, k).

    Parameters
    ----------
    fields : StrainFields
    eta : ndarray, shape (1, k)
    quantities : sequence of str
        Names of the scalars of the fields, "stress" or "strain".
    material : int, optional
        Row of the table of moduli to which values at nodes are restricted.
    """
    point_data: dict[str, np.ndarray] = {}
    cell_data: dict[str, np.ndarray] = {}
    for quantity in quantities:
        if quantity in fields.scalars:
            label = _label(quantity)
            point_data[label] = fields.scalar(quantity, "nodes", eta, material)[0]
            cell_data[label] = fields.scalar(quantity, "cells", eta)[0]
            continue
        values = fields.evaluate("stress" if quantity == "stress" else "strain", "nodes", eta, material)[0]
        unit = " [Pa]" if quantity == "stress" else ""
        for number, component in enumerate(COMPONENTS):
            point_data[f"{quantity} {component}{unit}"] = values[:, number]
    return point_data, cell_data


def shell_vtk_arrays(fields: ShellStrainFields, eta: np.ndarray, quantities: Sequence[str]) -> dict[str, np.ndarray]:
    """Return arrays of the points of `kanefe.fe_model.thick_shell.layered`, for modal coordinates (1, k)."""
    found: dict[str, np.ndarray] = {}
    for quantity in quantities:
        if quantity in fields.scalars:
            found[_label(quantity)] = np.concatenate(fields.scalar_in_plies(quantity, eta))
            continue
        unit = " [Pa]" if quantity == "stress" else ""
        values = np.concatenate(fields.tensor_in_plies("stress" if quantity == "stress" else "strain", eta))
        found |= {f"{quantity} {component}{unit}": values[:, i] for i, component in enumerate(COMPONENTS)}
    return found


def _label(quantity: str) -> str:
    """Return the name of an array of a scalar, with its unit."""
    return f"{quantity.replace('_', ' ')} [{'1' if quantity in FAILURES else 'Pa'}]"
