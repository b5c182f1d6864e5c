"""Runs in an environment of ross-rotordynamics: a rotor of two discs, its Campbell diagram and critical speeds."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

# before the peer: see there
from peer_answers import Answer, answer_requests  # isort: skip
import ross  # isort: skip


def versions() -> Answer:
    """Name the peer."""
    return {"ross": ross.__version__}


def _rotor(given: Answer) -> Any:
    steel = ross.Material("steel", rho=given["rho"], E=given["E"], G_s=given["G"])
    n = given["elements"]
    shaft = [ross.ShaftElement(L=given["length"] / n, idl=0.0, odl=given["diameter"], material=steel) for _ in range(n)]
    discs = [
        ross.DiskElement.from_geometry(n=at, material=steel, width=given["width"], i_d=given["diameter"], o_d=outer)
        for at, outer in given["discs"]
    ]
    bearings = [ross.BearingElement(n=at, kxx=given["stiffness"], kyy=given["stiffness"], cxx=0.0) for at in (0, n)]
    return ross.Rotor(shaft, discs, bearings)


def whirls(rotor: Answer, speed: float, count: int) -> Answer:
    """Return frequencies at a speed, rad/s, those along and about the shaft among them."""
    found = _rotor(rotor).run_modal(speed=speed, num_modes=4 * count)
    return {"wd": np.abs(found.wd).tolist()}


def campbell(rotor: Answer, speeds: list[float], count: int, repeats: int) -> Answer:
    """Return the CPU time of Campbell diagrams, s each, and the critical speeds of order 1, rad/s."""
    seconds = []
    for _ in range(repeats):
        made = _rotor(rotor)  # results of one are kept by it
        start = time.process_time()
        made.run_campbell(np.array(speeds), frequencies=count)
        seconds.append(time.process_time() - start)
    start = time.process_time()
    critical = made.run_critical_speed(num_modes=4 * count)
    return {"seconds": seconds, "critical": sorted(critical._wn), "critical_seconds": time.process_time() - start}


if __name__ == "__main__":
    answer_requests(versions, whirls, campbell)
