"""The `ShellStack` of a mesh: its thickness and layers for stresses, pictures and contacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.fe_model.model import Cells
from kanefe.fe_model.shell_stack import ShellStack
from kanefe_fem.shells.directors import Directors
from kanefe_fem.shells.of_groups import ShellGroup


class BlockOfGroup(NamedTuple):
    """A block of cells of one shape in one group.

    Attributes
    ----------
    group : int
        Number of the group.
    cells : Cells
    sides : ndarray of int, shape (m, nodes per cell)
        Numbers of the directors.
    thickness : ndarray, shape (m, nodes per cell)
        m.
    along : ndarray, shape (m, 3)
        Direction whose part in the surface is axis 1.
    """

    group: int
    cells: Cells
    sides: np.ndarray
    thickness: np.ndarray
    along: np.ndarray


def shell_stack(groups: Sequence[ShellGroup], blocks: Sequence[BlockOfGroup], found: Directors) -> ShellStack:
    """Return the stack of the cells of a shell, in the order of its blocks."""
    layers = [group.section.layers for group in groups]
    every = [layer for own in layers for layer in own]
    counts = np.concatenate([np.full(len(one.sides), one.sides.shape[1]) for one in blocks])
    return ShellStack(
        nodes=found.node,
        directors=found.normal,
        sides=np.concatenate([one.sides.ravel() for one in blocks]),
        cells=np.repeat(np.arange(len(counts)), counts),
        thickness=np.concatenate([one.thickness.ravel() for one in blocks]),
        along=np.concatenate([one.along for one in blocks]),
        of_cell=np.concatenate([np.full(len(one.sides), one.group) for one in blocks]),
        is_isotropic=np.array([group.is_isotropic for group in groups]),
        first=np.cumsum([0, *(len(own) for own in layers)]),
        heights=np.array([(layer.bottom, layer.top) for layer in every]),
        plane=np.array([layer.plane for layer in every]),
        shear=np.array([layer.shear for layer in every]),
        across=np.array([layer.across for layer in every]),
        angles=np.array([layer.angle for layer in every], dtype=float),
        strengths=np.array([layer.strengths for layer in every]),
        forces=np.array([group.section.shear for group in groups]),
    )
