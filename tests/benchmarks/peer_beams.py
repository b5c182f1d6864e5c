"""Runs in the peer's environment: Exudyn's geometrically exact beams, asked for over pipes as in `peer_scenes`."""

from __future__ import annotations

import json
import os
import sys
import time
from typing import Any

import numpy as np

ANSWERS = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)
# Exudyn's choice of its compiled module without range checks.
sys.exudynFast = True  # type: ignore[attr-defined]
import exudyn  # noqa: E402
import exudyn.itemInterface as items  # noqa: E402

Answer = dict[str, Any]


class Scene:
    """A scene of beams along straight lines; what is asked for are places of nodes at times."""

    def __init__(self) -> None:
        self.mbs = exudyn.SystemContainer().AddSystem()
        point = self.mbs.AddNode(items.NodePointGround(referenceCoordinates=[0, 0, 0]))
        self.ground = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=point, coordinate=0))
        self.asked: list[int] = []

    def planar_beam(self, start: list[float], along: float, section: Answer, elements: int) -> list[int]:
        """Add a planar beam, and return its nodes."""
        h = section["length"] / elements
        direction = np.array((np.cos(along), np.sin(along)))
        nodes = [
            self.mbs.AddNode(
                items.NodeRigidBody2D(referenceCoordinates=[*(np.array(start) + i * h * direction), along])
            )
            for i in range(elements + 1)
        ]
        for i in range(elements):
            self.mbs.AddObject(
                items.ObjectBeamGeometricallyExact2D(
                    nodeNumbers=nodes[i : i + 2],
                    length=h,
                    massPerLength=section["rho_A"],
                    crossSectionInertia=section["rho_I"],
                    bendingStiffness=section["EI"],
                    axialStiffness=section["EA"],
                    shearStiffness=section["GA"],
                    includeReferenceRotations=True,
                )
            )
        return nodes

    def spatial_beam(
        self, start: np.ndarray, turned: np.ndarray, section: Answer, nodes: list[int], elements: int
    ) -> None:
        """Add a beam in space to nodes, of which the first may be there."""
        h = section["length"] / elements
        while len(nodes) < elements + 1:
            place = start + turned[:, 0] * h * len(nodes)
            made = self.mbs.AddNode(
                items.NodeRigidBodyRotVecLG(
                    referenceCoordinates=[*place, *_rotation_vector(turned)], initialVelocities=[0.0] * 6
                )
            )
            nodes.append(made)
        data = exudyn.BeamSection()
        data.massPerLength = section["rho_A"]
        data.stiffnessMatrix = np.diag([section[k] for k in ("EA", "GA", "GA", "GJ", "EI", "EI")])
        data.inertia = section["rho_I"] * np.diag([2.0, 1.0, 1.0])
        for i in range(elements):
            self.mbs.AddObject(
                items.ObjectBeamGeometricallyExact(nodeNumbers=nodes[i : i + 2], length=h, sectionData=data)
            )

    def hold(self, node: int, coordinates: range) -> None:
        """Fix coordinates of a node."""
        for coordinate in coordinates:
            marker = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
            self.mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[self.ground, marker]))


def _rotation_vector(A: np.ndarray) -> np.ndarray:
    angle = np.arccos(np.clip(0.5 * (np.trace(A) - 1.0), -1.0, 1.0))
    axial = 0.5 * np.array((A[2, 1] - A[1, 2], A[0, 2] - A[2, 0], A[1, 0] - A[0, 1]))
    return axial if angle == 0.0 else axial * angle / np.sin(angle)


def flying(
    elements: int, section: Answer, start: list[float], along: float, force: float, torque: float, loaded: float
) -> Scene:
    """Return a free beam, loaded at its first node until a time."""
    scene = Scene()
    nodes = scene.planar_beam(start, along, section, elements)
    marker = scene.mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0]))
    scene.mbs.AddLoad(
        items.LoadForceVector(
            markerNumber=marker,
            loadVector=[force, 0, 0],
            loadVectorUserFunction=lambda mbs, t, load: load if t <= loaded else [0, 0, 0],
        )
    )
    scene.mbs.AddLoad(
        items.LoadTorqueVector(
            markerNumber=marker,
            loadVector=[0, 0, torque],
            loadVectorUserFunction=lambda mbs, t, load: load if t <= loaded else [0, 0, 0],
        )
    )
    scene.asked = [nodes[0], nodes[-1]]
    return scene


def right_angle(elements: int, section: Answer, force: float) -> Scene:
    """Return the cantilever of two legs, with a force on its elbow that rises for a second and falls for another."""
    scene = Scene()
    first: list[int] = []
    scene.spatial_beam(np.zeros(3), np.eye(3), section, first, elements)
    # nodes have the axes of their beam: the elbow has two, which are joined
    second: list[int] = []
    turned = np.array(((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    scene.spatial_beam(np.array((section["length"], 0.0, 0.0)), turned, section, second, elements)
    mbs = scene.mbs
    for node in (first[0],):
        point = mbs.AddObject(items.ObjectGround())
        fixed = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=point))
        root = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node))
        mbs.AddObject(items.GenericJoint(markerNumbers=[fixed, root]))
    ends = [mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node)) for node in (first[-1], second[0])]
    mbs.AddObject(items.GenericJoint(markerNumbers=ends, rotationMarker1=turned.T))
    mbs.AddLoad(
        items.LoadForceVector(
            markerNumber=ends[0],
            loadVector=[0, 0, force],
            loadVectorUserFunction=lambda mbs, t, load: [0, 0, load[2] * max(0.0, 1.0 - abs(t - 1.0))],
        )
    )
    scene.asked = [first[-1], second[-1]]
    return scene


def slewing(elements: int, section: Answer, angle: float, ramp: float) -> Scene:
    """Return a beam whose root is turned by an angle in a time, as a polynomial of fifth degree."""
    scene = Scene()
    nodes = scene.planar_beam([0.0, 0.0], 0.0, section, elements)
    scene.hold(nodes[0], range(2))

    def turn(mbs: Any, t: float, item: int, offset: float) -> float:
        x = min(t / ramp, 1.0)
        return float(angle * x**3 * (10.0 - 15.0 * x + 6.0 * x * x))

    marker = scene.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=2))
    scene.mbs.AddObject(
        items.ObjectConnectorCoordinate(markerNumbers=[scene.ground, marker], offset=0.0, offsetUserFunction=turn)
    )
    scene.asked = [nodes[-1]]
    return scene


SCENES = {"flying": flying, "right angle": right_angle, "slewing": slewing}


def solve(scene: str, elements: int, steps: int, until: float, rho: float, **what: Any) -> Answer:
    """Run a scene with generalised-alpha; answer the CPU seconds, and the places at the end."""
    made = SCENES[scene](elements, **what)
    mbs = made.mbs
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps, integration.endTime, integration.verboseMode = steps, until, 0
    integration.generalizedAlpha.spectralRadius = rho
    integration.newton.useModifiedNewton = True
    integration.newton.relativeTolerance = integration.newton.absoluteTolerance = 1e-7
    settings.solution.file.write = False
    settings.parallel.numberOfThreads = 1
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    start = time.process_time()
    mbs.SolveDynamic(settings)
    seconds = time.process_time() - start
    places = [mbs.GetNodeOutput(node, exudyn.OutputVariableType.Position) for node in made.asked]
    return {"seconds": seconds, "end": np.concatenate(places).tolist()}


def main() -> None:
    """Answer requests until there are no more."""
    for line in sys.stdin:
        request = json.loads(line)
        request.pop("do")
        try:
            answer = solve(**request)
        except (ValueError, KeyError, TypeError, AttributeError, RuntimeError) as error:
            answer = {"error": f"{type(error).__name__}: {error}"[:400]}
        print(json.dumps(answer), file=ANSWERS, flush=True)


if __name__ == "__main__":
    main()
