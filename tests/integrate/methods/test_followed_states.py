"""Internal states of loads in the implicit methods: friction that slips and holds, against closed forms."""

import numpy as np
import pytest

import kanefe as kf
import kanefe.reduction.build as build
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Tube
from kanefe_fem.materials.isotropic import Material

STOP, REST = 1.0 / 0.3 / 9.81, 0.5 / 0.3 / 9.81


def sliding() -> kf.System:
    """Return a block that begins at 1 m/s on a plane with mu = 0.3."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    slide = kf.Translation(position=(0.0, 0.0, -9.81e-5), velocity=(1.0, 0.0, 0.0))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=slide)
    scene.add_contact("feet", [block], floor, normal=kf.KelvinVoigt(1e5, damping=60.0), friction=kf.Coulomb(0.3))
    return scene


@pytest.mark.parametrize("method", ["generalised-alpha", "hht"])
def test_a_sliding_block_stops_and_stays(method):
    result = sliding().simulate((0.0, 0.8), method=method, rtol=1e-5)
    # onset: the anchor's spring yields 3e-5 m on the way; the methods are of second order
    assert result.events["feet stick"][0] == pytest.approx(STOP, abs=1e-3)
    assert result.position("block")[-1, 0] == pytest.approx(REST, abs=1e-3)
    after = result.times > STOP + 0.1  # the anchor has swung out
    assert np.ptp(result.position("block")[after, 0]) < 1e-5
    assert np.abs(result.energy.balance_error).max() < 1e-3 * 0.5


def test_friction_that_begins_to_hold_in_a_long_step_is_found():
    """A step of a half of the contact's period: Newton's iteration goes to and fro there unless steps are halved."""
    step = 0.01
    result = sliding().simulate((0.0, 0.8), method="generalised-alpha", step=step)
    assert result.status.is_finished
    assert "unconverged" not in result.statistics
    assert result.statistics["steps"] == 80
    assert result.events["feet stick"] == pytest.approx([STOP], abs=step)
    assert result.position("block")[-1, 0] == pytest.approx(REST, abs=0.5 * 0.3 * 9.81 * step**2)  # of half a step


def test_an_unreduced_body_on_a_joint_with_friction_is_run_by_auto(monkeypatch):
    monkeypatch.setattr(build, "LARGEST_DENSE", 0)  # small bodies are unreduced ones too
    tube = straight_beam(1.0, Tube(0.04, 0.002), Material(E=70e9, nu=0.33, rho=2700.0), elements=3)
    found = {}
    for name, reduction in (("unreduced", None), ("reduced", kf.CraigBampton(4))):
        scene = kf.System()
        hinge = kf.Revolute("z", speed=1.0, forces=kf.CoordinateForce(friction=0.2))
        scene.add_flexible_body(
            "arm",
            kf.flexible_body(tube, {"root": "clamped"}, reduction=reduction, damping=kf.RayleighDamping(0.0, 3e-4)),
            joint=hinge,
        )
        result = scene.simulate((0.0, 1.5), rtol=1e-6)
        found[name] = np.array((result.joint_coordinates("arm")[-1, 0], *result.events["arm stick"]))
    # where it stays, and when: the vibrations that end the slip are in part of modes that one of them leaves out
    np.testing.assert_allclose(found["unreduced"], found["reduced"], rtol=3e-3)
