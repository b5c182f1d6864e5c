"""Six by six moduli: rotated, condensed, homogenised; against tensors, closed forms and classical lamination theory."""

from __future__ import annotations

import numpy as np
import pytest

from fem_meshes import STEEL, shown
from kanefe.errors import ModelError
from kanefe_fem.materials import voigt
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.materials.laminate import Laminate, Ply
from kanefe_fem.materials.oriented import Oriented, axes_at_angle, cylindrical_axes, spherical_axes
from kanefe_fem.materials.orthotropic import Anisotropic, Orthotropic

CARBON = Orthotropic.transversely_isotropic(E1=140e9, E2=9e9, nu12=0.3, nu23=0.4, G12=5e9, rho=1600.0, name="carbon")
WOOD = Orthotropic(
    E1=11e9,
    E2=0.9e9,
    E3=0.5e9,
    nu12=0.37,
    nu13=0.42,
    nu23=0.47,
    G12=0.75e9,
    G13=0.7e9,
    G23=0.04e9,
    rho=450.0,
    name="wood",
)


def tensor(C):
    """C_abcd of a six by six matrix."""
    full = np.zeros((3, 3, 3, 3))
    for i, (a, b) in enumerate(voigt.PLACES):
        for j, (c, d) in enumerate(voigt.PLACES):
            full[a, b, c, d] = full[b, a, c, d] = full[a, b, d, c] = full[b, a, d, c] = C[i, j]
    return full


def random_rotation(seed):
    Q, R = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    Q = Q * np.sign(np.diag(R))
    return Q * np.linalg.det(Q)


def random_stiffness(seed):
    L = np.random.default_rng(seed).standard_normal((6, 6))
    return 1e9 * (L @ L.T + np.eye(6))


class TestVoigt:
    def test_rotation_is_that_of_the_tensor(self):
        C, A = random_stiffness(1), np.array([random_rotation(s) for s in (2, 3)])
        for turned, axes in zip(voigt.rotated(C, A), A, strict=True):
            expected = np.einsum("ai,bj,ck,dl,ijkl->abcd", axes, axes, axes, axes, tensor(C))
            np.testing.assert_allclose(tensor(turned), expected, atol=1e-14 * np.abs(C).max() * 81)

    def test_isotropic_is_the_same_in_all_axes(self):
        np.testing.assert_allclose(
            voigt.rotated(STEEL.stiffness, random_rotation(4)), STEEL.stiffness, rtol=0, atol=1e-3
        )

    def test_plane_stress_has_no_stress_across(self):
        C = random_stiffness(5)
        e = np.array([1e-3, -2e-3, 5e-4])
        across = [2, 3, 4]
        rest = np.linalg.solve(C[np.ix_(across, across)], -C[np.ix_(across, voigt.IN_PLANE)] @ e)
        s = C[np.ix_(voigt.IN_PLANE, voigt.IN_PLANE)] @ e + C[np.ix_(voigt.IN_PLANE, across)] @ rest
        np.testing.assert_allclose(voigt.plane_stress(C) @ e, s, rtol=1e-10)
        lame = voigt.plane_stress(STEEL.stiffness)[0, 1]
        assert lame == pytest.approx(STEEL.plane_stress_lame, rel=1e-12)

    def test_poisson_ratio(self):
        assert voigt.poisson_ratio(STEEL.stiffness) == pytest.approx(0.3, rel=1e-12)
        # a stiff fibre is no incompressible matter
        assert voigt.poisson_ratio(CARBON.stiffness) < 0.45


class TestOrthotropic:
    def test_stiffness_inverts_the_compliance_of_its_constants(self):
        S = np.linalg.inv(WOOD.stiffness)
        assert S[0, 0] == pytest.approx(1 / 11e9, rel=1e-12)
        # pulled along 1, it contracts along 2 by nu12
        assert -S[1, 0] / S[0, 0] == pytest.approx(0.37, rel=1e-12)
        assert -S[2, 0] / S[0, 0] == pytest.approx(0.42, rel=1e-12)
        assert -S[2, 1] / S[1, 1] == pytest.approx(0.47, rel=1e-12)
        np.testing.assert_allclose(1 / np.diag(S)[3:], [0.04e9, 0.7e9, 0.75e9], rtol=1e-12)

    def test_equal_constants_are_isotropic(self):
        E, nu = STEEL.E, STEEL.nu
        same = Orthotropic.transversely_isotropic(E1=E, E2=E, nu12=nu, nu23=nu, G12=STEEL.shear_modulus, rho=1.0)
        np.testing.assert_allclose(same.stiffness, STEEL.stiffness, rtol=1e-12, atol=1e-3)

    def test_across_the_fibres_all_directions_are_equal(self):
        turned = voigt.rotated(CARBON.stiffness, axes_at_angle(0.7, axis=(1, 0, 0), along=(0, 1, 0))[:, [2, 0, 1]])
        np.testing.assert_allclose(turned, CARBON.stiffness, rtol=1e-12, atol=1e-3)

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            ({"E2": -1.0}, ("E2 = -1", "wood")),
            ({"G23": np.nan}, ("G23 = nan",)),
            ({"rho": 0.0}, ("rho = 0",)),
            ({"E1": "11e9 Pa"}, ("E1 is",)),
            ({"nu12": np.inf}, ("nu12 is inf",)),
            # nu21 given where nu12 belongs, and the other way round
            ({"E1": 0.9e9, "E2": 11e9}, ("|nu12| = 0.37", "nu21")),
            ({"nu12": 2.5, "nu13": 3.0, "nu23": 0.9}, ("together",)),
        ],
    )
    def test_constants_out_of_range(self, change, words):
        given = {f: getattr(WOOD, f) for f in WOOD.__dataclass_fields__}
        with pytest.raises(ModelError) as error:
            Orthotropic(**{**given, **change})
        shown(error, *words)

    @pytest.mark.parametrize(
        ("matrix", "word"),
        [
            (np.eye(3), "shape (3, 3)"),
            (np.diag([1, 1, 1, 1, 1, 0.0]), "0, 0, 0, 0, 0, 1"),
            (np.diag([1, 1, -2.0, 1, 1, 1]), "-2 Pa"),
            (np.eye(6) + np.eye(6, k=1), "not symmetric"),
            (np.full((6, 6), np.nan), "not finite"),
        ],
    )
    def test_a_matrix_that_is_no_stiffness(self, matrix, word):
        with pytest.raises(ModelError) as error:
            Anisotropic(matrix, rho=1.0, name="jelly")
        shown(error, "jelly", word)


class TestLaminate:
    def test_isotropic_layers_agree_with_backus(self):
        # Backus, J. Geophys. Res. 67 (1962): horizontally layered isotropic media
        soft, hard = Material(3e9, 0.35, 1200.0), Material(70e9, 0.3, 2700.0)
        share = {soft: 0.3, hard: 0.7}

        def mean(f):
            return sum(w * f(m) for m, w in share.items())

        C = Laminate([Ply(m, w) for m, w in share.items()]).stiffness
        c33 = 1 / mean(lambda m: 1 / (m.lame + 2 * m.shear_modulus))
        ratio = mean(lambda m: m.lame / (m.lame + 2 * m.shear_modulus))
        bend = mean(lambda m: 4 * m.shear_modulus * (m.lame + m.shear_modulus) / (m.lame + 2 * m.shear_modulus))
        expected = [bend + c33 * ratio**2, c33, c33 * ratio, 1 / mean(lambda m: 1 / m.shear_modulus)]
        np.testing.assert_allclose([C[0, 0], C[2, 2], C[0, 2], C[3, 3]], expected, rtol=1e-13)
        assert C[5, 5] == pytest.approx(mean(lambda m: m.shear_modulus), rel=1e-13)
        assert Laminate([Ply(soft, 0.3), Ply(hard, 0.7)]).rho == pytest.approx(0.3 * 1200 + 0.7 * 2700)

    def test_membrane_stiffness_is_that_of_lamination_theory(self):
        angles = np.radians([0.0, 45.0, -45.0, 90.0, 20.0])
        thick = np.array([1.0, 2.0, 1.5, 0.5, 1.0]) * 1e-3
        laminate = Laminate([Ply(CARBON, t, a) for t, a in zip(thick, angles, strict=True)])
        # A of the classical theory: reduced stiffness of each ply, turned by Tsai's formulas
        Q11 = 140e9 / (1 - 0.3 * 0.3 * 9 / 140)
        Q22, Q12, Q66 = Q11 * 9 / 140, 0.3 * Q11 * 9 / 140, 5e9
        c, s = np.cos(angles), np.sin(angles)
        first = Q11 * c**4 + 2 * (Q12 + 2 * Q66) * s**2 * c**2 + Q22 * s**4
        twist = (Q11 - Q12 - 2 * Q66) * s * c**3 + (Q12 - Q22 + 2 * Q66) * s**3 * c
        reduced = voigt.plane_stress(laminate.stiffness)
        assert reduced[0, 0] == pytest.approx(thick @ first / thick.sum(), rel=1e-12)
        assert reduced[0, 2] == pytest.approx(thick @ twist / thick.sum(), rel=1e-12)

    def test_one_ply_is_its_material_turned(self):
        one = Laminate([Ply(WOOD, 2e-3, 0.4)])
        np.testing.assert_allclose(
            one.stiffness, voigt.rotated(WOOD.stiffness, axes_at_angle(0.4)), rtol=1e-10, atol=1.0
        )

    def test_bad_plies(self):
        for make, word in (
            (lambda: Ply("carbon", 1e-3), "is not a material"),
            (lambda: Ply(CARBON, 0.0), "thickness = 0"),
            (lambda: Ply(CARBON, 1e-3, np.nan), "angle"),
            (lambda: Laminate([]), "at least one"),
        ):
            with pytest.raises(ModelError) as error:
                make()
            shown(error, word)


class TestAxes:
    def test_cylinder(self):
        x = np.array([[2.0, 1.0, 5.0], [1.0, 3.0, -1.0]])
        A = cylindrical_axes(origin=(1, 1, 0))(x)
        np.testing.assert_allclose(A[0], np.eye(3), atol=1e-15)
        np.testing.assert_allclose(A[1], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
        around = cylindrical_axes(origin=(1, 1, 0), first="around")(x)
        np.testing.assert_allclose(around[0], [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-15)

    def test_ball(self):
        A = spherical_axes(first="north")(np.array([[3.0, 0.0, 0.0], [1.0, 2.0, 2.0]]))
        np.testing.assert_allclose(A[0], [[0, 1, 0], [0, 0, 1], [1, 0, 0]], atol=1e-15)
        np.testing.assert_allclose(A[1][:, 1], np.array([1, 2, 2]) / 3, atol=1e-15)
        np.testing.assert_allclose(np.linalg.det(A), 1.0, rtol=1e-14)
        assert A[1][2, 0] > 0  # north is up

    def test_angle(self):
        A = axes_at_angle(np.pi / 6, axis=(0, 0, 2), along=(1, 0, 1))
        np.testing.assert_allclose(A[:, 0], [np.sqrt(0.75), 0.5, 0], atol=1e-15)

    def test_axes_are_in_the_record_of_a_material(self):
        A = axes_at_angle(np.pi / 6)
        assert Oriented(CARBON, A).describe()["axes"] == A.tolist()
        of_cells = np.stack((A, np.eye(3)))
        digests = [Oriented(CARBON, axes).describe()["axes"]["sha256"] for axes in (of_cells, of_cells[::-1])]
        assert digests[0] != digests[1]

        def grown(x):
            return np.broadcast_to(A, (len(x), 3, 3))

        assert Oriented(CARBON, grown).describe()["axes"]["function"].endswith("grown")

    def test_bad_axes(self):
        for make, word in (
            (lambda: Oriented(CARBON, 2 * np.eye(3)), "orthonormal"),
            (lambda: Oriented(CARBON, np.diag([1.0, 1.0, -1.0])), "right-handed"),
            (lambda: Oriented(CARBON, np.eye(2)), "shape (2, 2)"),
            (lambda: Oriented("carbon", np.eye(3)), "is not a material"),
            (
                lambda: Oriented(CARBON, np.eye(3)[None]).stiffness_at("skin", np.zeros((4, 3))),
                "1 axes are given for 4",
            ),
            (lambda: Oriented(CARBON, lambda x: np.eye(3)).stiffness_at("skin", np.zeros((4, 3))), "for 4 points"),
            (lambda: cylindrical_axes(axis=(0, 0, 0)), "is not a direction"),
            (lambda: cylindrical_axes(first="up"), "outward, around, along"),
            (lambda: cylindrical_axes()(np.array([[1.0, 0, 0], [0, 0, 2.0]])), "(0, 0, 2) m"),
            (lambda: axes_at_angle(0.1, axis=(1, 0, 0)), "parallel"),
        ):
            with pytest.raises(ModelError) as error:
                make()
            shown(error, word)
