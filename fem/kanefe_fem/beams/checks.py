"""Checks of a frame of beams before its matrices are assembled."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.csgraph

from kanefe.errors import ModelError, UnitWarning, outside
from kanefe.fe_model.model import NodeGroup
from kanefe.frames import numbers
from kanefe_fem.beams.beam_section import BeamSection, LineMass
from kanefe_fem.materials.isotropic import WAVE_SPEED, odd_mass, odd_material

if TYPE_CHECKING:
    from kanefe_fem.materials.isotropic import Material

Groups = Mapping[str, int | Sequence[int]]


def check_nodes(nodes: Any, planar: bool) -> np.ndarray:
    """Return the nodes as floats of shape (n, 3)."""
    points = numbers(nodes)
    if points.ndim != 2 or points.shape[1] not in ((2, 3) if planar else (3,)) or len(points) < 2:
        wanted = "(n, 2) or (n, 3)" if planar else "(n, 3)"
        raise ModelError(f"nodes has shape {points.shape}; a beam model needs {wanted}, n >= 2. Remedy: one row a node")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise ModelError(f"node {bad[0]} has the position {points[bad[0]]}. Remedy: give finite coordinates in m")
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    out_of_plane = np.flatnonzero(points[:, 2] != 0.0) if planar else np.empty(0, dtype=int)
    if out_of_plane.size:
        raise ModelError(
            f"node {out_of_plane[0]} has z = {points[out_of_plane[0], 2]:g} m, but a planar model lies in the plane "
            "z = 0 of G. Remedy: put it there, or planar=False"
        )
    return points


def check_elements(elements: Any, points: np.ndarray) -> np.ndarray:
    """Return the elements as integers of shape (m, 2): known nodes, no zero length, no doubles, one connected part."""
    table = np.array(elements)
    if table.ndim != 2 or table.shape[1] != 2 or len(table) == 0:
        raise ModelError(f"elements has shape {table.shape}, not (m, 2). Remedy: two node numbers for each element")
    if not np.issubdtype(table.dtype, np.integer):
        raise ModelError(f"elements has numbers of type {table.dtype}. Remedy: whole node numbers, from 0")
    table = table.astype(np.int64)
    unknown = np.flatnonzero(((table < 0) | (table >= len(points))).any(axis=1))
    if unknown.size:
        raise ModelError(
            f"element {unknown[0]} has the nodes {table[unknown[0]].tolist()}, but the nodes are 0 to "
            f"{len(points) - 1}. Remedy: count them from 0"
        )
    span = np.ptp(points, axis=0).max()
    length = np.linalg.norm(points[table[:, 1]] - points[table[:, 0]], axis=1)
    empty = np.flatnonzero(length <= 1e-12 * span)
    if empty.size:
        raise ModelError(
            f"element {empty[0]} (nodes {table[empty[0]].tolist()}) has no length. Remedy: merge its nodes, or move one"
        )
    _, first, counts = np.unique(np.sort(table, axis=1), axis=0, return_index=True, return_counts=True)
    if (counts > 1).any():
        double = first[np.argmax(counts > 1)]
        raise ModelError(f"the element between nodes {table[double].tolist()} is given twice. Remedy: keep one")
    check_connected(table, len(points))
    return table


def check_connected(table: np.ndarray, count: int) -> None:
    """Raise a ModelError if a node belongs to no element or the frame falls into parts."""
    unused = np.setdiff1d(np.arange(count), table)
    if unused.size:
        raise ModelError(
            f"node {unused[0]} ({unused.size} in all) belongs to no element. Remedy: remove it, or connect it"
        )
    graph = sp.coo_matrix((np.ones(len(table)), (table[:, 0], table[:, 1])), shape=(count, count))
    parts, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    if parts > 1:
        raise ModelError(
            f"the frame falls into {parts} unconnected parts: node {np.argmax(label != label[0])} is not connected to "
            "node 0. Remedy: share the nodes where beams meet, or make one body of each part"
        )


def per_element(section: Any, material: Any, count: int) -> tuple[list[BeamSection], list[Material | None]]:
    """Return one section and one material (None: the section needs none) for each element."""
    table: dict[str, list[Any]] = {}
    for name, given in (("section", section), ("material", material)):
        several = isinstance(given, (Sequence, np.ndarray)) and not isinstance(given, str)
        items = list(given) if several else [given] * count
        if len(items) != count:
            raise ModelError(f"{len(items)} {name}s for {count} elements. Remedy: one for all, or one for each element")
        table[name] = items
    for number, (item, of) in enumerate(zip(table["section"], table["material"], strict=True)):
        if not isinstance(item, BeamSection):
            raise ModelError(f"the section of element {number} is {item!r}. Remedy: a section, as kanefe_fem.Section")
        check_material(item, of, f"element {number}")
    return table["section"], table["material"]


def check_material(section: BeamSection, material: Any, where: str) -> None:
    """Raise a ModelError if a section needs a material and has none, or has one that it does not need."""
    missing = [a for a in ("E", "shear_modulus", "rho") if not hasattr(material, a)] if section.needs_material else []
    if missing:
        raise ModelError(
            f"the material of {where} is {material!r}, which has no {missing[0]}. Remedy: kanefe_fem.Material, or a "
            "section by stiffness, Section.from_stiffness(...)"
        )
    if material is not None and not section.needs_material:
        raise ModelError(
            f"{where} has a material, and a section that has stiffness and mass of its own. Remedy: leave the material "
            "out (None)"
        )


def warn_of_beam_units(
    lengths: np.ndarray, masses: list[LineMass], stiffness: np.ndarray, materials: list[Material | None]
) -> None:
    """Warn (UnitWarning) of a frame of beams that is probably not in SI units.

    Beams may be kilometres long (cables, pipelines), so that only mass, density and the speed of waves are checked.

    Parameters
    ----------
    lengths : ndarray, shape (m,)
        Lengths of the elements, m.
    masses, materials : lists of m
    stiffness : ndarray, shape (m, 6, 6)
        Stiffness of the sections.
    """
    rho_A = np.array([mass.rho_A for mass in masses])
    odd = odd_mass(float(rho_A @ lengths))
    speeds = np.sqrt(stiffness[:, 0, 0] / rho_A)
    for material in {id(material): material for material in materials}.values():
        if material is not None:
            odd += odd_material(material.E, material.rho)
            continue
        own = speeds[[other is None for other in materials]]
        wrong = own[(own < WAVE_SPEED[0]) | (own > WAVE_SPEED[1])]
        if wrong.size:
            odd.append(f"the speed of waves along it, sqrt(EA/rho_A), is {wrong[0]:.3g} m/s")
    if odd:
        warnings.warn(
            f"the beams: {'; '.join(odd)}. Remedy: lengths in m, E in Pa, rho in kg/m3, EA in N, rho_A in kg/m",
            UnitWarning,
            stacklevel=outside(),
        )


def check_groups(groups: Groups, points: np.ndarray) -> dict[str, NodeGroup]:
    """Return the named groups of nodes; the reference point is the mean position."""
    if not isinstance(groups, Mapping):
        raise ModelError(f"groups must be a dict of names to node numbers, not {groups!r}")
    result = {}
    for name, given in groups.items():
        nodes = checked_indices(given, len(points), f"group {name!r} has the nodes")
        result[name] = NodeGroup(nodes, points[nodes].mean(axis=0))
    return result


def checked_indices(given: Any, count: int, what: str) -> np.ndarray:
    """Return indices below a count, ascending, each once; negative ones count from the end."""
    indices = np.atleast_1d(np.asarray(given))
    is_list = np.issubdtype(indices.dtype, np.integer) and indices.ndim == 1 and indices.size > 0
    if not is_list or (indices < -count).any() or (indices >= count).any():
        raise ModelError(f"{what} {given!r}. Remedy: numbers from 0 to {count - 1}")
    return np.unique(indices % count)
