"""The peer's run of an unreduced floating-frame body; in the peers' environment, alone in its process.

    python peer_unreduced.py MATRICES STEP STEPS

MATRICES is an .npz of nodes, K and M of a bar along x, whose face at x = 0 hangs on a hinge along y. Exudyn takes it as
`ObjectFFRF`, with gravity along -z, by generalised-alpha. Prints one line of JSON: CPU seconds of the run, and where a
corner of the other face is at its end.
"""

from __future__ import annotations

import json
import sys
import time

sys.exudynFast = True  # type: ignore[attr-defined]  # its module without range checks, which is the faster one

import exudyn  # noqa: E402
import exudyn.itemInterface as items  # noqa: E402
import numpy as np  # noqa: E402
import scipy.sparse as sp  # noqa: E402
from exudyn.FEM import FEMinterface, ObjectFFRFinterface  # noqa: E402

GRAVITY = [0.0, 0.0, -9.81]


def measured(path: str, step: float, steps: int) -> dict[str, object]:
    """Return seconds and the end of a run."""
    fem = FEMinterface()
    with np.load(path) as arrays:
        nodes = arrays["nodes"]
        fem.nodes = {"Position": nodes}
        for what, field in (("mass", "massMatrix"), ("stiffness", "stiffnessMatrix")):
            parts = (arrays[f"{what}_data"], arrays[f"{what}_indices"], arrays[f"{what}_indptr"])
            setattr(fem, field, sp.csr_matrix(parts))
    fem.ComputeEigenmodes(8, excludeRigidBodyModes=6, useSparseSolver=True)  # asked for, and not used in the run
    mbs = exudyn.SystemContainer().AddSystem()
    body = ObjectFFRFinterface(fem).AddObjectFFRF(exudyn, mbs, constrainRigidBodyMotion=True)
    # its mass-proportional load lifts such a body: the weight is a force on all nodes, shared as their masses are
    shares = np.asarray(fem.massMatrix.sum(axis=1)).reshape(-1, 3)[:, 2]
    everywhere = mbs.AddMarker(
        items.MarkerSuperElementPosition(
            bodyNumber=body["oFFRF"], meshNodeNumbers=np.arange(len(nodes)), weightingFactors=shares / shares.sum()
        )
    )
    mbs.AddLoad(items.LoadForceVector(markerNumber=everywhere, loadVector=[shares.sum() * g for g in GRAVITY]))
    ground = mbs.AddObject(items.ObjectGround())
    # it has no marker with a rotation for such a body: the hinge is a ball joint at each edge of the face
    for side, axes in ((nodes[:, 1].min(), [1, 1, 1]), (nodes[:, 1].max(), [1, 0, 1])):
        edge = np.flatnonzero((abs(nodes[:, 0]) < 1e-9) & (abs(nodes[:, 1] - side) < 1e-9))
        centre = list(nodes[edge].mean(axis=0))
        markers = [
            mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=centre)),
            mbs.AddMarker(
                items.MarkerSuperElementPosition(
                    bodyNumber=body["oFFRF"], meshNodeNumbers=edge, weightingFactors=np.ones(len(edge)) / len(edge)
                )
            ),
        ]
        mbs.AddObject(items.ObjectJointSpherical(markerNumbers=markers, constrainedAxes=axes))
    corner = int(np.argmax(nodes @ (1.0, 0.1, 0.01)))
    place = mbs.AddSensor(
        items.SensorSuperElement(
            bodyNumber=body["oFFRF"],
            meshNodeNumber=corner,
            storeInternal=True,
            writeToFile=False,
            outputVariableType=exudyn.OutputVariableType.Position,
        )
    )
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = steps * step
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    settings.parallel.numberOfThreads = 1
    start = time.process_time()
    mbs.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.GeneralizedAlpha)
    return {"seconds": time.process_time() - start, "end": np.array(mbs.GetSensorValues(place)).tolist()}


if __name__ == "__main__":
    print(json.dumps(measured(sys.argv[1], float(sys.argv[2]), int(sys.argv[3]))))
