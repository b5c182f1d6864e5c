"""Stresses of a shell, of the solids and of the beams in one mesh with it, as one field.

Nodes of solids are not those of the shell, so that each node has one stress; beams share the nodes of the shell, and
scalars there are those of the worse. Materials are numbered in the order of sections of the shell, beams, materials of
the solids.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from typing import cast
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.errors import ModelError
from kanefe.fe_model.drawn_shell import DrawnShell, drawn_shell, nodes_of
from kanefe.fe_model.model import COMPONENTS, Cells, Elasticity
from kanefe.fe_model.shapes import shape
from kanefe.fe_model.skin import skin
from kanefe.fe_model.thick_shell import thick_skin
from kanefe.results.body_shape import BodyShape
from kanefe_fem.recovery.mesh_error import Patch
from kanefe_fem.recovery.rib_fields import UNIAXIAL, RibFields
from kanefe_fem.recovery.scalars import FAILURES, SCALARS, worst_of
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.shell_points import ShellStrains
from kanefe_fem.recovery.strain_fields import CHUNK, Place, StrainFields, Tensor

TENSORS = ("stress", "strain")
"""Fields with six components."""

NO_MATERIAL = -1
"""Number of a material that no cell has."""

_KEPT: WeakKeyDictionary[FlexibleBody | BodyShape, tuple[RibFields | None, StrainFields | None]] = WeakKeyDictionary()


def shell_groups(body: BodyShape) -> list[str]:
    """Return the groups of a body with a shell by the numbers of their materials."""
    told = body.provenance
    return [*told.get("materials", {}), *told.get("stiffeners", {}), *told.get("solids", {}).get("materials", {})]


def fields_of_shell(body: BodyShape, face: str | None = None, ply: int | None = None) -> ShellStrainFields:
    """Return the fields of a body with a shell, and of the solids and beams in one mesh with it."""
    strains = ShellStrains.of_body(body)
    if all(shape(block.kind).dimension == 2 for block in body.cells):
        return ShellStrainFields(strains, body.name, face, ply)
    key: FlexibleBody | BodyShape = body if body.flexible is None else body.flexible
    if key not in _KEPT:
        _KEPT[key] = _beside(body)
    return JoinedFields(strains, body.name, (face, ply), *_KEPT[key], shell_groups(body))


def _beside(body: BodyShape) -> tuple[RibFields | None, StrainFields | None]:
    """Return the fields of beams and of solids in one mesh with a shell."""
    known = cast(Elasticity, body.elasticity)
    blocks = {d: tuple(b for b in body.cells if shape(b.kind).dimension == d) for d in (1, 3)}
    beams = None
    if known.ribs is not None:
        table = np.concatenate([block.nodes for block in blocks[1]])
        beams = RibFields(body.nodes, body.basis, table, known.ribs, list(body.provenance["stiffeners"]))
    if not blocks[3]:
        return beams, None
    count = sum(len(block.nodes) for block in blocks[3])
    moduli = Elasticity(known.table, known.of_cell[-count:])
    return beams, StrainFields(body.nodes, COMPONENTS, body.basis, blocks[3], moduli)


class JoinedFields(ShellStrainFields):
    """Fields of a shell at a face, or in a ply, of beams, and of solids; see `ShellStrainFields`.

    With a face or a ply, scalars leave beams out.

    Parameters
    ----------
    shell : ShellStrains
    name : str
        Of the body.
    level : tuple of str and int
        Face and ply, or None.
    ribs : RibFields or None
    solid : StrainFields or None
    groups : sequence of str
        The groups of the materials.
    """

    def __init__(
        self,
        shell: ShellStrains,
        name: str,
        level: tuple[str | None, int | None],
        ribs: RibFields | None,
        solid: StrainFields | None,
        groups: Sequence[str],
    ) -> None:
        super().__init__(shell, name, *level)
        self.ribs, self.solid, self.groups, self.of_shell = ribs, solid, groups, self.cells
        rows = [self.stack.of_cell]
        self.first_solid = len(self.stack.forces)
        if ribs is not None:
            rows.append(self.first_solid + ribs.ribs.of_line)
            self.first_solid += len(ribs.ribs.stiffness)
        if solid is not None:
            rows.append(self.first_solid + solid.elasticity.of_cell)
        self.cells = tuple(block for part in (shell, ribs, solid) if part is not None for block in part.cells)
        self.elasticity = Elasticity(np.zeros((0, 6, 6)), np.concatenate(rows))

    def part_of(self, material: int | None) -> tuple[str | None, int | None]:
        """Return "shell", "beams" or "solids" and the number of a material there; None for all."""
        if material is None:
            return None, None
        sections = len(self.stack.forces)
        if material < sections:
            return "shell", material
        if material < self.first_solid:
            return "beams", material - sections
        return "solids", material - self.first_solid

    @property
    def outside(self) -> tuple[Cells, ...]:
        """Cells of the shell and of the skin of the solids."""
        return (*self.of_shell, *(() if self.solid is None else skin(self.solid.cells)))

    def evaluate(self, what: Tensor, at: Place, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return a field at coordinates (T, k) in G, (T, n, 6) or (T, cells, 6); NaN in beams."""
        part, row = self.part_of(material)
        if part == "beams":
            raise ModelError(
                f"{self.groups[material or 0]!r} of {self.name!r} is of beams, which have section forces instead of a "
                f"{what} field. Remedy: recover(...).section_forces() or fibre_stress(), or scalars such as von_mises"
            )
        of_shell = super().evaluate(what, at, eta, row) if part in (None, "shell") else None
        of_solid = self.solid.evaluate(what, at, eta, row) if self.solid and part in (None, "solids") else None
        return self._together(at, of_shell, of_solid, (len(eta), 6))

    def surface_modes(self, material: int | None = None) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield nodes and the stress there of every unit coordinate: of faces, of solids, of the fibres of beams."""
        part, row = self.part_of(material)
        if part != "beams":
            yield from super().surface_modes(material)
        if self.ribs is not None and (part == "beams" or (part is None and not self.is_chosen)):
            yield self.ribs.modes(row)

    def in_layers(self, at: Place, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return the stress of the shell in the axes of the layer, as `evaluate`; NaN in solids and beams."""
        part, row = self.part_of(material)
        if part not in (None, "shell"):
            raise ModelError(f"{self.groups[material or 0]!r} of {self.name!r} is no shell and has no layers")
        return self._together(at, super().in_layers(at, eta, row), None, (len(eta), 6))

    def scalar(self, quantity: str, at: Place, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return a scalar of the stress, (T, n) or (T, cells): the worst through shells, and of the fibres of beams."""
        part, row = self.part_of(material)
        is_failure = quantity in FAILURES
        if is_failure and part not in (None, "shell"):
            raise ModelError(f"there is no {quantity} of {self.groups[material or 0]!r}, which is no shell")
        of_shell = super().scalar(quantity, at, eta, row) if part in (None, "shell") else None
        of_solid = None
        if self.solid is not None and part in (None, "solids") and not is_failure:
            of_solid = self.solid.scalar(quantity, at, eta, row)
        of_beams = None
        if self.ribs is not None and not is_failure and (part == "beams" or (part is None and not self.is_chosen)):
            of_beams = self.ribs.scalar(quantity, eta, row)
        found = self._together(at, of_shell, of_solid, (len(eta),), None if of_beams is None else of_beams[1])
        if of_beams is not None and at == "nodes":
            worst_of(quantity).at(found.T, self.ribs.table.ravel(), of_beams[0].reshape(len(eta), -1).T)  # type: ignore[union-attr]
        return found

    @property
    def is_chosen(self) -> bool:
        """Whether a face or a ply was chosen."""
        return self.face is not None or self.ply is not None

    def _together(
        self,
        at: Place,
        of_shell: np.ndarray | None,
        of_solid: np.ndarray | None,
        size: tuple[int, ...],
        of_beams: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return fields of shell and solid at all nodes or cells, and of beams at their cells; NaN where there is none.

        `size` is that of an array for one node: times, and components.
        """
        counts = [sum(len(block.nodes) for block in self.of_shell)]
        counts += [0 if part is None else sum(len(b.nodes) for b in part.cells) for part in (self.ribs, self.solid)]
        if at == "nodes":
            found = np.full((size[0], len(self.nodes), *size[1:]), np.nan)
            for own in (of_shell, of_solid):
                if own is not None:
                    np.copyto(found, own, where=np.isfinite(own))
            return found
        parts = [
            np.full((size[0], count, *size[1:]), np.nan) if own is None else own
            for own, count in zip((of_shell, of_beams, of_solid), counts, strict=True)
        ]
        return np.concatenate(parts, axis=1)

    def strain_at(self, nodes: np.ndarray, weights: np.ndarray, off: np.ndarray, eta: np.ndarray) -> np.ndarray:
        """Return the strain in G at a point of a cell of the shell or of a solid, by its nodes, shape (T, 6)."""
        if self.solid is None or not np.isin(nodes[0], nodes_of(self.solid.cells)):
            return super().strain_at(nodes, weights, off, eta)
        part, numbers = self.solid.around(nodes)
        return np.einsum("n,tni->ti", weights, part.evaluate("strain", "nodes", eta)[:, numbers])

    def faces_of(self, eta: np.ndarray) -> np.ndarray:
        """Return the stress in G at the points by which the body is drawn, (r, points, 6)."""
        parts = [super().faces_of(eta)]
        if self.solid is not None:
            parts.append(self.solid.evaluate("stress", "nodes", eta)[:, self._on_skin])
        return np.concatenate([*parts, self._of_fibres("stress", eta)], axis=1)

    def patches(self, node: int, eta: np.ndarray, material: int | None = None) -> list[Patch]:
        """Return the stresses around a node in all parts there, or in the one that has the material."""
        part, row = self.part_of(material)
        found: list[Patch] = []
        if part in (None, "shell"):
            found += super().patches(node, eta, row)
        if self.solid is not None and part in (None, "solids") and np.isin(node, nodes_of(self.solid.cells)):
            found += self.solid.patches(node, eta, row)
        if self.ribs is not None and (part == "beams" or (part is None and not self.is_chosen)):
            found += self.ribs.patches(node, eta, row)
        return found

    def drawn(self) -> DrawnShell:
        """Return the points and cells of a picture."""
        ribs, solids = (None if self.ribs is None else self.ribs.ribs), () if self.solid is None else self.solid.cells
        return drawn_shell(self.nodes, self.cells, ribs, thick_skin(self.cells, self.stack), skin(solids))

    def faces_scalar(self, quantity: str, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return the worst of coordinates (T, k) at the points by which the body is drawn."""
        part, row = self.part_of(material)
        found, worst = [super().faces_scalar(quantity, eta, material)], worst_of(quantity)
        rows = [row if part == own else NO_MATERIAL if part else None for own in ("solids", "beams")]
        for values, own, used in zip(
            (self._of_solid, self._of_fibres), rows, (self._on_skin, slice(None)), strict=True
        ):
            of_times = (values(quantity, eta[i : i + self._at_once], own) for i in range(0, len(eta), self._at_once))
            found.append(reduce(worst, [worst.reduce(one, axis=0) for one in of_times])[used])
        return np.concatenate(found)

    def in_plies(self, quantities: Sequence[str], eta: np.ndarray) -> dict[str, np.ndarray]:
        """Return fields at both ends of the plies, then in solids, then in beams, at the points of files.

        Failure indices are those of the shell alone, and beams have no strain field: NaN elsewhere.
        """
        found, used = super().in_plies(quantities, eta), nodes_of(() if self.solid is None else self.solid.cells)
        known = [name for name in quantities if name not in FAILURES]
        of_solids = {} if self.solid is None else self.solid.several(known, "nodes", eta)
        for name, of_shell in found.items():
            size = of_shell.shape[1:]
            own = of_solids[name][0, used] if name in of_solids else np.full((len(used), *size), np.nan)
            found[name] = np.concatenate((of_shell, own, self._of_fibres(name, eta)[0]))
        return found

    @property
    def _at_once(self) -> int:
        """Number of times whose values are computed at once."""
        return max(1, CHUNK // (6 * len(self.nodes)))

    @property
    def _on_skin(self) -> np.ndarray:
        return nodes_of(() if self.solid is None else skin(self.solid.cells))

    def _of_solid(self, quantity: str, eta: np.ndarray, row: int | None = None) -> np.ndarray:
        """Return a scalar of the solids at all nodes, (T, n): NaN for failure indices."""
        if self.solid is None or quantity not in SCALARS:
            return np.full((len(eta), len(self.nodes)), np.nan)
        return self.solid.scalar(quantity, "nodes", eta, row)

    def _of_fibres(self, quantity: str, eta: np.ndarray, row: int | None = None) -> np.ndarray:
        """Return a field of the fibres by which beams are drawn, (T, points) or (T, points, 6); NaN if not known."""
        if self.ribs is None:
            return np.zeros((len(eta), 0, 6) if quantity in TENSORS else (len(eta), 0))
        if quantity == "stress":
            return self.ribs.drawn_tensors(eta)
        stress = self.ribs.drawn(eta, row)
        if quantity in UNIAXIAL:
            return UNIAXIAL[quantity](stress)
        return np.full((*stress.shape, 6) if quantity in TENSORS else stress.shape, np.nan)
