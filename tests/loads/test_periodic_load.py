"""Loads of a rotor's hub: mean and harmonics along the axes of their frame."""

import numpy as np
import pytest

import kanefe as kf

MEAN = (10.0, -20.0, 500.0, 3.0, 4.0, -80.0)
SHAKES = {1: ((1, 2, 3, 4, 5, 6), (6, 5, 4, 3, 2, 1)), 4: ((0, 0, 40, 0, 0, 5), (7, 0, 0, 0, 9, 0))}


def hub(**options):
    scene = kf.System(gravity=(0, 0, -9.81))
    body = scene.add_rigid_body("body", 50.0, (4.0, 6.0, 7.0), joint=kf.Free())
    axes = kf.rotation_about("x", 0.2)
    scene.add(kf.PeriodicLoad("rotor", body.frame(at=(0, 0, 1), orientation=axes), 30.0, MEAN, SHAKES, **options))
    return scene


@pytest.mark.parametrize("options", [{}, {"azimuth": 0.4, "share": ((0.1, 0.3, 1.0), (1.0, 0.2, 0.0))}])
def test_routes_agree_to_round_off(options):
    model = hub(**options).freeze()
    random = np.random.default_rng(7)
    for t in (0.0, 0.123, 0.5, 3.0):
        q = random.normal(size=7)
        q[3:] /= np.linalg.norm(q[3:])
        y = np.concatenate((q, random.normal(size=6), np.zeros(2)))
        np.testing.assert_allclose(
            model.route.evaluate(t, y).rates, model.literal.evaluate(t, y).rates, rtol=1e-11, atol=1e-11
        )


def test_response_of_a_mass_on_a_spring_is_the_closed_form():
    """F cos(n psi) on m, k, c: amplitude and phase by the transfer function, after the start has died away."""
    m, k, c, rate, force = 100.0, 4e4, 2e3, 9.0, 50.0
    scene = kf.System()
    spring = kf.CoordinateForce(stiffness=k, damping=c)
    block = scene.add_point("block", m, joint=kf.Prismatic("z", forces=spring))
    scene.add(kf.PeriodicLoad("rotor", block, rate, np.zeros(6), {2: ((0, 0, force, 0, 0, 0), np.zeros(6))}))
    result = scene.simulate((0.0, 6.0), rtol=1e-9, output_step=0.01)
    w, late = 2.0 * rate, result.times > 4.0
    wanted = (force / (k - m * w**2 + 1j * c * w) * np.exp(1j * w * result.times)).real
    np.testing.assert_allclose(result.position("block")[late, 2], wanted[late], atol=1e-9)
    assert abs(result.energy.balance_error).max() < 1e-7
    assert result.statistics["route"] != "literal"


def test_it_turns_with_what_carries_it_and_fades():
    told = hub(share=((0.0, 1.0), (1.0, 0.0))).simulate((0.0, 1.0), output_step=0.25).load("rotor")
    t = np.linspace(0.0, 1.0, 5)
    fz = MEAN[2] + 3 * np.cos(30 * t) + 4 * np.sin(30 * t) + 40 * np.cos(120 * t)
    np.testing.assert_allclose(told[:, 2], (1.0 - t) * fz, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rate": "fast"}, "rate of periodic load 'r'"),
        ({"mean": (1, 2, 3)}, "mean of periodic load"),
        ({"harmonics": {0.5: (MEAN, MEAN)}}, "whole numbers per turn"),
        ({"harmonics": [1, 2]}, "mapping"),
        ({"harmonics": {1: MEAN}}, "harmonic 1"),
        ({"share": ((1, 0), (0, 1))}, "share of periodic load.*times rising"),
    ],
)
def test_bad_input_is_named(change, message):
    with pytest.raises(kf.ModelError, match=message):
        kf.PeriodicLoad("r", kf.System().ground, **{"rate": 1.0, "mean": MEAN, **change})
