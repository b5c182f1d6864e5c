"""Properties of a body besides its motion: names, mass, mesh and modes, for results and their files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.fe_model.model import COMPONENTS, Cells, Elasticity
from kanefe.results.quantities import XYZ
from kanefe.storage.scipy_later import sp
from kanefe.tree.body_terms import BodyTerms, FlexibleTerms
from kanefe.tree.model_data import ModelData
from kanefe.tree.neighbours import Neighbours, sources_of
from kanefe.tree.scales import kept_of_scene

if TYPE_CHECKING:
    from kanefe.bodies.exact.beam_line import BeamLine
    from kanefe.bodies.flexible import FlexibleBody


@dataclass(frozen=True, eq=False)
class BodyShape:
    """Properties of a body besides its motion: names, mass and, if it is flexible, its mesh and modes.

    Attributes
    ----------
    name, parent, parent_interface : str
        "" for the inertial frame, and for a parent's own frame.
    joint : str
        Kind of the joint.
    driven_names : tuple of str
        Coordinates of the joint that are prescribed functions of time, with units in brackets.
    coordinate_names, speed_names : tuple of str
        Of the joint, with units in brackets.
    mass : float
        kg.
    com : ndarray, shape (3,)
        Undeformed centre of mass in the body's frame, m.
    inertia : ndarray, shape (3, 3)
        Undeformed, about the centre of mass, kg m2.
    interfaces : tuple of str
        Names; none for a rigid body.
    components : tuple of str
        Degrees of freedom of the mesh's nodes.
    nodes : ndarray, shape (n, 3)
        In m; no rows for a rigid body.
    basis : ndarray, shape (n * components, k)
        Motion of the nodes from the modal coordinates.
    cells : tuple of Cells
    is_orthonormal : bool
        Whether the modes have unit modal mass, so that their coordinates are in kg^1/2 m.
    provenance : mapping
    elasticity : Elasticity or None
        Data for the recovery of stresses and section forces.
    stress_modes : ndarray, shape (n, 6, k), or None
        Stress at the nodes of unit coordinates, Pa, of elements with a stress recovery of their own.
    flexible : FlexibleBody or None
        The body itself, if the run is in memory.
    neighbours : mapping of str to Neighbours
        What acts at each interface, by name.
    line : BeamLine or None
        Of a body that bends far, which moves its nodes instead of the basis.
    """

    name: str
    parent: str
    parent_interface: str
    joint: str
    driven_names: tuple[str, ...]
    coordinate_names: tuple[str, ...]
    speed_names: tuple[str, ...]
    mass: float
    com: np.ndarray
    inertia: np.ndarray
    interfaces: tuple[str, ...]
    components: tuple[str, ...]
    nodes: np.ndarray
    basis: np.ndarray
    cells: tuple[Cells, ...]
    is_orthonormal: bool
    provenance: Mapping[str, Any]
    elasticity: Elasticity | None = None
    stress_modes: np.ndarray | None = None
    flexible: FlexibleBody | None = None
    neighbours: Mapping[str, Neighbours] = field(default_factory=dict)
    line: BeamLine | None = None

    @property
    def is_driven(self) -> bool:
        """Whether a coordinate of the joint is a prescribed function of time."""
        return len(self.driven_names) > 0

    @property
    def is_flexible(self) -> bool:
        """Whether the body has a mesh."""
        return len(self.nodes) > 0

    def displacements(self, eta: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        """Return the displacements of some nodes in G, (T, len(nodes), 3) in m, from eta (T, k); T may be left out."""
        if self.line is not None:
            moved = self.line.places(np.atleast_2d(eta))[1][:, nodes] - self.nodes[nodes]
            return moved if np.ndim(eta) == 2 else moved[0]
        if not sp.issparse(self.basis):
            motion = self.translations(nodes)
            # tensordot copies the basis, which takes longer than the product at a single time
            return motion @ eta if np.ndim(eta) == 1 else np.asarray(np.tensordot(eta, motion, axes=(-1, -1)))
        width = len(self.components)
        rows = self.basis[(nodes[:, None] * width + np.arange(width)).ravel()]
        moved = (rows @ np.atleast_2d(eta).T).T.reshape(-1, len(nodes), width)
        found = np.zeros((*moved.shape[:2], 3))
        for column, component in enumerate(self.components):
            if component in XYZ:
                found[:, :, COMPONENTS.index(component)] = moved[:, :, column]
        return found if np.ndim(eta) == 2 else found[0]

    def rotations(self, eta: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        """Return the rotations of some nodes in G, (r, len(nodes), 3) in rad, from coordinates (r, k)."""
        found, width, basis = np.zeros((len(eta), len(nodes), 3)), len(self.components), self.basis
        for axis, name in enumerate(COMPONENTS[3:]):
            if name in self.components:
                rows: Any = basis[nodes * width + self.components.index(name)]
                found[:, :, axis] = (rows @ eta.T).T
        return found

    def translations(self, nodes: np.ndarray) -> np.ndarray:
        """Return the rows of the basis that move some nodes along x, y and z, shape (len(nodes), 3, k)."""
        motion = self.basis.reshape(len(self.nodes), len(self.components), -1)
        if not np.array_equal(nodes, np.arange(len(motion))):
            motion = motion[nodes]
        if self.components == COMPONENTS[:3]:
            return np.asarray(motion)
        rows = np.zeros((len(nodes), 3, motion.shape[2]))
        for column, component in enumerate(self.components):
            if component in XYZ:
                rows[:, COMPONENTS.index(component)] = motion[:, column]
        return rows


def _is_orthonormal(terms: FlexibleTerms) -> bool:
    if sp.issparse(terms.body.basis):
        return False
    return bool(np.allclose(terms.free_moments.elastic_mass, np.eye(terms.body.free_count)))


@kept_of_scene
def body_shapes(model: ModelData) -> tuple[BodyShape, ...]:
    """Return the shapes of all bodies, found once for all runs of a scene."""
    return tuple(_body_shape(model, body) for body in model.bodies)


def _body_shape(model: ModelData, body: BodyTerms) -> BodyShape:
    mesh: dict[str, Any] = {"interfaces": (), "components": (), "cells": (), "is_orthonormal": False, "provenance": {}}
    mesh |= {"nodes": np.zeros((0, 3)), "basis": np.zeros((0, 0))}
    mass, com, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    if body.rigid is not None:
        mass, com, inertia = body.rigid.mass, body.rigid.com, body.rigid.inertia
    elif body.flexible is not None:
        flexible, sources = body.flexible.body, sources_of(model)
        stresses, k = flexible.stress_modes, flexible.free_count
        mass, com = flexible.mass, flexible.center_of_mass
        inertia = flexible.inertia - mass * (com @ com * np.eye(3) - np.outer(com, com))
        mesh = {
            "interfaces": tuple(frame.name for frame in flexible.interfaces),
            "components": flexible.components,
            "nodes": flexible.nodes,
            "basis": flexible.basis[:, :k],
            "cells": flexible.cells,
            "is_orthonormal": _is_orthonormal(body.flexible),
            "provenance": flexible.provenance,
            "elasticity": flexible.elasticity,
            "stress_modes": None if stresses is None else stresses[..., :k],
            "flexible": flexible,
            "line": flexible.line,
            "neighbours": {
                frame.name: sources[model.index(body.name), frame.name].neighbours for frame in flexible.interfaces
            },
        }
    return BodyShape(
        name=body.name,
        parent=model.bodies[body.parent].name if body.parent >= 0 else "",
        parent_interface=body.parent_interface.name if body.parent_interface is not None else "",
        joint=body.joint.kind,
        driven_names=tuple(body.joint.coordinate_names[i] for i in body.driven),
        coordinate_names=body.joint.coordinate_names,
        speed_names=body.joint.speed_names,
        mass=mass,
        com=com,
        inertia=inertia,
        **mesh,
    )
