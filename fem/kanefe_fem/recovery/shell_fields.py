"""Strains and stresses of a shell at its faces, in its middle and in its layers.

Stresses in the plane of the shell follow from the strains at their height, ``C e(z)`` with the moduli of the layer;
those across it, 13 and 23, balance the growth of bending through the thickness
(`kanefe_fem.shells.sections.ShearStress`) and vanish at the faces; the normal one, 33, is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from copy import copy
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.drawn_shell import DrawnShell, drawn_shell
from kanefe.fe_model.model import COMPONENTS, Cells, Elasticity
from kanefe.fe_model.thick_shell import thick_skin
from kanefe_fem.materials.voigt import bond_matrix
from kanefe_fem.recovery.mesh_error import Patch
from kanefe_fem.recovery.scalars import ACROSS, FAILURES, PLANE, SCALARS, worst_of
from kanefe_fem.recovery.shell_points import Points, ShellStrains
from kanefe_fem.recovery.shell_strains import pulled_back
from kanefe_fem.recovery.strain_fields import CHUNK, Place, StrainFields, Tensor
from kanefe_fem.shells.sections import ShearStress

FACES = {"bottom": 0.0, "middle": 0.5, "top": 1.0}
"""Heights in a shell or a ply, as fractions of its thickness."""


class Level(NamedTuple):
    """A height at each of p points.

    Attributes
    ----------
    layer : ndarray of int, shape (p,)
        -1 where the section has no such layer.
    height : ndarray, shape (p,)
        Above the surface of the nodes, as a fraction of the thickness.
    """

    layer: np.ndarray
    height: np.ndarray


class ShellStrainFields(StrainFields):
    """Fields of a shell at a face, or in a ply; without both, scalars are the worst through the thickness.

    Parameters
    ----------
    shell : ShellStrains
    name : str
        Of the body.
    face : {"bottom", "middle", "top"}, optional
        Of the shell, or of the ply.
    ply : int, optional
        Number of the ply, from 0 at the bottom.
    """

    def __init__(self, shell: ShellStrains, name: str, face: str | None = None, ply: int | None = None) -> None:
        of_cell = Elasticity(np.zeros((0, 6, 6)), shell.stack.of_cell)
        super().__init__(shell.nodes, COMPONENTS, shell.basis, shell.cells, of_cell)
        self.shell, self.stack = shell, shell.stack
        self.name, self.face, self.ply = name, face, ply
        most = self.stack.most_layers
        if ply is not None and not 0 <= ply < most:
            raise ModelError(f"ply={ply!r} of {name!r}, whose sections have {most} at most. Remedy: 0 is the bottom")

    @property
    def outside(self) -> tuple[Cells, ...]:
        """All cells: their faces are the surface."""
        return self.cells

    def around(self, chosen: np.ndarray) -> tuple[StrainFields, np.ndarray]:
        """Return these fields themselves."""
        return self, chosen

    @property
    def scalars(self) -> tuple[str, ...]:
        """Names of the scalars that there are."""
        return (*SCALARS, *FAILURES)

    def evaluate(self, what: Tensor, at: Place, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return a field at coordinates (T, k) in G, (T, n, 6) or (T, cells, 6); means over folds at nodes."""
        if self.face is None:
            raise ModelError(
                f"the {what} of the shell {self.name!r} differs through its thickness. Remedy: "
                f"recover(..., face='top'), or one of {', '.join(FACES)}"
            )
        points = self.shell.points(at)
        (level,) = self._levels(points)
        found = self._in_G(what, points, self.at_level(what, points, self.shell.strains(at, eta), level))
        return self._of_nodes(found, material) if at == "nodes" else found

    def in_layers(self, at: Place, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return the stress at coordinates in the axes of the layer, as `evaluate`."""
        if self.face is None:
            self.evaluate("stress", at, eta)
        points = self.shell.points(at)
        (level,) = self._levels(points)
        found = self._turned(self.stress(points, self.shell.strains(at, eta), level), level)
        return self._of_nodes(found, material) if at == "nodes" else found

    def modes(self, what: Tensor, at: Place, material: int | None = None) -> np.ndarray:
        """Return the field of every unit coordinate, shape (n, 6, k) or (cells, 6, k)."""
        return np.moveaxis(self.evaluate(what, at, np.eye(self.basis.shape[1]), material), 0, -1)

    def surface_modes(self, material: int | None = None) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield nodes and the stress there of every unit coordinate, at the chosen face or at both."""
        for face in ("bottom", "top") if self.face is None else (self.face,):
            own = copy(self)
            own.face = face
            yield from StrainFields.surface_modes(own, material)

    def scalar(self, quantity: str, at: Place, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return a scalar of the stress, (T, n) or (T, cells): the worst of the heights, and of the sides of a fold."""
        points = self.shell.points(at)
        worst = worst_of(quantity)
        total = np.full((len(eta), len(points.section)), np.nan)
        parts = self.shell.strains(at, eta)
        for level in self._levels(points):
            total = worst(total, self._scalar_of(quantity, self.stress(points, parts, level), level))
        return self._worst_of_nodes(total, worst, material) if at == "nodes" else total

    def _scalar_of(self, quantity: str, stress: np.ndarray, level: Level) -> np.ndarray:
        """Return a scalar of stresses (T, p, 6) in the axes of the points."""
        if quantity not in FAILURES:
            return SCALARS[quantity](stress)
        if not np.isfinite(self.stack.strengths).any():
            raise ModelError(
                f"no material of {self.name!r} has strengths, so there is no {quantity}. Remedy: "
                "Orthotropic(..., strengths=Strengths(...))"
            )
        return FAILURES[quantity](self._turned(stress, level), self.stack.strengths[level.layer])

    def in_plies(self, quantities: Sequence[str], eta: np.ndarray) -> dict[str, np.ndarray]:
        """Return scalars, "stress" and "strain" of coordinates (1, k) at the bottom and the top of each ply.

        In order of these and of the places: (ends P,) of scalars, (ends P, 6) of tensors, in G.
        """
        points, parts = self.shell.at_places, self.shell.strains("nodes", eta)
        found: dict[str, list[np.ndarray]] = {name: [] for name in quantities}
        for level in self._ends_of_plies(points):
            stress = self.stress(points, parts, level)
            for name in quantities:
                if name == "strain":
                    value = self._in_G("strain", points, self.at_level("strain", points, parts, level))
                elif name == "stress":
                    value = self._in_G("stress", points, stress)
                else:
                    value = self._scalar_of(name, stress, level)
                found[name].append(value[0])
        return {name: np.concatenate(values) for name, values in found.items()}

    def _ends_of_plies(self, points: Points) -> list[Level]:
        return [self.in_ply(points, ply, share) for ply in range(self.stack.most_layers) for share in (0.0, 1.0)]

    def _in_G(self, what: Tensor, points: Points, values: np.ndarray) -> np.ndarray:
        """Return fields (T, p, 6) in G from those in the axes of the points."""
        turn = bond_matrix(np.swapaxes(points.axes, 1, 2))
        if what == "strain":  # engineering strains turn by the inverse transpose
            turn = np.swapaxes(bond_matrix(points.axes), 1, 2)
        return np.einsum("pij,tpj->tpi", turn, values)

    def strain_at(self, nodes: np.ndarray, weights: np.ndarray, off: np.ndarray, eta: np.ndarray) -> np.ndarray:
        """Return the strain in G at a point of a cell, by its nodes and their weights, shape (T, 6).

        Without a chosen face that on whose side of the mesh it is, by its place `off` (3,) beside the mesh in m.

        Raises
        ------
        ModelError
            If no face was chosen, and it is nearer to the middle of the thickness than to a face.
        """
        places, points = self.shell.places_of(nodes), self.shell.at_places
        bottom, top = self.stack.heights_of(points.section[places[0]]) * points.thickness[places[0]]
        above = (float(off @ points.axes[places[0], 2]) - bottom) / (top - bottom)
        if self.face is None and (self.ply is not None or 0.25 < above < 0.75):
            raise ModelError(
                f"a gauge of the shell {self.name!r} is on a face of it. Remedy: recover(..., face='top'), or a "
                "position on the face"
            )
        level = self._levels(points)[0] if self.face else self._face(points, "top" if above > 0.5 else "bottom")
        own = self.at_level("strain", points, self.shell.strains("nodes", eta), level)
        strain = self._in_G("strain", points, own)
        return np.einsum("n,tni->ti", weights, strain[:, places])

    def faces_of(self, eta: np.ndarray) -> np.ndarray:
        """Return the stress in G of coordinates (r, k) at the bottom and then the top of all places, (r, 2 P, 6)."""
        points, parts = self.shell.at_places, self.shell.strains("nodes", eta)
        found = [self.stress(points, parts, self._face(points, face)) for face in ("bottom", "top")]
        return np.concatenate([self._in_G("stress", points, one) for one in found], axis=1)

    def patches(self, node: int, eta: np.ndarray, material: int | None = None) -> list[Patch]:
        """Return the stresses around a node for coordinates (1, k), of each side and section and at each height there.

        Places are in the tangent plane.
        """
        places, points, found = self.stack.places, self.shell.at_places, []
        means = self.shell.strains("nodes", eta)
        for place in np.flatnonzero((places.node == node) & self._chosen(material)):
            meeting = np.unique(self.stack.cells[places.of_corners == place])
            ring = np.unique(places.of_corners[np.isin(self.stack.cells, meeting)])
            of_section = self.stack.of_cell == places.section[place]
            cells = np.unique(self.stack.cells[np.isin(places.of_corners, ring) & of_section[self.stack.cells]])
            where, samples, strains = self.shell.samples(cells, eta)
            flat = np.zeros(where.shape)
            flat[:, :2] = (where - self.nodes[node]) @ points.axes[place, :2].T
            own, mean = Points(*(values[[place]] for values in points)), tuple(m[..., [place], :, :] for m in means)
            for here, there in zip(self._levels(own), self._levels(samples), strict=True):
                if here.layer[0] < 0:
                    continue
                stress = self._in_G("stress", samples, self.stress(samples, strains, there))[0]
                at_node = self._in_G("stress", own, self.stress(own, (mean[0], mean[1]), here))[0, 0]
                found.append(Patch(flat, stress, at_node, 2))
        return found

    def drawn(self) -> DrawnShell:
        """Return the points and cells of a picture."""
        return drawn_shell(self.nodes, self.cells, None, thick_skin(self.cells, self.stack), ())

    def faces_scalar(self, quantity: str, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return the worst of coordinates (T, k) at the bottom and then the top of all places, shape (2 P,)."""
        points, worst = self.shell.at_places, worst_of(quantity)
        found = []
        for level in (self._face(points, face) for face in ("bottom", "top")):
            best = np.full(len(points.section), np.nan)
            for first in range(0, len(eta), step := max(1, CHUNK // (11 * len(best)))):
                parts = self.shell.strains("nodes", eta[first : first + step])
                values = self._scalar_of(quantity, self.stress(points, parts, level), level)
                best = worst(best, worst.reduce(values, axis=0))
            found.append(np.where(self._chosen(material), best, np.nan))
        return np.concatenate(found)

    def at_level(self, what: Tensor, points: Points, parts: tuple[np.ndarray, np.ndarray], level: Level) -> np.ndarray:
        """Return a field at one height in the axes of the points, shape (T, p, 6), of `ShellStrains.strains` there."""
        stress = self.stress(points, parts, level)
        if what == "stress":
            return stress
        in_plane = self._in_plane(points, parts[0], level)
        shear = np.linalg.inv(self.stack.shear)[level.layer]
        across = np.einsum("pj,pjt->tp", self.stack.across[level.layer], in_plane)
        strain = np.zeros_like(stress)
        strain[..., PLANE] = np.moveaxis(in_plane, -1, 0)
        strain[..., 2] = across
        strain[..., ACROSS] = np.einsum("pij,tpj->tpi", shear, stress[..., ACROSS])
        return np.where((level.layer >= 0)[:, None], strain, np.nan)

    def stress(self, points: Points, parts: tuple[np.ndarray, np.ndarray], level: Level) -> np.ndarray:
        """Return the stress at one height in the axes of the points, shape (T, p, 6); NaN where there is no layer."""
        in_plane = self._in_plane(points, parts[0], level)
        stress = np.zeros((in_plane.shape[-1], len(points.section), 6))
        stress[..., PLANE] = np.einsum("pij,pjt->tpi", self.stack.plane[level.layer], in_plane, optimize=True)
        F = self._shear_of_forces(points.section, level)
        stress[..., ACROSS] = np.einsum("pij,pjt->tpi", F @ self.stack.forces[points.section], parts[1], optimize=True)
        stress[:, level.layer < 0] = np.nan
        return stress

    def _in_plane(self, points: Points, parts: np.ndarray, level: Level) -> np.ndarray:
        """Return the strains 11, 22, 12 at a height, shape (p, 3, T)."""
        z = (level.height * points.thickness)[:, None, None]
        shifter = np.eye(2) + z * np.swapaxes(points.curvature, 1, 2)
        return pulled_back(parts[0] + z * (parts[1] + z * parts[2]), np.linalg.inv(shifter))

    def _shear_of_forces(self, sections: np.ndarray, level: Level) -> np.ndarray:
        """Return the factors on shear forces over the thickness that give the stresses 13 and 23, shape (p, 2, 2)."""
        F = np.zeros((len(sections), 2, 2))
        for section in np.unique(sections):
            own = sections == section
            for layer, height in np.unique(np.column_stack((level.layer, level.height))[own], axis=0):
                if layer >= 0:
                    here = own & (level.layer == layer) & (level.height == height)
                    F[here] = self._equilibrium[section].at(int(layer) - self.stack.first[section], float(height))
        return F

    @cached_property
    def _equilibrium(self) -> list[ShearStress]:
        stack, ranges = self.stack, [self.stack.layers_of(i) for i in range(len(self.stack.first) - 1)]
        return [ShearStress([stack.heights[i] for i in own], [stack.plane[i] for i in own]) for own in ranges]

    def _levels(self, points: Points) -> list[Level]:
        """Return the heights that count: one, or all faces and middles of the layers."""
        if self.ply is not None:
            faces = FACES if self.face is None else {self.face: FACES[self.face]}
            return [self.in_ply(points, self.ply, share) for share in faces.values()]
        if self.face is not None:
            return [self._face(points, self.face)]
        plies = range(self.stack.most_layers)
        return [self.in_ply(points, ply, share) for ply in plies for share in FACES.values()]

    def in_ply(self, points: Points, ply: int, share: float) -> Level:
        """Return a height in the plies of one number, as a fraction of their thickness."""
        first, last = self.stack.first[points.section], self.stack.first[points.section + 1]
        layer = np.where(first + ply < last, first + ply, -1)
        bottom, top = self.stack.heights[layer].T
        return Level(layer, bottom + share * (top - bottom))

    def _face(self, points: Points, face: str) -> Level:
        """Return a face of the shell; a middle between two plies is that of the upper one."""
        stack = self.stack
        bottom, top = stack.heights_of(np.arange(len(stack.first) - 1)).T
        height = bottom + FACES[face] * (top - bottom)
        layer = [
            first + int(np.sum(stack.heights[first:last, 1] < z + 1e-9))  # the last one, if all others end below
            for first, last, z in zip(stack.first[:-1], stack.first[1:] - 1, height, strict=True)
        ]
        return Level(np.array(layer)[points.section], height[points.section])

    def _turned(self, stress: np.ndarray, level: Level) -> np.ndarray:
        """Return stresses in the axes of the layers from those in the axes of the points."""
        angle = self.stack.angles[level.layer]
        c, s, o = np.cos(angle), np.sin(angle), np.zeros(len(angle))
        axes = np.stack((c, s, o, -s, c, o, o, o, o + 1.0), axis=-1).reshape(-1, 3, 3)
        return np.einsum("pij,tpj->tpi", bond_matrix(axes), stress)

    def _of_nodes(self, values: np.ndarray, material: int | None) -> np.ndarray:
        """Return means at the nodes (T, n, 6) of values at the places (T, P, 6)."""
        places = self.stack.places
        chosen = np.flatnonzero(self._chosen(material) & np.isfinite(values).all(axis=(0, 2)))
        total, count = np.zeros((len(self.nodes), len(values) * 6)), np.zeros(len(self.nodes))
        np.add.at(total, places.node[chosen], np.moveaxis(values[:, chosen], 1, 0).reshape(len(chosen), -1))
        np.add.at(count, places.node[chosen], 1.0)
        with np.errstate(invalid="ignore"):  # 0 / 0 = NaN is intended where no cell has the material
            return np.moveaxis((total / count[:, None]).reshape(len(self.nodes), -1, 6), 1, 0)

    def _worst_of_nodes(self, values: np.ndarray, worst: Callable[..., np.ndarray], material: int | None) -> np.ndarray:
        places = self.stack.places
        found = np.full((len(self.nodes), len(values)), np.nan)
        chosen = np.flatnonzero(self._chosen(material))
        worst.at(found, places.node[chosen], values[:, chosen].T)  # type: ignore[attr-defined]
        return found.T

    def _chosen(self, material: int | None) -> np.ndarray:
        section = self.stack.places.section
        return np.ones(len(section), dtype=bool) if material is None else section == material
