"""The whole that is cut: its cells along a centre line, divided into segments, and the model of each."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from scipy.spatial import cKDTree

from kanefe.bodies.segmented import CUT
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.fe_model.interface import Interface, as_interface
from kanefe.fe_model.model import Cells, FiniteElementModel, NodeGroup
from kanefe.fe_model.place_field import LoadShape
from kanefe.fe_model.shapes import shape
from kanefe.fe_model.skin import skin, with_places
from kanefe_fem.materials.damping import losses_of
from kanefe_fem.mesh.groups import check_interfaces, group_nodes
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.segments.beam_parts import beam_chain, beam_part
from kanefe_fem.segments.centre_line import arc_lengths, check_line, found_line, given_line, stations, width_across
from kanefe_fem.solids.model import solid_model

MOVED, TRIED, NEARNESS = 0.3, 241, 0.02
"""How far a cut may be moved, relative to a segment; number of places tried; weight of the way against the depth."""

SOFTER = 2.6
"""Compliance due to a cut that is not flat, relative to its depth over the length of a segment: up to 2.5 in bars."""

FELT = 0.01
"""Compliance due to cuts that are not flat, relative to the body's, from which it is reported."""


@dataclass(frozen=True, eq=False)
class Division:
    """A division into k segments.

    Attributes
    ----------
    of_cell : ndarray of int
        Segment of each cell.
    nodes : tuple of k ndarray of int
        Nodes of each segment.
    faces : tuple of k - 1 ndarray of int
        Nodes of each cut.
    middles : ndarray, shape (k - 1, 3)
        Centres of the cuts, m.
    facets : tuple of k - 1 tuples of Cells
        Of the cuts of a solid; empty for beams.
    """

    of_cell: np.ndarray
    nodes: tuple[np.ndarray, ...]
    faces: tuple[np.ndarray, ...]
    middles: np.ndarray
    facets: tuple[tuple[Cells, ...], ...] = ()


class Whole(Protocol):
    """A slender body that can be divided.

    Attributes
    ----------
    nodes : ndarray, shape (n, 3)
    line : ndarray, shape (p, 3)
    interfaces : dict of str to Interface
        By groups.
    """

    nodes: np.ndarray
    line: np.ndarray
    interfaces: dict[str, Interface]

    def group(self, name: str) -> np.ndarray:
        """Return the nodes of a group."""
        ...

    def divided(self, count: int) -> Division:
        """Return the division into equal lengths."""
        ...

    def part(
        self, division: Division, number: int, origin: np.ndarray
    ) -> tuple[FiniteElementModel, np.ndarray, np.ndarray]:
        """Return the model of a segment about an origin, and the numbers in the whole of its nodes and cells."""
        ...


class BeamWhole:
    """A chain of beam elements."""

    def __init__(self, model: FiniteElementModel, interfaces: Mapping[str, Any]) -> None:
        if model.damping is not None or model.structural is not None or model.viscoelastic:
            raise ModelError(
                "the materials of a beam that is cut into segments are damped, and its segments would not be. Remedy: "
                "materials without, and damping= of the segments"
            )
        model, named = with_places(model, interfaces)
        groups, self.interfaces = dict(model.groups), {}
        for name, given in named.items():
            spec = as_interface(name, given)
            if not spec.group_names(name):
                node = int(np.argmin(np.linalg.norm(model.nodes - np.array(spec.position), axis=1)))
                groups[f"{name} (node)"] = NodeGroup(np.array([node]), model.nodes[node])
                spec = replace(spec, position=None, groups=(f"{name} (node)",))
            self.interfaces[name] = spec
        self.chain = beam_chain(replace(model, groups=groups))
        self.nodes, self.line = model.nodes, model.nodes[self.chain.nodes]
        check_line(self.line, self.chain.width)

    def group(self, name: str) -> np.ndarray:
        """Return the nodes of a group."""
        return self.chain.model.group(name).nodes

    def divided(self, count: int) -> Division:
        """Return the division at the nodes nearest to equal lengths."""
        elements = len(self.chain.elements)
        if count > elements:
            raise ModelError(
                f"{count} segments of {elements} elements. Remedy: at most one segment an element, or a model of more "
                "elements"
            )
        s = arc_lengths(self.line)
        at = [0]
        for i in range(1, count):  # each segment has an element
            nearest = int(np.argmin(abs(s - s[-1] * i / count)))
            at.append(min(max(nearest, at[-1] + 1), elements - (count - i)))
        ends = [*at, elements]
        of_cell = np.empty(elements, dtype=int)
        of_cell[self.chain.elements] = np.repeat(np.arange(count), np.diff(ends))
        order = self.chain.nodes
        return Division(
            of_cell,
            tuple(order[a : b + 1] for a, b in pairwise(ends)),
            tuple(order[[i]] for i in ends[1:-1]),
            self.nodes[order[ends[1:-1]]],
        )

    def part(
        self, division: Division, number: int, origin: np.ndarray
    ) -> tuple[FiniteElementModel, np.ndarray, np.ndarray]:
        """Return the model of a segment, and the numbers of its nodes and elements."""
        elements = np.flatnonzero(division.of_cell == number)
        model, nodes = beam_part(self.chain, elements, origin)
        groups = dict(model.groups)
        for cut in _cuts_of(number, len(division.nodes)):
            node = int(np.searchsorted(nodes, division.faces[cut - 1][0]))
            groups[f"{CUT}{cut}"] = NodeGroup(np.array([node]), model.nodes[node])
        return replace(model, groups=groups), nodes, elements


class SolidWhole:
    """A mesh of a slender solid."""

    def __init__(self, mesh: Mesh, materials: Any, interfaces: Mapping[str, Any], line: object, keywords: Any) -> None:
        if mesh.dimension < 2:
            raise ModelError(f"{mesh.source} has lines only. Remedy: segmented(beam_model_from_mesh(...), ...)")
        for name in ("preload", "lumped", "forms"):
            if keywords.get(name):
                raise ModelError(f"a body with {name}= cannot be cut. Remedy: leave it out; masses as rigid bodies")
        _check_materials(materials)
        mesh = mesh.with_order(keywords.get("order", 2))
        surfaces = keywords.get("surfaces", ())
        if isinstance(surfaces, Mapping):
            if any(isinstance(what, LoadShape) for what in surfaces.values()):
                raise ModelError("a body that is cut takes no LoadShape. Remedy: over= of add_pressure or add_traction")
            mesh, surfaces = mesh.with_groups(surfaces), list(surfaces)
        self.interfaces = {}
        check_interfaces(mesh, interfaces)
        for name, given in interfaces.items():
            spec = as_interface(name, given)
            if spec.at is not None:
                group = f"{name} (by its place)"
                mesh = mesh.with_groups({group: spec.at})
                spec = replace(spec, at=None, groups=(group,))
            elif not spec.group_names(name):
                node = int(np.argmin(np.linalg.norm(mesh.nodes - np.array(spec.position), axis=1)))
                mesh = replace(mesh, points={**mesh.points, f"{name} (node)": np.array([node])})
                spec = replace(spec, position=None, groups=(f"{name} (node)",))
            self.interfaces[name] = spec
        self.mesh, self.materials = mesh, materials
        self.keywords = {**keywords, "surfaces": tuple(surfaces)}
        self.nodes = np.asarray(mesh.nodes)
        self.line = found_line(self.nodes, mesh.cell_blocks) if line is None else given_line(line)
        fixed = [n for n, spec in self.interfaces.items() if len(spec.fixed)]
        if line is None and fixed:  # from the end that is fixed
            held = self.nodes[self.group(self.interfaces[fixed[0]].group_names(fixed[0])[0])].mean(axis=0)
            if np.linalg.norm(self.line[-1] - held) < np.linalg.norm(self.line[0] - held):
                self.line = self.line[::-1].copy()
        at, distance = stations(self.nodes, self.line)
        self.ends, self.width = (float(at.min()), float(at.max())), width_across(distance)
        check_line(self.line, self.width)
        of_cells = [at[block.nodes] for block in mesh.cell_blocks]
        self.at, self.low, self.high = (
            np.concatenate([part(own, axis=1) for own in of_cells]) for part in (np.mean, np.min, np.max)
        )

    def group(self, name: str) -> np.ndarray:
        """Return the nodes of a group."""
        return group_nodes(self.mesh, name)

    def divided(self, count: int) -> Division:
        """Return the division by the stations of the cells' centres."""
        low, high = self.ends
        if (high - low) / count < self.width:
            raise ModelError(
                f"{count} segments of {(high - low) / count:.3g} m are shorter than the width of {self.width:.3g} m, "
                "too short for what the motion of their faces neglects to fade between them. Remedy: at most "
                f"{max(1, int((high - low) / self.width))} segments"
            )
        of_cell = np.searchsorted(self._cuts(count), self.at)
        skins = [self._skin(of_cell == number) for number in range(count)]
        nodes = tuple(
            np.unique(np.concatenate([b.nodes.ravel() for b in self._cells(of_cell == number)] or [np.zeros(0, int)]))
            for number in range(count)
        )
        faces, middles, facets = [], np.zeros((count - 1, 3)), []
        for number in range(count - 1):
            face = tuple(_shared(block, skins[number + 1]) for block in skins[number].values())
            face = tuple(block for block in face if len(block.nodes))
            if not face:
                raise ModelError(
                    f"there are no cells between the cuts of segment {number + 1} or {number + 2} of {count}. Remedy: "
                    "fewer segments, or a finer mesh along the line"
                )
            facets.append(face)
            faces.append(np.unique(np.concatenate([block.nodes.ravel() for block in face])))
            middles[number] = self.nodes[faces[-1]].mean(axis=0)
            for other in range(number + 2, count):
                if np.intersect1d(nodes[number], nodes[other]).size:
                    raise ModelError(
                        f"segments {number + 1} and {other + 1} of {count} touch each other. Remedy: fewer segments, a "
                        "finer mesh along the line, or the centre line as line="
                    )
        return Division(of_cell, nodes, tuple(faces), middles, tuple(facets))

    def _cuts(self, count: int) -> np.ndarray:
        """Return the stations of the cuts: near equal lengths, where they run deepest through no cell."""
        low, high = self.ends
        length = (high - low) / count
        tried = length * np.linspace(-MOVED, MOVED, TRIED)
        chosen, deepest = [], 0.0
        for nominal in low + length * np.arange(1, count):
            near = (self.high > nominal - MOVED * length) & (self.low < nominal + MOVED * length)
            at = (nominal + tried)[:, None]
            depth = np.minimum(at - self.low[near], self.high[near] - at).max(axis=1, initial=0.0)
            best = int(np.argmin(depth + NEARNESS * abs(tried)))
            chosen.append(float(at[best, 0]))
            deepest = max(deepest, float(depth[best]))
        if SOFTER * deepest > FELT * length:
            warnings.warn(
                f"cuts of {self.mesh.source} follow cells up to {deepest:.2g} m off a plane across the centre line, so "
                f"that the body may be {100 * SOFTER * deepest / length:.2g} % too soft (cuts='rigid': too stiff). "
                "Remedy: a mesh in layers across the line, as by extrusion, finer cells along it, or fewer segments",
                AccuracyWarning,
                stacklevel=outside(),
            )
        return np.array(chosen)

    def part(
        self, division: Division, number: int, origin: np.ndarray
    ) -> tuple[FiniteElementModel, np.ndarray, np.ndarray]:
        """Return the model of a segment, and the numbers of its nodes and cells."""
        mesh, wanted = self.mesh, division.of_cell == number
        skins = self._skin(wanted)
        cells, start = {}, 0
        for name, blocks in mesh.cells.items():
            kept = []
            for block in blocks:
                own = wanted[start : start + len(block.nodes)]
                start += len(block.nodes)
                kept.append(Cells(block.kind, block.nodes[own]))
            if any(len(block.nodes) for block in kept):
                cells[name] = tuple(block for block in kept if len(block.nodes))
        facets = {name: tuple(_shared(b, skins) for b in blocks) for name, blocks in mesh.facets.items()}
        for cut in _cuts_of(number, len(division.nodes)):
            facets[f"{CUT}{cut}"] = division.facets[cut - 1]
        inside = np.isin(np.arange(len(mesh.nodes)), division.nodes[number])
        place = np.cumsum(inside) - 1

        def renumbered(groups: Mapping[str, tuple[Cells, ...]]) -> dict[str, tuple[Cells, ...]]:
            found = {
                name: tuple(Cells(b.kind, place[b.nodes]) for b in blocks if len(b.nodes))
                for name, blocks in groups.items()
            }
            return {name: blocks for name, blocks in found.items() if blocks}

        part = replace(
            mesh,
            nodes=self.nodes[inside] - origin,
            cells=renumbered(cells),
            facets=renumbered(facets),
            lines=renumbered({n: tuple(_inside(b, inside) for b in blocks) for n, blocks in mesh.lines.items()})
            if mesh.dimension == 3
            else renumbered(facets),
            points={name: place[ids[inside[ids]]] for name, ids in mesh.points.items() if inside[ids].any()},
            source=f"segment {number + 1} of {mesh.source}",
        )
        materials = self.materials
        if isinstance(materials, Mapping):
            materials = {name: material for name, material in materials.items() if name in part.cells}
        keywords = dict(self.keywords)
        keywords["surfaces"] = [name for name in keywords["surfaces"] if name in part.facets]
        if keywords.get("densities"):
            keywords["densities"] = {n: value for n, value in keywords["densities"].items() if n in part.cells}
        model = solid_model(part, materials, **keywords)
        _, nodes = cKDTree(part.nodes).query(model.nodes)
        return model, np.flatnonzero(inside)[nodes], np.flatnonzero(wanted)

    def _cells(self, wanted: np.ndarray) -> list[Cells]:
        ends = np.cumsum([0, *(len(block.nodes) for block in self.mesh.cell_blocks)])
        return [
            Cells(block.kind, block.nodes[wanted[a:b]])
            for block, a, b in zip(self.mesh.cell_blocks, ends, ends[1:], strict=False)
            if wanted[a:b].any()
        ]

    def _skin(self, wanted: np.ndarray) -> dict[str, Cells]:
        return {block.kind: block for block in skin(self._cells(wanted))}


def _check_materials(materials: Any) -> None:
    """Refuse damping in proportion to mass, which would act on the motion of each segment about its own frame."""
    for material in materials.values() if isinstance(materials, Mapping) else (materials,):
        own = losses_of(material).damping
        if own is not None and own.mass > 0.0:
            raise ModelError(
                f"a material of a solid that is cut has damping of mass={own.mass:g} 1/s, which would act on the modes "
                "of each segment, not of the whole. Remedy: RayleighDamping(mass=0.0, stiffness=...)"
            )


def _cuts_of(number: int, count: int) -> list[int]:
    """Return the numbers of the cuts of a segment, from 1: cut i is between segments i - 1 and i."""
    return [cut for cut in (number, number + 1) if 0 < cut < count]


def _shared(block: Cells, others: Mapping[str, Cells]) -> Cells:
    """Return the facets of a block that are also among others, by their corners."""
    other = others.get(block.kind)
    corners = shape(block.kind).corners
    known = set() if other is None else set(map(tuple, np.sort(other.nodes[:, :corners], axis=1).tolist()))
    is_shared = [key in known for key in map(tuple, np.sort(block.nodes[:, :corners], axis=1).tolist())]
    return Cells(block.kind, block.nodes[np.array(is_shared, dtype=bool)])


def _inside(block: Cells, inside: np.ndarray) -> Cells:
    return Cells(block.kind, block.nodes[inside[block.nodes].all(axis=1)])
