"""Materials on meshes: what the assembled matrices do, against closed forms; energies of the user's; bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg

from fem_meshes import STEEL, box, shown
from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.moduli import isotropic
from kanefe.storage.digest import digest
from kanefe_fem import _fenicsx
from kanefe_fem.materials import voigt
from kanefe_fem.materials.isotropic import AccuracyWarning, Material
from kanefe_fem.materials.laminate import Laminate, Ply
from kanefe_fem.materials.oriented import Oriented, axes_at_angle, cylindrical_axes, spherical_axes
from kanefe_fem.materials.orthotropic import Anisotropic, Orthotropic
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.solids.model import solid_model

SIZE = (0.3, 0.2, 0.1)
CARBON = Orthotropic.transversely_isotropic(E1=140e9, E2=9e9, nu12=0.3, nu23=0.4, G12=5e9, rho=1600.0, name="carbon")


def strained(model, strain):
    """Displacements of a uniform strain (6,) in engineering components, shape (N,)."""
    e = np.zeros((3, 3))
    for value, (a, b) in zip(strain, voigt.PLACES, strict=True):
        e[a, b] = e[b, a] = value if a == b else value / 2
    return (model.nodes @ e)[:, : len(model.components)].ravel()


def crystal(seed=3):
    L = np.random.default_rng(seed).standard_normal((6, 6))
    return Anisotropic(1e9 * (L @ L.T + np.eye(6)), rho=2000.0, name="crystal")


@pytest.mark.fenicsx
class TestAssembly:
    @pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
    @pytest.mark.parametrize("order", [1, 2])
    def test_energy_of_uniform_strains(self, kind, order):
        A = axes_at_angle(0.3, axis=(1, 2, 3))
        model = solid_model(box(kind, (2, 2, 1), SIZE), Oriented(crystal(), A), order=order)
        C = voigt.rotated(crystal().stiffness, A)
        U = np.stack([strained(model, e) for e in np.eye(6)], axis=1)
        # the field is in the space and the integrand constant: exact but for round-off
        np.testing.assert_allclose(U.T @ (model.stiffness @ U), C * np.prod(SIZE), rtol=0, atol=1e-11 * C.max())
        assert model.mass_field.mass.sum() == pytest.approx(2000 * np.prod(SIZE), rel=1e-13)

    def test_isotropic_by_either_form(self):
        mesh = box("tetra", (2, 1, 1), SIZE)
        by_lame, by_matrix = solid_model(mesh, STEEL), solid_model(mesh, Anisotropic(STEEL.stiffness, rho=STEEL.rho))
        difference = sp.linalg.norm(by_lame.stiffness - by_matrix.stiffness)
        assert difference < 1e-14 * sp.linalg.norm(by_lame.stiffness) * 10

    @pytest.mark.parametrize("plane", ["stress", "strain"])
    def test_plane_bodies(self, plane):
        mesh, thickness = box("triangle", (2, 2), SIZE[:2]), 0.01
        material = Oriented(CARBON, axes_at_angle(np.radians(30)))
        model = solid_model(mesh, material, plane=plane, thickness=thickness)
        C = voigt.rotated(CARBON.stiffness, axes_at_angle(np.radians(30)))
        Q = voigt.plane_stress(C) if plane == "stress" else voigt.plane_strain(C)
        U = np.stack([strained(model, np.eye(6)[i]) for i in voigt.IN_PLANE], axis=1)
        area = SIZE[0] * SIZE[1]
        np.testing.assert_allclose(U.T @ (model.stiffness @ U), Q * area * thickness, rtol=0, atol=1e-11 * Q.max())
        kept = model.elasticity.table[0]
        np.testing.assert_allclose(kept[np.ix_(voigt.IN_PLANE, voigt.IN_PLANE)], Q, rtol=1e-13, atol=1.0)
        if plane == "stress":
            assert not kept[2:5].any()
        else:  # the stress across the plane can be told
            np.testing.assert_allclose(kept[2], C[2])

    def test_each_cell_has_the_axes_of_its_place(self):
        # dolfinx numbers the cells anew; two groups, shuffled, one of them with axes that follow the position
        mesh = box("hexahedron", (6, 2, 2), SIZE)
        cells = np.random.default_rng(7).permutation(mesh.connectivity)
        left = mesh.nodes[cells].mean(axis=1)[:, 0] < 0.15
        two = replace(
            mesh,
            cells={"b": (Cells("hexahedron", cells[~left]),), "a": (Cells("hexahedron", cells[left]),)},
        )
        axes = cylindrical_axes(origin=(-0.1, -0.1, 0))
        model = solid_model(two, {"a": Oriented(CARBON, axes), "b": STEEL}, order=1)
        volume = np.prod(SIZE) / 24
        expected = volume * (
            sum(voigt.rotated(CARBON.stiffness, axes(x[None])[0]) for x in mesh.nodes[cells[left]].mean(axis=1))
            + np.count_nonzero(~left) * STEEL.stiffness
        )
        U = np.stack([strained(model, e) for e in np.eye(6)], axis=1)
        np.testing.assert_allclose(U.T @ (model.stiffness @ U), expected, rtol=0, atol=1e-11 * expected.max())
        # and locally: bending in x weighs the cells by their place
        shear = np.zeros((len(model.nodes), 3))
        shear[:, 1] = model.nodes[:, 0]
        inside = model.nodes[:, 0] <= 0.15 + 1e-12
        only_left = np.where(inside[:, None], shear, [0, 0.15, 0]).ravel()
        local = volume * sum(
            voigt.rotated(CARBON.stiffness, axes(x[None])[0])[5, 5] for x in mesh.nodes[cells[left]].mean(axis=1)
        )
        assert only_left @ (model.stiffness @ only_left) == pytest.approx(local, rel=1e-11)

    def test_elasticity_tells_the_moduli_of_each_cell(self):
        mesh = box("tetra", (2, 1, 1), SIZE)
        half = {"a": (Cells("tetra", mesh.connectivity[:5]),), "b": (Cells("tetra", mesh.connectivity[5:]),)}
        axes = spherical_axes(origin=(-1, 0.01, 0.02))
        model = solid_model(replace(mesh, cells=half), {"a": STEEL, "b": Oriented(CARBON, axes)})
        centres = np.concatenate([model.nodes[b.nodes[:, :4]].mean(axis=1) for b in model.cells])
        of = model.elasticity.table[model.elasticity.of_cell]
        assert len(model.elasticity.table) == 1 + len(mesh.connectivity) - 5
        np.testing.assert_allclose(of[:5], np.broadcast_to(STEEL.stiffness, (5, 6, 6)), rtol=1e-12)
        np.testing.assert_allclose(of[5:], voigt.rotated(CARBON.stiffness, axes(centres[5:])), rtol=1e-9, atol=10.0)

    def test_a_ring_with_fibres_around_breathes_at_its_hoop_frequency(self):
        # thin ring, plane stress: w^2 = E1 / (rho R^2); axes constant on each cell err with the angle squared
        R, t, n = 1.0, 0.02, 48
        phi = np.linspace(0, 2 * np.pi, n, endpoint=False)
        ring = np.column_stack([np.cos(phi), np.sin(phi), np.zeros(n)])
        nodes = np.concatenate([(R - t / 2) * ring, (R + t / 2) * ring])
        i, j = np.arange(n), (np.arange(n) + 1) % n
        mesh = Mesh(nodes, 2, {"ring": (Cells("quad", np.column_stack([i, i + n, j + n, j])),)})
        around = Oriented(CARBON, cylindrical_axes(first="around"))
        model = solid_model(mesh, around, plane="stress", thickness=0.01)
        u = (model.nodes[:, :2] / np.linalg.norm(model.nodes[:, :2], axis=1)[:, None]).ravel()
        square = (u @ (model.stiffness @ u)) / (u @ (model.mass @ u))
        assert square == pytest.approx(140e9 / (1600 * R**2), rel=0.01)
        across = solid_model(mesh, Oriented(CARBON, cylindrical_axes(first="outward")), plane="stress", thickness=0.01)
        assert (u @ (across.stiffness @ u)) / (u @ (across.mass @ u)) < 0.1 * square

    def test_a_laminate_stretches_as_its_plies_do(self):
        # four layers of cells, one for each ply, against one material: the same mean stress of the same stretch
        angles = np.radians([30.0, -30.0, -30.0, 30.0])
        plies = [Ply(CARBON, SIZE[2] / 4, a) for a in angles]
        mesh = box("hexahedron", (2, 2, 4), SIZE)
        layer = np.minimum(mesh.nodes[mesh.connectivity].mean(axis=1)[:, 2] // (SIZE[2] / 4), 3).astype(int)
        layers = {f"ply{i}": (Cells("hexahedron", mesh.connectivity[layer == i]),) for i in range(4)}
        one_by_one = solid_model(
            replace(mesh, cells=layers),
            {f"ply{i}": Oriented(CARBON, axes_at_angle(a)) for i, a in enumerate(angles)},
        )
        smeared = solid_model(mesh, Laminate(plies))
        energies = []
        for model in (one_by_one, smeared):
            u = strained(model, [1e-3, -4e-4, 0, 0, 0, 0]).reshape(-1, 3)
            inner = np.ones((len(model.nodes), 3), dtype=bool)
            # strains in the plane are given, the faces above and below are free
            inner[:, :2] = False
            inner[0, 2] = False
            free, held = np.flatnonzero(inner), np.flatnonzero(~inner)
            K, u = model.stiffness, u.ravel()
            u[free] = scipy.sparse.linalg.spsolve(K[free][:, free].tocsc(), -K[free][:, held] @ u[held])
            energies.append(u @ (K @ u))
        assert energies[0] == pytest.approx(energies[1], rel=1e-10)

    def test_density_of_a_group(self):
        mesh = box("tetra", (2, 1, 1), SIZE)
        half = {"a": (Cells("tetra", mesh.connectivity[:6]),), "b": (Cells("tetra", mesh.connectivity[6:]),)}
        model = solid_model(replace(mesh, cells=half), {"a": STEEL, "b": STEEL}, densities={"b": 1000.0})
        assert model.mass_field.mass.sum() == pytest.approx((7850 + 1000) * np.prod(SIZE) / 2, rel=1e-13)
        plain = solid_model(replace(mesh, cells=half), {"a": STEEL, "b": STEEL})
        assert abs(model.stiffness - plain.stiffness).max() == 0.0

    def test_all_anisotropic_materials_share_one_kernel(self):
        cache = _fenicsx.load().cache
        mesh = box("tetra", (2, 1, 1), SIZE)
        solid_model(mesh, crystal())
        before = {path.name for path in cache.iterdir()}
        solid_model(mesh, CARBON)
        solid_model(mesh, Oriented(CARBON, cylindrical_axes(origin=(-1, -1, -1))))
        solid_model(mesh, Laminate([Ply(CARBON, 1e-3), Ply(STEEL, 2e-3, 0.3)]))
        assert {path.name for path in cache.iterdir()} == before

    def test_provenance_is_json_able(self):
        import json

        axes = Oriented(Laminate([Ply(CARBON, 1e-3, 0.1)]), cylindrical_axes(origin=(-1, -1, -1)))
        model = solid_model(box("tetra", (1, 1, 1), SIZE), axes)
        kept = json.loads(json.dumps(model.provenance))["materials"]["bar"]
        assert kept["material"]["plies"][0]["angle_rad"] == 0.1
        assert kept["axes"]["kind"] == "cylindrical"


@pytest.mark.fenicsx
class TestUserEnergy:
    def test_strain_energy(self):
        import ufl

        from kanefe_fem.materials.user_energy import UserEnergy

        lame, mu = STEEL.lame, STEEL.shear_modulus
        hooke = UserEnergy(lambda e: lame / 2 * ufl.tr(e) ** 2 + mu * ufl.inner(e, e), rho=7850.0)
        np.testing.assert_allclose(hooke.stiffness, STEEL.stiffness, rtol=1e-14, atol=1e-4)

    def test_fibres_in_rubber(self):
        import ufl

        from kanefe_fem.materials.user_energy import UserEnergy

        mu, kappa, k = 0.5e6, 10e6, 3e6

        def W(F):
            C = F.T * F
            J = ufl.det(F)
            a = ufl.as_vector([1.0, 0.0, 0.0])
            I4 = ufl.inner(a, C * a)
            return mu / 2 * (ufl.tr(C) - 3 - 2 * ufl.ln(J)) + kappa / 2 * (J - 1) ** 2 + k / 8 * (I4 - 1) ** 2

        rubber = UserEnergy(W, rho=1100.0, of="deformation gradient", name="rubber")
        # neo-Hookean at rest: lambda = kappa, mu; the fibres add k to C_11: (I4 - 1) = 2 e_11 + ...
        expected = isotropic(kappa, mu)
        expected[0, 0] += k
        np.testing.assert_allclose(rubber.stiffness, expected, rtol=0, atol=1e-9 * kappa)

    def test_the_tangent_is_that_of_finite_differences(self):
        import ufl

        from kanefe_fem.materials.user_energy import UserEnergy

        def fung(e):
            Q = 4 * e[0, 0] ** 2 + 2 * e[1, 1] ** 2 + e[2, 2] ** 2 + 3 * e[0, 1] * e[1, 0] + e[0, 2] ** 2 + e[1, 2] ** 2
            Q += 0.5 * e[0, 0] * e[1, 1] + 0.7 * e[0, 0] * e[0, 1]
            return 1e4 * (ufl.exp(Q) - 1)

        found = UserEnergy(fung, rho=1000.0).stiffness
        h = 1e-3

        def energy(six):
            e = np.zeros((3, 3))
            for value, (a, b) in zip(six, voigt.PLACES, strict=True):
                e[a, b] = e[b, a] = value if a == b else value / 2
            Q = 4 * e[0, 0] ** 2 + 2 * e[1, 1] ** 2 + e[2, 2] ** 2 + 3 * e[0, 1] * e[1, 0] + e[0, 2] ** 2 + e[1, 2] ** 2
            Q += 0.5 * e[0, 0] * e[1, 1] + 0.7 * e[0, 0] * e[0, 1]
            return 1e4 * (np.exp(Q) - 1)

        unit = np.eye(6) * h
        numeric = [
            [(energy(a + b) - energy(a - b) - energy(b - a) + energy(-a - b)) / (4 * h**2) for a in unit] for b in unit
        ]
        # error of the differences: h^2 times fourth derivatives, some 10 times the modulus
        np.testing.assert_allclose(found, numeric, rtol=0, atol=1e-4 * found.max())

    def test_a_body_of_it(self):
        import ufl

        from kanefe_fem.materials.user_energy import UserEnergy

        mesh = box("tetra", (2, 1, 1), SIZE)
        lame, mu = STEEL.lame, STEEL.shear_modulus
        hooke = UserEnergy(lambda e: lame / 2 * ufl.tr(e) ** 2 + mu * ufl.inner(e, e), rho=7850.0)
        by_energy, plain = solid_model(mesh, hooke), solid_model(mesh, STEEL)
        assert abs(by_energy.stiffness - plain.stiffness).max() < 1e-13 * abs(plain.stiffness).max()

    def test_bad_energies(self):
        import ufl

        from kanefe_fem.materials.user_energy import UserEnergy

        gradient = "deformation gradient"
        for energy, of, words in (
            (lambda e: e, "strain", ("scalar", "(3, 3)")),
            (lambda e: ufl.sqrt(ufl.inner(e, e)), "strain", ("derivatives at rest",)),
            (lambda e: ufl.tr(e) + ufl.inner(e, e), "strain", ("stress 1 Pa", "rest")),
            (lambda e: ufl.tr(e) ** 2, "strain", ("not positive definite",)),
            (lambda e: "soft", "strain", ("not a UFL expression",)),
            (lambda F: ufl.tr(F.T * F), gradient, ("at rest", "ln J")),
            (lambda F: ufl.inner(F - ufl.Identity(3), F - ufl.Identity(3)), gradient, ("rotation",)),
            (lambda e: ufl.inner(e, e), "stress", ("of='stress'",)),
            (3.0, "strain", ("energy=3.0",)),
        ):
            with pytest.raises(ModelError) as error:
                UserEnergy(energy, 1000.0, of, "goo")
            shown(error, "goo", *words)

    def test_the_key_of_the_cache_is_its_tangent(self):
        import ufl

        from kanefe_fem.materials.user_energy import UserEnergy

        keys = [digest(m=UserEnergy(lambda e, k=k: k * ufl.inner(e, e), 1000.0)) for k in (1.0, 1.0, 2.0)]
        assert keys[0] == keys[1] != keys[2]


@pytest.mark.fenicsx
@pytest.mark.usefixtures("no_assembly")
class TestBadInput:
    def test_materials(self):
        mesh = box("tetra", (1, 1, 1), SIZE)
        for materials, options, word in (
            ("steel", {}, "is 'steel'"),
            ({"bar": 7}, {}, "is 7"),
            ({"beam": STEEL, "bar": STEEL}, {}, "'beam'"),
            (STEEL, {"densities": {"beam": 1.0}}, "'beam'"),
            (STEEL, {"densities": {"bar": -1.0}}, "rho = -1"),
            (Oriented(CARBON, np.tile(np.eye(3), (2, 1, 1))), {}, "2 axes are given for 6 cells"),
        ):
            with pytest.raises(ModelError) as error:
                solid_model(mesh, materials, **options)
            shown(error, word)

    @pytest.mark.parametrize(
        ("material", "order", "word"),
        [
            (Material(2e6, 0.46, 1100.0), 1, "nu = 0.46.*locking"),
            (Anisotropic(Material(2e6, 0.46, 1100.0).stiffness, 1100.0), 1, "average Poisson ratio = 0.46.*locking"),
            (Material(2e6, 0.4999, 1100.0), 2, "nearly incompressible"),
        ],
    )
    def test_nearly_incompressible(self, material, order, word):
        with pytest.warns(AccuracyWarning, match=word), pytest.raises(pytest.fail.Exception):
            solid_model(box("tetra", (1, 1, 1), SIZE), material, order=order)

    def test_what_is_not_warned_of(self, recwarn):
        for material, order in ((CARBON, 1), (Material(2e6, 0.49, 1100.0), 2)):
            with pytest.raises(pytest.fail.Exception):
                solid_model(box("tetra", (1, 1, 1), SIZE), material, order=order)
        # nothing resists the change of volume of a sheet
        with pytest.raises(pytest.fail.Exception):
            solid_model(box("quad", (1, 1), SIZE[:2]), Material(2e6, 0.49, 1100.0), 1, "stress", 0.01)
        assert not recwarn.list
