"""Tables of the motions of driven coordinates for the kernels."""

from __future__ import annotations

import math

import numpy as np

from kanefe.joints.motion import Motion
from kanefe.kernels.compiler._numba_functions import Part
from kanefe.kernels.compiler.filling import filler
from kanefe.kernels.sweeps.drives import Drives, Piece
from kanefe.tree.model_data import ModelData

PIECES_A_STEP = 2.0
"""Number of table pieces that a step may span. The stages of a step are then no more than a piece apart: a bump of a
table spans at least two pieces, and cannot lie between them unseen."""


def drive_tables(model: ModelData) -> Drives | None:
    """Return the motions of the driven coordinates for compiled code; None if one is in Python."""
    motions = [motion for motion, _ in model.drives]
    if not all(motion.pieces is not None or motion.is_compiled for motion in motions):
        return None
    pieces, rows = [np.zeros((0, Piece.number_count))], []
    parts: list[Part] = []
    for i, motion in enumerate(motions):
        own = _pieces(motion)
        rows.append((sum(map(len, pieces)), len(own)))
        pieces.append(own)
        if motion.pieces is None:
            functions = motion.position, motion.velocity, motion.acceleration
            parts += [(function, 3 * i + c, 0, False) for c, function in enumerate(functions) if function is not None]
    return Drives(
        motions=np.array(rows, dtype=np.int64).reshape(-1, 2),
        pieces=np.concatenate(pieces),
        spans=np.array([motion.known for motion in motions]).reshape(-1, 2),
        given=filler(tuple(parts)),
    )


def _pieces(motion: Motion) -> np.ndarray:
    """Return the pieces of a motion with the longest step from the start of each; none of compiled functions.

    A step may end where one of the following pieces allows it to, so that a coarse part of a table does not lead over a
    fine one.
    """
    if motion.pieces is None:
        return np.zeros((0, Piece.number_count))
    found = np.column_stack((motion.pieces, np.full(len(motion.pieces), math.inf)))
    lengths = np.diff(motion.pieces[:, 0], append=motion.span[1])
    longest = math.inf
    for piece, length in zip(found[::-1], lengths[::-1], strict=True):
        piece[-1] = longest = min(PIECES_A_STEP * length, length + longest)
    return found
