"""C06: a slider-crank with a flexible rod, driven at 150 rad/s."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.work_precision.scene import BenchScene, Setting
from kanefe.checks.verification.scenes import displaced_node
from kanefe.equations.model import Model
from kanefe.fe_model.interface import Interface
from kanefe_fem.verification import slider_crank

END = 0.08
OUTPUTS = 40
MIDDLE = slider_crank.ELEMENTS // 2


def crank() -> Model:
    """Return the mechanism, whose rod has its chord as the frame G."""
    held = Interface(fixed=("x", "y"))
    return slider_crank.slider_crank({"root": held, "tip": held})


def middle(model: Model, t: float, q: np.ndarray) -> np.ndarray:
    """Return the position in N of the middle of the rod, m."""
    return displaced_node(model, "rod", MIDDLE, (t, q, np.zeros(model.free_count)))[0]


def sliding_crank() -> BenchScene:
    """Return C06."""
    numbers = (slider_crank.CRANK, slider_crank.ROD, slider_crank.RATE, slider_crank.SLIDER, slider_crank.ELEMENTS)
    return BenchScene(
        name="C06",
        title="C06 · flexible slider-crank, a closed loop",
        build=crank,
        measure=middle,
        quantity=f"middle of the rod, largest of {OUTPUTS} times to {END:g} s",
        end=END,
        reference=Setting("dop853", rtol=1e-11),
        agreement=1e-9,
        outputs=OUTPUTS,
        largest_step=1e-3,
        parameters={"numbers": numbers, "end": END},
    )


SCENES: dict[str, Callable[[], BenchScene]] = {"C06": sliding_crank}
