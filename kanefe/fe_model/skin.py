"""The skin of a body, and the parts of it that places select."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.cut_facets import tell_cut
from kanefe.fe_model.interface import Interface, as_interface
from kanefe.fe_model.model import COMPONENTS, Cells, FiniteElementModel, NodeGroup
from kanefe.fe_model.places import PlaceLike, contained
from kanefe.fe_model.shapes import FACES, MIDS, corner_kind, row_numbers, shape, stretches

_DEGREE = 4
"""Degree of the quadrature: exact for two quadratic shapes on straight facets; the area of curved facets is not a
polynomial."""


def with_places(
    model: FiniteElementModel, interfaces: Mapping[str, str | Interface]
) -> tuple[FiniteElementModel, dict[str, str | Interface]]:
    """Return the model with a group for each interface that is given by a place, and the interfaces by groups.

    Raises
    ------
    ModelError
        If no part of the body is in a place.
    """
    if not isinstance(interfaces, Mapping):
        raise ModelError(
            f"interfaces must be a dict of names to kinds, such as {{'root': 'clamped'}}, not {interfaces!r}"
        )
    groups, named = dict(model.groups), dict(interfaces)
    for name, given in interfaces.items():
        spec = as_interface(name, given)
        if spec.at is None:
            continue
        group = name if name not in groups else f"{name} (by its place)"
        label = f"interface {name!r}"
        is_shell = set(COMPONENTS) <= set(model.components)
        groups[group] = group_at(model.nodes, model.cells, spec.at, label, is_shell=is_shell)
        named[name] = replace(spec, at=None, groups=(group,))
    return replace(model, groups=groups), named


def group_at(
    nodes: np.ndarray, cells: Sequence[Cells], place: PlaceLike, label: str, *, is_shell: bool = False
) -> NodeGroup:
    """Return the nodes in a place as a group, with its measure if they are facets of the body's skin.

    `is_shell`: cells of surfaces are shells, as for `facets_at`.

    Raises
    ------
    ModelError
        If there are none; `label` names their purpose.
    """
    facets = facets_at(nodes, cells, place, label, is_shell=is_shell)
    if facets:
        return facet_group(nodes, facets)
    inside = contained(nodes, place, label)
    outside = skin(cells) + (_surfaces(cells) if is_shell else ())
    if outside:
        on_skin = np.zeros(len(nodes), dtype=bool)
        for block in outside:
            on_skin[block.nodes] = True
        inside &= on_skin
    found = np.flatnonzero(inside)
    if not len(found):
        low, high = nodes.min(axis=0).tolist(), nodes.max(axis=0).tolist()
        raise ModelError(
            f"{label}: there is no node on the outside of the body at {place!r}; the body extends from {low} to {high} "
            "m. Remedy: a larger distance, or another place"
        )
    return NodeGroup(found, nodes[found].mean(axis=0))


def facets_at(
    nodes: np.ndarray, cells: Sequence[Cells], place: PlaceLike, label: str, *, is_shell: bool = False
) -> tuple[Cells, ...]:
    """Return the facets of the skin whose corners are all in a place; none if there are none.

    Of a shell the surface itself comes first, then its edges, then the lines between its cells.
    """
    inside = contained(nodes, place, label)
    surfaces = _surfaces(cells) if is_shell else ()
    solids = [block for block in cells if shape(block.kind).dimension == 3]
    faces = (*skin(solids), *surfaces) if is_shell else skin(cells)
    if found := _inside(faces, inside):
        tell_cut(nodes, faces, inside, place, label)
        return found
    if not is_shell:
        return ()
    return _inside(skin(surfaces), inside) or sides_at(nodes, cells, place, label)


def sides_at(nodes: np.ndarray, cells: Sequence[Cells], place: PlaceLike, label: str) -> tuple[Cells, ...]:
    """Return the sides of the cells of surfaces whose ends are in a place, each once; none if there are none."""
    return _inside(_sides(_surfaces(cells)), contained(nodes, place, label))


def _surfaces(cells: Sequence[Cells]) -> tuple[Cells, ...]:
    return tuple(block for block in cells if shape(block.kind).dimension == 2)


def _sides(surfaces: Sequence[Cells]) -> tuple[Cells, ...]:
    """Return the sides of all cells of surfaces, each once."""
    found: dict[str, list[np.ndarray]] = {}
    for block in surfaces:
        for side in FACES[corner_kind(block.kind)]:
            kind, columns = facet_of(block.kind, side)
            found.setdefault(kind, []).append(block.nodes[:, list(columns)])
    tables = {kind: np.concatenate(own) for kind, own in found.items()}
    once = {kind: np.unique(np.sort(own[:, :2], axis=1), axis=0, return_index=True)[1] for kind, own in tables.items()}
    return tuple(Cells(kind, own[once[kind]]) for kind, own in tables.items())


def _inside(blocks: Sequence[Cells], inside: np.ndarray) -> tuple[Cells, ...]:
    """Return the facets whose corners are all inside."""
    found = []
    for block in blocks:
        whole = inside[block.nodes[:, : shape(block.kind).corners]].all(axis=1)
        if whole.any():
            found.append(Cells(block.kind, block.nodes[whole]))
    return tuple(found)


def skin(cells: Sequence[Cells]) -> tuple[Cells, ...]:
    """Return the facets that bound one cell only, oriented by the outward normal; lines have none."""
    found: dict[str, list[np.ndarray]] = {}
    corners: dict[int, list[np.ndarray]] = {}
    for block in cells:
        for face in FACES.get(corner_kind(block.kind), ()):
            kind, columns = facet_of(block.kind, face)
            found.setdefault(kind, []).append(block.nodes[:, list(columns)])
    result = []
    for kind, tables in found.items():
        corners.setdefault(shape(kind).corners, []).extend(tables)
    for kind, tables in found.items():
        count = shape(kind).corners
        every = np.sort(np.concatenate([table[:, :count] for table in corners[count]]), axis=1)
        own = np.concatenate(tables)
        keys = row_numbers(np.vstack((every, np.sort(own[:, :count], axis=1))))
        once = np.bincount(keys[: len(every)], minlength=keys.max() + 1) == 1
        outer = own[once[keys[len(every) :]]]
        if len(outer):
            result.append(Cells(kind, outer))
    return tuple(result)


def facet_of(kind: str, face: tuple[int, ...]) -> tuple[str, tuple[int, ...]]:
    """Return the shape and the nodes of a facet of a cell with these corners."""
    mids = {frozenset(mid): shape(kind).corners + i for i, mid in enumerate(MIDS[kind])}
    linear, *quadratic = {2: ("line", "line3"), 3: ("triangle", "triangle6"), 4: ("quad", "quad9", "quad8")}[len(face)]
    for candidate in quadratic:
        columns = [mids.get(frozenset(face[c] for c in mid)) for mid in MIDS[candidate]]
        if None not in columns:
            return candidate, (*face, *(column for column in columns if column is not None))
    return linear, face


def facet_group(nodes: np.ndarray, facets: Sequence[Cells]) -> NodeGroup:
    """Return the nodes of facets or lines, at their centroid and with the integrals int N_i N_j."""
    members = np.unique(np.concatenate([block.nodes.reshape(-1) for block in facets]))
    measure = _measure(nodes, facets, members)
    total = measure.sum()
    if not total > 0.0:
        return NodeGroup(members, nodes[members].mean(axis=0))
    return NodeGroup(members, np.asarray(measure.sum(axis=0)).ravel() @ nodes[members] / total, measure)


def _measure(nodes: np.ndarray, blocks: Sequence[Cells], members: np.ndarray) -> sp.csr_matrix:
    """Return int N_i N_j over blocks of facets or lines, shape (members, members)."""
    total = sp.csr_matrix((len(members), len(members)))
    for block in blocks:
        at = np.searchsorted(members, block.nodes)
        weights, values, sizes = zip(*stretches(block.kind, nodes[block.nodes], _DEGREE), strict=True)
        products = np.einsum("q,qi,qj->qij", weights, values, values).reshape(len(weights), -1)
        entries = np.stack(sizes, axis=1) @ products
        count = block.nodes.shape[1]
        rows, columns = np.repeat(at, count, axis=1), np.tile(at, (1, count))
        total += sp.csr_matrix((entries.ravel(), (rows.ravel(), columns.ravel())), total.shape)
    return total
