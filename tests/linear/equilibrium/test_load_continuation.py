"""Rests that Newton's method does not find from the start: the loads are raised by themselves."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import SimulationError
from kanefe.linear.equilibrium import load_continuation
from kanefe.linear.equilibrium.balance import BalanceSearch
from kanefe.linear.paths import loaded_scene
from kanefe_fem import Section, exact_beam

TIP = np.array((0.410203352617, 0.053770903120, -1.091729019348))
"""Tip of the coiled beam under a tenth of the whole load, m: by shooting with Cosserat's equations, to 1e-11."""


def coiled(share: float, bending: int) -> kf.System:
    """Return the cantilever that a couple coils up to ten turns and a force pulls along its axis (Ibrahimbegovic)."""
    section = Section.from_stiffness(EA=1e4, GA_y=1e4, GA_z=1e4, GJ=100.0, EI_y=100.0, EI_z=100.0, rho_A=1.0)
    bends, stretches = ("twist", "curvature_y", "curvature_z"), ("stretch", "shear_y", "shear_z")
    basis = {**dict.fromkeys(bends, bending), **dict.fromkeys(stretches, 6)}
    beam = exact_beam(10.0, section, theory="shear-deformable", basis=basis, interfaces={"middle": 5.0, "tip": 10.0})
    scene = kf.System()
    tip = scene.add_flexible_body("beam", beam).interface("tip")
    scene.add_force(tip, (0.0, 0.0, 50.0 * share))
    scene.add_torque(tip, (0.0, 0.0, 200.0 * np.pi * share))
    return scene


def leaning() -> kf.System:
    """Return two rods on springs that lean far under their weight and a force."""
    scene = kf.System(gravity=(0, 0, -9.81))
    carrier: object = scene.ground
    for i, stiffness in enumerate((4.0, 2.0)):
        hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=stiffness))
        at = (0.0, 0.0, 0.5 * i)
        carrier = scene.add_rigid_body(f"rod {i}", 1.0, 0.1, com=(0, 0, 0.25), joint=hinge, parent=carrier, at=at)
    scene.add_force(carrier, (1.5, 0, 0), point=(0, 0, 0.5))
    return scene


def test_the_path_leads_to_the_rest_that_newton_finds() -> None:
    model = leaning().freeze()
    found = kf.equilibrium(model)
    led = load_continuation.raised_to(model, 0.0, model.initial_coordinates)
    assert abs(found.q[0]) > 0.5
    assert led == pytest.approx(found.q, abs=1e-9)


def test_the_rest_at_the_end_of_a_path_is_kept_if_it_is_unstable() -> None:
    """A search for a stable one would lead a rod that nearly stands on its hinge to where it hangs."""
    scene = kf.System(gravity=(0, 0, -9.81))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(0, 0, 0.25), joint=kf.Revolute("y"))
    model = scene.freeze()
    near = np.array([1e-3])
    search = BalanceSearch(model, 0.0, near, np.zeros(1), np.zeros(0, dtype=int), ())
    assert search.polished()[0] == pytest.approx(0.0, abs=1e-9)
    assert search.iterations < 5
    assert abs(np.cos(search.run()[0]) + 1.0) < 1e-9


def test_a_path_that_ends_leads_nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    model = leaning().freeze()
    monkeypatch.setattr(load_continuation, "MOST_STOPS", 2)
    assert load_continuation.raised_to(model, 0.0, model.initial_coordinates) is None


def test_a_step_takes_one_stiffness(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    whole = loaded_scene.stiffness_of

    def counted(*given: object) -> object:
        found.append(given)
        return whole(*given)

    monkeypatch.setattr(loaded_scene, "stiffness_of", counted)
    path = kf.equilibrium_path(leaning(), down_to=0.0)
    assert path.is_whole
    assert len(found) <= 1.3 * len(path)  # of four before; the step to the end of the range is cut


@pytest.mark.slow
def test_a_beam_that_coils_by_a_turn_is_led_there() -> None:
    found = kf.equilibrium(coiled(0.1, bending=8))
    assert found.imbalance.ratio < 1e-9
    # its functions, of the eighth degree over a turn, are the larger error
    assert found.position("beam", "tip") == pytest.approx(TIP, abs=1e-3)


def test_what_nothing_holds_is_not_led(monkeypatch: pytest.MonkeyPatch) -> None:
    def walks(*_: object) -> None:
        raise AssertionError("there is no path to follow")

    monkeypatch.setattr(load_continuation, "Walk", walks)
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, joint=kf.Prismatic("x"))
    scene.add_force(body, (1.0, 0.0, 0.0))
    with pytest.raises(SimulationError, match=r"1 N along body: distance .* remains, and nothing holds it"):
        kf.equilibrium(scene)
