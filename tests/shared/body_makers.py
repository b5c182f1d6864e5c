"""Flexible bodies of every kind that a file must hold."""

from dataclasses import replace

import numpy as np

import kanefe as kf
from kanefe.fe_model.load_pattern import LoadPattern
from kanefe.fe_model.model import Cells
from scenes import lattice_body

BODIES = {
    "reduced": lambda: lattice_body(0, reduction=kf.CraigBampton(modes=3), damping=kf.ModalDamping(0.02)),
    "unreduced": lambda: lattice_body(1),
    "nodal form": lambda: lattice_body(2, rotations=True),
    "floating, planar": lambda: lattice_body(3, {}, planar=True, reduction=kf.CraigBampton(modes=2)),
    "with load patterns": lambda: replace(
        lattice_body(5),
        load_patterns=(
            LoadPattern("top", "surface", True, 0.5, *(np.arange(n) + 0.1 for n in (3, 3, 3, 3, 4))),
            LoadPattern("span", "line", False, 2.0, *(np.zeros(n) for n in (3, 3, 3, 3, 4))),
        ),
    ),
    "with cells": lambda: replace(
        lattice_body(4), cells=(Cells("line", np.array([[0, 1], [1, 2]])), Cells("vertex", np.array([[3]])))
    ),
}
