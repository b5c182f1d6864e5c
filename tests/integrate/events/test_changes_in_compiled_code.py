"""Events that change states of their loads: compiled code does what Python does, and does not ask it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.events import event_search
from kanefe.kernels.events.watched_run import Does


def stop() -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    forces = kf.CoordinateForce(limits=(-0.3, None), limit_stiffness=1e4, limit_restitution=0.6)
    scene.add_rigid_body("lid", 1.0, 0.1, joint=kf.Revolute("y", speed=1.0, forces=forces), com=(-0.2, 0.0, 0.0))
    return scene


def breaking_away() -> kf.System:
    scene = kf.System()
    forces = kf.CoordinateForce(friction=0.1, static_friction=0.2, stiffness=2.0)
    scene.add_rigid_body("wheel", 1.0, 0.1, joint=kf.Revolute("z", speed=1.0, forces=forces))
    return scene


def impact() -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=kf.Free(position=(0.0, 0.0, 0.15), velocity=(0.5, 0.0, 0.0)))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    law = kf.Coulomb(0.1, static=0.15)
    scene.add_contact("touch", skin, floor, normal=kf.Restitution(1e5, 0.7), friction=law)
    return scene


def rope() -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    weight = scene.add_point("weight", 1.0, at=(0.0, 0.0, -0.9))
    ends = scene.ground, weight
    scene.add(kf.Rope("rope", ends, axial_stiffness=1e3, damping=1.0, length=1.0, breaking_load=40.0))
    return scene


def winch() -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    weight = scene.add_rigid_body(
        "weight", 1.0, 0.1, joint=kf.Free(position=(0.0, 0.0, -1.0), velocity=(0.0, 0.0, -4.0))
    )
    ends = scene.ground, weight
    scene.add(kf.Winch("winch", ends, tension=9.81, stiffness=1e3, speed=0.5, damping=50.0, breaking_load=60.0))
    return scene


SCENES: dict[str, tuple[Callable[[], kf.System], set[str]]] = {
    "stop": (stop, {"lid touch", "lid lift"}),
    "friction": (breaking_away, {"wheel slip", "wheel stick"}),
    "impact": (impact, {"touch touch", "touch lift", "touch slip", "touch stick"}),
    "rope": (rope, {"rope breaks"}),
    "winch": (winch, {"winch breaks"}),
}


def events_apart(result: kf.Result) -> dict[str, np.ndarray]:
    """Return the events of a run, but slips and sticks within a microsecond of a touch or a lift.

    The functions of both are zero there, so that the last digit says whether they pass it, and so does the place of the
    last step before a lift.
    """
    ends = np.concatenate([[-1.0], *(t for name, t in result.events.items() if name.endswith((" touch", " lift")))])
    return {
        name: t[np.abs(t[:, None] - ends).min(axis=1) > 1e-6] if name.endswith((" slip", " stick")) else t
        for name, t in result.events.items()
    }


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("method", ["radau5", "dop853"])
def test_compiled_changes_are_those_of_python(name: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, happens = SCENES[name]
    asked: list[float] = []
    scan = event_search.EventWatch.scan
    monkeypatch.setattr(
        event_search.EventWatch, "scan", lambda self, stepper, clock: asked.append(0.0) or scan(self, stepper, clock)
    )
    options = {"method": method, "rtol": 1e-10, "output_step": 0.01}
    compiled = scene().simulate((0.0, 0.45), **options)
    assert not asked
    kind = event_search.kind_for_kernels
    in_python = {Does.CHANGES: Does.ACTS}
    monkeypatch.setattr(event_search, "kind_for_kernels", lambda event: in_python.get(kind(event), kind(event)))
    in_python = scene().simulate((0.0, 0.45), **options)
    assert asked
    assert happens == {name for name, times in compiled.events.items() if len(times)}
    of_both = events_apart(compiled), events_apart(in_python)
    for event, times in of_both[1].items():
        # compiled code goes on from an event with other steps: both have the error of the run, bounce by bounce
        np.testing.assert_allclose(of_both[0][event], times, rtol=0, atol=1e-8, err_msg=event)
    np.testing.assert_allclose(
        compiled.run.trajectory.coordinates, in_python.run.trajectory.coordinates, rtol=0, atol=1e-8
    )
    np.testing.assert_allclose(compiled.energy.dissipated, in_python.energy.dissipated, rtol=0, atol=1e-8)
    scale = max(1.0, float(np.abs(compiled.energy.total).max()))
    assert np.abs(compiled.energy.balance_error).max() < 1e-5 * scale
