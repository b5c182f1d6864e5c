"""The door to rainflow: cycles of a history by ASTM E1049-85, 5.4.4."""

from __future__ import annotations

import numpy as np

from kanefe.errors import MissingDependency


def cycles_of(history: np.ndarray) -> np.ndarray:
    """Return range, mean and count of each cycle of a history (T,), shape (cycles, 3).

    Raises
    ------
    MissingDependency
        If rainflow is not installed.
    """
    try:
        import rainflow
    except ImportError as problem:
        raise MissingDependency("rainflow", "counting cycles", "pip install 'kanefe[fatigue]'") from problem
    values = history.tolist()
    # of two values the library makes no cycle, but half a one if the last is repeated
    found = [cycle[:3] for cycle in rainflow.extract_cycles([*values, values[-1]])]
    return np.array(found, dtype=float).reshape(-1, 3)
