"""Forms of the user: those of the materials again, closed forms, and forms that no body has."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.materials.orthotropic import Orthotropic
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.simple import box_mesh, rectangle_mesh
from kanefe_fem.recovery.recovery import recover
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.model import solid_model
from kanefe_fem.solids.own_forms import Forms
from kanefe_fem.solids.potential_flow import PotentialFlow

pytestmark = pytest.mark.fenicsx

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SIZE = (1.0, 0.2, 0.1)
BOX, TETRA = (box_mesh(SIZE, (4, 1, 1), kind) for kind in ("hexahedron", "tetra"))
NEAR_ROUND_OFF = 1e-12
"""Of sums of a hundred products of an element, relative to the largest entry."""

GRADIENT = 1e-3 * np.array([[1.0, 0.3, -0.2], [0.5, -0.7, 0.1], [0.4, 0.6, 0.8]])


def hooke(f, u):
    lame, shear = STEEL.lame, STEEL.shear_modulus
    return lame * f.ufl.tr(f.strain(u)) * f.ufl.Identity(3) + 2.0 * shear * f.strain(u)


def own(order=2, mesh=BOX, material=STEEL, **forms):
    return solid_model(mesh, material, order, forms=Forms(**forms))


def differ(A, B):
    return abs(A - B).max() / abs(B).max()


class TestOfMaterials:
    def test_the_forms_of_the_materials_give_their_matrices(self):
        model, found = solid_model(BOX, STEEL), own(stiffness=lambda f: f.stiffness, mass=lambda f: f.mass)
        assert differ(found.stiffness, model.stiffness) < NEAR_ROUND_OFF
        assert differ(found.mass, model.mass) < NEAR_ROUND_OFF
        assert differ(found.mass_field.mass, model.mass_field.mass) < NEAR_ROUND_OFF

    def test_hookes_stress_gives_stiffness_stiffening_and_stresses(self):
        model, found = solid_model(BOX, STEEL), own(stress=hooke)
        assert differ(found.stiffness, model.stiffness) < NEAR_ROUND_OFF
        w = (model.nodes @ GRADIENT).ravel()  # of uniform stress, whose integrals are exact by any rule
        assert differ(found.stress_stiffness(w), model.stress_stiffness(w)) < NEAR_ROUND_OFF
        moduli = found.elasticity.table[found.elasticity.of_cell]
        np.testing.assert_allclose(moduli, model.elasticity.table[model.elasticity.of_cell], rtol=1e-12, atol=1.0)

    def test_a_form_is_orthotropic_wood(self):
        wood = Orthotropic(
            E1=11e9, E2=0.9e9, E3=0.5e9, nu12=0.4, nu13=0.4, nu23=0.4, G12=0.7e9, G13=0.6e9, G23=0.05e9, rho=450.0
        )
        C = np.asarray(wood.stiffness)

        def stress(f, u):
            e = f.strain(u)
            strains = [e[0, 0], e[1, 1], e[2, 2], 2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]]
            s = [sum(float(C[i, j]) * strains[j] for j in range(6)) for i in range(6)]
            return f.ufl.as_matrix([[s[0], s[5], s[4]], [s[5], s[1], s[3]], [s[4], s[3], s[2]]])

        assert differ(own(stress=stress).stiffness, solid_model(BOX, wood).stiffness) < NEAR_ROUND_OFF

    def test_a_plane_body_has_the_thickness_in_its_forms(self):
        mesh, more = rectangle_mesh(1.0, 0.2, 4), {"plane": "stress", "thickness": 0.03}
        forms = Forms(
            stress=lambda f, u: STEEL.E * f.strain(u),
            mass=lambda f: STEEL.rho * f.thickness * f.p * f.q * f.dx,
        )
        found = solid_model(mesh, STEEL, forms=forms, **more)
        straight = solid_model(mesh, Material(E=STEEL.E, nu=0.0, rho=STEEL.rho), **more)
        assert differ(found.stiffness, straight.stiffness) < NEAR_ROUND_OFF
        assert differ(found.mass, straight.mass) < NEAR_ROUND_OFF


class TestMeasures:
    def test_groups_of_facets_may_overlap(self):
        for name, area in (("top", 0.2), ("half", 0.1)):
            A = own(added_mass=lambda f, name=name: f.ufl.inner(f.u, f.v) * f.ds(name), **HALVED).added_mass
            assert A.sum() / 3.0 == pytest.approx(area, rel=1e-12)

    def test_groups_of_cells(self):
        found = own(mass=lambda f: f.p * f.q * f.cells("left") + 3.0 * f.p * f.q * f.cells("right"), **HALVED)
        assert found.mass.sum() / 3.0 == pytest.approx(0.01 + 3.0 * 0.01, rel=1e-12)

    @pytest.mark.parametrize("measure", ["ds", "cells"])
    def test_an_unknown_group_is_named(self, measure):
        with pytest.raises(ModelError, match=r"'roof'.*Remedy.*"):
            own(mass=lambda f: f.p * f.q * f.dx + f.p * f.q * getattr(f, measure)("roof"))


def _halved():
    cells = BOX.cells["body"][0].nodes
    top = BOX.facets["top"][0].nodes
    return Mesh(
        BOX.nodes,
        3,
        {"left": (Cells("hexahedron", cells[:2]),), "right": (Cells("hexahedron", cells[2:]),)},
        {"top": (Cells("quad", top),), "half": (Cells("quad", top[:2]),)},
    )


HALVED = {"mesh": _halved(), "material": dict.fromkeys(("left", "right"), STEEL)}


class TestPhysics:
    def test_kelvin_voigt_damps_each_mode_by_its_frequency(self):
        body = solid_body(
            BOX,
            STEEL,
            {"root": "clamped"},
            kf.CraigBampton(modes=5),
            cache=False,
            forms=Forms(damping=lambda f: 2e-6 * f.stiffness),
        )
        ratios = np.diag(body.damping) / (2.0 * 2.0 * np.pi * body.frequencies)
        np.testing.assert_allclose(ratios, 2e-6 * np.pi * body.frequencies, rtol=1e-9)

    def test_residual_stress_in_balance_is_taken(self):
        """Airy's function (x (L - x) z (h - z))^2 has no tractions; u_x = x z has twice its integral as energy."""
        L, b, h = SIZE

        def residual(f):
            x, z = f.ufl.variable(f.x[0]), f.ufl.variable(f.x[2])
            airy, diff = 1e14 * (x * (L - x) * z * (h - z)) ** 2, f.ufl.diff
            s_xx, s_zz, s_xz = diff(diff(airy, z), z), diff(diff(airy, x), x), -diff(diff(airy, x), z)
            s = f.ufl.as_matrix([[s_xx, 0, s_xz], [0, 0, 0], [s_xz, 0, s_zz]])
            return f.ufl.inner(f.ufl.dot(f.ufl.grad(f.u), s), f.ufl.grad(f.v)) * f.dx

        plain, found = solid_model(BOX, STEEL), own(stiffness=lambda f: f.stiffness + residual(f))
        u = np.kron(plain.nodes[:, 0] * plain.nodes[:, 2], [1.0, 0.0, 0.0])
        exact = 2.0 * 1e14 * b * (L**5 / 30.0) * (h**5 / 30.0)
        assert u @ (found.stiffness - plain.stiffness) @ u == pytest.approx(exact, rel=1e-8)

    def test_a_plug_of_water_before_a_wall_is_all_added(self):
        """A piston moves the water of a pipe with an open end as a whole: A = rho S L."""
        water = box_mesh((0.6, 0.2, 0.1), (3, 1, 1), start=(1.0, 0.0, 0.0))
        flow = PotentialFlow(water, "root", 1000.0, free=["tip"])
        A = own(added_mass=flow).added_mass
        along = np.kron(np.ones(A.shape[0] // 3), [1.0, 0.0, 0.0])
        assert along @ A @ along == pytest.approx(1000.0 * 0.02 * 0.6, rel=1e-12)
        assert A[1::3].nnz == 0 or abs(A[1::3]).max() < 1e-12 * abs(A).max()

    def test_stresses_of_a_graded_bar_are_those_of_its_moduli(self):
        def stress(f, u):
            return 1e9 * (1.0 + f.x[0]) * f.strain(u)

        body = solid_body(
            box_mesh((1.0, 0.1, 0.1), (8, 1, 1)),
            Material(E=1e9, nu=0.0, rho=1000.0),
            {"root": "clamped", "tip": "rigid"},
            kf.CraigBampton(modes=2),
            cache=False,
            forms=Forms(stress=stress),
        )
        scene = kf.System()
        scene.add_force(scene.add_flexible_body("bar", body).interface("tip"), (50.0, 0.0, 0.0))
        fields = recover(kf.equilibrium(scene), "bar")
        # moduli at the middles of cells, 1/16 off at their ends of 1 + x
        middle = fields.stress_at_cells()[0][2:-2, 0]
        np.testing.assert_allclose(middle, 50.0 / 0.01, rtol=2e-3)

    def test_stiffening_follows_the_stress_of_the_form(self):
        options = {"cache": False, "stiffening": "inertial", "reduction": kf.CraigBampton(modes=3), "order": 1}
        by_form = solid_body(TETRA, STEEL, {"root": "clamped"}, forms=Forms(stress=hooke), **options)
        usual = solid_body(TETRA, STEEL, {"root": "clamped"}, **options)
        # of the same rule of quadrature; the products with modes are to 1e-12 of their largest
        found, expected = by_form.moments.quadratic_first, usual.moments.quadratic_first
        np.testing.assert_allclose(np.linalg.eigvalsh(found), np.linalg.eigvalsh(expected), atol=1e-6)

    def test_a_stiffness_alone_has_no_stiffening(self):
        with pytest.raises(ModelError, match="no geometric stiffness"):
            solid_body(
                BOX, STEEL, {"root": "clamped"}, kf.CraigBampton(modes=2), stiffening="inertial", cache=False,
                forms=Forms(stiffness=lambda f: f.stiffness),
            )  # fmt: skip

    def test_a_geometric_form_is_that_of_the_material(self):
        def geometric(f, w):
            return f.ufl.inner(f.ufl.dot(f.ufl.grad(f.u), f.stress(w)), f.ufl.grad(f.v)) * f.dx

        model, found = solid_model(BOX, STEEL), own(geometric_stiffness=geometric)
        w = (model.nodes @ GRADIENT).ravel()  # of uniform stress, whose integrals are exact by any rule
        assert differ(found.stress_stiffness(w), model.stress_stiffness(w)) < NEAR_ROUND_OFF


def test_bodies_of_forms_are_kept_and_told_apart(tmp_path, monkeypatch):
    monkeypatch.setenv("KANEFE_CACHE", "1")
    monkeypatch.setenv("KANEFE_CACHE_DIR", str(tmp_path))

    def wet(factor):
        forms = Forms(added_mass=lambda f: factor * f.ufl.dot(f.u, f.n) * f.ufl.dot(f.v, f.n) * f.ds("top"))
        return solid_body(BOX, STEEL, {"root": "clamped"}, kf.CraigBampton(modes=2), order=1, forms=forms)

    first, again, other = wet(100.0), wet(100.0), wet(200.0)
    assert [body.provenance["cache"]["found"] for body in (first, again, other)] == [False, True, False]
    np.testing.assert_array_equal(first.moments.fluid, again.moments.fluid)
    np.testing.assert_allclose(other.moments.fluid[:6, :6], 2.0 * first.moments.fluid[:6, :6], rtol=1e-9, atol=1e-9)


def turned(f, u):
    """Return a stress that a rotation has too."""
    return 1e9 * f.ufl.grad(u)


REFUSED = {
    "not symmetric": ({"stress": lambda f, u: 1e9 * (f.strain(u) + f.x[0] * f.ufl.diag(f.ufl.as_vector(
        [f.strain(u)[1, 1], 0, 0])))}, r"stiffness is not symmetric.*of the largest\. Remedy"),
    "resists a rotation": ({"stiffness": lambda f: f.stiffness + f.ufl.inner(turned(f, f.u), f.ufl.grad(f.v)) * f.dx},
        r"stiffness resists the rigid rotation [xyz].*Remedy"),
    "a spring to ground": ({"stiffness": lambda f: f.stiffness + 1e9 * f.u[1] * f.v[1] * f.ds("top")},
        r"resists the rigid (translation y|rotation).*Remedy"),
    "a stress out of balance": ({"stiffness": lambda f: f.stiffness
        + 1e7 * f.ufl.inner(f.ufl.grad(f.u), f.ufl.grad(f.v)) * f.dx}, "in balance without loads"),
    "negative stiffness": ({"stress": lambda f, u: -1e9 * f.strain(u)}, r"stiffness is not positive.*Remedy"),
    "negative in part": ({"stress": lambda f, u: 1e9 * (0.4 - f.x[0]) * f.strain(u)}, "stiffness is not positive"),
    "not finite": ({"stress": lambda f, u: 1e9 * f.ufl.sqrt(f.x[0] - 0.5) * f.strain(u)}, "not finite"),
    "negative mass": ({"mass": lambda f: (1.0 - 3.0 * f.x[0]) * f.p * f.q * f.dx}, r"mass is not positive.*kg.*Remedy"),
    "mass that is no mass": ({"mass": lambda f: f.p.dx(0) * f.q.dx(0) * f.dx}, r"mass is not positive.*Remedy"),
    "mass not symmetric": ({"mass": lambda f: f.p * (f.q + f.q.dx(0)) * f.dx}, "mass is not symmetric"),
    "mass of vectors": ({"mass": lambda f: f.ufl.inner(f.u, f.v) * f.dx}, "f.p and f.q"),
    "drag as damping": ({"damping": lambda f: f.ufl.inner(f.u, f.v) * f.dx}, r"damping resists.*drag"),
    "negative damping": ({"damping": lambda f: -1.0 * f.stiffness}, "damping is not positive"),
    "negative fluid": ({"added_mass": lambda f: -f.u[0] * f.v[0] * f.ds("tip")}, "added mass is not positive"),
    "fluid not symmetric": ({"added_mass": lambda f: f.u[0] * f.v[1] * f.ds("tip")}, "added mass is not symmetric"),
"not a form": ({"stiffness": lambda f: 3.0}, "stiffness is 3.0, not an integral"),
    "linear form": ({"stiffness": lambda f: f.v[0] * f.dx}, "not one of the two functions"),
    "a stress that is none": ({"stress": lambda f, u: f.ufl.tr(f.strain(u))}, "not a tensor of 3 x 3"),
    "quadratic in w": ({"geometric_stiffness": lambda f, w: f.ufl.inner(w, w) * f.ufl.inner(f.u, f.v) * f.dx},
        r"not linear in the displacement w.*Remedy"),
}  # fmt: skip


class TestRefused:
    @pytest.mark.parametrize("fault", REFUSED)
    def test_a_form_that_no_body_has(self, fault):
        forms, message = REFUSED[fault]
        with np.errstate(invalid="ignore"), pytest.raises(ModelError, match=message) as raised:
            own(order=1, **forms)
        assert "Remedy" in str(raised.value)

    def test_large_matrices_are_checked_by_their_pivots(self):
        with pytest.raises(ModelError, match="stiffness is not positive"):
            own(mesh=box_mesh(SIZE, (6, 3, 2)), stress=lambda f, u: 1e9 * (0.97 - f.x[0]) * f.strain(u))

    def test_no_forms_and_no_functions(self):
        with pytest.raises(ModelError, match="has no form"):
            Forms()
        with pytest.raises(ModelError, match="added mass is 3"):
            Forms(added_mass=3)

    def test_damping_of_materials_beside_a_stiffness_of_the_user(self):
        lossy = Material(E=210e9, nu=0.3, rho=7850.0, loss_factor=0.1)
        with pytest.raises(ModelError, match=r"damping of the materials.*Remedy"):
            own(material=lossy, stress=hooke, order=1)
        assert own(material=lossy, mass=lambda f: f.mass, order=1).structural is not None

    def test_a_fluid_that_is_closed_in(self):
        with pytest.raises(ModelError, match=r"closed in.*Remedy"):
            PotentialFlow(BOX, "root")

    def test_a_fluid_beside_the_body(self):
        water = box_mesh((0.6, 0.2, 0.1), (3, 1, 1), start=(1.01, 0.0, 0.0))
        with pytest.raises(ModelError, match=r"9 of 9 nodes.*Remedy"):
            own(added_mass=PotentialFlow(water, "root", free=["tip"]))

    def test_cells_that_dolfinx_has_not(self):
        wedge = Mesh(
            np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float),
            3,
            {"body": (Cells("wedge", np.array([[0, 1, 2, 3, 4, 5]])),)},
        )
        with pytest.raises(ModelError, match=r"assembles no forms.*Remedy"):
            own(mesh=wedge, stress=hooke, order=1)
