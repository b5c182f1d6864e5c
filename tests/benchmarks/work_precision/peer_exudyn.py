"""Exudyn's side of the scenes; runs in an environment of its own and is asked for runs over pipes.

A request is a line of JSON with "do", the answer is another. Times are CPU seconds of the solver alone. Scenes are
built from numbers and matrices that our side sends, so that both run the same physics on the same mesh.
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

# What the library prints must not get between the answers, and the first prints when it is imported.
ANSWERS = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)
# Exudyn's choice of its compiled module without range checks.
sys.exudynFast = True  # type: ignore[attr-defined]
import exudyn  # noqa: E402
import exudyn.itemInterface as items  # noqa: E402
import scipy.linalg  # noqa: E402
import scipy.sparse as sp  # noqa: E402
from exudyn.FEM import (  # noqa: E402
    FEMinterface,
    HCBstaticModeSelection,
    ObjectFFRFreducedOrderInterface,
)
from exudyn.utilities import CreateSymbolicUserFunction, RigidBodyInertia  # noqa: E402

Answer = dict[str, Any]
Sample = Callable[[Any, float], list[float]]
"""Function of system and time that returns the sampled quantities."""

SPECTRAL_RADIUS = 0.9

LARGEST_STEP = 0.5
"""Largest adaptive step, s: large enough never to limit the steps."""

STALL = 1e-6
"""Newton tolerances of the spin-up: with the defaults the iteration stalls at round-off and the step is refused."""

KINDS = {
    "rk4": exudyn.DynamicSolverType.RK44,
    "dopri5": exudyn.DynamicSolverType.DOPRI5,
    "generalised-alpha": exudyn.DynamicSolverType.GeneralizedAlpha,
}
OUTPUT = exudyn.OutputVariableType


class Scene:
    """A scene that can be built again for each run.

    Parameters
    ----------
    build : callable
        () -> (system, what `end` and `sample` need).
    end : callable
        (system, those) -> what the run is judged by.
    sample : callable, optional
        (system, those, time) -> the same, or more, in the middle of a run.
    tune : callable, optional
        Changes the settings of a run.
    """

    def __init__(self, build: Any, end: Any, sample: Any = None, tune: Any = None) -> None:
        self.build, self.end, self.sample, self.tune = build, end, sample, tune


class Runs:
    """Scenes built so far, by name."""

    def __init__(self) -> None:
        self.scenes: dict[str, Scene] = {}

    def versions(self) -> Answer:
        """Name the peer."""
        return {"exudyn": exudyn.__version__}

    def build_chain(self, name: str, links: list[Answer], gravity: list[float], q: list[float]) -> Answer:
        """Build S1: a tree of links in joint coordinates."""
        self.scenes[name] = Scene(lambda: _chain(links, gravity, q), _coordinates)
        return {}

    def build_beam(self, name: str, elements: int, beam: Answer) -> Answer:
        """Build S2: geometrically exact beam elements on a driven hub."""

        def tip(mbs: Any, node: int, t: float) -> list[float]:
            x, y = np.array(mbs.GetNodeOutput(node, OUTPUT.Position))[:2]
            angle = _hub(t, beam)
            return [float(math.cos(angle) * y - math.sin(angle) * x)]

        def tune(settings: Any) -> None:
            newton = settings.timeIntegration.newton
            newton.useModifiedNewton = False
            newton.relativeTolerance = newton.absoluteTolerance = STALL

        self.scenes[name] = Scene(lambda: _beam(elements, beam), _nothing, tip, tune)
        return {}

    def build_hinged(
        self, name: str, file: str, modes: int, ratio: float, gravity: list[float], corner: list[float]
    ) -> Answer:
        """Build S3 from its matrices: Craig-Bampton with both faces rigid, floating frame, rotation vector."""
        fem, ends = _fem(file)
        fem.ComputeHurtyCraigBamptonModes(
            ends, modes, useSparseSolver=True, computationMode=HCBstaticModeSelection.RBE2, timerTreshold=10**9
        )
        hertz, damping = _decouple(fem, ratio)
        body = ObjectFFRFreducedOrderInterface(fem, rigidBodyNodeType="NodeType.RotationRotationVector")
        weights = np.ones(len(ends[0])) / len(ends[0])
        node = fem.GetNodeAtPoint(corner)

        def build() -> tuple[Any, int]:
            mbs = exudyn.SystemContainer().AddSystem()
            made = body.AddObjectFFRFreducedOrder(mbs, positionRef=[0, 0, 0], gravity=gravity)
            if ratio:
                mbs.SetObjectParameter(made["oFFRFreducedOrder"], "dampingMatrixReduced", damping)
            ground = mbs.AddObject(items.ObjectGround())
            there = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=[0, 0, 0]))
            face = mbs.AddMarker(
                items.MarkerSuperElementRigid(
                    bodyNumber=made["oFFRFreducedOrder"], meshNodeNumbers=np.array(ends[0]), weightingFactors=weights
                )
            )
            mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[there, face], constrainedAxes=[1, 1, 1, 1, 0, 1]))
            return mbs, made["oFFRFreducedOrder"]

        self.scenes[name] = Scene(build, lambda mbs, body: _place(mbs, body, node))
        return {"hertz": hertz, "mass": float(body.totalMass)}

    def build_free(
        self, name: str, file: str, modes: int, velocity: list[float], omega: list[float], corner: list[float]
    ) -> Answer:
        """Build S4 from its matrices: free modes, rotation vector."""
        fem, _ = _fem(file)
        fem.ComputeEigenmodes(modes, excludeRigidBodyModes=6, useSparseSolver=True)
        body = ObjectFFRFreducedOrderInterface(fem, rigidBodyNodeType="NodeType.RotationRotationVector")
        node = fem.GetNodeAtPoint(corner)
        invariants = _Invariants(fem, body)

        def build() -> tuple[Any, Answer]:
            mbs = exudyn.SystemContainer().AddSystem()
            made = body.AddObjectFFRFreducedOrder(
                mbs, positionRef=[0, 0, 0], initialVelocity=velocity, initialAngularVelocity=omega
            )
            return mbs, made

        self.scenes[name] = Scene(
            build,
            lambda mbs, made: _place(mbs, made["oFFRFreducedOrder"], node),
            lambda mbs, made, t: invariants(mbs, made),
        )
        squares = scipy.linalg.eigvalsh(body.stiffnessMatrixReduced, body.massMatrixReduced)
        return {"hertz": (np.sqrt(squares) / (2 * np.pi)).tolist(), "mass": float(body.totalMass)}

    def build_ball(self, name: str, zone: float, ball: Answer) -> Answer:
        """Build a ball over a plane, a triangle that is much larger; friction is viscous below a speed (zone, m/s)."""

        def end(mbs: Any, node: int) -> list[float]:
            return [float(x) for x in mbs.GetNodeOutput(node, OUTPUT.Position)]

        def tune(settings: Any) -> None:
            run = settings.timeIntegration
            if run.automaticStepSize:
                run.numberOfSteps = round(run.endTime / ball["longest"])

        self.scenes[name] = Scene(lambda: _ball(zone, ball), end, tune=tune)
        return {}

    def solve(
        self,
        name: str,
        method: str,
        end: float,
        step: float | None = None,
        rtol: float | None = None,
        every: float | None = None,
    ) -> Answer:
        """Run a scene; with `every` (s) also sample it, which is not to be timed."""
        scene = self.scenes[name]
        mbs, parts = scene.build()
        samples: list[list[float]] = []
        if every is not None:

            def keep(mbs: Any, t: float, *_: Any) -> list[float]:
                samples.append([t, *scene.sample(mbs, parts, t)])
                return [0.0]

            mbs.AddSensor(
                items.SensorUserFunction(
                    sensorNumbers=[], factors=[], storeInternal=True, writeToFile=False, sensorUserFunction=keep
                )
            )
        mbs.Assemble()
        settings = _settings(method, end, step, rtol, every)
        if scene.tune is not None:
            scene.tune(settings)
        start = time.process_time()
        mbs.SolveDynamic(settings, solverType=KINDS[method])
        seconds = time.process_time() - start
        return {"seconds": seconds, "end": scene.end(mbs, parts), "samples": samples}


def _settings(method: str, end: float, step: float | None, rtol: float | None, every: float | None) -> Any:
    settings = exudyn.SimulationSettings()
    run = settings.timeIntegration
    run.endTime, run.verboseMode = end, 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = every or end
    settings.parallel.numberOfThreads = 1
    run.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    run.newton.useModifiedNewton = True
    if step is not None:
        run.automaticStepSize = False
        run.numberOfSteps = max(1, round(end / step))
        # where the iteration fails it halves the step, down to nanoseconds: better an error than a run without an end
        run.minimumStepSize = step / 40.0
    else:
        # the largest step of an adaptive run is the span over this number
        run.automaticStepSize, run.numberOfSteps = True, max(1, round(end / LARGEST_STEP))
        run.relativeTolerance = run.absoluteTolerance = rtol
        run.initialStepSize = 1e-3
    return settings


def _nothing(mbs: Any, parts: Any) -> list[float]:
    return []


def _coordinates(mbs: Any, node: int) -> list[float]:
    return [float(x) for x in np.atleast_1d(mbs.GetNodeOutput(node, OUTPUT.Coordinates))]


def _chain(links: list[Answer], gravity: list[float], q: list[float]) -> tuple[Any, int]:
    mbs = exudyn.SystemContainer().AddSystem()
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
    return mbs, node


LARGE = 100.0
"""Size of the triangle below a ball, m."""


def _ball(zone: float, ball: Answer) -> tuple[Any, int]:
    mbs = exudyn.SystemContainer().AddSystem()
    body = mbs.CreateRigidBody(
        inertia=RigidBodyInertia(mass=ball["mass"], inertiaTensor=np.eye(3) * ball["inertia"]),
        nodeType=exudyn.NodeType.RotationRotationVector,
        referencePosition=ball["position"],
        initialVelocity=ball["velocity"],
        initialAngularVelocity=ball["omega"],
        gravity=ball["gravity"],
    )
    bodies = body, mbs.AddObject(items.ObjectGround())
    corners = [[-LARGE, -LARGE, 0.0], [LARGE, -LARGE, 0.0], [0.0, 2.0 * LARGE, 0.0]]
    mbs.AddObject(
        items.ObjectContactSphereTriangle(
            markerNumbers=[
                mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=number, localPosition=[0, 0, 0])) for number in bodies
            ],
            nodeNumber=mbs.AddNode(
                items.NodeGenericData(numberOfDataCoordinates=4, initialCoordinates=[ball["radius"], 0, 0, 0])
            ),
            sphereRadius=ball["radius"],
            trianglePoints=exudyn.Vector3DList(corners),
            includeEdges=0,
            dynamicFriction=ball["friction"],
            frictionProportionalZone=zone,
            contactStiffness=ball["stiffness"],
        )
    )
    return mbs, mbs.GetObject(body)["nodeNumber"]


def _hub(t: float, beam: Answer) -> float:
    rate, start = beam["final_rate"], beam["start_time"]
    a = 2.0 * math.pi / start
    if t < start:
        return float(rate / start * (0.5 * t * t + (math.cos(a * t) - 1.0) / a**2))
    return float(rate * (t - 0.5 * start))


def _beam(elements: int, beam: Answer) -> tuple[Any, int]:
    mbs = exudyn.SystemContainer().AddSystem()
    point = mbs.AddNode(items.NodePointGround(referenceCoordinates=[0, 0, 0]))
    ground = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=point, coordinate=0))
    length = beam["length"] / elements
    nodes = [mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[i * length, 0, 0])) for i in range(elements + 1)]
    for i in range(elements):
        mbs.AddObject(
            items.ObjectBeamGeometricallyExact2D(
                nodeNumbers=nodes[i : i + 2],
                length=length,
                massPerLength=beam["line_mass"],
                crossSectionInertia=beam["line_inertia"],
                bendingStiffness=beam["EI"],
                axialStiffness=beam["EA"],
                shearStiffness=beam["GA"],
            )
        )
    root = [mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=k)) for k in range(3)]
    for marker in root[:2]:
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, marker]))
    rate, start = beam["final_rate"], beam["start_time"]
    a, math_of = 2.0 * math.pi / start, exudyn.symbolic

    def turned(mbs: Any, t: Any, item: int, offset: float) -> float:
        return _hub(t, beam)

    def symbolic(mbs: Any, t: Any, item: int, offset: float) -> Any:
        up = rate / start * (0.5 * t * t + 1 / (a * a) * (math_of.cos(a * t) - 1.0))
        return math_of.IfThenElse(t < start, up, rate * t - 0.5 * rate * start)

    drive = mbs.AddObject(
        items.ObjectConnectorCoordinate(markerNumbers=[ground, root[2]], offset=0.0, offsetUserFunction=turned)
    )
    # a symbolic function runs in its compiled code, which spares the calls of Python
    mbs.SetObjectParameter(
        drive, "offsetUserFunction", CreateSymbolicUserFunction(mbs, symbolic, "offsetUserFunction", drive)
    )
    return mbs, nodes[-1]


def _fem(file: str) -> tuple[Any, list[list[int]]]:
    """Return the mesh and matrices of a file, and the nodes of the faces at both ends."""
    fem = FEMinterface()
    with np.load(file) as arrays:
        nodes = arrays["nodes"]
        fem.nodes = {"Position": nodes}
        for what, field in (("mass", "massMatrix"), ("stiffness", "stiffnessMatrix")):
            parts = (arrays[f"{what}_data"], arrays[f"{what}_indices"], arrays[f"{what}_indptr"])
            setattr(fem, field, sp.csr_matrix(parts))
    x = nodes[:, 0]
    return fem, [np.flatnonzero(np.abs(x - at) < 1e-9).tolist() for at in (x.min(), x.max())]


def _decouple(fem: Any, ratio: float) -> tuple[list[float], Any]:
    """Turn the basis into the modes of the body with its root held: K, M and C become diagonal, which is faster."""
    basis = fem.modeBasis["matrix"]
    M, K = (basis.T @ (matrix @ basis) for matrix in (fem.massMatrix, fem.stiffnessMatrix))
    squares, modes = scipy.linalg.eigh(K, M)
    fem.modeBasis = {"matrix": basis @ modes, "type": "HCBmodes"}
    rates = np.sqrt(squares)
    damping = exudyn.MatrixContainer()
    damping.SetWithDenseMatrix(np.diag(2.0 * ratio * rates), useDenseMatrix=False)
    return (rates / (2 * np.pi)).tolist(), damping


def _place(mbs: Any, body: int, node: int) -> list[float]:
    place = mbs.GetObjectOutputSuperElement(body, OUTPUT.Position, node)
    return [float(x) for x in place]


class _Invariants:
    """Energy and angular momentum of a free body, from the full matrices of its mesh."""

    def __init__(self, fem: Any, body: Any) -> None:
        self.nodes, self.basis = fem.GetNodePositionsAsArray(), body.modeBasis
        self.mass, self.stiffness = fem.massMatrix, body.stiffnessMatrixReduced

    def __call__(self, mbs: Any, made: Answer) -> list[float]:
        """Return the energy (J) and the angular momentum (kg m2/s) in N."""

        def of(what: Any) -> np.ndarray:
            return np.array(mbs.GetNodeOutput(made["nRigidBody"], what))

        def modal(what: Any) -> np.ndarray:
            return np.atleast_1d(mbs.GetNodeOutput(made["nGenericODE2"], what))

        A, w = of(OUTPUT.RotationMatrix).reshape(3, 3), of(OUTPUT.AngularVelocityLocal)
        q, dq = modal(OUTPUT.Coordinates), modal(OUTPUT.Coordinates_t)
        places = self.nodes + (self.basis @ q).reshape(-1, 3)
        speeds = A.T @ of(OUTPUT.Velocity) + np.cross(w, places) + (self.basis @ dq).reshape(-1, 3)
        momenta = (self.mass @ speeds.ravel()).reshape(-1, 3)
        energy = 0.5 * np.sum(speeds * momenta) + 0.5 * q @ self.stiffness @ q
        spin = np.cross(of(OUTPUT.Position) + places @ A.T, momenta @ A.T).sum(axis=0)
        return [float(energy), *(float(x) for x in spin)]


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
