"""Derivatives where functions in Python look at the state: those of the law, by calls along what is read alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.dynamics import Dynamics
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

STIFFNESS, DAMPING = 30.0, 0.7  # N m/rad, N m s/rad
LINKS = 6

Law = Callable[[float, Any], Any]


def chain(law: Law | None = None, forces: kf.CoordinateForce | None = None) -> kf.System:
    """Return links on hinges whose third has a motor or a spring, and a beam at the end."""
    scene, parent = kf.System(gravity=(0, 0, -9.81)), None
    for i in range(LINKS):
        joint = kf.Revolute("y", position=0.1 * i, forces=forces if i == 2 else None)
        options = {} if parent is None else {"parent": parent, "at": (0.3, 0, 0)}
        parent = scene.add_rigid_body(f"link {i}", 1.0, 0.02, com=(0.15, 0, 0), joint=joint, **options)
    line = straight_beam(0.5, Rectangle(0.01, 0.02), Material(E=70e9, nu=0.3, rho=2700.0), elements=4)
    body = beam_body(line, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=3))
    scene.add_flexible_body("beam", body, parent=parent, at=(0.3, 0, 0))
    if law is not None:
        scene.add_motor(scene.body("link 2"), law)
    return scene


def moving(model: Model) -> tuple[Dynamics, np.ndarray]:
    """Return a state in motion, whose rates are known."""
    dynamics = Dynamics(model)
    y = dynamics.initial_state(0.0)
    rng = np.random.default_rng(1)
    y[model.coordinate_count :][: model.free_count] = 0.1 * rng.standard_normal(model.free_count)
    dynamics.rate(0.2, y)
    return dynamics, y


def by_joint(t: float, state: Any) -> float:
    return float(-STIFFNESS * state.joint_coordinates("link 2")[0] - DAMPING * state.joint_speeds("link 2")[0])


def by_place(t: float, state: Any) -> float:
    return float(state.position("beam", "tip")[2] * state.velocity("link 3")[0])


def by_modes(t: float, state: Any) -> float:
    return float(1e4 * state.modal_coordinates("beam")[0] + 3.0 * state.modal_speeds("beam")[1])


def by_either(t: float, state: Any) -> float:
    """What is read depends on what was read."""
    first = state.joint_coordinates("link 0")[0]
    return float(state.joint_speeds("link 5")[0] if first < 1.0 else state.vector[0])


def by_vector(t: float, state: Any) -> float:
    return float(state.vector @ np.arange(len(state.vector)))


def test_of_a_linear_law_they_are_those_of_a_spring_and_damper() -> None:
    """Differences of a linear function are exact to their round-off, 1e-16 over their reach of some 1e-6."""
    spring = kf.CoordinateForce(stiffness=STIFFNESS, damping=DAMPING)
    (ours, y), (wanted, _) = (moving(scene.freeze()) for scene in (chain(by_joint), chain(forces=spring)))
    expected = wanted.tangent_derivatives(0.2, y)[:-2]  # of the books of energy, a motor takes what a spring keeps
    found = ours.tangent_derivatives(0.2, y)[:-2]
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("law", [by_joint, by_place, by_modes, by_either, by_vector])
def test_they_are_those_of_the_rates(law: Law, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against differences of all, whose round-off is that of rates of 1e6 over their reach."""
    model = chain(law).freeze()
    dynamics, y = moving(model)
    found = dynamics.tangent_derivatives(0.2, y), dynamics.jacobian(0.2, y)
    monkeypatch.setattr(type(model.route), "derivatives", lambda *given: None)
    for one, wanted in zip(found, (dynamics.tangent_derivatives(0.2, y), dynamics.jacobian(0.2, y)), strict=True):
        assert np.abs(wanted).max() > 0.0
        scale = np.abs(wanted).max(axis=0) + 1e-3 * np.abs(wanted).max()
        assert (np.abs(one - wanted) / scale).max() < 2e-6


@pytest.mark.parametrize(("law", "read"), [(by_joint, 2), (by_modes, 2), (by_either, 2), (by_vector, None)])
def test_a_function_is_called_along_what_it_reads(law: Law, read: int | None) -> None:
    calls = []

    def counted(t: float, state: Any) -> float:
        calls.append(t)
        return float(law(t, state))

    model = chain(counted).freeze()
    dynamics, y = moving(model)
    foreseen = dynamics.calls_for_jacobian(0.0)
    calls.clear()
    dynamics.tangent_derivatives(0.2, y)
    entries = 2 * model.free_count if read is None else read
    if law is by_modes:
        entries = 2 * model.flexible_terms("beam").body.free_count
    assert len(calls) == foreseen == 2 + 2 * entries  # once for the rates, and once to see what it reads


def test_what_controllers_hold_is_an_entry_like_others() -> None:
    scene = chain(by_joint)
    reads = ("joint_coordinates link 0",)
    scene.add_controller("hold", lambda t, reads, memory: 0.0, every=0.1, reads=reads, drives="motor link 4")
    model = scene.freeze()
    dynamics, y = moving(model)
    held = model.coordinate_count + model.free_count
    column = dynamics.jacobian(0.2, y)[:, held]
    step = np.zeros(len(y))
    step[held] = 0.5
    wanted = dynamics.rate(0.2, y + step) - dynamics.rate(0.2, y - step)  # rates are linear in it
    assert np.abs(wanted).max() > 0.1
    np.testing.assert_allclose(column, wanted, atol=1e-9 * np.abs(wanted).max())
