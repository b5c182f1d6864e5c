"""Runs of contacts: forces that jump at a touch, laws that remember an impact."""

from __future__ import annotations

import math

import pytest

import kanefe as kf
from kanefe.checks.verification.contact import shaken_slope


def arrives(law: kf.contact.normal_laws.NormalLaw, method: str, rtol: float) -> kf.Result:
    """Return the run of a mass of 1 kg that meets a wall at 1 m/s, from 1 mm before it, and leaves it."""
    scene = kf.System()
    wall = scene.add_surface("wall", scene.ground, kf.shapes.Plane("z"))
    mass = scene.add_point("mass", 1.0, joint=kf.Prismatic("z", position=1e-3, speed=-1.0))
    scene.add_contact("impact", mass, wall, normal=law)
    return scene.simulate((0.0, 0.1), rtol=rtol, method=method)


@pytest.mark.parametrize("rtol", [1e-6, 1e-10, 1e-12])
@pytest.mark.parametrize("method", ["radau5", "dop853", "vern9"])
def test_a_force_that_jumps_at_a_touch_holds_no_method_up(method, rtol):
    """The power of a damper of 10 N s/m jumps by 10 W, in a scene that its size says has 1e-6 J."""
    ratio = 0.05
    root = math.sqrt(1.0 - ratio**2)
    left = math.exp(-2.0 * ratio / root * math.atan(root / ratio))
    run = arrives(kf.KelvinVoigt(1e4, damping=2.0 * ratio * 100.0), method, rtol)
    assert run.status.is_finished
    assert run.velocity("mass")[-1, 2] == pytest.approx(left, rel=max(10.0 * rtol, 1e-9))


@pytest.mark.parametrize("method", ["radau5", "dop853"])
def test_a_law_that_remembers_an_impact_needs_no_friction(method):
    """Its state stays between events: the implicit method does not solve for it, and has a row for it all the same."""
    run = arrives(kf.Restitution(1e4, 0.8), method, 1e-8)
    assert run.velocity("mass")[-1, 2] == pytest.approx(0.8, rel=1e-6)


@pytest.mark.parametrize("rtol", [1e-2, 1e-3])
def test_a_loose_run_does_not_shake_loose_what_sticks(rtol):
    """At 96 % of the cone; absolute errors of a scene of 1 m would be larger than what the contact yields by."""
    result = shaken_slope(0.112).simulate((0.0, 21.0), rtol=rtol, output_step=0.1)
    assert result.contact("block on slope").slip[-1] == 0.0
