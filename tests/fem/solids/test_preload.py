"""Preloaded bodies: strings, columns and heated bars against closed forms; static loads; what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from fem_meshes import STEEL, box, shown
from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.solids.model import solid_model
from kanefe_fem.solids.preload import Preload, preloaded

LENGTH, SECTION = 1.0, Rectangle(0.01, 0.02)
EI, EA = STEEL.E * SECTION.I_z, STEEL.E * SECTION.A
LINE = STEEL.rho * SECTION.A


def column(elements=12):
    """Planar Euler-Bernoulli bar along x."""
    return straight_beam(
        LENGTH, SECTION, STEEL, elements=elements, theory="euler-bernoulli", planar=True, rotary_inertia=False
    )


def frequencies(model, fixed, count=3):
    """First circular frequencies with some degrees of freedom held, rad/s."""
    free = np.setdiff1d(np.arange(model.size), fixed)
    K, M = (matrix.toarray()[np.ix_(free, free)] for matrix in (model.stiffness, model.mass))
    return np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[:count])


def pinned(model):
    return [0, 1, model.size - 2]


class TestBeams:
    @pytest.mark.parametrize("tension", [5e4, -0.5 * np.pi**2 * EI / LENGTH**2])
    def test_a_pinned_bar_under_tension(self, tension):
        model = column()
        load = Preload(held={"root": "xy", "tip": "y"}, forces={"tip": (tension, 0, 0)})
        tight = preloaded(model, load)
        n = np.pi * np.arange(1, 4) / LENGTH
        exact = np.sqrt((n**4 * EI + n**2 * tension) / LINE)
        # Hermite elements: (k h)^4 / 1440 of the third mode is 3e-4
        np.testing.assert_allclose(frequencies(tight, pinned(model)), exact, rtol=5e-4)
        share = tight.provenance["preload"]["share_of_buckling_load"]
        assert share == pytest.approx(0.5 if tension < 0 else 0.0, rel=1e-4, abs=1e-9)
        assert tight.provenance["preload"]["largest_displacement_m"] == pytest.approx(abs(tension) / EA, rel=1e-9)

    def test_a_pull_is_the_force_it_takes(self):
        model = column()
        by_force = preloaded(model, Preload(held={"root": ("x", "y", "rz")}, forces={"tip": (1e4, 0, 0)}))
        pull = {"tip": {"x": 1e4 * LENGTH / EA}}
        by_pull = preloaded(model, Preload(held={"root": ("x", "y", "rz"), **pull}))
        np.testing.assert_allclose(by_force.stiffness.toarray(), by_pull.stiffness.toarray(), atol=1e-9 * EA)

    def test_a_heated_bar_between_walls(self):
        model = column()
        strain = 0.3 * 4 * np.pi**2 * EI / LENGTH**2 / EA
        ends = {"root": ("x", "y", "rz"), "tip": ("x", "y", "rz")}
        hot = preloaded(model, Preload(held=ends, thermal_strain=strain))
        # the buckling load of 12 elements is 1e-4 too high
        assert hot.provenance["preload"]["share_of_buckling_load"] == pytest.approx(0.3, rel=2e-4)
        pressed = preloaded(model, Preload(held={**ends, "tip": {"x": -strain * LENGTH, "y": 0.0, "rz": 0.0}}))
        np.testing.assert_allclose(hot.stiffness.toarray(), pressed.stiffness.toarray(), atol=1e-9 * EA)

    def test_a_free_bar_expands_without_stress(self):
        model = column()
        free = preloaded(model, Preload(held={"root": ("x", "y", "rz")}, thermal_strain=1e-3))
        np.testing.assert_allclose(free.stiffness.toarray(), model.stiffness.toarray(), atol=1e-12 * EA)
        assert free.provenance["preload"]["largest_displacement_m"] == pytest.approx(1e-3 * LENGTH, rel=1e-9)

    @pytest.mark.parametrize("elements", [8, 40])  # dense, and by Lanczos
    def test_eulers_column_buckles(self, elements):
        critical = np.pi**2 * EI / (4 * LENGTH**2)
        model = column(elements)
        hold = {"root": ("x", "y", "rz")}
        near = preloaded(model, Preload(held=hold, forces={"tip": (-0.9 * critical, 0, 0)}))
        assert near.provenance["preload"]["share_of_buckling_load"] == pytest.approx(0.9, rel=1e-4)
        with pytest.raises(ModelError) as error:
            preloaded(model, Preload(held=hold, forces={"tip": (-2 * critical, 0, 0)}))
        shown(error, "buckles at 0.5 times this load")

    def test_rotation_and_gravity(self):
        model = column()
        hold = {"root": ("x", "y", "rz")}
        spun = preloaded(model, Preload(held=hold, angular_velocity=(0, 0, 50.0)))
        stretch = STEEL.rho * 50.0**2 * LENGTH**3 / (3 * STEEL.E)
        assert spun.provenance["preload"]["largest_displacement_m"] == pytest.approx(stretch, rel=1e-9)
        hung = preloaded(model, Preload(held=hold, acceleration=(9.81, 0, 0)))
        stretch = STEEL.rho * 9.81 * LENGTH**2 / (2 * STEEL.E)
        assert hung.provenance["preload"]["largest_displacement_m"] == pytest.approx(stretch, rel=1e-9)
        # about its own centre, both halves pull
        turned = preloaded(model, Preload(held=hold, angular_velocity=(0, 0, 50.0), center=(0.5, 0, 0)))
        assert (
            turned.provenance["preload"]["largest_displacement_m"]
            < 0.5 * spun.provenance["preload"]["largest_displacement_m"]
        )


@pytest.mark.fenicsx
class TestSolids:
    SIZE = (1.0, 0.02, 0.01)

    def test_a_stretched_strip_vibrates_as_a_bar_under_tension(self):
        mesh, pull = box("hexahedron", (20, 1, 1), self.SIZE), 2e-4
        load = Preload(held={"root": "xyz", "tip": {"x": pull, "y": 0.0, "z": 0.0}})
        tight, slack = solid_model(mesh, STEEL, preload=load), solid_model(mesh, STEEL)
        ends = np.concatenate([slack.groups[name].nodes for name in ("root", "tip")])
        fixed = (3 * ends[:, None] + np.arange(3)).ravel()
        first = frequencies(tight, fixed, 1)[0] / frequencies(slack, fixed, 1)[0]
        bar = straight_beam(1.0, Rectangle(0.02, 0.01), STEEL, elements=20, theory="euler-bernoulli")
        walls = {"root": COMPONENTS, "tip": {**dict.fromkeys(COMPONENTS, 0.0), "x": pull}}
        held = preloaded(bar, Preload(held=walls))
        clamped = [*range(6), *range(bar.size - 6, bar.size)]
        expected = frequencies(held, clamped, 1)[0] / frequencies(bar, clamped, 1)[0]
        assert expected > 1.2
        # the clamps of the solid hinder its contraction, and it shears
        assert first == pytest.approx(expected, rel=3e-3)

    def test_surface_loads(self):
        mesh = box("tetra", (4, 1, 1), (1.0, 0.1, 0.1))
        material = replace(STEEL, nu=0.0)
        for options, stress in (
            ({"pressures": {"tip": 2e6}}, -2e6),
            ({"tractions": {"tip": (3e6, 0, 0)}}, 3e6),
        ):
            model = solid_model(mesh, material, preload=Preload(held={"root": "xyz"}, **options))
            u = model.provenance["preload"]["largest_displacement_m"]
            assert u == pytest.approx(abs(stress) / STEEL.E, rel=1e-9)

    @pytest.mark.usefixtures("no_assembly")
    def test_groups_are_looked_up_before_the_assembly(self):
        mesh = box("tetra", (1, 1, 1), (1, 1, 1))
        for load in (
            Preload(held={"top": "xyz"}, acceleration=(0, 0, 1)),
            Preload(held={"root": "xyz"}, pressures={"top": 1.0}),
            Preload(held={"root": "xyz"}, forces={"top": (1.0, 0, 0)}),
        ):
            with pytest.raises(ModelError) as error:
                solid_model(mesh, STEEL, preload=load)
            shown(error, "'top'")


class TestBadInput:
    @pytest.mark.parametrize(
        ("options", "word"),
        [
            ({"held": {}}, "nothing is held"),
            ({"held": {"root": "xyz"}}, "no load"),
            ({"held": {"root": "xq"}, "thermal_strain": 1e-3}, "'xq'"),
            ({"held": {"root": {"x": np.nan}}}, "displacement of 'root' in x"),
            ({"held": {"root": "x"}, "forces": {"tip": (1.0, 2.0)}}, "forces on 'tip'"),
            ({"held": {"root": "x"}, "pressures": {"tip": "high"}}, "pressure on 'tip'"),
            ({"held": {"root": "x"}, "acceleration": 9.81}, "acceleration"),
        ],
    )
    def test_no_load_case(self, options, word):
        with pytest.raises(ModelError) as error:
            Preload(**options)
        shown(error, word)

    @pytest.mark.parametrize(
        ("options", "word"),
        [
            ({"held": {"root": "x"}, "forces": {"tip": (1.0, 0, 0)}}, "free to move"),
            ({"held": {"root": "z"}, "acceleration": (1, 0, 0)}, "held in 'z'"),
            ({"held": {"top": "x"}, "acceleration": (1, 0, 0)}, "'top'"),
            ({"held": {"root": "xy"}, "tractions": {"top": (1, 0, 0)}}, "no surface or line"),
            ({"held": {"root": ("x", "y", "rz")}, "pressures": {"span": 1.0}}, "is a line"),
        ],
    )
    def test_it_does_not_fit_the_model(self, options, word):
        with pytest.raises(ModelError) as error:
            preloaded(column(2), Preload(**options))
        shown(error, word)

    def test_no_geometric_stiffness(self):
        bare = replace(column(2), stress_stiffness=None)
        with pytest.raises(ModelError) as error:
            preloaded(bare, Preload(held={"root": ("x", "y", "rz")}, thermal_strain=1e-3))
        shown(error, "no geometric stiffness")
