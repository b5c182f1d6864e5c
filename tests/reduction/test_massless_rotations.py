"""Lumped mass matrices leave rotations without mass: reduction takes them, and the inertia is exact."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.imports.from_matrices import NodalFormWarning
from steel_beams import steel_beam


def lumped(elements: int, about_axis: float = 0.0) -> kf.FiniteElementModel:
    beam = steel_beam(elements)
    shares = np.ones(elements + 1)
    shares[[0, -1]] = 0.5
    mass = sp.diags(np.kron(shares * 4.71 / elements, (1, 1, 1, about_axis, 0, 0)))
    ends = {"root": 0, "tip": elements}
    return kf.model_from_matrices(mass, beam.stiffness, beam.nodes, components=beam.components, groups=ends)


def condensed_frequencies(model: kf.FiniteElementModel, held: int) -> np.ndarray:
    """Oracle: the massless rotations by static condensation, dense."""
    K, M = model.stiffness.toarray()[held:, held:], model.mass.diagonal()[held:]
    heavy, light = M > 0, M == 0
    coupling = K[np.ix_(heavy, light)]
    S = K[np.ix_(heavy, heavy)] - coupling @ np.linalg.solve(K[np.ix_(light, light)], coupling.T)
    squares = scipy.linalg.eigh(S, np.diag(M[heavy]), eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)


# from 400 rows on the modes come from a Krylov space
@pytest.mark.parametrize("elements", [8, 80])
def test_modes_of_a_clamped_and_of_a_floating_bar(elements: int) -> None:
    model = lumped(elements)
    held = kf.flexible_body(model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=5))
    assert held.is_exact
    # K of 80 elements has a condition of 1e9
    assert held.frequencies == pytest.approx(condensed_frequencies(model, 6)[:5], rel=1e-6)
    with pytest.warns(NodalFormWarning):
        turning = lumped(elements, about_axis=1e-4)
    free = kf.flexible_body(turning, {}, reduction=kf.CraigBampton(modes=5))
    assert free.frequencies == pytest.approx(condensed_frequencies(turning, 0)[6:11], rel=1e-4)


def test_a_floating_bar_without_inertia_about_its_axis_is_refused() -> None:
    with pytest.raises(ModelError, match=r"a rigid motion of the floating body has no mass.* Remedy"):
        kf.flexible_body(lumped(8), {}, reduction=kf.CraigBampton(modes=2))


def test_more_modes_than_masses_are_refused() -> None:
    with pytest.raises(ModelError, match=r"only 24 degrees of freedom have mass|fewer modes"):
        kf.flexible_body(lumped(8), {"root": "clamped"}, reduction=kf.CraigBampton(modes=30))
