"""Anderson's acceleration: slow and divergent directions of an iteration are found and left out."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np

from repository import surroundings

# a kernel is for kernels only: here it is plain Python
SOLVE = """
import json
import numpy as np
from kanefe.kernels.steppers.mixing import ROWS_OF_MIXING, mix

rng = np.random.default_rng(0)
n = 12
basis = np.linalg.qr(rng.standard_normal((n, n)))[0] + 0.1 * rng.standard_normal((n, n))
rates = np.concatenate(([-5.0, 0.9, -0.55], np.zeros(n - 3)))
A, target = basis @ np.diag(rates) @ np.linalg.inv(basis), rng.standard_normal(n)
weights = 10.0 ** rng.uniform(-1, 1, n)
memory, x, errors = np.full((ROWS_OF_MIXING, n), np.nan), np.zeros(n), []
for call in range(15):
    g = target + A @ (x - target)
    mix(memory, call, weights * (g - x), g, x)
    errors.append(float(abs(x - target).max()))
print(json.dumps(errors))
"""


def test_directions_of_slow_convergence_cost_one_iteration_each() -> None:
    environment = surroundings(KANEFE_JIT="0")
    run = subprocess.run([sys.executable, "-c", SOLVE], env=environment, capture_output=True, text=True, check=True)
    errors = np.array(json.loads(run.stdout))
    # a linear iteration with three rates beside zero ends after four changes, up to round-off times 1e2 of the basis;
    # without mixing the first rate makes 5^15 of an error, and once at rest it must stay so
    assert errors[0] > 1.0
    assert errors[4:].max() < 1e-11
