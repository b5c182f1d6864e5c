"""Stresses and strains at one time, as arrays of a file for ParaView."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe_fem.recovery.envelope import COMPONENTS, SCALARS
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
        Names in `SCALARS`, "stress" or "strain".
    material : int, optional
        Row of the table of moduli to which values at nodes are restricted.
    """
    point_data: dict[str, np.ndarray] = {}
    cell_data: dict[str, np.ndarray] = {}
    needs_stress = any(quantity != "strain" for quantity in quantities)
    at_nodes = fields.evaluate("stress", "nodes", eta, material)[0] if needs_stress else np.zeros(0)
    for quantity in quantities:
        if quantity in SCALARS:
            label = f"{quantity.replace('_', ' ')} [Pa]"
            point_data[label] = SCALARS[quantity](at_nodes)
            cell_data[label] = SCALARS[quantity](fields.evaluate("stress", "cells", eta)[0])
            continue
        values = at_nodes if quantity == "stress" else fields.evaluate("strain", "nodes", eta, material)[0]
        unit = " [Pa]" if quantity == "stress" else ""
        for number, component in enumerate(COMPONENTS):
            point_data[f"{quantity} {component}{unit}"] = values[:, number]
    return point_data, cell_data
