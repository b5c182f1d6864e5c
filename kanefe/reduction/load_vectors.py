"""Load-dependent vectors: static shapes of load cases, which make a basis statically complete for them.

Wilson, Yuan & Dickens (1982), "Dynamic analysis by direct superposition of Ritz vectors".
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.reduction.load_cases import Load, load_groups
from kanefe.statics import StaticProblem


def load_vectors(problem: StaticProblem, loads: Sequence[Load]) -> tuple[np.ndarray, dict[str, int]]:
    """Return the static shapes of loads, shape (tied, m), and how many each group of them has.

    Of a floating body: under the loads balanced by the inertia of its rigid motion.
    """
    groups = load_groups(problem, loads)
    if not groups:
        return np.zeros((problem.size, 0)), {}
    shapes = problem.solve(np.hstack([group.forces for group in groups]))
    return shapes, {group.name: group.forces.shape[1] for group in groups}
