"""Surfaces that carry loads: integrals over facets against closed forms, and what is refused before assembly."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

import kanefe as kf
from fem_meshes import KINDS, STEEL, box, deformed, shown
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.model import Cells
from kanefe.fe_model.pressure_change import PressureChange
from kanefe.fe_model.shapes import measures
from kanefe.frames import skew
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.checks import check_mesh
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.surfaces import loaded_face
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.model import solid_model

SIZE = (0.3, 0.1, 0.08)
THICKNESS = 0.02
SIDES = {
    "tetra": ("triangle", [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]),
    "hexahedron": (
        "quad",
        [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)],
    ),
    "triangle": ("line", [(0, 1), (1, 2), (2, 0)]),
    "quad": ("line", [(0, 1), (1, 2), (2, 3), (3, 0)]),
}


def bent(x):
    y = x.copy()
    y[:, 0] += 0.9 * x[:, 0] ** 2
    y[:, 1] += 0.6 * x[:, 0] ** 2 + 1.5 * x[:, 0] * x[:, 1]
    y[:, 2] += 0.8 * x[:, 0] * x[:, 2]
    # and shake the nodes, or errors on opposite sides cancel
    shaken = np.random.default_rng(1).uniform(-0.002, 0.002, x.shape)
    return y + np.where(np.ptp(x, axis=0) > 0.0, shaken, 0.0)


def skinned(kind, divisions=(3, 2, 2)):
    """Return a box with the groups "skin" (all outer facets), "top" (y = b) and "inside"; facets turn either way."""
    mesh = box(kind, divisions, SIZE)
    facet, sides = SIDES[kind]
    all_sides = np.concatenate([mesh.connectivity[:, list(side)] for side in sides])
    _, first, counts = np.unique(np.sort(all_sides, axis=1), axis=0, return_index=True, return_counts=True)
    outer, inner = all_sides[first[counts == 1]], all_sides[first[counts == 2]]
    turned = np.random.default_rng(0).random(len(outer)) < 0.5
    outer[turned] = outer[turned][:, ::-1]
    top = outer[(abs(mesh.nodes[outer][:, :, 1] - SIZE[1]) < 1e-12).all(axis=1)]
    groups = {"skin": outer, "top": top, "inside": inner}
    facets = {**mesh.facets, **{name: (Cells(facet, nodes),) for name, nodes in groups.items()}}
    return check_mesh(replace(mesh, facets=facets))


def options(mesh):
    return {"plane": "stress", "thickness": THICKNESS} if mesh.dimension == 2 else {}


def depth(mesh):
    return SIZE[2] if mesh.dimension == 3 else THICKNESS


class Integrals(NamedTuple):
    """Integrals over a face: int N_i dA (n,), -int N_i n dA (n, 3), and the change of these."""

    shares: np.ndarray
    pressure: np.ndarray
    change: PressureChange


def integrals(mesh, name, thickness=1.0):
    pattern = NodalPattern.of_face(loaded_face(mesh, name, thickness))
    pressure = np.zeros((len(mesh.nodes), 3))
    pressure[:, : mesh.dimension] = pattern.pressure.reshape(-1, mesh.dimension)
    return Integrals(pattern.traction[:: mesh.dimension, 0], pressure, pattern.pressure_change)


class TestIntegrals:
    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("geometry_order", [1, 2])
    @pytest.mark.parametrize("order", [1, 2])
    def test_a_closed_surface_has_no_resultant_and_encloses_the_volume(self, kind, geometry_order, order):
        mesh = deformed(skinned(kind).with_order(geometry_order), bent).with_order(order)
        found = integrals(mesh, "skin")
        area = found.shares.sum()
        moment = np.cross(mesh.nodes, found.pressure).sum(axis=0)
        volume = sum(float(measures(b.kind, mesh.nodes[b.nodes], degree=12)[0].sum()) for b in mesh.cell_blocks)
        # the integrands are polynomials of a degree that the quadrature integrates exactly: only round-off is left
        assert abs(found.pressure.sum(axis=0)).max() < 1e-14 * area
        assert abs(moment).max() < 1e-14 * area
        # Gauss: the integral of X . n is d times the volume; its sign says that n points outward
        enclosed = -np.sum(mesh.nodes[:, : mesh.dimension] * found.pressure[:, : mesh.dimension])
        assert enclosed == pytest.approx(mesh.dimension * volume, rel=1e-12)

    @pytest.mark.parametrize("kind", KINDS)
    def test_forces_of_a_pressure_change_as_those_on_the_deformed_surface_do(self, kind):
        """They are polynomials of second degree in the displacements, so that central differences are exact."""
        mesh = deformed(skinned(kind), bent).with_order(2)
        d = mesh.dimension
        along = np.zeros_like(mesh.nodes)
        along[:, :d] = np.random.default_rng(2).standard_normal((len(along), d))

        def forces(h):
            moved = deformed(mesh, lambda x: x + h * along)
            pressure = integrals(moved, "top").pressure
            moment = np.cross(moved.nodes, pressure).sum(axis=0)
            return np.concatenate((pressure.sum(axis=0), moment, pressure[:, :d].ravel()))

        step = 1e-3 * min(SIZE)
        rate = (forces(step) - forces(-step)) / (2.0 * step)
        if d == 3:  # the moment is of third degree
            rate = (4.0 * rate - (forces(2.0 * step) - forces(-2.0 * step)) / (4.0 * step)) / 3.0
        found = integrals(mesh, "top").change.over(np.eye(along[:, :d].size)) @ along[:, :d].ravel()
        np.testing.assert_allclose(found, rate, rtol=0, atol=1e-10 * abs(rate).max())

    @pytest.mark.parametrize("kind", KINDS)
    def test_shares_integrate_what_the_elements_interpolate(self, kind):
        mesh = skinned(kind).with_order(2)
        shares = integrals(mesh, "top", 1.0).shares
        x = mesh.nodes
        a, c = SIZE[0], (SIZE[2] if mesh.dimension == 3 else 1.0)
        assert shares.sum() == pytest.approx(a * c, rel=1e-13)
        assert shares @ x[:, 0] ** 2 == pytest.approx(c * a**3 / 3, rel=1e-13)
        if mesh.dimension == 3:
            assert shares @ (x[:, 0] * x[:, 2]) == pytest.approx((a * c) ** 2 / 4, rel=1e-13)

    @pytest.mark.parametrize("order", [1, 2])
    def test_a_round_surface_has_the_area_and_force_of_the_round_one(self, order):
        # a quarter of a tube bent from a box: inside radius 0.2; the error of quadratic arcs falls with h^4
        def roll(x):
            radius, angle = 0.2 + x[:, 1], np.pi / 2 * (1 - x[:, 0] / SIZE[0])
            return np.column_stack((radius * np.cos(angle), radius * np.sin(angle), x[:, 2]))

        mesh = skinned("hexahedron", (6, 1, 1)).with_order(order)
        top = integrals(deformed(mesh, roll), "top")
        R, c = 0.2 + SIZE[1], SIZE[2]
        rtol = 2e-2 if order == 1 else 2e-5
        assert top.shares.sum() == pytest.approx(np.pi / 2 * R * c, rel=rtol)
        # the resultant of a pressure is that of the plane through the edge: exact whatever the mesh
        np.testing.assert_allclose(top.pressure.sum(axis=0), [-R * c, -R * c, 0], rtol=1e-12, atol=1e-15)


@pytest.mark.fenicsx
class TestModel:
    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("order", [1, 2])
    def test_the_forces_do_the_work_of_their_resultants_on_rigid_motions(self, kind, order):
        mesh = skinned(kind)
        model = solid_model(mesh, STEEL, order=order, surfaces=["top", "skin"], **options(mesh))
        top = model.load_patterns["top"]
        area = SIZE[0] * depth(mesh)
        centre = np.array([SIZE[0] / 2, SIZE[1], SIZE[2] / 2 if mesh.dimension == 3 else 0.0])
        assert top.measure == pytest.approx(area, rel=1e-13)
        np.testing.assert_allclose(top.first, area * centre, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(top.pressure_force, [0, -area, 0], rtol=1e-13, atol=1e-15)
        np.testing.assert_allclose(top.pressure_moment, np.cross(centre, [0, -area, 0]), rtol=1e-12, atol=1e-15)
        d = mesh.dimension
        rows = list(range(6)) if d == 3 else [0, 1, 5]
        expected = np.vstack((top.measure * np.eye(3), skew(top.first)))[rows, :d]
        work = model.rigid_modes().T
        np.testing.assert_allclose((work @ top.traction)[rows, :d], expected, rtol=0, atol=1e-14)
        resultant = np.concatenate((top.pressure_force, top.pressure_moment))
        np.testing.assert_allclose((work @ top.pressure)[rows], resultant[rows], rtol=0, atol=1e-14)

    def test_a_uniform_pressure_squeezes_a_body_as_hooke_says(self):
        # all round pressure p: strain -p (1 - 2 nu) / E in every direction, which the elements hold exactly
        mesh = skinned("tetra")
        model = solid_model(mesh, STEEL, surfaces=["skin"])
        strain = (1 - 2 * STEEL.nu) / STEEL.E
        displacement = -strain * model.nodes.reshape(-1)
        forces = model.load_patterns["skin"].pressure
        residual = model.stiffness @ displacement - forces
        assert abs(residual).max() < 1e-12 * abs(forces).max()

    @pytest.mark.parametrize("loading", ["traction", "pressure"])
    def test_a_cantilever_under_a_load_on_its_top_bends_as_a_beam(self, loading):
        # nu = 0 leaves the clamped end free to be a beam's; 12 x 2 x 2 quadratic hexahedra
        mesh = skinned("hexahedron", (12, 2, 2))
        length, height, width = SIZE
        steel = Material(E=210e9, nu=0.0, rho=7850.0)
        body = solid_body(
            mesh, steel, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=40), surfaces=["top"]
        )
        pattern = body.load_pattern("top")
        p, k = 1e5, body.free_count
        if loading == "traction":
            _, _, elastic = pattern.of_traction(np.array([0.0, -p, 0.0]), np.zeros(k))
        else:
            _, _, elastic = pattern.of_pressure(p, np.zeros(k))
        eta = np.linalg.solve(body.stiffness[:k, :k], elastic)
        w, EI, GA = p * width, steel.E * width * height**3 / 12, steel.E / 2 * width * height * 5 / 6
        expected = w * length**4 / (8 * EI) + w * length**2 / (2 * GA)
        deflection = -(body.interface("tip").motion[:, :k] @ eta)[1]
        # 0.5 %: the rigid end patches (RBE2) shorten the free span a little, and the root is held against warping
        assert deflection == pytest.approx(expected, rel=5e-3)


class TestBadInput:
    @pytest.mark.parametrize(
        ("surfaces", "error", "words"),
        [
            (["lid"], ModelError, ["no group of facets called 'lid'", "inside, off, root, skin, tip, top"]),
            (["bar"], ModelError, ["'bar' is a group of cells"]),
            ([""], ModelError, ["no group of facets called ''"]),
            ("top", ModelError, ["not a list of names", "'top'"]),
            ([3], ModelError, ["not a list of names"]),
            (["inside"], MeshError, ["'inside'", "inside the body"]),
            (["empty"], MeshError, ["the group 'empty' has no facets"]),
            (["twice"], MeshError, ["'twice'", "twice in it"]),
            (["off"], MeshError, ["'off'", "not on the body"]),
            (["diagonal"], MeshError, ["'diagonal'", "not a side of a cell"]),
        ],
    )
    @pytest.mark.usefixtures("no_assembly")
    def test_a_surface_that_cannot_carry_a_load_is_refused_before_assembly(self, surfaces, error, words):
        mesh = skinned("hexahedron")
        top = mesh.facets["top"][0].nodes
        cell = mesh.connectivity[0]
        extra = {
            "empty": np.zeros((0, 4), dtype=int),
            "twice": np.vstack((top, top[:1, ::-1])),
            "off": np.array([[0, 5, 17, 30]]),
            "diagonal": cell[[0, 1, 6, 7]][None],
        }
        facets = {**mesh.facets, **{name: (Cells("quad", nodes),) for name, nodes in extra.items()}}
        with pytest.raises(error) as refusal:
            solid_body(replace(mesh, facets=facets), STEEL, {"root": "clamped"}, surfaces=surfaces)
        shown(refusal, *words)

    def test_facets_may_come_in_several_blocks(self):
        mesh = skinned("hexahedron")
        top = mesh.facets["top"][0].nodes
        split = Mesh(mesh.nodes, 3, mesh.cells, {"top": (Cells("quad", top[:2]), Cells("quad", top[2:]))})
        whole, parts = integrals(mesh, "top"), integrals(split, "top")
        np.testing.assert_allclose(parts.pressure, whole.pressure, rtol=0, atol=1e-18)
