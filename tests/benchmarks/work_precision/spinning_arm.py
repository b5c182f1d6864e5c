"""S2: a flexible arm that spins up to 1.6 times its first natural frequency, as a reduced body that stiffens."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np

from benchmarks.work_precision.scene import BenchScene, Setting
from kanefe.bodies.flexible import FlexibleBody
from kanefe.equations.model import Model
from kanefe.joints import Revolute
from kanefe.reduction import CraigBampton
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Section
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.verification import spin_up

END = 20.0
OUTPUTS = 200
PEAK = 0.57384
"""Largest tip deflection of a geometrically exact beam, m (D01)."""

ELEMENTS = 20


@cache
def arm(modes: int) -> FlexibleBody:
    """Return the arm of planar Timoshenko beams with `modes` normal modes beside the three of its tip."""
    of_density = spin_up.LINE_INERTIA / spin_up.DENSITY
    section = Section(A=spin_up.AREA, I_y=of_density, I_z=of_density, J=1e-6)
    E = spin_up.EA / spin_up.AREA
    material = Material(E=E, nu=section.shear_y * spin_up.EA / spin_up.GA / 2.0 - 1.0, rho=spin_up.DENSITY)
    model = straight_beam(spin_up.LENGTH, section, material, elements=ELEMENTS, planar=True)
    interfaces = {"root": "clamped", "tip": "rigid"}
    return beam_body(model, interfaces, reduction=CraigBampton(modes=modes), stiffening="full")


def spinning(modes: int) -> Model:
    """Return the arm on its hub."""
    scene = System()
    scene.add_flexible_body("arm", arm(modes), joint=Revolute("z", motion=spin_up.spin_up().compiled()))
    return scene.freeze()


def deflection(model: Model, t: float, q: np.ndarray) -> np.ndarray:
    """Return the displacement of the tip across the arm, in the frame of the hub, (1,), m."""
    return spin_up.tip_motion(model, (t, q, np.zeros(model.free_count)))[1:2]


def peak(values: np.ndarray) -> float:
    """Return the largest deflection between samples of it at equal steps, by a parabola through three of them, m."""
    size = np.abs(np.ravel(values))
    at = min(max(int(np.argmax(size)), 1), len(size) - 2)
    before, top, after = size[at - 1 : at + 2]
    bend = before - 2.0 * top + after
    return float(top - (after - before) ** 2 / (8.0 * bend)) if bend < 0.0 else float(top)


def spinning_arm(modes: int, name: str) -> BenchScene:
    """Return S2 with so many normal modes."""
    return BenchScene(
        name=name,
        title=f"S2 · spin-up with stiffening, {modes + 3} modes",
        build=lambda: spinning(modes),
        measure=deflection,
        quantity=f"tip deflection, largest of {OUTPUTS} times to {END:g} s",
        end=END,
        reference=Setting("dop853", rtol=1e-9),
        agreement=3e-7,
        outputs=OUTPUTS,
        largest_step=0.1,
        parameters={"modes": modes, "elements": ELEMENTS, "arm": _numbers(), "end": END},
    )


def _numbers() -> tuple[float, ...]:
    return tuple(
        float(getattr(spin_up, name)) for name in ("LENGTH", "EA", "GA", "EI", "LINE_MASS", "LINE_INERTIA", "DENSITY")
    )


SCENES: dict[str, Callable[[], BenchScene]] = {"S2": partial(spinning_arm, 4, "S2")}
