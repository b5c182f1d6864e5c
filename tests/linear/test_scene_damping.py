"""Ratios of the modes of a scene: exact for one body whatever it carries, told where they cannot be had."""

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

MODEL = straight_beam(0.8, Rectangle(0.01, 0.04), Material(E=70e9, nu=0.33, rho=2700.0), elements=6)


@pytest.fixture(scope="module")
def body() -> kf.FlexibleBody:
    return beam_body(MODEL, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=3), kf.ModalDamping(0.01))


def carrying(body: kf.FlexibleBody, mass: float, joint: kf.Joint | None = None) -> kf.System:
    scene = kf.System()
    arm = scene.add_flexible_body("arm", body, joint=joint or kf.Fixed())
    scene.add_rigid_body("tool", mass, 1e-3, parent=arm.interface("tip"))
    return scene


@pytest.mark.parametrize("mass", [0.1, 10.0])
@pytest.mark.parametrize("joint", [kf.Fixed(), kf.Revolute("z")], ids=["fixed", "free hinge"])
def test_all_elastic_modes_have_the_ratio_whatever_the_body_carries(body, mass, joint):
    scene = carrying(body, mass, joint)
    kf.SceneDamping((0.02, 0.01)).put_on(scene)
    modes = kf.linearise(scene).modes()
    ratios = modes.damping_ratios[~modes.is_rigid]
    assert ratios[0] == pytest.approx(0.02, rel=1e-9)
    np.testing.assert_allclose(ratios[1:], 0.01, rtol=1e-9)


def test_two_bodies_share_nearly(body):
    """Of two arms in a chain the parts between them are left out, and the others adjusted: C feeds no energy in."""
    scene = carrying(body, 0.5)
    scene.add_flexible_body("second", body, parent=scene.body("tool"))
    kf.SceneDamping(0.01).put_on(scene)
    np.testing.assert_allclose(kf.linearise(scene).modes().damping_ratios, 0.01, rtol=0.05)
    for name in ("arm", "second"):
        damping = scene.body(name).body.damping
        assert np.linalg.eigvalsh(damping).min() > -1e-12 * abs(damping).max()


def test_the_table_of_modes_shows_the_ratios_of_bodies_alone(body):
    text = str(kf.linearise(carrying(body, 1.0)).modes())
    assert text.splitlines()[-1] == "damping of bodies alone, with fixed interfaces held: arm 1 %"
    assert text.splitlines()[1].split()[3] == "0.4092"  # of the whole


def test_modes_of_springs_are_left_to_dampers_of_these(body):
    soft = kf.Revolute("z", forces=kf.CoordinateForce(stiffness=5.0))
    scene = carrying(body, 1.0, soft)
    kf.SceneDamping(0.01).put_on(scene)
    ratios = kf.linearise(scene).modes().damping_ratios
    assert ratios[0] < 1e-3
    np.testing.assert_allclose(ratios[1:], 0.01, rtol=0.05)


def test_ratios_that_cannot_be_had_are_told(body):
    scene = kf.System()
    first = scene.add_flexible_body("first", body, joint=kf.Revolute("z", forces=kf.CoordinateForce(stiffness=500.0)))
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=50.0))
    scene.add_flexible_body("second", body, parent=first.interface("tip"), joint=hinge)
    with pytest.warns(
        kf.AccuracyWarning, match=r"SceneDamping: \d+ of \d+ modes miss their ratio by more than a tenth"
    ):
        kf.SceneDamping(0.01).put_on(scene)


def test_bad_input_is_named(body):
    with pytest.raises(kf.ModelError, match="no flexible body with modes"):
        kf.SceneDamping(0.01).put_on(kf.System())
    with pytest.raises(kf.ModelError, match=r"is above 1.*Remedy: 0\.02 for 2 %"):
        kf.SceneDamping(2.0)
    with pytest.raises(kf.ModelError, match=r"of a whole scene\. Remedy: \.put_on\(scene\)"):
        beam_body(MODEL, {"root": "clamped"}, kf.CraigBampton(modes=3), kf.SceneDamping(0.01))
    scene = carrying(body, 1.0)
    with pytest.raises(kf.ModelError, match="9 elastic modes"):
        kf.SceneDamping((0.01,) * 10).put_on(scene)
    scene.freeze()
    with pytest.raises(kf.ModelError, match="damping of the scene cannot be added or changed"):
        kf.SceneDamping(0.01).put_on(scene)
