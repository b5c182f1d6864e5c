"""A rotor of two discs against ross-rotordynamics: whirl frequencies, critical speeds, and the time of a diagram.

    python tests/benchmarks/rotors.py [--json FILE] [--env FOLDER]

makes an environment of its own for ross. The rotor is example 5.9.1 of Friswell, Penny, Garvey and Lees, Dynamics of
Rotating Machines (2010), of as many beams in both.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.command_line import parser, run
from benchmarks.goals import Figure, Goal, median
from benchmarks.peer_process import Peers, peer_python

SERVER = Path(__file__).with_name("peer_ross.py")
PACKAGES = ("ross-rotordynamics==2.3.0", "plotly<6")
SPEEDS, COUNT, REPEATS = np.linspace(20.0, 600.0, 30), 8, 9
WHIRL = Goal("two discs, whirl at 4000 rpm, largest difference to ross, relative", 1e-4)
CRITICAL = Goal("two discs, critical speeds, largest difference to ross, relative", 1e-4)
TIME = Goal("Campbell diagram of 30 speeds, CPU time / that of ross", 1.0)


def arguments() -> argparse.Namespace:
    """Return the options of the command line."""
    return parser(__doc__, quick="the same").parse_args()


def measured(options: argparse.Namespace) -> list[Figure]:
    """Return differences and times."""
    import platformdirs

    import kanefe as kf
    from kanefe.checks.verification.references import load_references
    from kanefe_fem.verification.two_discs import DIMENSIONS, rotor_of_two_discs, seen_from_the_ground

    folder = options.env or Path(platformdirs.user_cache_dir("kanefe")) / "ross"
    speed = 4000.0 * np.pi / 30.0
    own = seen_from_the_ground(kf.equilibrium(rotor_of_two_discs(speed)).linearise().modes(), speed)
    seconds: list[float] = []
    of_ross: list[float] = []
    with Peers(peer_python(folder, PACKAGES, "import ross"), SERVER) as peers:
        whirls = np.array(peers.ask("whirls", rotor=DIMENSIONS, speed=speed, count=COUNT)["wd"])
        for _ in range(REPEATS):  # by turns: what else the machine does slows both
            theirs = peers.ask("campbell", rotor=DIMENSIONS, speeds=SPEEDS.tolist(), count=COUNT, repeats=1)
            of_ross += theirs["seconds"]
            start = time.process_time()
            diagram = kf.campbell(rotor_of_two_discs, SPEEDS, modes=COUNT)
            seconds.append(time.process_time() - start)
    # seen from the shaft an unbalance stands still, and a backward whirl at the speed turns at twice the speed
    found = [one.speed for one in diagram.critical_speeds(0.0)]
    found += [one.speed for one in diagram.critical_speeds(2.0) if one.sense == "backward"]
    lateral = np.array([whirls[np.abs(whirls - value).argmin()] for value in load_references()["R04"].values["whirl"]])
    return [
        WHIRL.figure(_largest(own, lateral)),
        CRITICAL.figure(_largest(np.array(theirs["critical"]), np.array(found))),
        TIME.figure(median(seconds) / median(of_ross), f"{median(seconds):.2f} s against {median(of_ross):.2f} s"),
    ]


def _largest(of: np.ndarray, wanted: np.ndarray) -> float:
    """Return the largest relative distance of wanted numbers to the nearest of some."""
    return float(max(np.abs(of - value).min() / value for value in wanted))


if __name__ == "__main__":
    sys.exit(run(arguments(), measured))
