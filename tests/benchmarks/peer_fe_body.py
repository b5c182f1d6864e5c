"""The peer's way from a mesh file to a Craig-Bampton body; runs in the peers' environment, alone in its process.

    python peer_fe_body.py MESH MODES
    python peer_fe_body.py MATRICES.npz MODES

MESH is gmsh's, format 2.2 in ascii, a steel bar along x from 0 to 1 m. Netgen reads it, NGSolve assembles quadratic
elements, Exudyn takes the matrices over and finds the modes with scipy. Prints one line of JSON: CPU seconds of
assembly, of the modes and of the terms of the moving body (not of reading the mesh), and the frequencies.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import numpy as np
import scipy.sparse as sp

E, NU, RHO, LENGTH = 210e9, 0.3, 7850.0, 1.0


def measured(path: str, modes: int) -> dict[str, object]:
    """Return the seconds of each stage and the first frequencies with both ends held, Hz."""
    sys.exudynFast = True  # type: ignore[attr-defined]  # its module without range checks, which is the faster one
    import exudyn
    import ngsolve
    from exudyn.FEM import FEMinterface, HCBstaticModeSelection, ObjectFFRFreducedOrderInterface
    from netgen.read_gmsh import ReadGmsh

    ngsolve.SetNumThreads(1)
    fem, clock = FEMinterface(), [time.process_time()]
    if path.endswith(".npz"):
        root, tip = imported(fem, np.load(path))
        clock.append(time.process_time())
    else:
        mesh = ngsolve.Mesh(ReadGmsh(path))
        clock = [time.process_time()]
        fem.ImportMeshFromNGsolve(mesh, density=RHO, youngsModulus=E, poissonsRatio=NU, meshOrder=2)
        clock.append(time.process_time())
        root, tip = (fem.GetNodesInPlane([x, 0, 0], [1, 0, 0]) for x in (0.0, LENGTH))
    fem.ComputeHurtyCraigBamptonModes(
        [root, tip], modes, useSparseSolver=True, computationMode=HCBstaticModeSelection.RBE2, timerTreshold=10**9
    )
    clock.append(time.process_time())
    body = ObjectFFRFreducedOrderInterface(fem, rigidBodyNodeType=exudyn.NodeType.RotationRotationVector)
    clock.append(time.process_time())
    stages = ("assemble", "modes", "terms")
    return {
        "seconds": dict(zip(stages, np.diff(clock).tolist(), strict=True)),
        "dofs": 3 * fem.NumberOfNodes(),
        "mass": float(body.totalMass),
        "frequencies": (np.sqrt(np.abs(fem.eigenValues[:modes])) / (2 * np.pi)).tolist(),
    }


def imported(fem: Any, arrays: Any) -> tuple[list[int], list[int]]:
    """Give the peer the matrices of a shell; return its nodes at both ends."""
    fem.nodes = {"Position": np.repeat(arrays["nodes"], 2, axis=0)}
    size = 3 * len(fem.nodes["Position"])
    fem.stiffnessMatrix, fem.massMatrix = (
        sp.csr_matrix(tuple(arrays[f"{name}_{part}"] for part in ("data", "indices", "indptr")), shape=(size, size))
        for name in "KM"
    )
    root, tip = (np.concatenate((2 * arrays[end], 2 * arrays[end] + 1)).tolist() for end in ("root", "tip"))
    return root, tip


if __name__ == "__main__":
    print(json.dumps(measured(sys.argv[1], int(sys.argv[2]))))
