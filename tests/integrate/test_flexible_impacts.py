"""The error follows rtol where impacts begin vibrations that hardly decay, and meet them again."""

from __future__ import annotations

import pytest

import kanefe as kf
from kanefe_fem.beams.body import beam_body
from steel_beams import steel_beam

LENGTH = 1.0
MOST = 10.0
"""Error at the end over rtol times the size of the scene. A hundred periods of the modes that an impact begins add
errors of one step each, and two more impacts multiply them by ten."""


def ball_on_a_beam(damping: float) -> kf.System:
    """Return a ball of 0.5 kg over the tip of a steel beam of six modes, on which it falls 20 mm."""
    body = beam_body(
        steel_beam(), {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=6), kf.ModalDamping(0.005)
    )
    scene = kf.System(gravity=(0, 0, -9.81))
    beam = scene.add_flexible_body("beam", body, parent=scene.ground)
    top = scene.add_surface("top", beam.interface("tip"), kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 0.5, 1e-4, joint=kf.Prismatic("z", position=0.04), at=(LENGTH, 0, 0))
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.02))
    scene.add_contact("c", skin, top, normal=kf.HuntCrossley(1e7, damping=damping))
    return scene


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_the_error_of_a_ball_on_a_beam_follows_rtol(damping):
    scene = ball_on_a_beam(damping)

    def end(rtol: float, method: str = "auto") -> float:
        result = scene.simulate((0.0, 0.15), rtol=rtol, method=method)
        assert len(result.events["c touch"]) >= 3
        return float(result.position("ball")[-1, 2])

    there = end(1e-12, "dop853")
    errors = {rtol: abs(end(rtol) - there) / (rtol * LENGTH) for rtol in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)}
    assert max(errors.values()) < MOST, errors
