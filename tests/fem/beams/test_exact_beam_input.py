"""What `exact_beam` refuses, and what it makes of its arguments."""

import numpy as np
import pytest

import kanefe as kf
import kanefe_fem as fem

SECTION = fem.Section.from_stiffness(EA=300.0, GA_y=200.0, GA_z=150.0, GJ=6.0, EI_y=5.0, EI_z=4.0, rho_A=1.0)
FLAT = fem.Section.from_stiffness(EA=300.0, EI_z=4.0, rho_A=1.0)


def made(section=SECTION, length=2.0, **options):
    return fem.exact_beam(length, section, **options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"length": 0.0}, "length = 0.0 must be positive"),
        ({"length": float("inf")}, "must be positive and finite|finite"),
        ({"theory": "thick"}, "unknown theory 'thick'|theory"),
        ({"basis": 0}, "basis of twist = 0"),
        ({"basis": {"twist": 3}}, "no functions for curvature_y, curvature_z"),
        ({"basis": {"shear_y": 3}}, "basis names .*shear_y.*this beam has twist"),
        ({"basis": {"twist": 3, "curvature_y": 2, "curvature_z": "two"}}, "basis of curvature_z = 'two'|basis"),
        ({"interfaces": {"beyond": 2.5}}, "must be arc lengths within the beam, from 0 to 2 m"),
        ({"interfaces": {}}, "interfaces is not a mapping"),
        ({"axes": np.diag((1.0, 1.0, -1.0))}, "rotation matrix"),
        ({"axes": 2.0 * np.eye(3)}, "rotation matrix"),
        ({"curvature": (0.0, 1.0)}, "three finite numbers"),
        ({"planar": True, "curvature": (0.0, 1.0, 0.0)}, "no twist and no curvature about y"),
        ({"curvature": lambda s: (0.0, 0.0, float("nan"))}, "three finite numbers"),
        ({"section": lambda s: "square"}, "section at .* m is 'square'"),
        ({"section": fem.Rectangle(0.1, 0.1)}, "material of an exact beam is None, which has no E. Remedy"),
        (
            {"section": fem.Rectangle(0.1, 0.1), "material": 1e7},
            "material of an exact beam is 10000000.0, which has no E",
        ),
        ({"section": FLAT}, "has no GJ and no EI_y|which a beam in space needs"),
        (
            {"section": FLAT, "planar": True, "theory": "shear-deformable"},
            "no finite, positive stiffness against shear_y",
        ),
        ({"damping": 0.01}, "RayleighDamping or kanefe.ModalDamping|damping"),
    ],
    ids=lambda given: "" if isinstance(given, str) else "-".join(given),
)
def test_bad_input_is_named(options, message):
    with pytest.raises(kf.ModelError, match=message):
        made(**options)


def test_theories_have_their_strains():
    for theory, strains in (("shear-rigid", 3), ("stretching", 4), ("shear-deformable", 6)):
        assert made(theory=theory, basis=2).free_count == 2 * strains
    assert made(FLAT, planar=True).free_count == 8


def test_interfaces_are_where_they_were_put():
    beam = made(interfaces={"root": 0.0, "middle": 0.7, "tip": 2.0 + 1e-13}, curvature=(0.0, 0.0, 0.8))
    for name, s in (("root", 0.0), ("middle", 0.7), ("tip", 2.0)):
        arc = np.array((np.sin(0.8 * s), 1.0 - np.cos(0.8 * s), 0.0)) / 0.8
        np.testing.assert_allclose(beam.interface(name).position, arc, rtol=0, atol=1e-12)


def test_a_taper_bends_as_beam_theory_says():
    """A cantilever under a small tip force: v = int P (L - s)^2 / EI ds, EI = 4 (2 - s / L)."""
    beam = made(
        lambda s: fem.Section.from_stiffness(EA=300.0, EI_z=4.0 * (2.0 - s / 2.0), rho_A=1.0), planar=True, basis=8
    )
    scene = kf.System()
    force = 1e-4
    scene.add_force(scene.add_flexible_body("beam", beam).interface("tip"), (0.0, force, 0.0))
    x, w = np.polynomial.legendre.leggauss(12)
    s = x + 1.0
    expected = force * np.sum(w * (2.0 - s) ** 2 / (4.0 * (2.0 - s / 2.0)))
    # to second order in the slope, 1e-4, and what 8 functions leave of 1 / EI
    assert kf.equilibrium(scene).position("beam", "tip")[1] == pytest.approx(expected, rel=1e-7)


def test_a_jump_of_the_section_needs_a_break():
    """With a break and degree 0 on both sides a couple bends two arcs, exactly."""

    def section(s):
        return fem.Section.from_stiffness(EA=300.0, EI_z=4.0 if s < 0.7 else 2.0, rho_A=1.0)

    beam = made(section, planar=True, basis=kf.BSpline(0, (0.35,)), interfaces={"jump": 0.7, "tip": 2.0})
    scene = kf.System()
    scene.add_torque(scene.add_flexible_body("beam", beam).interface("tip"), (0.0, 0.0, 1.0))
    eta = kf.equilibrium(scene).modal_coordinates("beam")
    np.testing.assert_allclose(eta, (0.25, 0.5), rtol=1e-12)
