"""Beams along the lines of a shell, with the displacements of its nodes.

A line of three nodes carries a beam whose axis is beside it. The section moves rigidly with the shell's nodes,

    u_c = sum N_i (u_i + theta_i x r_i),    theta = sum N_i theta_i,

with the arms r_i from the nodes to the axis, so that beam and shell fit along the whole line. The strains of the
section are ``a . u_c' + (0, -theta . e_z, theta . e_y)`` and ``a . theta'`` along its axes a = (e_x, e_y, e_z); two
points of quadrature a line neither lock nor leave a mechanism (Hughes, Taylor and Kanoknukulchai, Int. J. Numer.
Methods Eng. 11 (1977) 1529).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.model import MassField
from kanefe.fe_model.pressure_change import turning
from kanefe.fe_model.ribs import Ribs, axes_along
from kanefe.fe_model.shapes import shape
from kanefe.frames import skews
from kanefe_fem.beams.beam_section import LineMass
from kanefe_fem.beams.mass import section_points
from kanefe_fem.beams.section_shapes import FIBRES
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.shells.directors import Directors
from kanefe_fem.shells.problem import ShellCells
from kanefe_fem.shells.stiffener import SIDES, Stiffener

STATIONS = {"stiffness": 2, "mass": 3}
"""Gauss's points along a line."""

ACROSS = 1e-3
"""Sine of the least angle between a line and the local z of its section, rad."""


class Station:
    """Fields of lines with beams at one point of them."""

    def __init__(self, places: np.ndarray, ribs: Ribs, xi: float, weight: float = 1.0) -> None:
        element, at = shape("line3"), np.array([[xi]])
        N, slope = element.values(at)[0], element.gradients(at)[0, :, 0]
        self.axes, length, sine = axes_along(places + ribs.arms, ribs.upright, xi)
        if sine.min() < ACROSS:
            place = places[sine.argmin()].mean(axis=0).round(6).tolist()
            raise ModelError(f"a stiffener at {place} m is along the local z of its section. Remedy: orientation=")
        self.weight = weight * length
        self.u, self.theta = _motion(N, ribs.arms)
        self.slope = slope / length[:, None]
        self.du, self.dtheta = (motion / length[:, None, None] for motion in _motion(slope, ribs.arms))

    @property
    def strains(self) -> np.ndarray:
        """Strains of the section from the displacements of three nodes, shape (m, 6, 18)."""
        stretch = self.axes @ self.du
        stretch[:, 1] -= np.einsum("mi,mij->mj", self.axes[:, 2], self.theta)
        stretch[:, 2] += np.einsum("mi,mij->mj", self.axes[:, 1], self.theta)
        return np.concatenate((stretch, self.axes @ self.dtheta), axis=1)


def _motion(shares: np.ndarray, arms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return displacement of the axis and rotation from the displacements of three nodes, each (m, 3, 18)."""
    u, theta = np.zeros((len(arms), 3, 3, 6)), np.zeros((len(arms), 3, 3, 6))
    for i, share in enumerate(shares):
        u[:, :, i, :3] = theta[:, :, i, 3:] = share * np.eye(3)
        u[:, :, i, 3:] = share * -skews(arms[:, i])
    return u.reshape(len(arms), 3, 18), theta.reshape(len(arms), 3, 18)


@dataclass(frozen=True, eq=False)
class StiffenerLines:
    """The lines of one stiffener.

    Attributes
    ----------
    name : str
    stiffener : Stiffener
    nodes : ndarray of int, shape (m, 3)
    places : ndarray, shape (m, 3, 3)
        Of the nodes, m.
    arms : ndarray, shape (m, 3, 3)
        From the nodes to the axis, m.
    upright : ndarray, shape (m, 3, 3)
        Direction of local z at the nodes.
    """

    name: str
    stiffener: Stiffener
    nodes: np.ndarray
    places: np.ndarray
    arms: np.ndarray
    upright: np.ndarray

    @property
    def line_mass(self) -> LineMass:
        """Mass of the section."""
        return self.stiffener.section.mass_of(self.stiffener.material)

    @property
    def mass(self) -> float:
        """Mass of the stiffener, kg."""
        return float(self.line_mass.rho_A * sum(at.weight.sum() for at in self.stations("mass")))

    @property
    def section_stiffness(self) -> np.ndarray:
        """Stiffness of the section as far as its foot holds it, shape (6, 6).

        A rib beside the shell that is narrower than high turns about the shell's normal by itself above its foot: only
        a height of the order of its width w is held. Its lateral shear V_y counts by ``(w / 2 h)^3``, up to 1, with
        ``(w / h)^2 = EI_z / EI_y``; tied to the shell it would resist twist by ``G A e^2``, many times GJ.
        """
        D = self.stiffener.stiffness
        if not self.arms.any():
            return D
        scale = np.ones(6)
        scale[1] = np.sqrt(min(1.0, (D[5, 5] / D[4, 4] / 4.0) ** 1.5))
        return np.asarray(scale[:, None] * D * scale)

    @property
    def described(self) -> str:
        """What it is, for the record."""
        beside = np.linalg.norm(self.arms, axis=2)
        return f"{self.stiffener.section!r}, axis {beside.min():.4g} to {beside.max():.4g} m off"

    @property
    def ribs(self) -> Ribs:
        """What stresses and pictures need of it."""
        fibres = self.stiffener.section.fibres_of(self.stiffener.material)
        outline = np.zeros((FIBRES, 3)) if fibres is None else fibres
        of_line = np.zeros(len(self.nodes), dtype=np.int64)
        return Ribs(self.arms, self.upright, of_line, self.section_stiffness[None], outline[None])

    def stations(self, purpose: str) -> list[Station]:
        """Return the points of quadrature for "stiffness" or "mass"."""
        x, w = np.polynomial.legendre.leggauss(STATIONS[purpose])
        return [Station(self.places, self.ribs, 0.5 * (1.0 + xi), 0.5 * v) for xi, v in zip(x, w, strict=True)]

    def assembled(self, blocks: np.ndarray, count: int) -> sp.csr_matrix:
        """Return matrices of the lines (m, 18, 18) as one over the components of `count` nodes."""
        dofs = self._dofs
        rows, columns = np.repeat(dofs, 18, axis=1).ravel(), np.tile(dofs, (1, 18)).ravel()
        return sp.csr_matrix((blocks.ravel(), (rows, columns)), shape=(6 * count, 6 * count))

    @property
    def _dofs(self) -> np.ndarray:
        return (6 * self.nodes[:, :, None] + np.arange(6)).reshape(-1, 18)

    def stiffness(self, count: int) -> sp.csr_matrix:
        """Return K, shape (6 count, 6 count)."""
        D, total = self.section_stiffness, np.zeros((len(self.nodes), 18, 18))
        for at in self.stations("stiffness"):
            B = at.strains
            total += at.weight[:, None, None] * (B.swapaxes(1, 2) @ D @ B)
        return self.assembled(total, count)

    def stress_stiffness(self, displacement: np.ndarray, count: int) -> sp.csr_matrix:
        """Return the geometric stiffness of the forces n and moments m of a displacement (6 count,).

        Their work on the strains of second order of sections that stay rigid, as in
        `kanefe_fem.beams.geometric_stiffness`, with ``theta_i x (theta_i x r_i) / 2`` in the displacement of the axis
        and ``N (I_y + I_z) / A`` of the twist.
        """
        D, q = self.section_stiffness, displacement[self._dofs]
        radius = (D[4, 4] + D[5, 5]) / D[0, 0]
        total = np.zeros((len(self.nodes), 18, 18))
        for at in self.stations("stiffness"):
            force = np.einsum("st,mtj,mj->ms", D, at.strains, q) * at.weight[:, None]
            n, m = (np.einsum("mai,ma->mi", at.axes, part) for part in (force[:, :3], force[:, 3:]))
            theta = at.theta.swapaxes(1, 2)
            mixed = theta @ (skews(n) @ at.du + 0.5 * skews(m) @ at.dtheta)
            total += mixed + mixed.swapaxes(1, 2) + theta @ turning(n, at.axes[:, 0]) @ at.theta
            for i, slope in enumerate(at.slope.T):
                of_node = slice(6 * i + 3, 6 * i + 6)
                total[:, of_node, of_node] += slope[:, None, None] * turning(n, self.arms[:, i])
            twist = np.einsum("mi,mij->mj", at.axes[:, 0], at.dtheta)
            total += radius * force[:, 0, None, None] * twist[:, :, None] * twist[:, None, :]
        return self.assembled(total, count)

    def mass_field(self, count: int) -> MassField:
        """Return the mass as points of the sections, over the components of `count` nodes."""
        line = self.line_mass
        in_section = section_points([line], planar=False, rotary_inertia=True)[0]
        points, shares, motions, turns, arms = [], [], [], [], []
        for at in self.stations("mass"):
            N = at.theta[:, 0, 3::6]
            middle = np.einsum("mn,mni->mi", N, self.places)
            to_axis = np.einsum("mn,mni->mi", N, self.arms)
            for place in in_section:
                across = np.einsum("i,mij->mj", place, at.axes)
                points.append(middle + to_axis + across)
                arms.append(to_axis + across)
                shares.append(line.rho_A / len(in_section) * at.weight)
                motions.append(self._rows(at.u - skews(across) @ at.theta, count))
                turns.append(self._rows(at.theta, count))
        return MassField(
            points=np.concatenate(points),
            mass=sp.diags(np.concatenate(shares), format="csr"),
            interpolation=sp.vstack(motions, format="csr"),
            turns=sp.vstack(turns, format="csr"),
            arms=np.concatenate(arms),
        )

    def _rows(self, blocks: np.ndarray, count: int) -> sp.csr_matrix:
        """Return vectors at points (m, 3, 18) over the components of `count` nodes."""
        columns = np.broadcast_to(self._dofs[:, None], blocks.shape).ravel()
        rows = np.repeat(np.arange(3 * len(blocks)), 18)
        return sp.csr_matrix((blocks.ravel(), (rows, columns)), shape=(3 * len(blocks), 6 * count))


def ribs_together(lines: Sequence[StiffenerLines]) -> Ribs:
    """Return the stiffeners of a shell as one record."""
    own = [one.ribs for one in lines]
    return Ribs(
        np.concatenate([one.arms for one in own]),
        np.concatenate([one.upright for one in own]),
        np.repeat(np.arange(len(own)), [len(one.of_line) for one in own]),
        np.concatenate([one.stiffness for one in own]),
        np.concatenate([one.fibres for one in own]),
    )


def stiffener_lines(
    mesh: Mesh, beams: Mapping[str, Stiffener], found: Directors, cells: Sequence[ShellCells]
) -> list[StiffenerLines]:
    """Return the lines of the stiffeners of a shell.

    Parameters
    ----------
    mesh : Mesh
        Of order 2, without its unused nodes.
    beams : dict of str to Stiffener
        By the name of a group of lines.
    found : Directors
    cells : sequence of ShellCells
        For the thickness, which "above" and "below" need.

    Raises
    ------
    MeshError
        If there is no such group, or its lines are not on sides of the cells.
    ModelError
        If a normal is needed where the shell is folded or branched.
    """
    made = []
    for name, stiffener in beams.items():
        blocks = mesh.facets.get(name) or mesh.lines.get(name) or ()
        table = np.concatenate([np.zeros((0, 3), dtype=np.int64), *(block.nodes for block in blocks)])
        if not len(table):
            known = ", ".join(sorted({*mesh.facets, *mesh.lines})) or "none"
            raise MeshError(
                f"{mesh.source}: no group of lines {name!r} along sides of the shell's cells, for a stiffener. Remedy: "
                f"one of those it has ({known}), or embed the line in the surface and give it a physical group"
            )
        table = table[np.unique(np.sort(table, axis=1), axis=0, return_index=True)[1]]
        normals = _normals(name, stiffener, table, found)
        heights = _heights(stiffener, table, found, cells)
        fixed = isinstance(stiffener.offset, tuple)
        arms = np.broadcast_to(stiffener.offset, normals.shape) if fixed else heights[:, :, None] * normals
        upright = normals if stiffener.orientation is None else np.broadcast_to(stiffener.orientation, normals.shape)
        made.append(StiffenerLines(name, stiffener, table, mesh.nodes[table], np.array(arms), np.array(upright)))
    return made


def _normals(name: str, stiffener: Stiffener, table: np.ndarray, found: Directors) -> np.ndarray:
    """Return the normals of the shell at the nodes of lines, shape (m, 3, 3)."""
    if isinstance(stiffener.offset, tuple) and stiffener.orientation is not None:
        return np.zeros((*table.shape, 3))
    used = np.unique(table)
    sides = np.bincount(found.node, minlength=used.max() + 1)[used]
    if sides.max() > 1:
        raise ModelError(
            f"the stiffener {name!r} lies on a fold or a branch of the shell, which has {sides.max()} normals there. "
            "Remedy: offset= a vector and orientation= a direction"
        )
    of_node = np.zeros(used.max() + 1, dtype=np.int64)
    known = np.isin(found.node, used)
    of_node[found.node[known]] = np.flatnonzero(known)
    return np.asarray(found.normal[of_node[table]])


def _heights(stiffener: Stiffener, table: np.ndarray, found: Directors, cells: Sequence[ShellCells]) -> np.ndarray:
    """Return the heights of the axis above the nodes of lines, m, shape (m, 3)."""
    if not isinstance(stiffener.offset, str):
        return np.full(table.shape, stiffener.offset if isinstance(stiffener.offset, float) else 0.0)
    side = SIDES[stiffener.offset]
    below, above = stiffener.half_height
    face = np.full(int(max(found.node.max(), table.max())) + 1, -np.inf)
    for block in cells:
        ends = np.array([[one.layers[0].bottom, one.layers[-1].top] for one in block.sections])[block.of_cell]
        reach = side * ends[:, 1 if side > 0.0 else 0, None] * block.thickness
        np.maximum.at(face, block.cells.nodes, reach)
    return np.asarray(side * (face[table] + (below if side > 0.0 else above)))
