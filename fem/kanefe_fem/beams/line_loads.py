"""Lines of a frame of beams that carry distributed loads: sets of elements, and their consistent nodal forces.

The nodal forces are the integrals of the load times the interpolation of the displacement of the axis, forces and end
moments, so that nodal deflections under a uniform load are exact.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.model import NodeGroup
from kanefe_fem.beams import elements as be
from kanefe_fem.beams.checks import Groups, checked_indices
from kanefe_fem.beams.properties import ElementProperties


def check_lines(lines: Groups, count: int) -> dict[str, np.ndarray]:
    """Return the elements of each named line, numbers from 0, each once."""
    if not isinstance(lines, Mapping):
        raise ModelError(f"lines must be a dict of names to element numbers, not {lines!r}")
    return {name: checked_indices(given, count, f"line {name!r} has the elements") for name, given in lines.items()}


def line_groups(lines: Mapping[str, np.ndarray], points: np.ndarray, table: np.ndarray) -> dict[str, NodeGroup]:
    """Return the nodes of each line, at its centroid and with the integrals of linear shapes along it.

    Parameters
    ----------
    lines : mapping of str to ndarray of int
        Elements of each line.
    points : ndarray, shape (n, 3)
        m.
    table : ndarray of int, shape (m, 2)
        Nodes of all elements.
    """
    groups = {}
    for name, numbers in lines.items():
        ends = table[numbers]
        lengths = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
        nodes, at = np.unique(ends, return_inverse=True)
        at = at.reshape(ends.shape)
        shares = lengths[:, None] * np.array([2.0, 1.0, 1.0, 2.0]) / 6.0
        rows, columns = np.repeat(at, 2, axis=1), np.tile(at, (1, 2))
        measure = sp.csr_matrix((shares.ravel(), (rows.ravel(), columns.ravel())), (len(nodes), len(nodes)))
        position = np.asarray(measure.sum(axis=0)).ravel() @ points[nodes] / lengths.sum()
        groups[name] = NodeGroup(nodes, position, measure)
    return groups


def chosen_lines(patterns: Mapping[str, NodalPattern], names: Sequence[str]) -> dict[str, NodalPattern]:
    """Return the patterns with these names."""
    if isinstance(names, str) or not isinstance(names, Collection):
        raise ModelError(f"lines={names!r} is not a list of names. Remedy: lines=[{names!r}]")
    for name in names:
        if not isinstance(name, str) or name not in patterns:
            raise ModelError(
                f"the model has no line called {name!r}. Remedy: use one of those it has "
                f"({', '.join(patterns) or 'none'}), or name its elements in beam_model(..., lines=...)"
            )
    return {name: patterns[name] for name in names}


def line_pattern(
    numbers: np.ndarray,
    ends: np.ndarray,
    properties: ElementProperties,
    axes: np.ndarray,
    dofs: np.ndarray,
    planar: bool,
    size: int,
) -> NodalPattern:
    """Return the consistent nodal forces of a uniform load along the axes of some elements.

    Parameters
    ----------
    numbers : ndarray of int
        The elements.
    ends : ndarray, shape (m, 2, 3)
        Ends of all elements in G in m.
    properties, axes, dofs
        Stiffnesses, A_GL and degrees of freedom of all elements.
    planar : bool
        Loads along z then act on the body as a whole, but do not deform it.
    size : int
        Number of degrees of freedom.
    """
    stations, weights = be.gauss_stations(2)  # exact: the deflection is cubic
    N_L = be.interpolation(properties, stations)[numbers, :, :3]
    A, length = axes[numbers], properties.length[numbers]
    shares = np.einsum("m,g,mgij->mij", length, weights, N_L)
    rows = np.einsum("mab,mbi,mij->maj", A, shares, be.spatial_transformation(A))
    if planar:
        rows = rows[:, :, be.PLANAR_DOFS]
    traction = np.zeros((size, 3))
    np.add.at(traction, dofs[numbers], rows.transpose(0, 2, 1))
    return NodalPattern(
        kind="line",
        measure=float(length.sum()),
        first=length @ ends[numbers].mean(axis=1),
        traction=traction,
        pressure=None,
        pressure_force=np.zeros(3),
        pressure_moment=np.zeros(3),
        cells=numbers,
    )
