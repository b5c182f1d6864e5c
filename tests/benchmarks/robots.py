"""Accelerations of public robots against Pinocchio's: all URDF files of the package example-robot-data.

    python tests/benchmarks/robots.py [--json FILE] [--env FOLDER] [--only TEXT]
    python tests/benchmarks/robots.py --reference    # writes tests/robots/pinocchio.json anew

makes an environment of its own for Pinocchio and the robots. Each robot is in a state at random, without damping and
friction in joints, which Pinocchio does not have; those that mimic others keep to it in both. 300 models of MJCF
drawn at random follow, without contacts, against `mj_forward` of MuJoCo; where equalities hold, which MuJoCo makes
compliant, against its own inertia, forces and Jacobians under the constraint.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "shared"))

import numpy as np

from benchmarks.command_line import parser, run
from benchmarks.drawn_mjcf import difference as difference_to_mujoco
from benchmarks.goals import Figure, Goal
from benchmarks.peer_process import Peers, peer_python

SERVER = Path(__file__).with_name("peer_pinocchio.py")
OWN = Path(__file__).resolve().parents[1] / "robots"
SAME = Goal("accelerations of {} robots, largest difference to Pinocchio's, relative", 1e-10)
DRAWN = Goal("accelerations of {} models drawn at random, largest difference to MuJoCo's, relative", 1e-9)


def arguments() -> argparse.Namespace:
    """Return the options of the command line."""
    options = parser(__doc__, quick="the first twelve robots only")
    options.add_argument("--reference", action="store_true", help="write the reference of the tests anew")
    return options.parse_args()


def environment(options: argparse.Namespace) -> Path:
    """Return the Python of Pinocchio's environment."""
    import platformdirs

    folder = options.env or Path(platformdirs.user_cache_dir("kanefe")) / "robots"
    return peer_python(folder, ("pin", "example-robot-data", "numpy"), "import pinocchio")


def measured(options: argparse.Namespace) -> list[Figure]:
    """Return the figure of all robots; each is printed as it is compared, and why, where it is not."""
    import kanefe as kf
    from robot_states import accelerations, asked_state, difference

    errors = []
    with Peers(environment(options), SERVER) as peers:
        files = [Path(path) for path in peers.ask("robots")["files"] if options.only in path]
        for path in files[: 12 if options.quick else None]:
            label = f"{path.parents[1].name}/{path.name}"
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    scene = kf.read_urdf(path, joint_forces=False)
                asked = asked_state(scene, seed=len(errors))
                if not asked["positions"]:
                    print(f"{label}: nothing moves")
                    continue
                errors.append(
                    difference(accelerations(scene, asked), peers.ask("accelerations", path=str(path), **asked))
                )
            except kf.KanefeError as refusal:
                print(f"{label}: not read: {refusal}".replace(str(path), path.name))
                continue
            print(f"{label}: {len(asked['positions'])} joints, {errors[-1]:.1e}")
    drawn = [difference_to_mujoco(seed) for seed in range(12 if options.quick else 300)]
    compared = [error for error in drawn if error is not None]
    named = f"{len(drawn) - len(compared)} more have parts that the reader names as not taken"
    return [_figure(SAME, errors), _figure(DRAWN, compared, named)]


def _figure(goal: Goal, errors: list[float], remark: str = "") -> Figure:
    largest = np.max(errors) if errors else np.nan  # of numpy, for which NaN is the largest
    return Goal(goal.what.format(len(errors)), goal.limit).figure(largest, remark)


def write_reference(options: argparse.Namespace) -> None:
    """Compute the accelerations of the tests' own robots by Pinocchio."""
    import datetime

    import kanefe as kf
    from robot_states import asked_state

    with Peers(environment(options), SERVER) as peers:
        made: dict[str, object] = {
            "provenance": {
                "program": f"pinocchio {peers.ask('versions')['pinocchio']}, aba and crba",
                "written": datetime.datetime.now(tz=datetime.UTC).date().isoformat(),
                "by": "python tests/benchmarks/robots.py --reference",
            }
        }
        for path in sorted(OWN.glob("*.urdf")):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                base = kf.Free() if path.stem == "walker" else None
                scene = kf.read_urdf(path, base=base, joint_forces=False)
            asked = asked_state(scene, seed=1)
            made[path.stem] = {"state": asked, "accelerations": peers.ask("accelerations", path=str(path), **asked)}
    (OWN / "pinocchio.json").write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    given = arguments()
    sys.exit(write_reference(given) if given.reference else run(given, measured))
