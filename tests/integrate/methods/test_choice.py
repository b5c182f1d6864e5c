"""What method="auto" takes of the methods for stiff scenes: where vibrations are followed, and where stepped over."""

from __future__ import annotations

import pytest

import kanefe as kf
from kanefe.integrate.choice import choose
from kanefe.integrate.options import RunOptions
from steel_beams import steel_bar

SLOWEST = 92.8
"""Frequency in Hz of the bar clamped at its root: 1.875^2 / (2 pi L^2) sqrt(E I / (rho A)), of 0.3 m by 1 cm."""


def bar(gravity: float) -> kf.Model:
    """Return a bar on a hinge, straight at the start: gravity is what bends it."""
    return steel_bar(0.02, 0.01, gravity=gravity, reduction=kf.CraigBampton(modes=10)).freeze()


@pytest.mark.parametrize(
    ("gravity", "periods", "rtol", "name", "reason"),
    [
        (9.81, 100.0, 1e-4, "extrapolation", "stiff over"),
        # g / w^2 of some 3e-5 m, a ten-thousandth of the length
        (9.81, 100.0, 1e-6, "radau5", "and vibrate by more than rtol=1e-06 at the start"),
        (0.0981, 100.0, 1e-6, "extrapolation", "stiff over"),
        (0.0, 100.0, 2e-7, "extrapolation", "stiff over"),
        (0.0, 100.0, 5e-8, "radau5", "and rtol=5e-08 follows their vibrations"),
        (0.0, 20.0, 1e-6, "radau5", "and the slowest, of 92.8 Hz, is followed"),
        (0.0, 20.0, 1e-4, "extrapolation", "stiff over"),
    ],
)
def test_vibrations_that_the_tolerance_asks_for_are_followed(
    gravity: float, periods: float, rtol: float, name: str, reason: str
) -> None:
    choice = choose(bar(gravity), RunOptions(t_span=(0.0, periods / SLOWEST), rtol=rtol))
    assert choice.name == name
    assert reason in choice.reason
