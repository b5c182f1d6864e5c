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
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.model import COMPONENTS
from kanefe.fe_model.places import Place, PlaceLike, contained
from kanefe.fe_model.pressure_change import PushedFace, pressure_change
from kanefe.fe_model.shapes import quadrature, shape
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.shells.directors import Directors
from kanefe_fem.shells.of_groups import ShellGroup
from kanefe_fem.shells.stack import BlockOfGroup

DEGREE = 8
"""Degree of quadrature: exact for pressures on curved cells of second order."""

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


Surfaces = Sequence[str] | Mapping[str, str | PlaceLike | ShellFace]


def checked_surfaces(mesh: Mesh, surfaces: Any) -> dict[str, ShellFace | str]:
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
    found: dict[str, ShellFace | str] = {}
    for name, what in given.items():
        if isinstance(what, str) and what in mesh.facets and what not in mesh.cells:
            found[name] = what
            continue
        face = what if isinstance(what, ShellFace) else ShellFace(of=what)
        of_place = isinstance(face.of, Place) or callable(face.of) or face.of is None
        if not isinstance(name, str) or not (of_place or face.of in mesh.cells):
            raise ModelError(
                f"{mesh.source} has no group of cells {face.of!r} for the surface {name!r} of a shell. It has: "
                f"{', '.join(known) or 'none'}; of lines, for loads per length: {', '.join(lines) or 'none'}. Remedy: "
                "one of them, or ShellFace('top', of=...)"
            )
        found[name] = face
    return found


def shell_patterns(
    mesh: Mesh,
    surfaces: Mapping[str, ShellFace | str],
    groups: Mapping[str, ShellGroup],
    blocks: Sequence[BlockOfGroup],
    found: Directors,
) -> dict[str, NodalPattern]:
    """Return the patterns of loads of checked faces and lines."""
    return {
        name: _of_line(mesh, what) if isinstance(what, str) else _of_face(mesh, name, what, groups, blocks, found)
        for name, what in surfaces.items()
    }


def _of_line(mesh: Mesh, group: str) -> NodalPattern:
    nodes, shares = np.asarray(mesh.nodes), np.zeros(len(mesh.nodes))
    for block in mesh.facets[group]:
        values, weights, tangents = _at_points(block.kind, nodes[block.nodes])
        length = np.linalg.norm(tangents[..., 0], axis=2)
        np.add.at(shares, block.nodes, np.einsum("mp,p,pn->mn", length, weights, values))
    return NodalPattern.of_nodes(nodes, COMPONENTS, shares, kind="line")


def _of_face(
    mesh: Mesh,
    name: str,
    face: ShellFace,
    groups: Mapping[str, ShellGroup],
    blocks: Sequence[BlockOfGroup],
    found: Directors,
) -> NodalPattern:
    nodes, own = np.asarray(mesh.nodes), list(groups.values())
    first, traction, area = np.zeros(3), np.zeros((len(nodes), 6, 3)), 0.0
    pushed, along = [], 1.0 if face.side == "bottom" else -1.0
    for block, chosen in zip(blocks, _chosen(mesh, name, face, list(groups), blocks), strict=True):
        layers = own[block.group].section.layers
        height = layers[0].bottom + SIDES[face.side] * (layers[-1].top - layers[0].bottom)
        table = block.cells.nodes[chosen]
        arm = height * block.thickness[chosen][..., None] * found.normal[block.sides[chosen]]
        places = nodes[table] + arm
        values, weights, tangents = _at_points(block.cells.kind, places)
        stretch = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=2)
        shares = np.einsum("mp,p,pn->mn", stretch, weights, values)
        forces = shares[..., None, None] * np.eye(3)
        np.add.at(traction, table, np.concatenate((forces, np.cross(arm[..., None], forces, axis=2)), axis=2))
        area, first = area + shares.sum(), first + np.einsum("mn,mni->i", shares, places)
        pushed.append(PushedFace(block.cells.kind, table, places, np.full(len(table), along), arm))
    change = pressure_change(pushed, len(nodes), len(COMPONENTS))
    return NodalPattern(
        kind="surface",
        measure=float(area),
        first=first,
        traction=traction.reshape(-1, 3),
        pressure=change.on_components,
        pressure_force=change.forces.sum(axis=0),
        pressure_moment=np.cross(change.points, change.forces).sum(axis=0),
        pressure_change=change,
    )


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


def _at_points(kind: str, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return shape functions at the points of the quadrature, weights, and tangents (m, p, 3, d)."""
    points, weights = quadrature(kind, DEGREE)
    element = shape(kind)
    return element.values(points), weights, np.einsum("pna,mni->mpia", element.gradients(points), x)
