"""Segmented bodies in results: the segments "NAME 1", "NAME 2", ... read as one body called NAME."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kanefe.bodies.segmented import CUT
from kanefe.fe_model.model import Cells, Elasticity
from kanefe.frames import euler_parameters_from_matrix, rotation_matrices, rotation_vector
from kanefe.results.body_shape import BodyShape
from kanefe.storage.scipy_later import sp


def segments_of(shapes: Mapping[str, BodyShape], name: str) -> tuple[str, ...]:
    """Return the names of the segments of a segmented body along its line; none if there is no such body."""
    first = shapes.get(f"{name} 1")
    count = 0 if first is None else first.provenance.get("segment", {}).get("count", 0)
    names = tuple(f"{name} {number + 1}" for number in range(count))
    whole = all(n in shapes and shapes[n].provenance.get("segment", {}).get("number") == i for i, n in enumerate(names))
    return names if whole else ()


def wholes_of(shapes: Mapping[str, BodyShape]) -> dict[str, tuple[str, ...]]:
    """Return the segments of each segmented body of a run, by its name."""
    starts = [name[:-2] for name in shapes if name.endswith(" 1") and name[:-2] not in shapes]
    return {name: found for name in starts if (found := segments_of(shapes, name))}


def whole_shape(name: str, parts: Sequence[BodyShape]) -> BodyShape:
    """Return the shape of a segmented body from those of its segments.

    Its first nodes are those of the whole, in their numbers there. The nodes of cuts follow a second time, as those of
    the segments further from the base: each has its own frame, relative to which its nodes are displaced.
    """
    places = [part.provenance["segment"] for part in parts]
    base, (numbers, count) = places[0]["base"], _numbers(places)
    extra = 1 + max(int(own.max()) for own in numbers)
    width = len(parts[0].components)
    points, blocks = np.zeros((extra, 3)), []
    for i, part in enumerate(parts):
        points[numbers[i]] = part.nodes + np.array(places[i]["origin"])
        rows = (numbers[i][:, None] * width + np.arange(width)).ravel()
        own = sp.coo_matrix(part.basis)
        blocks.append(sp.csr_matrix((own.data, (rows[own.row], own.col)), (extra * width, own.shape[1])))
    cells = np.concatenate([place["cells"] for place in places])
    owner = parts[base]
    mass = sum(part.mass for part in parts)
    centres = [part.com + np.array(place["origin"]) for part, place in zip(parts, places, strict=True)]
    com = np.sum([part.mass * c for part, c in zip(parts, centres, strict=True)], axis=0) / mass
    inertia = sum(
        part.inertia + part.mass * ((c - com) @ (c - com) * np.eye(3) - np.outer(c - com, c - com))
        for part, c in zip(parts, centres, strict=True)
    )
    return replace(
        owner,
        name=name,
        mass=mass,
        com=com,
        inertia=np.asarray(inertia),
        interfaces=tuple(face for part in parts for face in part.interfaces if not face.startswith(CUT)),
        nodes=points,
        basis=sp.hstack(blocks, format="csr"),
        cells=_cells(parts, numbers, cells),
        elasticity=_elasticity(parts, cells),
        provenance={key: value for key, value in owner.provenance.items() if key != "segment"}
        | {"segments": len(parts), "whole_nodes": count}
        | ({"materials": dict.fromkeys(_materials(parts))} if "materials" in owner.provenance else {}),
        flexible=None,
        neighbours={face: value for part in parts for face, value in part.neighbours.items()},
    )


def parts_of_cells(parts: Sequence[BodyShape]) -> np.ndarray:
    """Return the number of the segment of each cell of the whole, in the order of its cells."""
    cells = [place["cells"] for place in (part.provenance["segment"] for part in parts)]
    of_cell = np.repeat(np.arange(len(parts)), [len(own) for own in cells])
    return of_cell[np.argsort(np.concatenate(cells))] if _one_kind(parts) else of_cell


def numbers_of_parts(shapes: Mapping[str, BodyShape], names: Sequence[str]) -> np.ndarray:
    """Return the number in the whole of each node of the segments, one segment after the other."""
    return np.concatenate(_numbers([shapes[name].provenance["segment"] for name in names])[0])


def _numbers(places: Sequence[Mapping[str, Any]]) -> tuple[list[np.ndarray], int]:
    """Return the numbers of each segment's nodes in the shape of the whole, and how many the whole has."""
    count = 1 + max(max(place["nodes"]) for place in places)
    owned, extra, numbers = np.zeros(count, dtype=bool), count, [np.zeros(0, dtype=int)] * len(places)
    for i in sorted(range(len(places)), key=lambda i: abs(i - places[0]["base"])):
        nodes = np.array(places[i]["nodes"])
        twice = owned[nodes]
        owned[nodes] = True
        nodes[twice] = extra + np.arange(twice.sum())
        numbers[i], extra = nodes, extra + int(twice.sum())
    return numbers, count


def _one_kind(parts: Sequence[BodyShape]) -> bool:
    return len({block.kind for part in parts for block in part.cells}) == 1


def _cells(parts: Sequence[BodyShape], numbers: Sequence[np.ndarray], cells: np.ndarray) -> tuple[Cells, ...]:
    """Return the cells of all segments: in the order of the whole, if they are of one kind."""
    blocks = [Cells(b.kind, numbers[i][b.nodes]) for i, part in enumerate(parts) for b in part.cells]
    if not _one_kind(parts):
        return tuple(blocks)
    return (Cells(blocks[0].kind, np.concatenate([b.nodes for b in blocks])[np.argsort(cells)]),)


def _materials(parts: Sequence[BodyShape]) -> list[str]:
    return list(dict.fromkeys(name for part in parts for name in part.provenance.get("materials", {})))


def _elasticity(parts: Sequence[BodyShape], cells: np.ndarray) -> Elasticity | None:
    own = [part.elasticity for part in parts]
    if any(one is None for one in own):
        return None
    given: list[Elasticity] = [one for one in own if one is not None]
    tables, rows = [one.table for one in given], [one.of_cell for one in given]
    named = _materials(parts)
    if named and all(len(p.provenance["materials"]) == len(t) for p, t in zip(parts, tables, strict=True)):
        table = np.zeros((len(named), 6, 6))
        for i, part in enumerate(parts):
            place = np.array([named.index(name) for name in part.provenance["materials"]])
            table[place] = tables[i]
            rows[i] = place[rows[i]]
    elif all(np.array_equal(t, tables[0]) for t in tables):
        table = tables[0]
    else:
        starts = np.cumsum([0, *(len(t) for t in tables)])
        table, rows = np.concatenate(tables), [r + s for r, s in zip(rows, starts, strict=False)]
    order = np.argsort(cells) if _one_kind(parts) else np.arange(len(cells))
    axes = None if given[0].axes is None else np.concatenate([np.asarray(one.axes) for one in given])[order]
    fibres = given[0].fibres if len(table) == len(tables[0]) else None
    return Elasticity(table, np.concatenate(rows)[order], axes, fibres)


def whole_motion(
    quantity: str,
    shapes: Sequence[BodyShape],
    interface: str | None,
    of: str | None,
    read: Callable[..., np.ndarray],
) -> np.ndarray:
    """Return a quantity of a segmented body by `read(quantity, segment, interface, of)` of its segments."""
    base = shapes[0].provenance["segment"]["base"]
    names = [shape.name for shape in shapes]
    owner = next((s for s in shapes if interface is not None and interface in s.interfaces), shapes[base])
    if quantity == "deflection" and interface is not None:
        return _deflection(owner, interface, names[base], read)
    if quantity in ("modal_coordinates", "modal_speeds"):
        return np.concatenate([read(quantity, name) for name in names], axis=-1)
    if quantity == "center_of_mass":
        mass = np.array([shape.mass for shape in shapes])
        return np.asarray(sum(m * read(quantity, n) for m, n in zip(mass, names, strict=True)) / mass.sum())
    return read(quantity, owner.name, interface, of)


def _deflection(owner: BodyShape, interface: str, base: str, read: Callable[..., np.ndarray]) -> np.ndarray:
    """Return translation and rotation vector of an interface from its undeformed place in G of the whole, (T, 6)."""
    A_NG = rotation_matrices(read("rotation", base))
    A_Nn = rotation_matrices(read("rotation", owner.name, interface))
    A_Gn = A_NG.transpose(0, 2, 1) @ A_Nn
    moved = np.einsum("tba,tb->ta", A_NG, read("position", owner.name, interface) - read("position", base))
    place: Any = owner.provenance["segment"]["interfaces"][interface]
    turned = A_Gn @ np.array(place["axes"]).T
    return np.concatenate(
        [moved - np.array(place["position"]), [rotation_vector(euler_parameters_from_matrix(A)) for A in turned]],
        axis=1,
    )
