"""Faces and edges of a shell that carry distributed loads: their integrals, with arms through the thickness.

A load on a face acts at its height, ``x + z n``, and moves with it, ``u + z theta x n``: so a uniform pressure on a
closed shell has no resultant, on either side, and the forces of a traction have their moments about the nodes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.cut_facets import tell_cut
from kanefe.fe_model.load_pattern import NodalPattern, PatternKind
from kanefe.fe_model.loaded_face import FacetBlock, LoadedFace
from kanefe.fe_model.model import COMPONENTS
from kanefe.fe_model.place_field import LoadShape, PlaceField, field_of
from kanefe.fe_model.places import Place, PlaceLike, contained
from kanefe.fe_model.shapes import shape
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.shells.directors import Directors
from kanefe_fem.shells.of_groups import ShellGroup
from kanefe_fem.shells.stack import BlockOfGroup

SIDES = {"top": 1.0, "middle": 0.5, "bottom": 0.0}
"""Heights of the sides, as fractions of the thickness."""


@checked
@dataclass(frozen=True)
class ShellFace:
    """A face of a shell that carries distributed loads.

    Parameters
    ----------
    side : {"top", "bottom", "middle"}
        The top is where the normal of the shell points. A positive pressure pushes inward, against the normal on the
        top and along it on the bottom; on the middle it acts as on the top.
    of : str, Place or function of nodes (n, 3) -> bool (n,), optional
        A group of cells, or the cells whose corners are all in a place. Default: all cells.

    Raises
    ------
    ModelError
        If there is no such side.

    Examples
    --------
    >>> inside = ShellFace("bottom")
    """

    side: Literal["top", "bottom", "middle"] = "top"
    of: str | PlaceLike | None = None


Surfaces = Sequence[str] | Mapping[str, str | PlaceLike | ShellFace | LoadShape]


@dataclass(frozen=True)
class Loaded:
    """What carries a load: a face or a group of lines, and by what the load varies."""

    what: ShellFace | str
    over: PlaceField | None = None


def checked_surfaces(mesh: Mesh, surfaces: Any) -> dict[str, Loaded]:
    """Return the faces and the groups of lines that are asked for, by name.

    Raises
    ------
    ModelError
        If one is neither a group of the mesh nor a face; the message lists the groups.
    """
    if isinstance(surfaces, str) or not isinstance(surfaces, Mapping | Sequence):
        raise ModelError(f"surfaces={surfaces!r} of a shell. Remedy: a list of names, or a dict of names to ShellFace")
    given = surfaces if isinstance(surfaces, Mapping) else {name: name for name in surfaces}
    known, lines = sorted(set(mesh.cells) - {""}), sorted(set(mesh.facets) - {""})
    found: dict[str, Loaded] = {}
    for name, what in given.items():
        over = None
        if isinstance(what, LoadShape):
            what, over = what.of, field_of(what, name)
        if isinstance(what, str) and what in mesh.facets and what not in mesh.cells:
            found[name] = Loaded(what, over)
            continue
        face = what if isinstance(what, ShellFace) else ShellFace(of=what)
        of_place = isinstance(face.of, Place) or callable(face.of) or face.of is None
        if not isinstance(name, str) or not (of_place or face.of in mesh.cells):
            raise ModelError(
                f"{mesh.source} has no group of cells {face.of!r} for the surface {name!r} of a shell. It has: "
                f"{', '.join(known) or 'none'}; of lines, for loads per length: {', '.join(lines) or 'none'}. Remedy: "
                "one of them, or ShellFace('top', of=...)"
            )
        found[name] = Loaded(face, over)
    return found


def shell_patterns(
    mesh: Mesh,
    surfaces: Mapping[str, Loaded],
    groups: Mapping[str, ShellGroup],
    blocks: Sequence[BlockOfGroup],
    found: Directors,
) -> dict[str, NodalPattern]:
    """Return the patterns of loads of checked faces and lines."""
    patterns = {}
    for name, loaded in surfaces.items():
        kind: PatternKind = "line" if isinstance(loaded.what, str) else "surface"
        if isinstance(loaded.what, str):
            own = _of_line(mesh, loaded.what)
        else:
            own = _of_face(mesh, name, loaded.what, groups, blocks, found)
        face = LoadedFace(tuple(own), len(mesh.nodes), len(COMPONENTS))
        patterns[name] = NodalPattern.of_face(face, loaded.over, kind)
    return patterns


def _of_line(mesh: Mesh, group: str) -> list[FacetBlock]:
    blocks = mesh.facets[group]
    return [FacetBlock(one.kind, one.nodes, mesh.nodes[one.nodes], np.ones(len(one.nodes))) for one in blocks]


def _of_face(
    mesh: Mesh,
    name: str,
    face: ShellFace,
    groups: Mapping[str, ShellGroup],
    blocks: Sequence[BlockOfGroup],
    found: Directors,
) -> list[FacetBlock]:
    own, made, along = list(groups.values()), [], 1.0 if face.side == "bottom" else -1.0
    for block, chosen in zip(blocks, _chosen(mesh, name, face, list(groups), blocks), strict=True):
        layers = own[block.group].section.layers
        height = layers[0].bottom + SIDES[face.side] * (layers[-1].top - layers[0].bottom)
        table = block.cells.nodes[chosen]
        arm = height * block.thickness[chosen][..., None] * found.normal[block.sides[chosen]]
        made.append(FacetBlock(block.cells.kind, table, mesh.nodes[table] + arm, np.full(len(table), along), arm))
    return made


def _chosen(
    mesh: Mesh, name: str, face: ShellFace, groups: Sequence[str], blocks: Sequence[BlockOfGroup]
) -> list[np.ndarray]:
    """Return which cells of each block belong to a face."""
    inside, label = np.ones(len(mesh.nodes), dtype=bool), f"surface {name!r}"
    place = None if isinstance(face.of, str) else face.of
    if place is not None:
        inside = contained(np.asarray(mesh.nodes), place, label)
    chosen = []
    for block in blocks:
        corners = block.cells.nodes[:, : shape(block.cells.kind).corners]
        is_meant = not isinstance(face.of, str) or face.of == groups[block.group]
        chosen.append(inside[corners].all(axis=1) & is_meant)
    if not any(one.any() for one in chosen):
        raise ModelError(
            f"{mesh.source}: no cell has all its corners in the surface {name!r}, {face.of!r}. Remedy: a larger place"
        )
    if place is not None:
        tell_cut(np.asarray(mesh.nodes), [block.cells for block in blocks], inside, place, label)
    return chosen
