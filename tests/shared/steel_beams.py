"""Beams of steel: one of 1 m by 20 x 30 mm, and a short stiff one on a hinge."""

from typing import Any

import numpy as np
import scipy.linalg

import kanefe as kf
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
BAR_LENGTH = 0.3


def steel_beam(elements: int = 20, **options: Any) -> kf.FiniteElementModel:
    """Return the beam of 1 m; options of `straight_beam`."""
    return straight_beam(1.0, Rectangle(0.02, 0.03), STEEL, elements=elements, **options)


def craig_bampton(full: kf.FiniteElementModel, boundary: list[int], modes: int) -> np.ndarray:
    """Return shapes of a beam (N, K) from its boundary nodes and its modes with these held, by dense algebra."""
    held = np.add.outer(6 * np.array(boundary), np.arange(6)).ravel()
    inner = np.setdiff1d(np.arange(full.size), held)
    K, M = full.stiffness.toarray(), full.mass.toarray()
    _, shapes = scipy.linalg.eigh(K[np.ix_(inner, inner)], M[np.ix_(inner, inner)], subset_by_index=(0, modes - 1))
    T = np.zeros((full.size, len(held) + modes))
    T[held, range(len(held))] = 1.0
    T[inner, : len(held)] = -np.linalg.solve(K[np.ix_(inner, inner)], K[np.ix_(inner, held)])
    T[inner, len(held) :] = shapes
    return T


def steel_bar(width: float = 0.01, height: float = 0.02, *, gravity: float = 9.81, **options: Any) -> kf.System:
    """Return a bar of 0.3 m with modes up to some 100 kHz, level on a hinge in gravity; options of `beam_body`."""
    model = straight_beam(BAR_LENGTH, Rectangle(width, height), STEEL, elements=10)
    scene = kf.System(gravity=(0.0, 0.0, -gravity))
    scene.add_flexible_body("bar", beam_body(model, {"root": "clamped"}, **options), joint=kf.Revolute("y"))
    return scene
