"""Runs of unreduced bodies, alone in a process.

    python -m benchmarks.unreduced_process matrices MESH FILE       K, M and nodes of a mesh, for the peer
    python -m benchmarks.unreduced_process swing MESH SPAN ROUNDS   the bar on a hinge: time of a step, and where it is
    python -m benchmarks.unreduced_process iterate MESH COUNT       time of an iteration, and of a triangular solve

Prints one line of JSON.
"""

from __future__ import annotations

import json
import sys
import time
from statistics import median
from typing import Any

E, NU, RHO = 210e9, 0.3, 7850.0
RTOL = 1e-5

SWING = 4.0
"""Seconds of the run that is timed, some 1000 steps: long enough for the few factorisations not to count."""


def _body(mesh: str) -> Any:
    from kanefe_fem.materials.isotropic import Material
    from kanefe_fem.solids.body import solid_body

    return solid_body(mesh, Material(E=E, nu=NU, rho=RHO), {"root": "clamped"}, None, cache=False)


def _scene(body: Any) -> Any:
    import kanefe as kf

    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_flexible_body("bar", body, joint=kf.Revolute("y"))
    return scene


def _stepper(body: Any, span: float) -> Any:
    from kanefe.integrate.dynamics import Dynamics
    from kanefe.integrate.methods.generalised_alpha_unreduced import METHOD
    from kanefe.integrate.stepper import StepControl

    return METHOD.make(Dynamics(_scene(body).freeze()), 0.0, span, StepControl(RTOL, 0.0, None))


def matrices(mesh: str, file: str) -> dict[str, Any]:
    """Write what the peer reads."""
    import numpy as np

    from kanefe_fem.materials.isotropic import Material
    from kanefe_fem.solids.model import solid_model

    model = solid_model(mesh, Material(E=E, nu=NU, rho=RHO))
    arrays = {"nodes": model.nodes}
    for name, matrix in (("stiffness", model.stiffness), ("mass", model.mass)):
        arrays |= {f"{name}_{part}": getattr(matrix, part) for part in ("data", "indices", "indptr")}
    np.savez(file, **arrays)
    return {"nodes": len(model.nodes)}


def swing(mesh: str, span: str, rounds: str) -> dict[str, Any]:
    """Return CPU seconds of a step, matrices of all step sizes factored in them, and the end of a run of `span` s."""
    import numpy as np

    body = _body(mesh)
    end = _scene(body).simulate((0.0, float(span)), rtol=RTOL, output_step=float(span))
    corner = int(np.argmax(body.nodes @ (1.0, 0.1, 0.01)))
    times = []
    for _ in range(int(rounds) + 1):
        stepper = _stepper(body, SWING)
        states = np.empty((1, len(stepper.state())))
        start = time.process_time()
        stepper.integrate_through(np.array([SWING]), states, 1_000_000)
        times.append((time.process_time() - start) / stepper.statistics["steps"])
    return {
        "seconds": times[1:],
        **stepper.statistics,
        "end": end.nodal_positions("bar", frames=-1, nodes=[corner])[0].tolist(),
    }


def iterate(mesh: str, count: str) -> dict[str, Any]:
    """Return CPU seconds of a Newton iteration, of a solve with the factors of S, and of a factorisation."""
    import numpy as np

    body = _body(mesh)
    start = time.process_time()
    stepper = _stepper(body, 0.02)
    first = time.process_time() - start
    h, du = 0.02 / 512, stepper.accelerations(np.zeros(1))[0]
    start = time.process_time()
    done = stepper.iterate(h, du)  # factors S
    factoring = time.process_time() - start
    [border] = done.bordered.borders
    right = np.random.default_rng(0).standard_normal(body.free_count)
    clocks: dict[str, list[float]] = {"iteration": [], "solve": []}
    for _ in range(int(count)):
        for name, call in (
            ("iteration", lambda: stepper.iterate(h, du)),
            ("solve", lambda: border.factors.solve(right)),
        ):
            start = time.process_time()
            call()
            clocks[name].append(time.process_time() - start)
    return {
        **{name: median(values) for name, values in clocks.items()},
        "ratio": median([a / b for a, b in zip(clocks["iteration"], clocks["solve"], strict=True)]),
        "factoring": factoring,
        "start": first,
        "dofs": body.free_count,
    }


if __name__ == "__main__":
    print(json.dumps({"matrices": matrices, "swing": swing, "iterate": iterate}[sys.argv[1]](*sys.argv[2:])))
