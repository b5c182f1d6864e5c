"""Warnings about the start of a contact."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

from kanefe.errors import SimulationWarning, outside

if TYPE_CHECKING:
    from kanefe.contact.geometry.shape import Probe
    from kanefe.contact.touching_point import Touch
    from kanefe.loads.action import End

DEEP = 1e-3
"""Initial depth for which a warning is issued, m: contacts at rest on anything but tyres and rubber are less deep."""

FLAT = 1.0 - 1e-8
"""Cosine of the angle between the axis of a rim and the normal from which the rim lies flat: 1.4e-4 rad."""


def warn_of_start(
    name: str, probes: Sequence[tuple[int, Probe]], ends: Sequence[End], touches: Sequence[Touch]
) -> None:
    """Warn of what begins deep in its surface, and of rims that lie flat on it."""
    deepest = max(touches, key=lambda touch: touch.depth)
    if deepest.depth > DEEP:
        warnings.warn(
            f"contact {name!r} begins {deepest.depth:.3g} m deep in its surface, with {deepest.normal_force:.3g} N: "
            "unless this force is balanced, the body will be thrown out. Remedy: place it outside, or start from "
            "kf.equilibrium",
            SimulationWarning,
            stacklevel=outside(),
        )
    for (end, probe), touch in zip(probes, touches, strict=True):
        if probe.ring > 0.0 and abs(ends[end].A @ probe.axis @ touch.normal) > FLAT:
            warnings.warn(
                f"contact {name!r} starts with a rim that lies flat, of which no point is the lowest: it "
                "will rock, and be slow. Remedy: points instead of its shape, shape.sampled(spacing)",
                SimulationWarning,
                stacklevel=outside(),
            )
            return
