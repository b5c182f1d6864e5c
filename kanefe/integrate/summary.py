"""A run told in a few lines: how it ended, what did it, and what it cost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from kanefe.integrate.status import RunStatus

LEAST_SECONDS = 5e-4
"""Parts of a run that took less are not told."""


def summary(status: RunStatus, statistics: Mapping[str, Any], events: Mapping[str, np.ndarray]) -> str:
    """Return some lines about a run.

    Examples
    --------
    >>> counts = {"steps": 214, "rejected": 3, "evaluations": 2390, "factorisations": 0, "jacobians": 0}
    >>> told = {"method": "dop853", "reason": "no stiff elastic modes", "rtol": 1e-6, **counts, "seconds": 0.0125}
    >>> told["seconds_by_part"] = {"set-up": 0.0025, "steps": 0.01}
    >>> print(summary(RunStatus("finished", 5.0), told, {"floor": np.array([0.45, 1.2])}))
    the run finished at t = 5 s
      method  dop853 (no stiff elastic modes), rtol 1e-06
      counts  214 steps, 3 rejected, 2390 evaluations
      time    0.0125 s: set-up 0.0025, steps 0.01
      events  floor 2
    """
    control = [f"{name} {statistics[name]:g}" for name in ("rtol", "step") if name in statistics]
    counts = [
        f"{value} {name}" for name, value in statistics.items() if isinstance(value, int) and (value or name == "steps")
    ]
    parts = [
        f"{name} {seconds:.3g}" for name, seconds in statistics["seconds_by_part"].items() if seconds >= LEAST_SECONDS
    ]
    lines = [
        str(status),
        "  method  " + ", ".join((f"{statistics['method']} ({statistics['reason']})", *control)),
        "  counts  " + ", ".join(counts),
        f"  time    {statistics['seconds']:.3g} s" + (f": {', '.join(parts)}" if parts else ""),
    ]
    if events:
        lines.append("  events  " + ", ".join(f"{name} {len(times)}" for name, times in events.items()))
    return "\n".join(lines)
