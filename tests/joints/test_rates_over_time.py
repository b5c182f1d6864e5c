"""Functions of motion are held against their own rates all through a run."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.joints.rates_over_time import contradiction

Chain = tuple[Callable[[float], Any], Callable[[float], Any], Callable[[float], Any]]
TIMES = np.linspace(0.0, 1.0, 961)


def zero(t: float) -> float:
    return 0.0


def swing(w: float, size: float = 1.0) -> Chain:
    return (
        lambda t: size * math.sin(w * t),
        lambda t: size * w * math.cos(w * t),
        lambda t: -size * w * w * math.sin(w * t),
    )


def arm(motion: kf.Motion) -> kf.System:
    scene = kf.System(gravity=(0, -9.81, 0))
    crank = scene.add_rigid_body("crank", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z", motion=motion))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(0.5, 0, 0), parent=crank, at=(1, 0, 0), joint=kf.Revolute("z"))
    return scene


def deck(**functions: Any) -> kf.System:
    scene = kf.System()
    plate = scene.add_frame("deck", joint=kf.Spherical(motion=kf.PoseMotion(**functions)))
    scene.add_rigid_body("mast", 1.0, 0.1, parent=plate, at=(0, 0, 1), joint=kf.Revolute("y"))
    return scene


def rolling(turn: Callable[[float], float], rate: Callable[[float], float], second: Callable[[float], float]) -> Any:
    x = np.array((1.0, 0.0, 0.0))
    return {
        "orientation": lambda t: kf.rotation_about("x", turn(t)),
        "angular_velocity": lambda t: rate(t) * x,
        "angular_acceleration": lambda t: second(t) * x,
    }


@pytest.mark.parametrize(
    ("motion", "said"),
    [
        (kf.Motion(lambda t: 5.0 * max(t - 0.5, 0.0) ** 2, zero, zero), "position changes by .* its velocity is 0"),
        (kf.Motion(lambda t: float(t > 0.5), zero, zero), r"t = 0\.5 s its position jumps by 1, .* velocity is 0"),
        (
            kf.Motion(lambda t: max(t - 0.3, 0.0), lambda t: float(t > 0.3), zero),
            r"t = 0\.3 s its velocity jumps by 1, where its acceleration is 0: a speed takes time to change",
        ),
        (
            kf.Motion(*swing(3.0)[:2], lambda t: -9 * math.sin(3 * t) * (1 + (t > 0.7))),
            "velocity changes by .* where its acceleration is",
        ),
        (
            kf.Motion(swing(9.0)[0], lambda t: 9 * math.cos(9 * t) * (57.3 if t > 0.5 else 1.0), swing(9.0)[2]),
            "position changes by .* where its velocity is",
        ),
        (kf.Motion(lambda t: 1.0 if t > 0.5 else 0.0, zero, zero).compiled(), "position jumps by 1"),
    ],
)  # fmt: skip
def test_rates_that_do_not_fit_later_are_refused_before_the_run(motion: kf.Motion, said: str) -> None:
    scene = arm(motion)
    with pytest.raises(kf.ModelError, match=rf"motion of body 'crank': at .*{said}.*Remedy: .*Motion\.table"):
        scene.simulate((0.0, 1.0))
    with pytest.raises(kf.ModelError, match=said):
        scene.simulate((0.0, 1.0), method="generalised-alpha", step=0.01)


def test_a_contradiction_after_the_run_does_not_matter() -> None:
    result = arm(kf.Motion(lambda t: 5.0 * max(t - 0.5, 0.0) ** 2, zero, zero)).simulate((0.0, 0.5))
    assert result.status.is_finished


@pytest.mark.parametrize(
    ("functions", "said"),
    [
        (swing(0.6, 0.1), None),
        ((swing(0.6, 0.1)[0], lambda t: (57.3 if t > 5.0 else 1.0) * 0.06 * math.cos(0.6 * t), swing(0.6, 0.1)[2]),
         "orientation changes by .* where its angular velocity is"),
        ((lambda t: 0.2 * (t > 7.0), zero, zero), r"t = 7 s its orientation jumps by \[0.198669"),
        ((*swing(0.6, 0.1)[:2], lambda t: (-1.0 if t > 5.0 else 1.0) * -0.036 * math.sin(0.6 * t)),
         "angular velocity changes by .* where its angular acceleration is"),
    ],
)  # fmt: skip
def test_poses_are_held_against_their_rates(functions: Chain, said: str | None) -> None:
    scene = deck(**rolling(*functions))
    if said is None:
        assert scene.simulate((0.0, 10.0), rtol=1e-3).status.is_finished
    else:
        with pytest.raises(kf.ModelError, match=f"motion of body 'deck': at .*{said}"):
            scene.simulate((0.0, 10.0))


def test_motions_without_fault_raise_no_alarm_and_wrong_rates_are_found() -> None:
    rng = np.random.default_rng(0)
    for _ in range(60):
        span, start = 10.0 ** rng.uniform(-2, 4), rng.choice((0.0, 50.0))
        w, size = (
            10.0 ** rng.uniform(-0.5, 5) / span,
            10.0 ** rng.uniform(-3, 3),
        )  # up to 16 periods from sample to sample
        times = np.linspace(start, start + span, 961)
        x, v, a = swing(w, size)
        assert contradiction((x, v, a), times) is None
        # at any frequency: rates are also compared within intervals far shorter than the samples
        assert contradiction((x, lambda t, v=v: 1.1 * v(t), a), times) is not None
        assert contradiction((x, v, lambda t, a=a: 1.1 * a(t)), times) is not None
        if w * span < 60.0:  # ten periods; a tenth of the amplitude
            jump = start + rng.uniform() * span
            found = contradiction((lambda t, x=x, j=jump, s=size: x(t) + 0.1 * s * (t > j), v, a), times)
            # 1e-6 of the span: it is followed down to a hundred thousandth of the distance of the samples
            assert found is not None
            assert found.is_jump
            assert found.time == pytest.approx(jump, abs=1e-6 * span)


def test_vibrations_sampled_at_one_phase_raise_no_alarm() -> None:
    for periods in (1, 8, 40):  # from one sample to the next
        assert contradiction(swing(2.0 * math.pi * 960.0 * periods), TIMES) is None


def profile(t: float, middle: float, w: float) -> tuple[float, float, float]:
    """Return a step by constant acceleration over a time w and back over another: its acceleration jumps."""
    s = t - middle + w
    if s <= 0.0:
        return 0.0, 0.0, 0.0
    if s < w:
        return 0.5 * s * s, s, 1.0
    return (w * w - 0.5 * (2 * w - s) ** 2, 2 * w - s, -1.0) if s < 2 * w else (w * w, 0.0, 0.0)


@pytest.mark.parametrize("w", [0.2, 0.01, 1e-3, 1e-4, 1e-5, 1e-6])
def test_accelerations_may_jump_and_pulses_may_be_shorter_than_a_sample(w: float) -> None:
    functions = tuple(lambda t, i=i: profile(t, 0.51234, w)[i] for i in range(3))
    assert contradiction(functions, TIMES) is None  # type: ignore[arg-type]


def test_polynomials_tables_and_smooth_steps_raise_no_alarm() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        p = np.polynomial.Polynomial(rng.normal(size=rng.integers(1, 9)))
        assert contradiction((p, p.deriv(), p.deriv(2)), TIMES) is None
        table = kf.Motion.table(np.linspace(0.0, 1.0, 40), np.cumsum(rng.normal(size=40)))
        assert contradiction((table.position, table.velocity, table.acceleration), TIMES) is None  # type: ignore[arg-type]
        k, m = 10.0 ** rng.uniform(0, 4), rng.uniform()
        th = lambda t, k=k, m=m: math.tanh(k * (t - m))  # noqa: E731
        chain = (
            th,
            lambda t, k=k, th=th: k * (1 - th(t) ** 2),
            lambda t, k=k, th=th: -2 * k * k * th(t) * (1 - th(t) ** 2),
        )
        assert contradiction(chain, TIMES) is None


def test_what_fails_or_is_no_number_later_is_left_to_the_run() -> None:
    for later in (math.nan, "x", None, [1.0, 2.0]):
        bad: Callable[[float], Any] = lambda t, later=later: later if t > 0.5 else 0.0  # noqa: E731
        assert contradiction((bad, zero, zero), TIMES) is None
        assert contradiction((zero, zero, bad), TIMES) is None
    assert contradiction((lambda t: 1.0 / (0.5 - t) if t > 0.499 and t == 0.5 else 0.0, zero, zero), TIMES) is None


def test_the_look_costs_a_third_of_the_samples_that_are_taken_anyway() -> None:
    counts = [0, 0, 0]

    def counted(i: int, function: Callable[[float], float]) -> Callable[[float], float]:
        def call(t: float) -> float:
            counts[i] += 1
            return function(t)

        return call

    functions = [counted(i, f) for i, f in enumerate(swing(3.0))]
    scene = arm(kf.Motion(*functions))
    scene.simulate((0.0, 1.0))
    one_run = list(counts)
    model, counts[:] = scene.freeze(0.0), [0, 0, 0]
    from kanefe.integrate.set_up import check_motions

    check_motions(model, 0.0, 1.0)
    # the accelerations are those of 961 samples, which the run's breakpoints are found by and which are not taken again
    assert counts[2] <= 961 + 40
    assert sum(counts[:2]) <= 2 * 121 + 120
    assert one_run[2] < 2 * 961


def test_tables_whose_spline_swings_out_beside_a_step_are_refused() -> None:
    times, step = [0.0, 0.3, 0.5, 0.5 + 1e-9, 0.7, 1.0], [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    for make in (
        lambda: kf.Motion.table(times, step),
        lambda: kf.PoseTable(times, np.outer(step, (1.0, 0.0, 0.0))),
        lambda: kf.Motion.table(times, 1e200 * np.array(step)),
    ):
        with pytest.raises(kf.ModelError, match=r"overshoots to .*they change by 1(e\+200)? in 1e-09 s from 0\.5 s on"):
            make()
    even = np.linspace(0.0, 1.0, 11)
    assert kf.Motion.table(even, (even > 0.5) * 1.0).position(0.45) == pytest.approx(-0.1, abs=0.05)
    kf.Motion.table(even, np.full(11, 3.0))
