"""Shells with stiffeners and with solids as one model.

The nodes of the solids come after those of the shell; their rotations are those of a cell there, half of curl u. They,
and the components of a seam that follow the solid, have no stiffness and mass of their own,

    x = T y,    T = 1 - P + G,    K = T^T K_0 T + (P - G)^T k (P - G),

with the projector P on what follows and G from what it follows. The spring k between both is relaxed in every motion,
so that its size does not matter.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple, cast

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.block_diagonal import block_diagonal
from kanefe.fe_model.model import (
    Cells,
    Elasticity,
    FiniteElementModel,
    MassField,
    NodeGroup,
    StressStiffness,
    fields_together,
)
from kanefe.fe_model.pressure_change import turning
from kanefe.fe_model.shapes import shape
from kanefe.frames import skews
from kanefe_fem.shells.seams import Seams
from kanefe_fem.shells.stiffeners import StiffenerLines, ribs_together

STIFF = 1e3
"""Stiffness of a component that follows, relative to that of the shell there."""


def with_stiffeners(model: FiniteElementModel, lines: Sequence[StiffenerLines]) -> FiniteElementModel:
    """Return the model of a shell with the stiffness and the mass of stiffeners."""
    count = len(model.nodes)
    stiffness = model.stiffness + sum(one.stiffness(count) for one in lines)
    field = fields_together([cast(MassField, model.mass_field), *(one.mass_field(count) for one in lines)])
    of_shell, own, ribs = model.stress_stiffness, cast(Elasticity, model.elasticity), ribs_together(lines)

    def stress_stiffness(displacement: np.ndarray, load: np.ndarray | None = None) -> sp.csr_matrix:
        total = of_shell(displacement) if of_shell is not None else sp.csr_matrix(stiffness.shape)
        return (total + sum(one.stress_stiffness(displacement, count) for one in lines)).tocsr()

    return replace(
        model,
        stiffness=stiffness.tocsr(),
        mass=field.mass_matrix(),
        mass_field=field,
        stress_stiffness=stress_stiffness,
        cells=(*model.cells, *(Cells("line3", one.nodes) for one in lines)),
        elasticity=replace(own, of_cell=np.append(own.of_cell, ribs.of_line), ribs=ribs),
        provenance={
            **model.provenance,
            "stiffeners": {one.name: one.described for one in lines},
            "stiffener_masses_kg": {one.name: one.mass for one in lines},
        },
    )


class _Parts(NamedTuple):
    """How matrices of a shell and of a solid become those of one model."""

    shell: FiniteElementModel
    solid: FiniteElementModel
    in_space: sp.csr_matrix
    motion: sp.csr_matrix
    seams: Seams

    def joined(self, of_shell: sp.csr_matrix | None, of_solid: sp.csr_matrix | None) -> sp.csr_matrix | None:
        """Return a matrix of both, or None if neither has one."""
        if of_shell is None and of_solid is None:
            return None
        first = sp.csr_matrix((self.shell.size,) * 2) if of_shell is None else of_shell
        second = sp.csr_matrix((self.solid.size,) * 2) if of_solid is None else of_solid
        both = sp.block_diag((first, self.in_space @ second @ self.in_space.T), format="csr")
        return (self.motion.T @ both @ self.motion).tocsr()


def with_solid(shell: FiniteElementModel, solid: FiniteElementModel, seams: Seams) -> FiniteElementModel:
    """Return the model of a shell and of a solid that meet at seams.

    Parameters
    ----------
    shell : FiniteElementModel
        Six components a node.
    solid : FiniteElementModel
        Three components a node.
    seams : Seams
    """
    count, size = len(shell.nodes), shell.size + 6 * len(solid.nodes)
    in_space = sp.kron(sp.identity(len(solid.nodes)), sp.eye(6, 3), format="csr")
    wide = (in_space @ solid.stiffness @ in_space.T).tocsr()
    curl = _half_curl(solid)
    rotations = sp.kron(sp.identity(len(solid.nodes)), sp.eye(6, 3, k=-3), format="csr")
    off = rotations.T - curl @ in_space.T
    held, follows = _constraints(seams, count, size, in_space)
    parts = _Parts(shell, solid, in_space, (sp.identity(size) - held + follows).tocsr(), seams)
    turning = off.T @ sp.diags(_turning_sizes(solid, curl)) @ off
    first = sp.block_diag((shell.stiffness, wide + turning), format="csr")
    gap = held - follows
    springs = sp.diags(STIFF * _sizes(shell, seams, size))
    shell_field, solid_field = cast(MassField, shell.mass_field), cast(MassField, solid.mass_field)
    fields = (
        _widened(shell_field, lambda N: sp.hstack((N, sp.csr_matrix((N.shape[0], size - shell.size)))) @ parts.motion),
        _widened(
            solid_field,
            lambda N: sp.hstack((sp.csr_matrix((N.shape[0], shell.size)), N @ in_space.T)) @ parts.motion,
        ),
    )
    field = fields_together(fields)
    unit = sp.hstack((sp.csr_matrix((rotations.shape[1], shell.size)), rotations.T))
    return replace(
        shell,
        nodes=np.concatenate((shell.nodes, solid.nodes)),
        stiffness=(parts.motion.T @ first @ parts.motion + gap.T @ springs @ gap).tocsr(),
        mass=field.mass_matrix(),
        mass_field=field,
        following=sp.vstack((unit, _directions(seams, size)), format="csr"),
        cells=(*shell.cells, *(Cells(block.kind, block.nodes + count) for block in solid.cells)),
        elasticity=_moduli(shell, solid),
        groups=_groups(shell, solid, seams),
        load_patterns={name: one.moved_by(parts.motion[: shell.size]) for name, one in shell.load_patterns.items()},
        damping=parts.joined(shell.damping, solid.damping),
        structural=parts.joined(shell.structural, solid.structural),
        viscoelastic=tuple(replace(one, stiffness=parts.joined(None, one.stiffness)) for one in solid.viscoelastic),
        stress_stiffness=partial(_stress_stiffness, parts),
        provenance={
            **shell.provenance,
            "solids": {name: solid.provenance[name] for name in ("element", "materials", "nodes", "cells")}
            | {"mass_kg": float(solid_field.mass.sum())},
            "seams": {"edges": seams.edges, "cells": seams.faces, "of the thickness on the solid": seams.on_solid},
            "nodes": count + len(solid.nodes),
            "dofs": size,
        },
    )


def _moduli(shell: FiniteElementModel, solid: FiniteElementModel) -> Elasticity:
    """Return the sections of the shell and the moduli of the solid."""
    first, second = (cast(Elasticity, one.elasticity) for one in (shell, solid))
    return replace(first, table=second.table, of_cell=np.append(first.of_cell, second.of_cell))


def _half_curl(solid: FiniteElementModel) -> sp.csr_matrix:
    """Return the rotations of the nodes of a solid, those of one cell at each of them, from their displacements."""
    rows, columns, values = [], [], []
    missing = np.ones(len(solid.nodes), dtype=bool)
    for block in solid.cells:
        element = shape(block.kind)
        for local in range(block.nodes.shape[1]):
            node, first = np.unique(block.nodes[:, local], return_index=True)
            first, node = first[missing[node]], node[missing[node]]
            missing[node] = False
            if not len(node):
                continue
            own = block.nodes[first]
            slope = element.gradients(element.nodes[local][None])[0]
            J = np.einsum("mni,na->mia", solid.nodes[own], slope)
            gradient = np.einsum("na,mai->mni", slope, np.linalg.inv(J))
            # theta_i = e_ijk N,j u_k / 2
            turn = 0.5 * np.cross(gradient[:, :, None, :], np.eye(3)[None, None]).swapaxes(2, 3)
            at = np.broadcast_to(3 * node[:, None, None, None] + np.arange(3)[:, None], turn.shape)
            to = np.broadcast_to(3 * own[:, :, None, None] + np.arange(3), turn.shape)
            rows.append(at.ravel())
            columns.append(to.ravel())
            values.append(turn.ravel())
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sp.csr_matrix(entries, (solid.size, solid.size))


def _turning_sizes(solid: FiniteElementModel, curl: sp.csr_matrix) -> np.ndarray:
    """Return stiffnesses of rotations as large as those of displacements around a node, N m/rad, shape (3 n,)."""
    typical = np.repeat(solid.stiffness.diagonal().reshape(-1, 3).mean(axis=1), 3)
    return np.asarray(typical / np.maximum(curl.power(2).sum(axis=1).A1, 1e-300))


def _stress_stiffness(parts: _Parts, displacement: np.ndarray, load: np.ndarray | None = None) -> sp.csr_matrix | None:
    """Return the geometric stiffness of both, of the stress of a displacement (size,) under forces (3 P,) on points."""
    of_shell, of_solid = (cast(StressStiffness, one.stress_stiffness) for one in (parts.shell, parts.solid))
    moved = parts.motion @ displacement
    own = moved[: parts.shell.size]
    forces = parts.shell.stiffness @ own
    if load is not None:
        field = cast(MassField, parts.shell.mass_field)
        forces = forces - field.interpolation.T @ load[: field.interpolation.shape[0]]
    return parts.joined(
        of_shell(own) + _turned_seams(parts.seams, forces.reshape(-1, 6)),
        of_solid(parts.in_space.T @ moved[parts.shell.size :]),
    )


def _turned_seams(seams: Seams, forces: np.ndarray) -> sp.csr_matrix:
    """Return what the forces (n, 6) of the shell do on the motion of second order of nodes that follow.

    A node beside the solid by the arm r is at ``u - 1/2 theta x (theta x r)``; of a director that follows a tilt,
    ``theta x n`` lacks ``1/2 theta (theta . n)``, so that ``theta`` has ``-1/2 (theta . n) n x theta`` in addition.
    """
    blocks = np.zeros((len(seams.nodes), 6, 6))
    force, moment = forces[seams.nodes, :3], forces[seams.nodes, 3:]
    blocks[:, 3:, 3:] = -turning(force, seams.arms)
    mixed = skews(moment) @ (np.eye(3) - seams.held[:, 3:, 3:])  # of a single director n n^T is not held
    blocks[:, 3:, 3:] -= 0.5 * (mixed + mixed.swapaxes(1, 2))
    rows = (6 * seams.nodes[:, None] + np.arange(6)).ravel()
    at = sp.csr_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))), (forces.size, len(rows)))
    return at @ block_diagonal(blocks) @ at.T


def _constraints(seams: Seams, count: int, size: int, in_space: sp.csr_matrix) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Return P and G over all components."""
    rows = (6 * seams.nodes[:, None] + np.arange(6)).ravel()
    at = sp.csr_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))), (size, len(rows)))
    own = np.zeros((len(seams.nodes), 6, 6))
    own[:, :3, 3:] = -skews(seams.arms)
    follows = sp.hstack((sp.csr_matrix((len(rows), 6 * count)), seams.follows @ in_space.T), format="csr")
    held = at @ block_diagonal(seams.held) @ at.T
    return held.tocsr(), (at @ (follows + block_diagonal(own) @ at.T)).tocsr()


def _sizes(shell: FiniteElementModel, seams: Seams, size: int) -> np.ndarray:
    """Return stiffnesses of the shell at the components of seams, the mean of the three of a node; 0 elsewhere."""
    found = np.zeros(size)
    diagonal = shell.stiffness.diagonal().reshape(-1, 2, 3).mean(axis=2)
    rows = (6 * seams.nodes[:, None] + np.arange(6)).ravel()
    found[rows] = np.repeat(diagonal[seams.nodes], 3, axis=1).ravel()
    return found


def _directions(seams: Seams, size: int) -> sp.csr_matrix:
    """Return unit directions of the components that follow, one a row."""
    rows, columns, values, count = [], [], [], 0
    for node, held in zip(seams.nodes, seams.held, strict=True):
        for first in (0, 3):
            squares, axes = np.linalg.eigh(held[first : first + 3, first : first + 3])
            for axis in axes[:, squares > 0.5].T:
                rows.append(np.full(3, count))
                columns.append(6 * node + first + np.arange(3))
                values.append(axis)
                count += 1
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sp.csr_matrix(entries, (count, size))


def _widened(field: MassField, wide: Callable[[sp.csr_matrix], sp.spmatrix]) -> MassField:
    """Return a field over the components of both."""
    turns = None if field.turns is None else sp.csr_matrix(wide(field.turns))
    return replace(field, interpolation=sp.csr_matrix(wide(field.interpolation)), turns=turns)


def _groups(shell: FiniteElementModel, solid: FiniteElementModel, seams: Seams) -> dict[str, NodeGroup]:
    """Return the groups of both: of a name that both have, on seams that of the solid, elsewhere both."""
    count = len(shell.nodes)
    groups = {name: replace(one, nodes=np.asarray(one.nodes) + count) for name, one in solid.groups.items()}
    for name, one in shell.groups.items():
        if name not in groups:
            groups[name] = one
        elif not np.isin(one.nodes, seams.nodes).all():
            nodes = np.append(one.nodes[~np.isin(one.nodes, seams.nodes)], groups[name].nodes)
            groups[name] = NodeGroup(nodes, np.concatenate((shell.nodes, solid.nodes))[nodes].mean(axis=0))
    return groups
