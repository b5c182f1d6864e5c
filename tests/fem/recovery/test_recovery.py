"""Stresses and strains against closed forms: patch test, bending, torsion, a spinning bar; gauges, envelopes, files."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from fem_meshes import KINDS, box
from kanefe_fem.recovery import scalars as measures
from kanefe_fem.recovery.gauges import find_point, rosette_principal
from kanefe_fem.recovery.recovery import recover
from kanefe_fem.recovery.strain_fields import StrainFields
from recovered_boxes import NU, SIZE, E, G, fields_of, isotropic, mesh_of, recovered, shape_of
from result_scenes import robot, turntable


def stretch(x: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    return (x @ gradient.T)[:, :, None]


def expected_strain(gradient: np.ndarray) -> np.ndarray:
    g = gradient
    return np.array([g[0, 0], g[1, 1], g[2, 2], g[1, 2] + g[2, 1], g[0, 2] + g[2, 0], g[0, 1] + g[1, 0]])


class TestPatch:
    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("order", [1, 2])
    @pytest.mark.parametrize("bent", [False, True])
    def test_a_linear_displacement_has_its_constant_strain_everywhere(self, kind, order, bent):
        mesh = mesh_of(kind, order, bent)
        gradient = 1e-3 * np.array([[1.0, 0.3, -0.2], [-0.7, 0.4, 0.9], [0.5, -0.6, 0.8]])
        if mesh.dimension == 2:
            gradient[2], gradient[:, 2] = 0.0, 0.0
        fields = fields_of(mesh, stretch(mesh.nodes, gradient))
        strain = expected_strain(gradient)
        for at in ("nodes", "cells", "gauss"):
            found = fields.evaluate("strain", at, np.ones((1, 1)))
            np.testing.assert_allclose(found, np.broadcast_to(strain, found.shape), atol=1e-15)  # round-off of 1e-3
            stress = fields.evaluate("stress", at, np.ones((1, 1)))
            expected = isotropic(mesh.dimension) @ strain
            np.testing.assert_allclose(stress, np.broadcast_to(expected, stress.shape), atol=1e-12 * E * 1e-3)

    @pytest.mark.parametrize("kind", KINDS)
    def test_a_rigid_rotation_has_no_strain(self, kind):
        mesh = mesh_of(kind, 2, True)
        spin = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
        fields = fields_of(mesh, stretch(mesh.nodes, spin))
        assert abs(fields.evaluate("strain", "nodes", np.ones((1, 1)))).max() < 1e-13


class TestClosedForms:
    @pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
    def test_pure_bending_has_the_stress_of_the_beam(self, kind):
        mesh, curvature = mesh_of(kind, 2), 0.02
        x, y, z = mesh.nodes.T
        u = curvature * np.stack([-x * y, 0.5 * (x**2 + NU * (y**2 - z**2)), NU * y * z], axis=1)[:, :, None]
        stress = fields_of(mesh, u).evaluate("stress", "nodes", np.ones((1, 1)))[0]
        expected = np.zeros_like(stress)
        expected[:, 0] = -E * curvature * y  # M y / I
        np.testing.assert_allclose(stress, expected, atol=1e-11 * E * curvature * SIZE[1])

    @pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
    def test_a_twisted_round_shaft_has_shear_by_the_radius(self, kind):
        mesh, twist = mesh_of(kind, 2), 0.01
        x, y, z = mesh.nodes.T
        u = twist * np.stack([0 * x, -x * z, x * y], axis=1)[:, :, None]
        fields = fields_of(mesh, u)
        stress = fields.evaluate("stress", "nodes", np.ones((1, 1)))[0]
        scale = 1e-11 * G * twist
        np.testing.assert_allclose(stress[:, 5], -G * twist * z, atol=scale)  # xy
        np.testing.assert_allclose(stress[:, 4], G * twist * y, atol=scale)  # xz
        np.testing.assert_allclose(measures.von_mises(stress), np.sqrt(3) * G * twist * np.hypot(y, z), atol=scale)

    def test_equivalent_and_principal_stresses(self):
        uniaxial, shear = np.array([7.0, 0, 0, 0, 0, 0]), np.array([0, 0, 0, 0, 0, 3.0])
        assert measures.von_mises(uniaxial) == pytest.approx(7.0)
        assert measures.von_mises(np.array([5.0, 5, 5, 0, 0, 0])) == 0.0
        assert measures.principal(shear) == pytest.approx([3.0, 0.0, -3.0])
        assert measures.tresca(shear) == pytest.approx(6.0)
        assert measures.principal_strains(shear) == pytest.approx([1.5, 0.0, -1.5])
        rng = np.random.default_rng(0)
        any_stress = rng.standard_normal((20, 6))
        p = measures.principal(any_stress)
        by_principal = np.sqrt(0.5 * ((p - np.roll(p, 1, axis=-1)) ** 2).sum(axis=-1))
        np.testing.assert_allclose(measures.von_mises(any_stress), by_principal, rtol=1e-12)


class TestGauges:
    def test_a_rosette_finds_the_principal_strains(self):
        mesh = mesh_of("tetra", 2)
        gradient = 1e-4 * np.array([[3.0, 2.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 0.5]])
        fields = recovered(fields_of(mesh, stretch(mesh.nodes, gradient)), np.array([[1.0], [2.0]]))
        place, normal = (0.13, 0.04, SIZE[2]), (0, 0, 1)
        along = fields.gauge(place, (2.0, 0, 0))
        np.testing.assert_allclose(along, [3e-4, 6e-4], rtol=1e-12)
        strains = fields.rosette(place, (1, 0, 0.3), normal)  # its part in the surface counts
        e = expected_strain(gradient)
        expected = np.linalg.eigvalsh(np.array([[e[0], e[5] / 2], [e[5] / 2, e[1]]]))[::-1]
        found = rosette_principal(strains)
        np.testing.assert_allclose(found[0, :2], expected, rtol=1e-10)
        np.testing.assert_allclose(found[1, :2], 2 * expected, rtol=1e-10)
        direction = np.array([np.cos(found[0, 2]), np.sin(found[0, 2]), 0.0])
        np.testing.assert_allclose(fields.gauge(place, direction)[0], expected[0], rtol=1e-10)

    def test_a_gauge_with_very_many_coordinates_needs_no_modes_of_all_nodes(self):
        mesh = mesh_of("hexahedron", 1)
        basis = np.eye(3 * len(mesh.nodes)).reshape(len(mesh.nodes), 3, -1)
        gradient = 1e-3 * np.diag([1.0, 2.0, 3.0])
        eta = (mesh.nodes @ gradient.T).reshape(1, -1)
        fields = fields_of(mesh, basis)
        fields._modes = None  # any use of the modes of the whole body fails
        found = recovered(fields, eta).gauge((0.1, 0.05, 0.0), (0, 1, 0))
        np.testing.assert_allclose(found, [2e-3], rtol=1e-12)

    def test_a_point_off_the_mesh_is_refused_and_one_just_off_it_is_moved(self):
        mesh = mesh_of("tetra", 1)
        wanted = np.ones(mesh.cell_count, dtype=bool)
        found = find_point(mesh.nodes, mesh.cell_blocks, wanted, np.array([0.1, 0.05, SIZE[2] + 1e-3]))
        np.testing.assert_allclose(found.position, [0.1, 0.05, SIZE[2]], atol=1e-3)
        np.testing.assert_allclose(found.weights @ mesh.nodes[found.nodes], found.position, atol=1e-15)
        with pytest.raises(kf.ModelError, match=r"outside of the mesh.*nearest point.*Remedy"):
            find_point(mesh.nodes, mesh.cell_blocks, wanted, np.array([0.1, 0.05, 0.3]))

    @pytest.mark.parametrize("kind", KINDS)
    def test_a_point_inside_bent_cells_is_found_exactly(self, kind):
        mesh = mesh_of(kind, 2, True)
        place = mesh.nodes[mesh.connectivity[4]].mean(axis=0)
        found = find_point(mesh.nodes, mesh.cell_blocks, np.ones(mesh.cell_count, dtype=bool), place)
        np.testing.assert_allclose(found.position, place, atol=1e-12)

    def test_gauges_without_sense_are_refused(self):
        fields = recovered(fields_of(mesh_of("tetra", 1), np.zeros((36, 3, 1))), np.ones((1, 1)))
        with pytest.raises(kf.ModelError, match="direction"):
            fields.gauge((0, 0, 0), (0, 0, 0))
        with pytest.raises(kf.ModelError, match="position"):
            fields.gauge((0, 0), (1, 0, 0))
        with pytest.raises(kf.ModelError, match="across the normal"):
            fields.rosette((0, 0, 0), (0, 0, 1), (0, 0, 2))
        with pytest.raises(kf.ModelError, match="three different directions"):
            rosette_principal(np.zeros((1, 3)), (0.0, 0.0, 1.0))


class TestMaterials:
    def two(self) -> StrainFields:
        """A bar stretched evenly, of a soft left half and a stiff right half."""
        mesh = box("hexahedron", (4, 1, 1), SIZE)
        of_cell = (mesh.nodes[mesh.connectivity].mean(axis=1)[:, 0] > SIZE[0] / 2).astype(int)
        u = stretch(mesh.nodes, np.diag([1e-3, 0.0, 0.0]))
        return fields_of(mesh, u, np.stack([isotropic(), 3 * isotropic()]), of_cell)

    def test_each_side_of_a_boundary_has_its_own_stress(self):
        fields = self.two()
        at_boundary = np.isclose(fields.nodes[:, 0], SIZE[0] / 2)
        soft = isotropic()[0, 0] * 1e-3
        left, right, mean = (
            recovered(fields, np.ones((1, 1)), m).stress_at_nodes()[0, :, 0] for m in ("left", 1, None)
        )
        np.testing.assert_allclose(left[at_boundary], soft)
        np.testing.assert_allclose(right[at_boundary], 3 * soft)
        np.testing.assert_allclose(mean[at_boundary], 2 * soft)
        assert np.isnan(left[fields.nodes[:, 0] > 0.6 * SIZE[0]]).all()

    def test_the_envelope_of_a_material_looks_at_its_cells_only(self):
        fields = self.two()
        eta = np.array([[1.0], [-4.0], [2.0]])
        for at in ("nodes", "cells"):
            envelope = recovered(fields, eta, "left").envelope("max_principal", at)
            assert envelope.peak == pytest.approx(2 * isotropic()[0, 0] * 1e-3)
            assert envelope.peak_time == 2.0
            assert envelope.peak_position[0] <= SIZE[0] / 2
            least = recovered(fields, eta, "right").envelope("min_principal", at)
            assert least.peak == pytest.approx(-4 * 3 * isotropic()[0, 0] * 1e-3)
            assert least.peak_time == 1.0

    def test_an_unknown_material_is_refused(self):
        with pytest.raises(kf.ModelError, match=r"'middle'.*left, right"):
            recovered(self.two(), np.ones((1, 1)), "middle")
        with pytest.raises(kf.ModelError, match="none of 0 to 1"):
            recovered(self.two(), np.ones((1, 1)), 2)


def test_modes_and_displacements_give_the_same_fields(monkeypatch):
    from kanefe_fem.recovery import strain_fields

    mesh, rng = mesh_of("tetra", 2, True), np.random.default_rng(1)
    u = rng.standard_normal((len(mesh.nodes), 3, 4))
    eta = rng.standard_normal((3, 4))
    by_modes = fields_of(mesh, u)
    monkeypatch.setattr(strain_fields, "CHUNK", 2000)  # several pieces
    by_displacement = fields_of(mesh, u)
    monkeypatch.setattr(strain_fields, "MOST_MODES", 0)
    for what in ("strain", "stress"):
        for at in ("nodes", "cells", "gauss"):
            monkeypatch.setattr(strain_fields, "MOST_MODES", 100)
            first = by_modes.evaluate(what, at, eta)
            monkeypatch.setattr(strain_fields, "MOST_MODES", 0)
            second = by_displacement.evaluate(what, at, eta)
            np.testing.assert_allclose(first, second, rtol=0, atol=1e-12 * abs(first).max())
    assert by_displacement._modes == {}


def test_stress_modes_are_made_once_for_a_body():
    mesh = mesh_of("tetra", 1)
    fields = fields_of(mesh, np.zeros((len(mesh.nodes), 3, 2)))
    assert fields.modes("stress", "nodes") is fields.modes("stress", "nodes")
    shape = shape_of(fields)
    assert StrainFields.of_body("b", shape) is StrainFields.of_body("b", shape)


class TestBadInput:
    def test_times_and_frames(self):
        result = robot()
        assert recover(result, "arm", times=[0.1, 0.204]).times == pytest.approx([0.1, 0.2])
        assert recover(result, "arm", frames=-1).times == pytest.approx([0.4])
        with pytest.raises(kf.ModelError, match=r"0.5 s was not stored.*0 to 0.4 s"):
            recover(result, "arm", times=[0.5])
        with pytest.raises(kf.ModelError, match="not both"):
            recover(result, "arm", times=[0.1], frames=[1])

    def test_bodies_without_stresses(self):
        with pytest.raises(kf.ModelError, match="rigid"):
            recover(turntable(), "table")
        with pytest.raises(kf.ModelError, match=r"beams.*section_forces"):
            recover(robot(), "arm").stress_at_nodes()

    def test_quantities_and_places(self):
        fields = recovered(fields_of(mesh_of("tetra", 1), np.zeros((36, 3, 1))), np.ones((1, 1)))
        with pytest.raises(kf.ModelError, match=r"no envelope of 'mises'.*von_mises"):
            fields.envelope("mises")
        with pytest.raises(kf.ModelError, match="'nodes' or 'cells'"):
            fields.envelope(at="gauss")
        with pytest.raises(kf.ModelError, match="centroid"):
            fields.stress_at_cells("middle")

    def test_too_large_a_table_is_refused_by_its_size(self, monkeypatch):
        from kanefe_fem.recovery import fields_at_times

        monkeypatch.setattr(fields_at_times, "LARGEST_TABLE", 1000)
        fields = recovered(fields_of(mesh_of("tetra", 1), np.zeros((36, 3, 1))), np.ones((1, 1)))
        with pytest.raises(kf.ModelError, match=r"GiB.*times="):
            fields.stress_at_nodes()
