"""Constants of a beam that bends far, in the kernels' order: see `kanefe.kernels.beams.ExactBeam`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Matrix
from kanefe.kernels.beams import ExactBeam
from kanefe.order_n.tables.modal_constants import ModalConstants
from kanefe.tree.body_terms import FlexibleTerms

if TYPE_CHECKING:
    from kanefe.bodies.exact.beam_line import BeamLine


BEAM_LENGTHS = ("k", "section_count", "point_count")
"""Lengths of what changes of a beam."""


def put_beam(beam: ExactBeam, line: BeamLine) -> None:
    """Write the lengths of a beam."""
    cells, points = line.masses.shape
    beam.cell_count, beam.point_count, beam.end_count = cells, points, points + 1
    beam.step_count, beam.mass_count, beam.section_count = (
        cells * (points + 1),
        cells * points,
        1 + cells * (points + 1),
    )
    beam.in_plane = line.is_in_plane


def place_of_motion(beam: ExactBeam, station: int) -> int:
    """Return where the motion of a section by the coordinates, (6, k), is in the modal work."""
    first = ExactBeam.fields["motions"].kind.place(beam.__getattribute__)
    return int(first) + 6 * beam.k * station


def beam_numbers(line: BeamLine, stiffness: Matrix) -> tuple[np.ndarray, ...]:
    """Return the numbers of a beam in the pool."""
    begins = np.searchsorted(line.strain_of, np.arange(7))
    rows, columns = np.triu_indices(3)
    cells, points = line.masses.shape
    sections = np.concatenate(
        (line.masses[..., None], line.centres, line.inertias[..., rows, columns]), axis=-1
    ).reshape(cells * points, 10)
    return (
        line.axes,
        begins,
        line.lengths,
        line.integration,
        line.turn_rest,
        line.turn_values,
        line.values,
        sections,
        stiffness,
    )


def constants_of_beam(terms: FlexibleTerms) -> ModalConstants:
    """Return what the kernels need of a beam as of other bodies: its mass, and the diagonal of K for scales."""
    body = terms.body
    constants = np.atleast_1d(body.mass), np.zeros(3), np.zeros(6), np.diag(body.stiffness)
    return ModalConstants(constants, None, terms.damping, None)
