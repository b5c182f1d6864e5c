"""One run of the finite element side, alone in a process: what a mesh costs in time and in memory.

    python -m benchmarks.fe_process body MESH MODES     a Craig-Bampton body from a mesh file, all compiled and imported
    python -m benchmarks.fe_process shell MESH MODES    the same of a sheet
    python -m benchmarks.fe_process shell_matrices MESH FILE       K and M of the sheet, for the peer
    python -m benchmarks.fe_process evaluations SHEET BAR MODES    right-hand sides of both bodies in turn
    python -m benchmarks.fe_process matrices MESH       our matrices and dolfinx's own calls in turn
    python -m benchmarks.fe_process scene MESH MODES    a scene with that body, up to its first time step

Prints one line of JSON.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.fe_meshes import bar, sheet

E, NU, RHO = 210e9, 0.3, 7850.0
THICKNESS = 2e-3
ENDS = {"root": "clamped", "tip": "rigid"}


def body(mesh: str, modes: str) -> dict[str, Any]:
    """Return seconds, peak memory and the frequencies of the body with both ends held."""
    return _timed(bar, mesh, modes)


def shell(mesh: str, modes: str) -> dict[str, Any]:
    """Return the same of a body of a sheet."""
    return _timed(sheet, mesh, modes)


def _timed(kind: Callable[[Path, str], Path], mesh: str, modes: str) -> dict[str, Any]:
    import resource

    small = str(kind(Path(mesh).parent, "3k"))
    start = time.process_time()
    made(kind, small, 4)  # imports, and compiles the forms
    warm_up = time.process_time() - start

    wall, start = time.perf_counter(), time.process_time()
    arm = made(kind, mesh, int(modes))
    return {
        "cpu": time.process_time() - start,
        "wall": time.perf_counter() - wall,
        "warm_up": warm_up,
        "stages": arm.provenance["stages"],
        "gigabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024e-9,
        "dofs": arm.basis.shape[0],
        "frequencies": held_frequencies(arm),
    }


def made(kind: Callable[[Path, str], Path], mesh: str, modes: int) -> Any:
    """Return the body of a mesh of one of the kinds of `benchmarks.fe_meshes`."""
    import kanefe as kf
    from kanefe_fem import Material, shell_body, solid_body

    steel, reduction = Material(E=E, nu=NU, rho=RHO), kf.CraigBampton(modes=modes)
    if kind is sheet:
        return shell_body(mesh, steel, ENDS, THICKNESS, reduction, cache=False)
    return solid_body(mesh, steel, ENDS, reduction=reduction, cache=False)


def shell_matrices(mesh: str, path: str) -> dict[str, Any]:
    """Write K and M of a sheet, its nodes, and which of them are held at either end."""
    import numpy as np

    from kanefe_fem import Material, shell_model

    model = shell_model(mesh, Material(E=E, nu=NU, rho=RHO), THICKNESS)
    of = {"K": model.stiffness, "M": model.mass}
    parts = {f"{name}_{part}": getattr(of[name], part) for name in of for part in ("data", "indices", "indptr")}
    np.savez(path, nodes=model.nodes, **parts, **{name: model.groups[name].nodes for name in ENDS})
    return {"dofs": model.size}


def evaluations(sheet_file: str, bar_file: str, modes: str) -> dict[str, Any]:
    """Return the seconds of a right-hand side with a body of a sheet and with one of a bar, in pairs."""
    from benchmarks.clocks import fill, repeated
    from benchmarks.engine_scenes import evaluation
    from benchmarks.work_precision.steel_bar import hinged_bar

    bodies = [made(kind, mesh, int(modes)) for kind, mesh in ((sheet, sheet_file), (bar, bar_file))]
    sides = [evaluation(hinged_bar(body)) for body in bodies]
    for side in sides:
        side()  # loads the kernels
    counts = [fill(side) for side in sides]
    pairs = [[repeated(side, count) for side, count in zip(sides, counts, strict=True)] for _ in range(15)]
    return {"shell": [pair[0] for pair in pairs], "solid": [pair[1] for pair in pairs]}


def held_frequencies(arm: Any) -> list[float]:
    """Return the frequencies of a body with its free interface held as well, Hz."""
    import numpy as np
    import scipy.linalg

    k = arm.free_count
    held = scipy.linalg.null_space(arm.interface("tip").motion[:, :k])
    K, M = (held.T @ matrix[:k, :k] @ held for matrix in (arm.stiffness, arm.moments.elastic_mass))
    return list(np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)) / (2 * np.pi))


def matrices(path: str) -> dict[str, Any]:
    """Return seconds of our matrices, and of dolfinx's own calls for the same ones, in turn."""
    from kanefe_fem.materials.isotropic import Material
    from kanefe_fem.mesh.mesh import to_order
    from kanefe_fem.mesh_files import read_mesh
    from kanefe_fem.solids.model import solid_model

    mesh = read_mesh(path)
    lifted = to_order(mesh, 2)
    steel = Material(E=E, nu=NU, rho=RHO)
    ours, theirs = [], []
    for _ in range(4):
        start = time.process_time()
        model = solid_model(mesh, steel)
        ours.append(time.process_time() - start)
        start = time.process_time()
        K, M = dolfinx_matrices(mesh)
        theirs.append(time.process_time() - start)
    x = model.nodes[:, 0].repeat(3)
    energies = [float(x @ model.stiffness @ x), float(x @ model.mass @ x)]
    return {
        "ours": ours[1:],
        "theirs": theirs[1:],
        "dofs": len(lifted.nodes) * 3,
        "energies": energies,
        "traces": [
            [model.stiffness.diagonal().sum(), model.mass.diagonal().sum()],
            [K.diagonal().sum(), M.diagonal().sum()],
        ],
    }


def dolfinx_matrices(mesh: Any) -> tuple[Any, Any]:
    """Return K and M by dolfinx's own functions, in its numbering: mesh, space, two forms, two matrices."""
    import scipy.sparse as sp

    from kanefe.fe_model.shapes import shape
    from kanefe_fem import _fenicsx

    fx = _fenicsx.load()
    domain = _fenicsx.create_mesh(fx, mesh.nodes, mesh.connectivity, shape("tetra"))
    space = _fenicsx.lagrange_space(fx, domain, shape("tetra10"), 3)
    u, v = fx.ufl.TrialFunction(space), fx.ufl.TestFunction(space)
    e, f = fx.ufl.sym(fx.ufl.grad(u)), fx.ufl.sym(fx.ufl.grad(v))
    lame = fx.fem.Constant(domain, E * NU / ((1 + NU) * (1 - 2 * NU)))
    shear, density = fx.fem.Constant(domain, E / (2 * (1 + NU))), fx.fem.Constant(domain, RHO)
    energy = lame * fx.ufl.tr(e) * fx.ufl.tr(f) + 2.0 * shear * fx.ufl.inner(e, f)
    found = []
    for form in (energy * fx.ufl.dx, density * fx.ufl.inner(u, v) * fx.ufl.dx):
        matrix = fx.petsc.assemble_matrix(fx.fem.form(form))
        matrix.assemble()
        indptr, indices, data = matrix.getValuesCSR()
        found.append(sp.csr_matrix((data, indices, indptr), shape=matrix.getSize()))
    return found[0], found[1]


def scene(mesh: str, modes: str) -> dict[str, Any]:
    """Make a scene with the body from a mesh and go one step; tell when that was, and the CPU time of the process."""
    import kanefe as kf
    from kanefe_fem.materials.isotropic import Material
    from kanefe_fem.solids.body import solid_body

    arm = solid_body(mesh, Material(E=E, nu=NU, rho=RHO), ENDS, reduction=kf.CraigBampton(modes=int(modes)))
    swing = kf.System(gravity=(0.0, 0.0, -9.81))
    swing.add_flexible_body("bar", arm, joint=kf.Revolute("y"))
    result = swing.simulate((0.0, 1e-4), method="generalised-alpha", output_step=1e-4)
    heavy = [name for name in ("gmsh", "meshio", "dolfinx", "petsc4py") if name in sys.modules]
    found = arm.provenance["cache"]["found"]
    return {"at": time.time(), "cpu": time.process_time(), "heavy": heavy, "found": found, "times": len(result.times)}


if __name__ == "__main__":
    parts = (body, shell, shell_matrices, evaluations, matrices, scene)
    print(json.dumps({part.__name__: part for part in parts}[sys.argv[1]](*sys.argv[2:])))
