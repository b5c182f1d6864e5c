"""Stresses and strains at one time, as arrays of a file for ParaView."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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
    at_nodes = fields.several(quantities, "nodes", eta, material)
    at_cells = fields.several([name for name in quantities if name in fields.scalars], "cells", eta)
    of_nodes, of_cells = ({name: value[0] for name, value in own.items()} for own in (at_nodes, at_cells))
    return _titled(of_nodes), _titled(of_cells)


def shell_vtk_arrays(fields: ShellStrainFields, eta: np.ndarray, quantities: Sequence[str]) -> dict[str, np.ndarray]:
    """Return arrays of the points of a shell's layers and of what is beside it, for modal coordinates (1, k).

    See `kanefe.fe_model.drawn_shell`.
    """
    return _titled(fields.in_plies(quantities, eta))


def _titled(found: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return scalars and the components of tensors by their titles, with units."""
    titled: dict[str, np.ndarray] = {}
    for name, values in found.items():
        if values.ndim == 1:
            titled[f"{name.replace('_', ' ')} [{'1' if name in FAILURES else 'Pa'}]"] = values
            continue
        unit = " [Pa]" if name == "stress" else ""
        titled |= {f"{name} {component}{unit}": values[:, i] for i, component in enumerate(COMPONENTS)}
    return titled
