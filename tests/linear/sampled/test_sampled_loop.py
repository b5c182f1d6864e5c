"""Sampled loops: poles against matrices written out, several rates and responses against runs, and bad input."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.linalg

import kanefe as kf
from kanefe.errors import ModelError

STIFFNESS, DAMPING, MASS = 50.0, 0.3, 2.0
A = np.array(((0.0, 1.0), (-STIFFNESS / MASS, -DAMPING / MASS)))
B = np.array(((0.0,), (1.0 / MASS,)))


def cart(speed: float = 0.0) -> kf.System:
    scene = kf.System()
    spring = kf.CoordinateForce(STIFFNESS, damping=DAMPING)
    scene.add_rigid_body("cart", MASS, joint=kf.Prismatic("x", speed=speed, forces=spring))
    return scene


def with_pid(every: float, delay: float, kp: float = 20.0, kd: float = 4.0, ki: float = 10.0) -> kf.System:
    def law(t: float, reads: np.ndarray, memory: dict[str, Any]) -> float:
        memory["sum"] = memory.get("sum", 0.0) + ki * every * reads[0]
        memory["calls"] = memory.get("calls", 0) + 1  # counts, and drives nothing
        return float(-kp * reads[0] - kd * reads[1] - memory["sum"])

    scene = cart()
    reads = ("joint_coordinates cart", "joint_speeds cart")
    scene.add_controller("pid", law, every=every, reads=reads, drives="motor cart", delay=delay)
    return scene


def held(dt: float) -> tuple[np.ndarray, np.ndarray]:
    E = scipy.linalg.expm(np.block([[A, B], [np.zeros((1, 3))]]) * dt)
    return E[:2, :2], E[:2, 2:]


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.05, 0.12])
def test_poles_of_a_pid_loop_with_a_delay_are_those_of_its_matrix(delay: float) -> None:
    every, kp, kd, ki = 0.05, 20.0, 4.0, 10.0
    whole = math.floor(delay / every + 1e-12)
    (F_1, G_1), (F_2, G_2) = held(delay - whole * every), held(every - delay + whole * every)
    # position, speed, sum, and the drives of the last samples
    size = 4 + whole
    now = np.zeros(size)
    now[:3] = -kp - ki * every, -kd, -1.0
    drives = [now, *np.eye(size)[3:]]
    Z = np.zeros((size, size))
    Z[:2, :2] = F_2 @ F_1
    Z[:2] += F_2 @ G_1 @ drives[whole + 1][None] + G_2 @ drives[whole][None]
    Z[2, (0, 2)] = ki * every, 1.0
    Z[3:] = drives[: whole + 1]
    loop = kf.sampled_loop(with_pid(every, delay))
    found, expected = (np.sort_complex(z[np.abs(z) > 1e-9]) for z in (loop.poles, np.linalg.eigvals(Z)))
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert loop.is_stable
    assert "[Hz]" in str(loop)


def two_rates(gain: float) -> kf.System:
    """Return a cart with a fast brake, a slow hold that is late, and a filter of an acceleration."""
    scene = cart(speed=1e-3)

    def filtered(t: float, reads: np.ndarray, memory: dict[str, Any]) -> float:
        memory["past"] = [*memory.get("past", [0.0, 0.0])[1:], float(reads[0])]
        return -0.3 * sum(memory["past"])

    scene.add_controller(
        "brake", lambda t, r, m: -2.0 * r[0], every=0.02, reads="joint_speeds cart", drives="motor cart"
    )
    position = "position cart x"
    scene.add_controller(
        "hold", lambda t, r, m: -gain * r[0], every=0.05, reads=position, drives="force cart x", delay=0.03
    )
    scene.add_controller("feel", filtered, every=0.1, reads="acceleration cart x", drives="motor cart")
    return scene


@pytest.mark.parametrize("gain", [30.0, 150.0])
def test_several_rates_decay_or_grow_as_a_run_does(gain: float) -> None:
    loop = kf.sampled_loop(two_rates(gain), start=np.zeros(2))
    assert loop.period == pytest.approx(0.1)
    result = two_rates(gain).simulate((0.0, 6.0), rtol=1e-10, output_step=0.1, atol=1e-14)
    x = result.joint_coordinates("cart")[-20:, 0]
    # what is left in the end is one pair of poles: x_k+2 = 2 Re(z) x_k+1 - |z|^2 x_k
    sums, product = np.linalg.lstsq(np.column_stack((x[1:-1], -x[:-2])), x[2:], rcond=None)[0]
    largest = np.abs(loop.poles[0])
    assert np.sqrt(product) == pytest.approx(largest, rel=1e-4)  # of the next pair, after 40 periods
    assert sums == pytest.approx(2.0 * loop.poles[0].real, abs=1e-3)
    assert loop.is_stable == (gain < 100.0) == (largest < 1.0)


def test_the_response_of_a_sampled_loop_is_that_of_a_run() -> None:
    """The mean of x exp(-2 pi i f t) over many periods of both, once what the start brings has decayed."""
    f, force = 0.8, 0.5
    scene = two_rates(30.0)
    loop = kf.sampled_loop(
        scene, start=np.zeros(2), inputs="force cart x", outputs=("position cart x", "acceleration cart x")
    )
    response = loop.frequency_response([f])
    scene = scene.copy()
    scene.add_force(scene.body("cart"), lambda t: (force * math.sin(2.0 * math.pi * f * t), 0.0, 0.0))
    span = 5.0  # four periods of the force, fifty of the loop
    result = scene.simulate((0.0, 60.0 + span), rtol=1e-9, output_step=0.002)
    late = result.times >= 60.0 - 1e-9
    t, x = result.times[late], result.position("cart")[late, 0]
    amplitude = 2.0 * np.mean((x * np.exp(-2j * np.pi * f * t))[:-1]) / (force / 1j)
    assert response.receptance("position cart x", "force cart x")[0] == pytest.approx(amplitude, rel=1e-4)
    ratio = response.transmissibility("acceleration cart x", "position cart x")[0]
    assert ratio == pytest.approx(-((2.0 * np.pi * f) ** 2), rel=1e-9)


def test_python_control_gets_the_loop() -> None:
    pytest.importorskip("control")
    loop = kf.sampled_loop(with_pid(0.05, 0.02), outputs="position cart x")
    system = loop.to_control()
    assert system.dt == pytest.approx(0.05)
    np.testing.assert_allclose(np.sort_complex(system.poles()), np.sort_complex(loop.poles), atol=1e-9)


def controlled(function: Any, **options: Any) -> kf.System:
    scene = cart()
    given = {"every": 0.01, "reads": "joint_speeds cart", "drives": "motor cart"} | options
    scene.add_controller("law", function, **given)
    return scene


def forgetful() -> Any:
    past = [0.0]

    def law(t: float, reads: np.ndarray, memory: dict[str, Any]) -> float:
        past[0] += 1.0
        return past[0]

    return law


def unlike() -> kf.System:
    scene = controlled(lambda t, r, m: -r[0])
    other = 0.01 * math.sqrt(2.0)
    scene.add_controller("other", lambda t, r, m: -r[0], every=other, reads="joint_speeds cart", drives="motor cart")
    return scene


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (cart, "has no controllers. Remedy: add_controller"),
        (unlike, "'law' .every 0.01 s. and 'other' .* have no common multiple"),
        (lambda: controlled(forgetful()), "keeps something outside of its memory"),
        (lambda: controlled(lambda t, r, m: m.setdefault("filter", object()) and 0.0), "remembers 'filter', a object"),
        (
            lambda: controlled(lambda t, r, m: m.update({str(len(m)): 1.0}) or 0.0),
            "changes its shape from call",
        ),
    ],
)
def test_what_has_no_poles_is_named(build: Any, words: str) -> None:
    with pytest.raises(ModelError, match=words):
        kf.sampled_loop(build())


def test_a_loop_that_grows_has_no_response() -> None:
    loop = kf.sampled_loop(two_rates(150.0), start=np.zeros(2), inputs="force cart x", outputs="position cart x")
    with pytest.raises(ModelError, match="the loop is not stable, it grows by"):
        loop.frequency_response([1.0])
