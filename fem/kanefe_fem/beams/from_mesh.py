"""Frames of beams from the line elements of a mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.model import FiniteElementModel
from kanefe.fe_model.source import changed_model
from kanefe_fem.beams.beam_section import BeamSection
from kanefe_fem.beams.body import Theory, beam_model

if TYPE_CHECKING:
    from kanefe_fem.materials.isotropic import Material
    from kanefe_fem.mesh.mesh import Mesh


@checked("mesh", "sections")
def beam_model_from_mesh(
    mesh: Mesh | str | Path,
    sections: Mapping[str, BeamSection],
    materials: Material | Mapping[str, Material | None] | None = None,
    *,
    theory: Theory = "timoshenko",
    planar: bool = False,
    orientation: Sequence[float] | Mapping[str, Sequence[float]] | None = None,
    rotary_inertia: bool = True,
) -> FiniteElementModel:
    """Return the model of a frame whose beams are the line elements (of order 1) of a mesh.

    The groups of the model are the mesh's groups of points that lie on beams, and of the groups of lines that have a
    section; these are also its lines for loads.

    Parameters
    ----------
    mesh : Mesh, str or Path
        From `kanefe_fem.read_mesh`, or the file.
    sections : mapping of str to BeamSection
        Section of each group of lines. In a mesh with lines only, every group must have one; in a mesh with surfaces or
        volumes, lines of other groups are ignored.
    materials : Material or mapping of str to Material, optional
        For all, or by group; None for sections by stiffness.
    orientation : array_like, shape (3,), or mapping of str to such, optional
        As in `beam_model`, for all or by group; every group of `sections` if by group.
    theory, planar, rotary_inertia
        As in `beam_model`.

    Returns
    -------
    FiniteElementModel
        As from `beam_model`, without the nodes that no beam uses.

    Raises
    ------
    ModelError
        If a group has no section, material or orientation, or as `beam_model` (with the numbers of the model).
    MeshError
        If there is no such group of lines, the lines are of order 2, or a line lies in two of the groups.

    Examples
    --------
    >>> frame = beam_model_from_mesh("frame.msh", {"legs": Tube(0.05, 0.003)}, steel)  # doctest: +SKIP
    """
    from kanefe_fem.mesh_files import read_mesh

    if isinstance(mesh, (str, Path)):
        mesh = read_mesh(mesh)
    lines = {name: _lines_of(mesh, name) for name in sections}
    if not lines:
        raise ModelError(f"no sections for {mesh.source}. Remedy: one for each group of lines ({_known(mesh.lines)})")
    left_out = sorted(set(mesh.lines) - set(sections))
    if mesh.dimension == 1 and left_out:
        raise ModelError(f"the group of lines {left_out[0]!r} of {mesh.source} has no section. Remedy: add one")
    by_group: dict[str, Mapping[str, Any]] = {"section": sections}
    for what, given in (("material", materials), ("orientation", orientation)):
        by_group[what] = given if isinstance(given, Mapping) else dict.fromkeys(sections, given)
        for name in sections:
            if name not in by_group[what]:
                raise ModelError(
                    f"the group of lines {name!r} has no {what}. Remedy: one for each group, or one for all"
                )

    def spread(what: str) -> list[Any]:
        return [by_group[what][name] for name, table in lines.items() for _ in table]

    table = np.concatenate(list(lines.values()))
    _refuse_shared_lines(table, np.repeat(list(lines), [len(block) for block in lines.values()]), mesh.source)
    used, numbers = np.unique(table, return_inverse=True)
    points = {name: np.searchsorted(used, np.intersect1d(nodes, used)) for name, nodes in mesh.points.items()}
    model = beam_model(
        mesh.nodes[used],
        numbers.reshape(table.shape),
        spread("section"),
        spread("material"),
        theory=theory,
        planar=planar,
        orientation=None if orientation is None else spread("orientation"),
        rotary_inertia=rotary_inertia,
        groups={name: nodes.tolist() for name, nodes in points.items() if nodes.size},
        lines=_element_numbers(lines),
    )
    source = {"source": "kanefe_fem.beam_model_from_mesh", "mesh": mesh.source, **mesh.provenance}
    return changed_model(model, lambda made: replace(made, provenance={**made.provenance, **source}))


def _lines_of(mesh: Mesh, name: str) -> np.ndarray:
    """Return the nodes of a group of straight lines, shape (m, 2)."""
    if name not in mesh.lines:
        raise MeshError(
            f"{mesh.source} has no group of lines called {name!r}. Remedy: one of those it has ({_known(mesh.lines)}), "
            "or name a physical curve so"
        )
    blocks = mesh.lines[name]
    curved = [block.kind for block in blocks if block.kind != "line"]
    if curved:
        raise MeshError(f"the lines of group {name!r} are of kind {curved[0]!r}. Remedy: mesh with order 1 for beams")
    return np.concatenate([block.nodes for block in blocks])


def _element_numbers(lines: Mapping[str, np.ndarray]) -> dict[str, list[int]]:
    """Return the numbers of each group's elements in the concatenation of all groups."""
    ends = np.cumsum([len(table) for table in lines.values()])
    return {name: list(range(end - len(table), end)) for (name, table), end in zip(lines.items(), ends, strict=True)}


def _refuse_shared_lines(table: np.ndarray, owner: np.ndarray, source: str) -> None:
    _, first, inverse = np.unique(np.sort(table, axis=1), axis=0, return_index=True, return_inverse=True)
    other = np.flatnonzero(owner[first[inverse.ravel()]] != owner)
    if other.size:
        line = other[0]
        raise MeshError(
            f"the line between nodes {table[line].tolist()} of {source} is in the groups "
            f"{str(owner[first[inverse.ravel()[line]]])!r} and {str(owner[line])!r}. "
            "Remedy: give a section to one of them only"
        )


def _known(names: Mapping[str, Any]) -> str:
    return ", ".join(sorted(names)) or "none"
