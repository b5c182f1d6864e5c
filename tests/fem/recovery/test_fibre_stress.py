"""Normal stress in the outer fibres of beams, and as colours of a page: against M / W and N / A."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.views.player.page import page_of
from kanefe_fem import (
    Box,
    Material,
    Rectangle,
    Section,
    SolidCircle,
    Tube,
    beam_body,
    box_mesh,
    recover,
    solid_body,
    straight_beam,
)
from kanefe_fem.beams.section_shapes import FIBRES
from player_pages import body_of, read_page

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
PULL, PUSH_Y, PUSH_Z = 400.0, 30.0, -20.0  # N at the tip
LENGTH = 0.8

SECTIONS = {
    Rectangle(0.02, 0.03): (2 / 0.02, 2 / 0.03),
    Box(0.03, 0.02, 0.002): (2 / 0.03, 2 / 0.02),
    SolidCircle(0.02): None,
    Tube(0.03, 0.002): None,
}


def bent(section: object, **options: object) -> kf.Equilibrium:
    model = straight_beam(LENGTH, section, STEEL, elements=4, direction=(1.0, 2.0, 2.0), **options)
    body = beam_body(model, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=2))
    scene = kf.System()
    arm = scene.add_flexible_body("arm", body)
    axes = model.elasticity.axes[0]
    scene.add_force(arm.interface("tip"), axes @ (PULL, PUSH_Y, PUSH_Z))
    return kf.equilibrium(scene)


@pytest.mark.parametrize("section", SECTIONS, ids=lambda section: type(section).__name__)
def test_the_root_has_the_stress_of_textbooks(section):
    rest = bent(section)
    fields = recover(rest, "arm")
    stress = fields.stress_of(fields.eta)[0].reshape(4, 2, FIBRES, 6)
    along = stress[0, 0, :, :3].sum(axis=1)  # the trace: one stress alone, along the axis
    about_y, about_z = LENGTH * abs(PUSH_Z), LENGTH * PUSH_Y
    if SECTIONS[section] is not None:
        over_y, over_z = SECTIONS[section]
        bending = about_z / (section.I_z * over_y) + about_y / (section.I_y * over_z)
        tolerance = 1e-6  # statics of the tip are exact; the rest is the tip's own deflection in the equilibrium
    else:
        radius = 0.5 * getattr(section, "diameter", getattr(section, "outer_diameter", 0.0))
        bending = np.hypot(about_y, about_z) * radius / section.I_y
        tolerance = 1.0 - np.cos(np.pi / FIBRES)  # between two fibres
    assert along.max() == pytest.approx(PULL / section.A + bending, abs=tolerance * bending)
    assert along.min() == pytest.approx(PULL / section.A - bending, abs=tolerance * bending)
    # at the tip nothing bends
    np.testing.assert_allclose(stress[-1, 1, :, :3].sum(axis=1), PULL / section.A, rtol=1e-5)


def test_a_push_upwards_presses_the_upper_fibres():
    model = straight_beam(1.0, Rectangle(0.02, 0.02), STEEL, elements=2)
    body = beam_body(model, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=1))
    scene = kf.System()
    arm = scene.add_flexible_body("arm", body)
    scene.add_force(arm.interface("tip"), (0, 0, 10.0))
    fields = recover(kf.equilibrium(scene), "arm")
    xx = fields.stress_of(fields.eta)[0].reshape(2, 2, FIBRES, 6)[0, 0, :, 0]
    np.testing.assert_allclose(fields.fibre_stress()[0, 0, 0], xx, atol=1e-9 * np.abs(xx).max())
    z = model.elasticity.fibres[0, :, 1]
    assert (xx[z > 0.009] < 0.0).all()
    assert (xx[z < -0.009] > 0.0).all()


def test_a_page_has_the_stress_of_beams_as_colours():
    scene = kf.System(gravity=(0, 0, -9.81))
    body = beam_body(
        straight_beam(1.0, Tube(0.03, 0.002), STEEL, elements=4), {"root": "clamped"}, kf.CraigBampton(modes=2)
    )
    scene.add_flexible_body("arm", body)
    bar = solid_body(box_mesh((0.2, 0.02, 0.02), (4, 1, 1)), STEEL, {"root": "clamped"}, kf.CraigBampton(modes=1))
    scene.add_flexible_body("bar", bar, at=(0, 1, 0))
    result = scene.simulate((0.0, 0.05), output_step=0.01)
    fields = recover(result, "arm")
    told = read_page(page_of(result, stress=fields).html)
    assert told["stress_name"] == "normal stress"
    part = body_of(told, "arm")["parts"][0]
    shown = np.tensordot(part["amplitudes"][-1] * part["stress_factors"], part["stresses"].astype(float), axes=1)
    exact = fields.stress_of(fields.eta[-1:])[0]
    np.testing.assert_allclose(shown, exact, atol=2e-4 * np.abs(exact).max())  # 16 bits
    both = read_page(page_of(result, stress=[fields, recover(result, "bar")]).html)
    assert both["stress_name"] == "stress, normal in beams"
    of_bar = read_page(page_of(result, stress=recover(result, "bar")).html)
    assert of_bar["stress_name"].startswith("von Mises stress (error of mesh ")


def test_sections_by_numbers_have_no_outer_fibres():
    rest = bent(Section(A=1e-3, I_y=2e-7, I_z=4e-7, J=3e-7))
    fields = recover(rest, "arm")
    with pytest.raises(kf.ModelError, match=r"'arm' have section constants but no shape.*Tube.*section_forces\(\)"):
        fields.stress_of(fields.eta)


def test_fibres_come_back_from_a_file(tmp_path):
    scene = kf.System(gravity=(0, 0, -9.81))
    body = beam_body(
        straight_beam(1.0, Tube(0.03, 0.002), STEEL, elements=2), {"root": "clamped"}, kf.CraigBampton(modes=2)
    )
    scene.add_flexible_body("arm", body)
    result = scene.simulate((0.0, 0.02), output_step=0.01)
    result.save(tmp_path / "run.h5")
    loaded = kf.load_result(tmp_path / "run.h5")
    first, second = recover(result, "arm"), recover(loaded, "arm")
    np.testing.assert_array_equal(first.stress_of(first.eta), second.stress_of(second.eta))
