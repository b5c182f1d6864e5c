"""Bearings and coupled bushings: the routes, energy, tables over the speed, and bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.kane.assemble import accelerations
from kanefe.states.state import State


def coefficients(rng: np.random.Generator, drag: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return a stiffness that circulates, and a damping of which a skew part gives no power."""
    root, skew = rng.normal(size=(2, 6, 6))
    K, C = 30.0 * rng.normal(size=(6, 6)), 0.1 * root @ root.T
    if drag:
        for matrix in (K, C):
            kept = matrix[3, 3]
            matrix[3], matrix[:, 3] = 0.0, 0.0
        C[3, 3] = abs(kept)
    else:
        C += 0.1 * (skew - skew.T)
    return K, C


def rotor_in_a_house(kind: str) -> kf.System:
    """Return two free bodies that turn and move, held to each other."""
    rng = np.random.default_rng(5)
    scene = kf.System(gravity=(0, 0, -9.81))
    moving = {"position": (0.1, 0, 0.2), "velocity": (0.1, 0.2, 0.3), "angular_velocity": (0.3, 0.2, -0.1)}
    house = scene.add_rigid_body("house", 2.0, np.diag((0.1, 0.2, 0.15)), joint=kf.Free(**moving))
    spin = 1.0 if kind == "bushing" else 100.0
    turning = moving | {"position": (0.1, 0.01, 0.21), "angular_velocity": (spin, 0.2, 0.1)}
    joint = kf.Free(orientation=kf.rotation_about("y", 0.1), **turning)
    rotor = scene.add_rigid_body("rotor", 5.0, (0.02, 0.01, 0.01), joint=joint)
    if kind == "bushing":
        K, C = coefficients(rng, drag=False)
        scene.add_bushing("held", house, rotor, stiffness=K, damping=C)
    elif kind == "bearing":
        scene.add(kf.Bearing("held", (house, rotor), *coefficients(rng, drag=True)))
    else:
        tables = [np.array(rows) for rows in zip(*(coefficients(rng, drag=True) for _ in range(4)), strict=True)]
        scene.add(kf.Bearing("held", (house, rotor), *tables, speeds=(-50.0, 90.0, 110.0, 150.0)))
    return scene


@pytest.mark.parametrize("kind", ["bushing", "bearing", "table"])
def test_routes_agree_and_energy_is_kept(kind: str) -> None:
    scene = rotor_in_a_house(kind)
    model = scene.freeze()
    y = model.initial_state
    q, u, _ = model.parts(y)
    literal = accelerations(State(model, 0.0, q, u))
    np.testing.assert_allclose(model.rhs(0.0, y)[-len(u) :], literal, rtol=0, atol=1e-13 * np.abs(literal).max())
    energy = scene.simulate((0.0, 0.05), rtol=1e-9).energy
    moved = max(np.abs(energy.dissipated).max(), np.abs(energy.work).max())
    assert moved > 1e-3
    assert np.abs(energy.balance_error).max() < 1e-7 * moved  # some hundred steps at rtol 1e-9


def test_a_bearing_over_its_speed_is_that_of_the_table_there() -> None:
    """Of a table that is straight over the speed, the coefficients between its rows are straight too."""
    cross = np.array(((0.0, 1.0), (-1.0, 0.0)))
    speeds = np.array((0.0, 100.0, 300.0))
    table = kf.Bearing("t", ("a", "b"), [1e5 * np.eye(2) + 10.0 * s * cross for s in speeds], speeds=speeds)
    K, _ = table.coefficients(170.0)
    np.testing.assert_allclose(K[1:3, 1:3], 1e5 * np.eye(2) + 1700.0 * cross, rtol=1e-13)


def spinning(motion: kf.Motion | None, **options: Any) -> kf.System:
    scene = kf.System()
    slide = scene.add_frame("slide", joint=kf.Prismatic("y", position=1e-3))
    spin = kf.Revolute("x", motion=motion)
    rotor = scene.add_rigid_body("rotor", 2.0, (0.02, 0.01, 0.01), parent=slide, joint=spin)
    given = {"stiffness": 2 * [1e4 * np.eye(2)], "speeds": (0.0, 50.0)} | options
    scene.add(kf.Bearing("journal", (scene.ground, rotor), **given))
    return scene


def test_a_speed_outside_the_table_is_named() -> None:
    with pytest.raises(ModelError, match="bearing 'journal' reach from 0 to 50 rad/s, and it turns at 60 rad/s at"):
        spinning(kf.Motion.steady(60.0)).freeze()
    faster = kf.Motion(lambda t: 50.0 * t**2, lambda t: 100.0 * t, lambda t: 100.0)
    with pytest.warns(kf.SimulationWarning, match="turns at 50 rad/s at t = 0.5 s. Remedy: speeds="):
        result = spinning(faster).simulate((0.0, 1.0))
    assert result.times[-1] == pytest.approx(0.5)


def test_where_a_step_tries_speeds_outside_the_table_its_ends_hold() -> None:
    ends = [1e4 * np.eye(2), 3e4 * np.eye(2)]
    model = spinning(None, stiffness=ends).freeze()
    for speed, K in ((-20.0, ends[0]), (80.0, ends[1])):
        y = model.initial_state.copy()
        _, u, _ = model.parts(y)
        u[1] = speed
        # K x / m of the slide, which the rotor is 1e-3 m along with
        assert model.rhs(0.0, y)[-2] == pytest.approx(-K[0, 0] * 1e-3 / 2.0, rel=1e-13)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"stiffness": np.eye(3)}, r"stiffness of bearing 'b' must be finite numbers, shape \(2, 2\) or \(6, 6\)"),
        ({"stiffness": np.eye(2), "speeds": (0.0, 1.0)}, "for each of the 2 speeds, not"),
        ({"stiffness": np.eye(2), "speeds": (1.0, 1.0)}, "speeds of bearing 'b' must be two or more that ascend"),
        ({"stiffness": np.eye(6)}, "resists the turn about its axis x"),
        ({"damping": -np.eye(2)}, "damping of bearing 'b' drives"),
        ({}, "bearing 'b' does nothing"),
        ({"stiffness": np.eye(2), "axis": "q"}, "axis of bearing 'b' must be 'x', 'y' or 'z', not 'q'"),
        ({"stiffness": np.eye(2), "ends": ("a",)}, "ends of bearing 'b' must be"),
    ],
)
def test_what_is_wrong_with_a_bearing_is_named(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        kf.Bearing(**{"name": "b", "ends": ("a", "b"), "stiffness": np.zeros((2, 2)), **options})
