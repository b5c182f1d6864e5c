"""Materials: values out of range are refused, mixed-up units and locking are warned of."""

from __future__ import annotations

import numpy as np
import pytest

from fem_meshes import STEEL, box, shown
from kanefe.errors import ModelError
from kanefe_fem.materials.isotropic import AccuracyWarning, Material, UnitWarning, warn_of_units
from kanefe_fem.solids.model import solid_model


class TestMaterial:
    @pytest.mark.parametrize(
        ("values", "word"),
        [
            ((0.0, 0.3, 1.0), "E = 0"),
            ((-1.0, 0.3, 1.0), "E = -1"),
            ((1e9, 0.5, 1.0), "nu = 0.5"),
            ((1e9, 0.7, 1.0), "nu = 0.7"),
            ((1e9, -1.0, 1.0), "nu = -1"),
            ((1e9, 0.3, 0.0), "rho = 0"),
            ((1e9, 0.3, -5.0), "rho = -5"),
            ((np.nan, 0.3, 1.0), "E = nan"),
            ((1e9, np.inf, 1.0), "nu = inf"),
            ((1e9, 0.3, np.inf), "rho = inf"),
            ((None, 0.3, 1.0), "E is None"),
            ((1e9, 0.3, "7850"), "rho is '7850'"),
        ],
    )
    def test_values_out_of_range(self, values, word):
        with pytest.raises(ModelError) as error:
            Material(*values, name="putty")
        shown(error, "putty", word)

    def test_it_is_frozen_and_knows_its_moduli(self):
        with pytest.raises(AttributeError):
            STEEL.E = 1.0
        # bulk modulus by two ways
        assert STEEL.lame + 2 / 3 * STEEL.shear_modulus == pytest.approx(STEEL.E / (3 * (1 - 2 * STEEL.nu)), rel=1e-14)

    @pytest.mark.parametrize(
        ("material", "size", "mass", "word"),
        [
            (STEEL, 1000.0, 1.0, "mesh in mm"),
            (STEEL, 150.0, 1e9, "mass is 1e\\+09 kg"),
            (Material(210e3, 0.3, 7850.0), 1.0, 1.0, "E in MPa"),
            (Material(210e9, 0.3, 7.85), 1.0, 1.0, "rho in g/cm3"),
            (Material(210e3, 0.3, 7.85e-9), 1.0, 1.0, "t/mm3"),
            (STEEL, 1e-6, 1e-9, "in size"),
        ],
    )
    def test_mixed_up_units_are_warned_of(self, material, size, mass, word):
        with pytest.warns(UnitWarning, match=word):
            warn_of_units("bar", material.E, material.rho, size, mass)

    @pytest.mark.parametrize(
        "material",
        [STEEL, Material(2e6, 0.45, 1100.0), Material(1e12, 0.1, 3500.0), Material(10e9, 0.3, 500.0)],
        ids=["steel", "rubber", "diamond", "wood"],
    )
    @pytest.mark.parametrize("size", [1e-4, 1.0, 110.0])
    def test_what_exists_is_not_warned_of(self, material, size, recwarn):
        warn_of_units("bar", material.E, material.rho, size, material.rho * size**3 / 1000)
        assert not recwarn.list

    @pytest.mark.usefixtures("no_assembly")
    def test_a_mesh_in_millimetres_and_locking(self):
        mm = box("tetra", (2, 1, 1), (1000.0, 100.0, 100.0))
        with pytest.warns(UnitWarning, match="group 'bar' of tetra box"), pytest.raises(pytest.fail.Exception):
            solid_model(mm, STEEL)
        soft = Material(2e6, 0.49, 1100.0)
        with pytest.warns(AccuracyWarning, match="locking"), pytest.raises(pytest.fail.Exception):
            solid_model(box("tetra", (2, 1, 1), (1, 1, 1)), soft, order=1)
