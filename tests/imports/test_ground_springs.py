"""Springs from rotations to the ground are told from a wrong order of the nodes, from supports and from mechanisms."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import AccuracyWarning, ModelError
from kanefe.imports.nodal_inertia import NodalFormWarning
from steel_beams import steel_beam

BEAM = steel_beam(20)


def with_springs(stiffness: float) -> kf.FiniteElementModel:
    """The beam with springs to ground about y at every node, N m/rad."""
    K = BEAM.stiffness + sp.diags(np.tile((0, 0, 0, 0, stiffness, 0), 21))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NodalFormWarning)
        return kf.model_from_matrices(BEAM.mass, K, BEAM.nodes, components=BEAM.components, groups={"root": 0})


def test_strong_springs_are_refused_as_what_they_are() -> None:
    for stiffness in (1e2, 1e4):
        moment = f"{21 * stiffness:.3g}".replace("+", r"\+")
        with pytest.raises(ModelError, match=rf"resisted by {moment} N m, by moments and no forces: springs to ground"):
            with_springs(stiffness)


def test_weak_springs_are_told() -> None:
    # (w / w1)^2 = (21 k / J) / w1^2 lies between round-off and a thousandth
    with pytest.warns(
        AccuracyWarning, match=r"springs to ground at the rotations of 21 node\(s\) .* squared frequency"
    ):
        model = with_springs(1.0)
    held = kf.flexible_body(model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=2))
    right = kf.flexible_body(with_springs(0.0), {"root": "clamped"}, reduction=kf.CraigBampton(modes=2))
    assert held.frequencies == pytest.approx(right.frequencies, rel=1e-3)
    with pytest.raises(ModelError, match="springs to ground"):
        kf.flexible_body(model, {}, reduction=kf.CraigBampton(modes=2))


def test_other_faults_are_no_springs() -> None:
    with pytest.raises(
        ModelError, match="translations are free, so it is not a support: the nodes are in another order"
    ):
        kf.model_from_matrices(BEAM.mass, BEAM.stiffness, BEAM.nodes[::-1], components=BEAM.components)
    held = BEAM.stiffness + sp.diags(np.append(np.full(6, 1e6), np.zeros(120)))
    with pytest.raises(ModelError, match="exported unsupported"):
        kf.model_from_matrices(BEAM.mass, held, BEAM.nodes, components=BEAM.components)
    hinged = BEAM.stiffness.tolil()
    hinged[3::6] = hinged[:, 3::6] = 0.0
    with pytest.raises(ModelError, match="leaves more than the 6 rigid motions free"):
        kf.model_from_matrices(BEAM.mass, hinged.tocsr(), BEAM.nodes, components=BEAM.components)
