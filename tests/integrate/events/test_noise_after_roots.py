"""Below what a function has no sign after a root: what its values differ by there, not how far it jumps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.kernels.events.event_search import LIMITS, Within, noise_after, time_tolerance


def noise_of(function: Callable[[float], float]) -> float:
    return noise_after(lambda _, t: function(t), None, 0.5, Within(0.4, 0.6, 1.0), 8.0)


def test_a_slope_is_noise_and_a_jump_is_none() -> None:
    tolerance = time_tolerance(1.0, 0.5)
    assert noise_of(lambda t: 3.0 * (t - 0.5)) == pytest.approx(LIMITS.noise * 3.0 * tolerance, rel=1e-3)
    assert noise_of(lambda t: -8.0 if t < 0.5 else 5.0) == LIMITS.round_off * 8.0
    late = 0.5 + 0.5 * tolerance  # the place that was found is before the jump
    assert noise_of(lambda t: -8.0 if t < late else 5.0) == LIMITS.round_off * 8.0
    # what begins at zero behind the root: its first values
    assert noise_of(lambda t: -8.0 if t < 0.5 else t - 0.5) <= 1.001 * LIMITS.noise * tolerance


@pytest.mark.parametrize("width", [1.0, 5.5, 40.0])
def test_values_that_change_in_steps_have_a_step_as_their_noise(width: float) -> None:
    """What changes slowly beside its own size is the same number for many tolerances about its root."""
    tolerance, slope = time_tolerance(1.0, 0.5), 1.0
    step = width * tolerance * slope
    noise = noise_of(lambda t: step * np.floor(slope * (t - 0.5) / step))
    # it doubles its distance until two values differ: by two steps at most
    assert step <= noise <= 3.0 * LIMITS.noise * step


def test_a_block_that_has_bounced_is_seen_to_stick() -> None:
    """Its slip jumps at each touch by more than friction ever holds; it slides to rest afterwards."""
    scene = kf.System(gravity=(0, 0, -9.81))
    table = scene.add_surface("table", scene.ground, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, 0.12), velocity=(2.0, 0, 0))
    block = scene.add_rigid_body("block", 2.0, (0.02, 0.03, 0.04), joint=start)
    feet = [block.frame(at=(x, y, -0.1)) for x in (-0.15, 0.15) for y in (-0.1, 0.1)]
    scene.add_contact("feet", feet, table, normal=kf.HuntCrossley(2e5, damping=0.5), friction=kf.Coulomb(0.3))
    result = scene.simulate((0.0, 1.0), output_step=1e-3)
    status = np.array(result.contact("feet").status)
    last = np.flatnonzero(status != "sticks")[-1]
    assert result.events["feet stick"][-1] == pytest.approx(result.times[last + 1], abs=2e-3)
