"""What the discretisation of a beam that bends far leaves open, from a state itself: an estimate."""

from __future__ import annotations

import math

import numpy as np

from kanefe.bodies.exact.beam_line import BeamLine
from kanefe.frames import Vector


def doubt(line: BeamLine, eta: Vector) -> float:
    """Return how far the last functions move a section in a state, and the errors of the quadratures, m.

    The coefficients of smooth strains fall with the degree, once there are functions enough for the waves of the
    strains, so that functions that are left out move sections by less than the last ones that are there. Forces that
    change with the shape are not looked at.
    """
    found = line.motion(eta, np.zeros_like(eta))
    moved = np.linalg.norm(found.V[:, :, line.last] @ eta[line.last], axis=1).max()
    return float(moved + _error_of_turns(line, eta) + line.lengths @ _errors_of_places(line, eta))


def _error_of_turns(line: BeamLine, eta: Vector) -> float:
    """Return how far a section moves if the axes turn by half the steps: their Magnus expansions err by 2^-6 of it."""
    marks = line.marks
    middle = 0.5 * (marks[1:] + marks[:-1])
    step = np.arange(len(middle))
    halves = [line.turns_within(eta[None], step, *ends) for ends in ((marks[:-1], middle), (middle, marks[1:]))]
    finer = line.placed(eta[None], halves[0] @ halves[1])[1]
    return float(np.linalg.norm(finer - line.places(eta[None])[1], axis=-1).max())


def _errors_of_places(line: BeamLine, eta: Vector) -> Vector:
    """Return the errors of the quadrature of places in each cell, relative to its length.

    They are those of P Gauss points for ``exp(i theta x)``, theta the turn of the cell:
    ``theta^2P (P!)^4 / ((2 P + 1) (2 P)!^3)``.
    """
    P, turns = len(line.points), np.linalg.norm(line.turn_vectors(eta[None])[0, :, :, 0], axis=-1).sum(axis=1)
    scale = 4.0 * math.lgamma(P + 1) - 3.0 * math.lgamma(2 * P + 1) - np.log(2 * P + 1)
    with np.errstate(divide="ignore"):
        return np.asarray(np.exp(np.minimum(2 * P * np.log(turns) + scale, 0.0)))
