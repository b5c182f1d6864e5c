"""The peer's side of a strip that bends far: ANCF cables and geometrically exact beams in the plane, in Exudyn."""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
from peer_answers import answer_requests

# Exudyn's choice of its compiled module without range checks.
sys.exudynFast = True  # type: ignore[attr-defined]
import exudyn  # noqa: E402
import exudyn.itemInterface as items  # noqa: E402
from exudyn.utilities import CreateSymbolicUserFunction  # noqa: E402

Answer = dict[str, Any]

SPECTRAL_RADIUS = 0.9
SHEAR = 5.0 / 6.0 / 2.6
"""Shear stiffness over that of stretch, of a rectangle with Poisson's ratio 0.3."""

TOLERANCE = 1e-6
"""Of Newton's iteration."""


def version() -> Answer:
    """Name the peer."""
    return {"exudyn": exudyn.__version__}


def slew(beam: Answer, kind: str, elements: int, steps: int) -> Answer:
    """Run the link that slews by steps of generalised-alpha."""
    mbs, tip, count = _build(beam, kind, elements, is_driven=True)
    settings = _settings()
    run = settings.timeIntegration
    run.numberOfSteps, run.endTime, run.verboseMode = steps, beam["end"], 0
    run.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    run.newton.useModifiedNewton = False
    run.newton.relativeTolerance = run.newton.absoluteTolerance = TOLERANCE
    # where the iteration fails it halves the step, down to nanoseconds: better an error than a run without an end
    run.minimumStepSize = beam["end"] / steps / 40.0
    settings.solution.sensors.writePeriod = beam["end"] / beam["samples"]
    sensor = mbs.AddSensor(
        items.SensorNode(
            nodeNumber=tip, outputVariableType=exudyn.OutputVariableType.Position, storeInternal=True, writeToFile=False
        )
    )
    mbs.Assemble()
    start = time.process_time()
    mbs.SolveDynamic(settings)
    seconds = time.process_time() - start
    places = np.asarray(mbs.GetSensorStoredData(sensor))
    return {"seconds": seconds, "tip": places[1:, 1:3].tolist(), "coordinates": count}


def bend(beam: Answer, kind: str, elements: int, load_steps: int) -> Answer:
    """Return the rest under a dead load across the tip."""
    mbs, tip, count = _build(beam, kind, elements, is_driven=False)
    at = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=tip))
    mbs.AddLoad(items.LoadForceVector(markerNumber=at, loadVector=[0, beam["force"], 0]))
    mbs.Assemble()
    settings = _settings()
    settings.staticSolver.numberOfLoadSteps, settings.staticSolver.verboseMode = load_steps, 0
    newton = settings.staticSolver.newton
    newton.relativeTolerance, newton.absoluteTolerance = TOLERANCE, 1e-10
    start = time.process_time()
    mbs.SolveStatic(settings)
    seconds = time.process_time() - start
    place = mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Position)
    return {"seconds": seconds, "tip": np.asarray(place)[:2].tolist(), "coordinates": count}


def _settings() -> Any:
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.parallel.numberOfThreads = 1
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    return settings


def _build(beam: Answer, kind: str, elements: int, is_driven: bool) -> tuple[Any, int, int]:
    """Return the system, the node of the tip and the number of coordinates that are not held."""
    mbs = exudyn.SystemContainer().AddSystem()
    point = mbs.AddNode(items.NodePointGround(referenceCoordinates=[0, 0, 0]))
    ground = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=point, coordinate=0))
    h = beam["length"] / elements
    common = {"length": h, "massPerLength": beam["line_mass"]}
    common |= {"bendingStiffness": beam["bending"], "axialStiffness": beam["stretching"]}
    is_cable = kind == "cable"
    node = items.NodePoint2DSlope1 if is_cable else items.NodeRigidBody2D
    rest = [1, 0] if is_cable else [0]
    nodes = [mbs.AddNode(node(referenceCoordinates=[i * h, 0, *rest])) for i in range(elements + 1)]
    for i in range(elements):
        ends = nodes[i : i + 2]
        if is_cable:
            mbs.AddObject(items.ObjectANCFCable2D(nodeNumbers=ends, **common))
        else:
            more = {"crossSectionInertia": beam["line_inertia"], "shearStiffness": SHEAR * beam["stretching"]}
            mbs.AddObject(items.ObjectBeamGeometricallyExact2D(nodeNumbers=ends, **common, **more))
    count = (4 if is_cable else 3) * (elements + 1) - 3
    if not is_cable or not is_driven:
        held = [0, 1, 3] if is_cable else [0, 1, 2]
        _hold(mbs, ground, nodes[0], held, beam if is_driven else None)
        return mbs, nodes[-1], count
    # a slope is turned by a rigid hub
    hub = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[0, 0, 0]))
    body = mbs.AddObject(items.ObjectRigidBody2D(nodeNumber=hub, mass=1.0, inertia=1.0))
    _hold(mbs, ground, hub, [0, 1, 2], beam)
    ends = [
        mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0])),
        mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=[0, 0, 0])),
    ]
    mbs.AddObject(items.ObjectJointGeneric(markerNumbers=ends, constrainedAxes=[1, 1, 0, 0, 0, 1]))
    return mbs, nodes[-1], count


def _hold(mbs: Any, ground: int, node: int, coordinates: list[int], beam: Answer | None) -> None:
    """Hold coordinates of a node; the last one follows the motor, if there is one."""
    for coordinate in coordinates:
        marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        held = items.ObjectConnectorCoordinate(markerNumbers=[ground, marker])
        if beam is None or coordinate != coordinates[-1]:
            mbs.AddObject(held)
            continue
        _drive(mbs, [ground, marker], beam)


def _drive(mbs: Any, markers: list[int], beam: Answer) -> None:
    """Turn a coordinate by the angle of the motor."""
    angle, slewed, math = beam["angle"], beam["slewed"], exudyn.symbolic

    def plain(mbs: Any, t: float, item: int, offset: float) -> float:
        x = min(t / slewed, 1.0)
        return float(angle * x**4 * (35.0 - 84.0 * x + 70.0 * x**2 - 20.0 * x**3))

    def symbolic(mbs: Any, t: Any, item: int, offset: float) -> Any:
        x = t * (1.0 / slewed)
        up = angle * x * x * x * x * (35.0 - 84.0 * x + 70.0 * x * x - 20.0 * x * x * x)
        return math.IfThenElse(t < slewed, up, angle * math.abs(1.0 + 0.0 * t))

    drive = mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=markers, offset=0.0, offsetUserFunction=plain))
    # a symbolic function runs in its compiled code, which spares the calls of Python
    mbs.SetObjectParameter(
        drive, "offsetUserFunction", CreateSymbolicUserFunction(mbs, symbolic, "offsetUserFunction", drive)
    )


if __name__ == "__main__":
    answer_requests(version, slew, bend)
