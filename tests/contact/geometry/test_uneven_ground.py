"""Balls and tyres on fields of heights: nearest places, lowest places of rings, and the energy that they keep."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq, minimize, minimize_scalar

import kanefe as kf
from kanefe import shapes

GRID = np.linspace(-8.0, 8.0, 65)
HILLS = 0.1 * np.sin(1.2 * GRID)[:, None] + 0.05 * np.cos(0.9 * GRID)
FIELD = shapes.HeightField(GRID, GRID, HILLS)


def height(a: float, b: float) -> float:
    """Return the height of the field, from where a point of no radius is on it."""
    return float(brentq(lambda c: FIELD.distance((a, b, c))[0], -1.0, 1.0, xtol=1e-15))


@pytest.mark.parametrize("above", [-0.3, 0.0, 0.4, 1.0])
def test_the_distance_is_that_of_the_nearest_place(above):
    generator = np.random.default_rng(4)
    for a, b in generator.uniform(-3.0, 3.0, (4, 2)):
        place = np.array((a, b, height(a, b) + above))
        found = minimize(
            lambda p, x=place: float(np.sum((x - (*p, height(*p))) ** 2)), (a, b), method="Nelder-Mead", tol=1e-12
        )
        distance, normal = FIELD.distance(place)
        assert abs(distance) == pytest.approx(np.sqrt(found.fun), abs=1e-9)
        assert FIELD.distance(place - distance * normal)[0] == pytest.approx(0.0, abs=1e-12)


def rolling(shape: shapes.SurfaceShape, friction: kf.Coulomb | None) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    ground = scene.add_surface("ground", scene.ground, FIELD)
    joint = kf.Free(position=(0, 0.1, 0.45), velocity=(2.0, 0, 0), angular_velocity=(0, 2.0 / 0.35, 0))
    body = scene.add_rigid_body("body", 20.0, (0.6, 1.0, 0.6), joint=joint)
    skin = scene.add_surface("skin", body, shape)
    scene.add_contact("rolls", skin, ground, normal=kf.HuntCrossley(2e5, damping=0.5), friction=friction)
    return scene


@pytest.mark.parametrize("friction", [None, kf.Coulomb(0.6)])
@pytest.mark.parametrize("shape", [shapes.Sphere(0.35), shapes.Torus(0.3, 0.05, "y"), shapes.Capsule(0.35, 0.3, "y")])
def test_what_rolls_over_hills_keeps_its_energy(shape, friction):
    """The normal is the gradient of the distance: by the tangent plane below 7e-3 of what moved went astray."""
    result = rolling(shape, friction).simulate((0.0, 1.0), rtol=1e-8, output_step=0.1)
    energy = result.energy
    # dop853, of order 8, steps over kinks of the curvature
    assert abs(energy.balance_error[-1]) < 1e-5 * np.ptp(energy.kinetic)


def test_the_lowest_place_of_a_ring_is_the_nearest():
    tyre = shapes.Torus(0.6, 0.1, (0.1, 1.0, 0.2))
    scene = rolling(tyre, None)
    model = scene.freeze()
    axes = np.linalg.svd(tyre.axis[None])[2][1:]
    for x in np.linspace(-2.0, 2.0, 9):
        state = model.initial_state.copy()
        state[:3] = x, 0.3, 0.6
        touch = model.loads[0].touches(*in_state(model, state))[0]

        def gap(angle: float, middle: np.ndarray = state[:3]) -> float:
            place = middle + 0.6 * (np.cos(angle) * axes[0] + np.sin(angle) * axes[1])
            return FIELD.distance(place)[0] - 0.1

        angles = np.linspace(0.0, 2.0 * np.pi, 101)
        best = angles[np.argmin([gap(angle) for angle in angles])]
        found = minimize_scalar(gap, bracket=(best - 0.07, best, best + 0.07), tol=1e-10)
        assert touch.depth == pytest.approx(-found.fun, abs=1e-12)


def in_state(model: kf.Model, y: np.ndarray) -> tuple[object, np.ndarray]:
    state = model.route.state(0.0, y)
    return state.load_ends(0), state.load_states(0)


@pytest.mark.parametrize(
    ("shape", "inertia"), [(shapes.Sphere(0.2), 0.016), (shapes.Torus(0.15, 0.05, "y"), 0.03)], ids=["ball", "tyre"]
)
def test_what_rolls_in_a_trough_swings_as_its_middle_does_on_a_parallel_curve(shape, inertia):
    """``w^2 = g / ((R - r) (1 + I / m r^2))`` in a trough of radius R; heights of second order are kept exactly."""
    grid, radius, r = np.linspace(-1.0, 1.0, 41), 1.0, 0.2
    trough = shapes.HeightField(grid, grid, np.repeat(0.5 / radius * grid[:, None] ** 2, 41, axis=1))
    scene = kf.System(gravity=(0, 0, -9.81))
    ground = scene.add_surface("ground", scene.ground, trough)
    body = scene.add_rigid_body("body", 1.0, inertia, joint=kf.Free(position=(0.016, 0, r + 0.0002)))
    law, rough = kf.HuntCrossley(1e6, damping=1.0), kf.Coulomb(1.0, stiffness=1e6, damping=1e3)
    scene.add_contact("rolls", scene.add_surface("skin", body, shape), ground, normal=law, friction=rough)
    found = 2.0 * np.pi * kf.equilibrium(scene).linearise().modes().frequencies
    wanted = np.sqrt(9.81 / ((radius - r) * (1.0 + inertia / r**2)))
    # the contact yields by 1e-5 m, of 0.8
    assert found[np.argmin(np.abs(found - wanted))] == pytest.approx(wanted, rel=3e-5)


def test_valleys_that_are_too_narrow_are_told_of():
    narrow = shapes.HeightField(GRID, GRID, 0.3 * np.sin(3.0 * GRID)[:, None] + 0.0 * GRID)
    assert 0.3 < narrow.narrowest < 0.5  # 1 / (0.3 * 3^2) = 0.37 by the sine itself
    scene = kf.System()
    ground = scene.add_surface("ground", scene.ground, narrow)
    body = scene.add_rigid_body("body", 1.0, 1.0, joint=kf.Free(position=(0, 0, 3.0)))
    wheel = scene.add_surface("wheel", body, shapes.Torus(0.5, 0.1))
    with pytest.warns(kf.AccuracyWarning, match=r"valleys of the height field have a radius of 0\.\d+ m.*of 0\.6 m"):
        scene.add_contact("c", wheel, ground, normal=kf.HuntCrossley(1e5))
