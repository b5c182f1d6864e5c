"""Cases of sampled controllers: poles of the sampled loop, its stability limit, and a run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.joints import Prismatic
from kanefe.linear.sampled.sampled_loop import sampled_loop
from kanefe.system import System

MASS, EVERY, STIFFNESS = 2.0, 0.05, 80.0
"""Mass, kg; sampling interval, s; stiffness of the controller, N/m."""

START = 0.1
"""Initial displacement, m."""


def controlled_mass(damping: float, delay: float = 0.0) -> System:
    """Return a mass on a line, held by a sampled controller with a stiffness and a damping (N s/m)."""
    scene = System()
    scene.add_point("mass", MASS, joint=Prismatic("x", position=START))

    def control(t: float, reads: np.ndarray, memory: dict[str, Any]) -> float:
        return -STIFFNESS * float(reads[0]) - damping * float(reads[1])

    reads = ("joint_coordinates mass", "joint_speeds mass")
    scene.add_controller("pd", control, every=EVERY, reads=reads, drives="motor mass", delay=delay)
    return scene


def sampled_mass(reference: Reference) -> Iterator[Check]:
    """P01: a mass held by a sampled controller, without and with delay."""
    for delay, of in reference.values["delays"].items():
        scene = controlled_mass(20.0, float(delay))
        loop = sampled_loop(scene, start=np.zeros(3))
        poles = loop.poles[np.abs(loop.poles) > 1e-9]
        parts = np.stack((poles.real, np.abs(poles.imag)), axis=-1)
        label = f"drives {delay} s after the samples"
        yield Check.absolute(f"poles z, {label}", parts, of["poles"], 1e-9)
        run = scene.simulate((0.0, 10 * EVERY), output_step=EVERY, rtol=1e-9)
        yield Check.absolute(
            f"position after 10 samples, {label} [m]", run.joint_coordinates("mass")[-1, 0], of["place"], 1e-9
        )
    limit = reference.values["limit"]
    found = [sampled_loop(controlled_mass(share * limit)).is_stable for share in (1.0 - 1e-6, 1.0 + 1e-6)]
    yield Check.absolute("whether it is stable with 1e-6 less and more than the largest damping", found, (1, 0), 0.0)


CASES = (Case("P01", sampled_mass),)
