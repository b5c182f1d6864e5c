"""Contacts that are stiffer than numbers or a run can follow are told early, by name."""

from __future__ import annotations

import warnings

import pytest

import kanefe as kf
from kanefe.integrate import pace


def resting(stiffness: float, gravity: float = 9.81) -> kf.System:
    """Return a ball of 1 kg that begins on a floor, and slides."""
    scene = kf.System(gravity=(0, 0, -gravity))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 0.1, joint=kf.Free(position=(0, 0, 0.1), velocity=(0.1, 0, 0)))
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("stands", skin, floor, normal=kf.HuntCrossley(stiffness, damping=1.0))
    return scene


def test_a_contact_below_round_off_is_told_where_a_run_begins() -> None:
    """9.8 N over 1e20 N/m, in a scene of 0.3 m: 1e-19 m, where places are rounded by 1e-16 m."""
    match = r"contact 'stands' of 1e\+20 N/m deflects by 9\.8e-20 m .*, 1\.2e-16 m: .* Remedy: .* at most 8e\+10 N/m"
    with pytest.warns(kf.SimulationWarning, match=match):
        resting(1e20).simulate((0.0, 1e-6), most_steps=5)
    with pytest.warns(kf.SimulationWarning, match="contact 'stands' of 1e\\+20 N/m"):
        resting(1e20).start(every=1e-6)
    for scene in (resting(8e10), resting(1e20, gravity=0.0)):
        with warnings.catch_warnings():
            warnings.simplefilter("error", kf.SimulationWarning)
            scene.simulate((0.0, 1e-6), most_steps=5)


def test_a_run_that_follows_a_contact_step_by_step_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pace, "SOON", 0.0)
    monkeypatch.setattr(pace, "LONG", 0.0)
    match = (
        r"they resolve contact 'stands' of 1e\+12 N/m, on which 1 kg vibrates with a period of 6\.3e-06 s.* Remedy: "
    )
    with pytest.warns(kf.SimulationWarning, match=match) as told:
        resting(1e12).simulate((0.0, 1.0), most_steps=500)
    assert sum("they resolve" in str(one.message) for one in told) == 1
    with warnings.catch_warnings():  # 250 periods of 0.02 s
        warnings.simplefilter("error", kf.SimulationWarning)
        resting(1e5).simulate((0.0, 5.0))
