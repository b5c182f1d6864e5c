"""The peer's side of the arm that a sampled controller moves: beams and rigid bodies in a plane, in Exudyn."""

from __future__ import annotations

import math
import time
from typing import Any

import exudyn
import exudyn.itemInterface as items
import numpy as np
from arm_torque import torque

Answer = dict[str, Any]

SPECTRAL_RADIUS = 0.8


def solve_arm(arm: Answer, steps: int, h: float) -> Answer:
    """Run the arm with generalised-alpha; the controller is a Python function that is called before each step."""
    mbs, tip = _build(arm, h)
    settings = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps, integration.endTime, integration.verboseMode = steps, steps * h, 0
    integration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    # with the defaults Newton's iteration stalls at round-off, and the run ends
    integration.newton.relativeTolerance = integration.newton.absoluteTolerance = 1e-6
    settings.solution.file.write = False
    settings.parallel.numberOfThreads = 1
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    start = time.process_time()
    mbs.SolveDynamic(settings)
    seconds = time.process_time() - start
    where = mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Position)
    return {"seconds": seconds, "end": np.asarray(where)[:2].tolist()}


def _build(arm: Answer, h: float) -> tuple[Any, int]:
    """Return the system and the node of the tool."""
    mbs = exudyn.SystemContainer().AddSystem()
    point = mbs.AddNode(items.NodePointGround(referenceCoordinates=[0, 0, 0]))
    ground = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=point, coordinate=0))
    one, two = arm["links"]
    along = _direction(one["angle"])
    first = _link(mbs, arm, one, np.zeros(2), one["angle"])
    second = _link(mbs, arm, two, (one["length"] + arm["elbow"]["at"]) * along, one["angle"] + two["angle"])
    elbow = _rigid(mbs, first[-1], arm["elbow"], arm["gravity"])
    _rigid(mbs, second[-1], arm["tool"], arm["gravity"])
    for coordinate in range(2):
        held = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=first[0], coordinate=coordinate))
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, held]))
    ends = [
        mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=elbow, localPosition=[arm["elbow"]["at"], 0, 0])),
        mbs.AddMarker(items.MarkerNodePosition(nodeNumber=second[0])),
    ]
    mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=ends))
    mbs.SetPreStepUserFunction(_controller(mbs, arm, (first[0], first[-1], second[0]), h))
    mbs.Assemble()
    return mbs, second[-1]


def _direction(angle: float) -> np.ndarray:
    return np.array([math.cos(angle), math.sin(angle)])


def _link(mbs: Any, arm: Answer, link: Answer, start: np.ndarray, angle: float) -> list[int]:
    """Return the nodes of a link of geometrically exact beams."""
    count = arm["elements"]
    h, along = link["length"] / count, _direction(angle)
    nodes = [
        mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[*(start + i * h * along), angle]))
        for i in range(count + 1)
    ]
    stiffness = {name: link[name] for name in ("bending", "axial", "shear")}
    for i in range(count):
        beam = mbs.AddObject(
            items.ObjectBeamGeometricallyExact2D(
                nodeNumbers=nodes[i : i + 2],
                length=h,
                massPerLength=link["line_mass"],
                crossSectionInertia=link["line_inertia"],
                **{f"{name}Stiffness": value for name, value in stiffness.items()},
                **{f"{name}Damping": arm["damping"] * value for name, value in stiffness.items()},
            )
        )
        _fall(mbs, beam, arm["gravity"])
    return nodes


def _rigid(mbs: Any, node: int, body: Answer, gravity: float) -> int:
    added = mbs.AddObject(items.ObjectRigidBody2D(nodeNumber=node, mass=body["mass"], inertia=body["inertia"]))
    _fall(mbs, added, gravity)
    return int(added)


def _fall(mbs: Any, body: int, gravity: float) -> None:
    marker = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
    mbs.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=[0, -gravity, 0]))


def _controller(mbs: Any, arm: Answer, nodes: tuple[int, int, int], h: float) -> Any:
    """Return the function that reads the joints and sets the torques where a sample begins."""
    one, two, every, seconds = *arm["links"], arm["every"], arm["time"]
    loads = []
    for node in nodes:
        marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=2))
        loads.append(mbs.AddLoad(items.LoadCoordinate(markerNumber=marker, load=0.0)))
    angle, rate = exudyn.OutputVariableType.Coordinates, exudyn.OutputVariableType.Coordinates_t

    def control(mbs: Any, t: float) -> bool:
        at = t - h  # the time that is given is that of the end of the step
        if abs(at / every - round(at / every)) > 1e-6:
            return True
        q = [mbs.GetNodeOutput(node, angle)[2] for node in nodes]
        v = [mbs.GetNodeOutput(node, rate)[2] for node in nodes]
        shoulder = torque(at, one, seconds, one["angle"] + q[0], v[0])
        elbow = torque(at, two, seconds, two["angle"] + q[2] - q[1], v[2] - v[1])
        for load, value in zip(loads, (shoulder, -elbow, elbow), strict=True):
            mbs.SetLoadParameter(load, "load", value)
        return True

    return control
