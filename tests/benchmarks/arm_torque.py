"""The controller of the arm, the same on both sides: it is run by both Pythons."""

from __future__ import annotations

from collections.abc import Mapping


def torque(t: float, link: Mapping[str, float], seconds: float, angle: float, rate: float) -> float:
    """Return what drives a joint towards where it should be: a quintic from its start to its end."""
    s = min(t / seconds, 1.0)
    way = link["to"] - link["angle"]
    wanted = link["angle"] + way * s**3 * (10 - 15 * s + 6 * s * s)
    speed = way * 30 * s * s * (1 - s) ** 2 / seconds
    return float(link["kp"] * (wanted - angle) + link["kd"] * (speed - rate))
