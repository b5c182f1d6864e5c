"""Runs in the peers' environment: the side of Exudyn, Pinocchio and MuJoCo of the scenes, asked for over pipes.

A request is a line of JSON with "do", the answer is another. Times are CPU seconds of this process.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

# What the libraries print must not get between the answers, and the first prints when it is imported.
ANSWERS = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)
# Exudyn's choice of its compiled module without range checks.
sys.exudynFast = True  # type: ignore[attr-defined]
import exudyn  # noqa: E402
import exudyn.itemInterface as items  # noqa: E402
import mujoco  # noqa: E402
import pinocchio  # noqa: E402
import scipy.sparse as sp  # noqa: E402
from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface  # noqa: E402
from exudyn.utilities import RigidBodyInertia, RotationMatrixY, RotationMatrixZ  # noqa: E402
from peer_arm import solve_arm  # noqa: E402
from peer_car import built_car  # noqa: E402
from peer_mujoco import call_forward, mujoco_chain, roll_out, solve_chain  # noqa: E402

Answer = dict[str, Any]

SPECTRAL_RADIUS = 0.8


class Runs:
    """Scenes built so far, by name."""

    def __init__(self) -> None:
        self.solves: dict[str, Callable[[int, float], Answer]] = {}
        self.calls: dict[str, Callable[[int], Answer]] = {}
        self.many: dict[str, Callable[[list[list[float]], int, float], Answer]] = {}

    def versions(self) -> Answer:
        """Name the peers."""
        return {"exudyn": exudyn.__version__, "pinocchio": pinocchio.__version__, "mujoco": mujoco.__version__}

    def build_chain(self, name: str, links: list[Answer], gravity: list[float], q: list[float]) -> Answer:
        """Build a chain of links in joint coordinates, for both."""
        self.solves[name] = lambda steps, h: _solve_chain(links, gravity, q, steps, h)
        model, data = _pinocchio_chain(links, gravity)
        self.calls[name] = lambda count: _call_aba(model, data, q, count)
        return {}

    def build_flexible(self, name: str, file: str, modes: int, velocity: list[float], omega: list[float]) -> Answer:
        """Build a free flexible body from its matrices: floating frame, free modes, rotation vector."""
        fem, body = _free_body(file, modes)
        self.solves[name] = lambda steps, h: _solve_flexible(body, velocity, omega, steps, h)
        return {"hertz": (np.sqrt(np.abs(fem.eigenValues[6 : 6 + modes])) / (2 * np.pi)).tolist()}

    def build_mixed(self, name: str, chain: Answer, bars: Answer) -> Answer:
        """Build a chain of rigid bodies on joints, in redundant coordinates, and free flexible bodies beside it."""
        _, body = _free_body(bars["file"], bars["modes"])
        self.solves[name] = lambda steps, h: _solve_mixed(chain, body, bars, steps, h)
        return {}

    def build_car(self, name: str, car: Answer) -> Answer:
        """Take what the car on four loops is made of; it is built for each run, as its end is its state."""
        self.solves[name] = lambda steps, h: _solve_car(car, steps, h)
        return {}

    def build_arm(self, name: str, arm: Answer) -> Answer:
        """Take what the arm with a sampled controller is made of; it is built for each run, as its end is its state."""
        self.solves[name] = lambda steps, h: solve_arm(arm, steps, h)
        return {}

    def build_mujoco_chain(self, name: str, links: list[Answer], gravity: list[float], q: list[float]) -> Answer:
        """Build a chain of links for MuJoCo."""
        model = mujoco_chain(links, gravity)
        self.solves[name] = lambda steps, h: solve_chain(model, q, steps, h)
        self.calls[name] = lambda count: call_forward(model, q, count)
        self.many[name] = lambda starts, steps, h: roll_out(model, starts, steps, h)
        return {}

    def solve(self, name: str, steps: int, h: float) -> Answer:
        """Run a scene from its start: arm and mixed scene implicitly, others with the Runge-Kutta method of order 4."""
        return self.solves[name](steps, h)

    def roll_out(self, name: str, starts: list[list[float]], steps: int, h: float) -> Answer:
        """Run a chain from many starts."""
        return self.many[name](starts, steps, h)

    def call(self, name: str, count: int) -> Answer:
        """Evaluate the accelerations of a chain many times."""
        return self.calls[name](count)


def _free_body(file: str, modes: int) -> tuple[Any, Any]:
    """Return the matrices of a file, and a body of them with free modes."""
    fem = FEMinterface()
    with np.load(file) as arrays:
        fem.nodes = {"Position": arrays["nodes"]}
        for what, field in (("mass", "massMatrix"), ("stiffness", "stiffnessMatrix")):
            parts = (arrays[f"{what}_data"], arrays[f"{what}_indices"], arrays[f"{what}_indptr"])
            setattr(fem, field, sp.csr_matrix(parts))
    fem.ComputeEigenmodes(modes, excludeRigidBodyModes=6, useSparseSolver=True)
    return fem, ObjectFFRFreducedOrderInterface(fem, rigidBodyNodeType="NodeType.RotationRotationVector")


def _timed(mbs: Any, steps: int, h: float, is_implicit: bool = False) -> float:
    """Return the seconds of a run, without output; generalised-alpha with what is fastest there: kept matrices."""
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = steps * h
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.parallel.numberOfThreads = 1
    start = time.process_time()
    solver = exudyn.DynamicSolverType
    mbs.SolveDynamic(settings, solverType=solver.GeneralizedAlpha if is_implicit else solver.RK44)
    return time.process_time() - start


def _solve_chain(links: list[Answer], gravity: list[float], q: list[float], steps: int, h: float) -> Answer:
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    n = len(links)
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0.0] * n,
            initialCoordinates=q,
            initialCoordinates_t=[0.0] * n,
            numberOfODE2Coordinates=n,
        )
    )
    turns, inertias = exudyn.Matrix3DList(), exudyn.Matrix3DList()
    offsets, centres = exudyn.Vector3DList(), exudyn.Vector3DList()
    for link in links:
        turns.Append(np.eye(3))
        inertias.Append(np.diag(link["inertia"]))
        offsets.Append(link["at"])
        centres.Append(link["com"])
    kinds = {"y": exudyn.JointType.RevoluteY, "z": exudyn.JointType.RevoluteZ}
    mbs.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node,
            gravity=gravity,
            jointTypes=[kinds[link["axis"]] for link in links],
            linkParents=list(range(-1, n - 1)),
            jointTransformations=turns,
            jointOffsets=offsets,
            linkInertiasCOM=inertias,
            linkCOMs=centres,
            linkMasses=[link["mass"] for link in links],
        )
    )
    mbs.Assemble()
    seconds = _timed(mbs, steps, h)
    end = np.atleast_1d(mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates))
    return {"seconds": seconds, "end": end.tolist()}


def _solve_flexible(body: Any, velocity: list[float], omega: list[float], steps: int, h: float) -> Answer:
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    made = body.AddObjectFFRFreducedOrder(
        mbs, positionRef=[0, 0, 0], initialVelocity=velocity, initialAngularVelocity=omega
    )
    mbs.Assemble()
    seconds = _timed(mbs, steps, h)
    where = mbs.GetNodeOutput(made["nRigidBody"], exudyn.OutputVariableType.Position)
    return {"seconds": seconds, "end": np.asarray(where).tolist()}


def _solve_mixed(chain: Answer, body: Any, bars: Answer, steps: int, h: float) -> Answer:
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    last, place, turned = mbs.CreateGround(), np.zeros(3), np.eye(3)
    for link, angle in zip(chain["links"], chain["q"], strict=True):
        place = place + turned @ link["at"]
        is_y = link["axis"] == "y"
        axis = turned @ ([0, 1, 0] if is_y else [0, 0, 1])
        turned = turned @ (RotationMatrixY if is_y else RotationMatrixZ)(angle)
        made = mbs.CreateRigidBody(
            inertia=RigidBodyInertia(mass=link["mass"], inertiaTensor=np.diag(link["inertia"])),
            referencePosition=place + turned @ link["com"],
            referenceRotationMatrix=turned,
            gravity=chain["gravity"],
            nodeType=exudyn.NodeType.RotationRotationVector,
        )
        mbs.CreateRevoluteJoint(itemNumbers=[last, made], position=place, axis=axis, useGlobalFrame=True)
        last = made
    for _ in range(bars["count"]):
        bar = body.AddObjectFFRFreducedOrder(
            mbs, positionRef=[0, 0, 0], initialVelocity=bars["velocity"], initialAngularVelocity=bars["omega"]
        )
    mbs.Assemble()
    seconds = _timed(mbs, steps, h, is_implicit=True)
    position = exudyn.OutputVariableType.Position
    where = mbs.GetObjectOutputBody(last, position), mbs.GetNodeOutput(bar["nRigidBody"], position)
    return {"seconds": seconds, "end": np.concatenate(where).tolist()}


def _solve_car(car: Answer, steps: int, h: float) -> Answer:
    mbs, upright = built_car(car)
    seconds = _timed(mbs, steps, h, is_implicit=True)
    where = mbs.GetObjectOutputBody(upright, exudyn.OutputVariableType.Position)
    return {"seconds": seconds, "end": np.asarray(where).tolist()}


def _pinocchio_chain(links: list[Answer], gravity: list[float]) -> tuple[Any, Any]:
    model = pinocchio.Model()
    model.gravity.linear = np.array(gravity)
    kinds = {"y": pinocchio.JointModelRY, "z": pinocchio.JointModelRZ}
    last = 0
    for i, link in enumerate(links):
        place = pinocchio.SE3(np.eye(3), np.array(link["at"]))
        last = model.addJoint(last, kinds[link["axis"]](), place, f"joint {i}")
        inertia = pinocchio.Inertia(link["mass"], np.array(link["com"]), np.diag(link["inertia"]))
        model.appendBodyToJoint(last, inertia, pinocchio.SE3.Identity())
    return model, model.createData()


def _call_aba(model: Any, data: Any, q: list[float], count: int) -> Answer:
    at, still = np.array(q), np.zeros(len(q))
    aba = pinocchio.aba
    start = time.process_time()
    for _ in range(count):
        found = aba(model, data, at, still, still)
    return {"seconds": time.process_time() - start, "end": found.tolist()}


def main() -> None:
    """Answer requests until there are no more."""
    runs = Runs()
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = getattr(runs, request.pop("do"))(**request)
        except (ValueError, KeyError, TypeError, AttributeError, RuntimeError, OSError) as error:
            answer = {"error": f"{type(error).__name__}: {error}"[:400]}
        print(json.dumps(answer), file=ANSWERS, flush=True)


if __name__ == "__main__":
    main()
