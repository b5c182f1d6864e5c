"""The skips, each as a scene that is run with and without it.

What skipping saves: each skip of a scene that needs less, timed with and without it, and that both agree.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np

from benchmarks.clocks import FEW_ROUNDS, Race, seconds
from benchmarks.work_precision import steel_bar, swinging_arm
from benchmarks.work_precision.rigid_chain import chain_scene
from kanefe.bodies.flexible import FlexibleBody
from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.integrate.run import integrate
from kanefe.kernels.bodies import ModalBodies
from kanefe.order_n.route import OrderN
from kanefe.result import Result

LINKS = 20


CHAIN = f"a step of {LINKS} links"


STEPS = 1000


STEP, BAR_STEP = 1e-3, 1e-5


HEAVY = ("dolfinx", "petsc4py", "gmsh", "matplotlib", "pyvista", "h5py", "meshio")


START = """
import importlib, json, sys, time
for name in json.loads(sys.argv[1]):
    importlib.import_module(name)
import kanefe as kf
scene = kf.System(gravity=(0.0, 0.0, -9.81))
scene.add_rigid_body("link", 1.0, 0.1, com=(0.5, 0.0, 0.0), joint=kf.Revolute("y"))
model = scene.freeze()
print(json.dumps([model.rhs(0.0, model.initial_state).tolist(), time.process_time()]))
"""
"""A program that uses none of the heavy packages."""


def imports(rounds: int) -> Skip:
    """Import only what a scene uses, or all that kanefe can use."""

    def program(names: list[str]) -> list[Any]:
        command = [sys.executable, "-c", START, json.dumps(names)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=dict(os.environ))
        if done.returncode:
            raise SimulationError(f"a program that imports {names} fails: {done.stderr.strip()[-200:]}")
        answer: list[Any] = json.loads(done.stdout.strip().splitlines()[-1])
        return answer

    heavy = [name for name in HEAVY if find_spec(name)]
    ran = [program(names) for names in ([], heavy)]
    clocks = (lambda: float(program([])[1]), lambda: float(program(heavy)[1]))
    what = f"imports that are not used: {', '.join(heavy)}"
    return compared(what, "a program with one pendulum", clocks, (ran[0][0], ran[1][0]), min(rounds, FEW_ROUNDS))


def planar(rounds: int) -> Skip:
    """Take three speeds a body in a plane, or six in space."""

    def to_space(model: Model) -> None:
        model.__dict__["route"] = OrderN(model)

    what = "motion out of the plane: 3 speeds a body, no gyroscopic moments"
    return _of_steps(what, CHAIN, partial(_chain, "y"), to_space, STEP, rounds)


def damping(rounds: int) -> Skip:
    """Leave out the product with the damping matrix where C = 0, or multiply by zeros."""

    def with_zeros(model: Model) -> None:
        order_n = _tables_of(model)
        flexible = order_n.flexible
        bodies = flexible.bodies.copy()
        records = ModalBodies(bodies, flexible.pool, np.zeros(0))
        if len(records) == 0 or records[0].damped != -1:
            raise SimulationError("the bar of S4 should be flexible and without damping")
        k, records[0].damped = records[0].k, len(flexible.pool)
        order_n.flexible = flexible._replace(bodies=bodies, pool=np.concatenate((flexible.pool, np.zeros(k * k))))

    def build() -> Model:
        return steel_bar.free_bar(steel_bar.free_body())

    timed = f"a step of S4, {steel_bar.FREE_MODES} modes"
    return _of_steps("damping where C = 0", timed, build, with_zeros, BAR_STEP, rounds)


def forces(rounds: int) -> Skip:
    """Leave out forces that do no work, or ask for them at every output."""
    model = swinging_arm.swinging_arm().build()

    def run(asks: bool) -> np.ndarray:
        result = Result(model, integrate(model, (0.0, 0.5), rtol=1e-5, output_step=5e-3, progress=False))
        if asks:
            result.coupling_force("arm", "root")
            result.joint_reaction("hub")
        return result.position("tip")

    clocks = (lambda: seconds(lambda: run(False)), lambda: seconds(lambda: run(True)))
    return compared("forces F_u that nobody asks for", "the demo to 0.5 s", clocks, (run(False), run(True)), rounds)


def cached(rounds: int) -> Skip:
    """Read a body whose mesh and options have not changed from the cache, or assemble and reduce it again."""

    def make(is_cached: bool) -> FlexibleBody:
        return steel_bar.made_body(8, is_cached=is_cached)

    make(True)
    clocks = (lambda: seconds(lambda: make(True)), lambda: seconds(lambda: make(False)))
    values = (make(True).frequencies, make(False).frequencies)
    return compared(
        "assembly and reduction of an unchanged mesh", "the body of S3", clocks, values, min(rounds, FEW_ROUNDS)
    )


SKIPS: dict[str, Callable[[int], Skip]] = {
    "imports": imports,
    "planar": planar,
    "damping": damping,
    "forces": forces,
    "cached": cached,
}


def _chain(axes: str = "yz") -> Model:
    return chain_scene(LINKS, axes).freeze()


def _rates(order_n: OrderN, y: np.ndarray) -> np.ndarray:
    return order_n.held_rates(0.0, y)[0]


def _tables_of(model: Model) -> OrderN:
    """Return the route of a model, whose tables are changed."""
    if not isinstance(model.route, OrderN):
        raise SimulationError("the scene has no tables to be changed")
    return model.route


def _of_steps(
    what: str, timed: str, build: Callable[[], Model], undo: Callable[[Model], None], step: float, rounds: int
) -> Skip:
    """Return a skip from compiled runs of a scene and of the same one whose tables were changed."""
    sparing, full = build(), build()
    undo(full)
    end = STEPS * step

    def run(model: Model) -> np.ndarray:
        found = integrate(model, (0.0, end), method="rk4", step=step, output_step=end, progress=False)
        return np.concatenate((found.coordinates[-1], found.speeds[-1]))

    clocks = (lambda: seconds(lambda: run(sparing)) / STEPS, lambda: seconds(lambda: run(full)) / STEPS)
    return compared(what, timed, clocks, (run(sparing), run(full)), rounds)


SAME = 1e-9
"""Largest difference of the two results relative to the largest number: sums are rounded in a different order."""


@dataclass(frozen=True)
class Skip:
    """A skip and what it saves.

    Attributes
    ----------
    what : str
        What is skipped, and where.
    timed : str
        Of what the times are.
    sparing, full : float
        CPU seconds with the skip and without it.
    difference : float
        Of the results, as a part of the largest number.
    """

    what: str
    timed: str
    sparing: float
    full: float
    difference: float

    @property
    def agrees(self) -> bool:
        """Whether both give the same."""
        return bool(self.difference <= SAME)

    def told(self) -> dict[str, Any]:
        """Return the skip as JSON has it."""
        return {**asdict(self), "saved": 1.0 - self.sparing / self.full, "agrees": self.agrees}


Clock = Callable[[], float]


def compared(what: str, timed: str, clocks: tuple[Clock, Clock], values: tuple[Any, Any], rounds: int) -> Skip:
    """Return a skip from its two clocks (s), with and without it, and what both give."""
    race = Race(*clocks, rounds)
    with_skip, without = (np.asarray(value, dtype=float).ravel() for value in values)
    difference = float(np.abs(with_skip - without).max() / np.abs(without).max())
    return Skip(what, timed, race.ours, race.theirs, difference)


def skips_table(rows: Sequence[Skip]) -> str:
    """Return the skips as a table for a terminal."""
    lines = [("skipped", "of", "with the skip", "without", "saved", "results differ by", "")]
    for row in rows:
        lines.append(
            (
                row.what,
                row.timed,
                _time(row.sparing),
                _time(row.full),
                f"{100 * (1 - row.sparing / row.full):.0f} %",
                f"{row.difference:.1e}",
                "" if row.agrees else "NO",
            )
        )
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)).rstrip() for line in lines)


def _time(seconds: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{1e9 * seconds:.3g} ns"
