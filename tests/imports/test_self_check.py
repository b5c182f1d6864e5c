"""The self-check of given models: rigid motions, zero modes, mass properties by two routes, units."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import ModelError, UnitWarning
from kanefe.fe_model.factorise import splu_factorise
from kanefe.imports import self_check as home
from kanefe.imports.self_check import self_check, wave_speed
from scenes import lattice_model
from steel_beams import steel_beam

SOLID = lattice_model(0)
BEAM = steel_beam(4)


def test_rotations_without_mass_keep_the_exact_inertia() -> None:
    lumped = sp.diags(np.tile([0.5, 0.5, 0.5, 0, 0, 0], len(BEAM.nodes)))
    model = kf.model_from_matrices(lumped, BEAM.stiffness, BEAM.nodes, components=BEAM.components)
    assert model.mass_field is not None
    assert abs(model.mass_field.mass_matrix() - lumped).max() == 0.0


def test_large_models_are_counted_with_a_given_factorisation(monkeypatch: pytest.MonkeyPatch) -> None:
    model = steel_beam(80)
    calls = []

    def factorise(matrix: Any) -> Any:
        calls.append(matrix.shape)
        return splu_factorise(matrix)

    monkeypatch.setattr(home, "COUNTED_SIZE", 100)
    assert self_check(model).zero_modes is None
    assert self_check(model, factorise=factorise).zero_modes == 6
    assert calls == [(486, 486)]


def test_stated_mass_properties_are_compared() -> None:
    found = self_check(SOLID)
    m, c, J = found.mass, np.array(found.center_of_mass), np.array(found.inertia)
    about_center = J - m * (c @ c * np.eye(3) - np.outer(c, c))
    self_check(SOLID, expected_mass=m, expected_center=c, expected_inertia=about_center)
    with pytest.raises(ModelError, match=r"centre of mass by its matrix is .* was expected\. Remedy"):
        self_check(SOLID, expected_center=c + 0.01)
    with pytest.raises(ModelError, match=r"inertia about its centre of mass .* was expected\. Remedy"):
        self_check(SOLID, expected_inertia=about_center * np.sign(about_center + 1e-30) * 1.01)


def test_units_that_no_material_has_are_told() -> None:
    # the longitudinal wave of the bar runs at sqrt(E/rho) = 5172 m/s; the estimate knows it within a factor of four
    speed = wave_speed(BEAM)
    assert speed is not None
    assert 5172 / 4 < speed < 4 * 5172
    steel = lattice_model(0)
    K = steel.stiffness * (5000.0 / wave_speed(steel)) ** 2
    with warnings.catch_warnings():
        warnings.simplefilter("error", UnitWarning)
        kf.model_from_matrices(steel.mass, K, steel.nodes)
    with pytest.warns(UnitWarning, match=r"waves would run .* at some 5e\+06 m/s.*units='mm, t, s'"):
        kf.model_from_matrices(steel.mass, K, steel.nodes * 1000)
