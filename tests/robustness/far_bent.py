"""Bodies that bend far: rods twisted by a hundred turns, whips, strips on a tether, and arches that snap through."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator

import numpy as np

from kanefe.bodies.exact.beam import ExactBeam
from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.errors import SimulationWarning
from kanefe.fe_model.damping import RayleighDamping
from kanefe.frames import rotation_about
from kanefe.joints import Revolute
from kanefe.linear.paths.equilibrium_path import equilibrium_path
from kanefe.loads.rope import Rope
from kanefe.system import System
from kanefe_fem import Section, exact_beam
from kanefe_fem.beams.stiffness_section import StiffnessSection

LENGTH, TORSION, ROUND = 2.0, 40.0, 0.1
"""Length of a rod (m), its GJ (N m2) and its inertia against bending per length (kg m), half of that about its axis."""

METHODS = {"dop853": 1e-9, "radau5": 1e-8, "generalised-alpha": 1e-6}
"""Tolerance (relative) of each method."""


def rod(twist: int) -> ExactBeam:
    """Return a rod with so many functions of twist and two of each curvature."""
    section = Section.from_stiffness(stiffness=np.diag((1e4, 1e4, 1e4, TORSION, 50.0, 60.0)), rho_A=1.0, rho_I=ROUND)
    basis = {"twist": twist, "curvature_y": 2, "curvature_z": 2}
    return exact_beam(LENGTH, section, theory="shear-rigid", basis=basis, interfaces={"root": 0.0, "tip": LENGTH})


def twists(effort: Effort) -> Iterator[Finding]:
    """Let a clamped rod swing back from many turns, in its first mode of torsion."""
    count = 8
    places, weights = np.polynomial.legendre.leggauss(40)
    shape = 0.5 * math.pi / LENGTH * np.cos(0.25 * math.pi * (1.0 + places))
    parts = [
        (k + 0.5) * float(weights @ (shape * np.polynomial.legendre.Legendre.basis(k)(places))) for k in range(count)
    ]
    period = 4.0 * LENGTH * math.sqrt(2.0 * ROUND / TORSION)
    for turns in (2, 100):
        angle = 2.0 * math.pi * turns
        scene = System()
        start = angle * np.array((*parts, *np.zeros(4)))
        scene.add_flexible_body("rod", rod(count), modal_coordinates=start.tolist())
        for method, rtol in METHODS.items():
            span = (1.0 if effort.is_quick else 20.0) * period
            run = scene.simulate((0.0, span), method=method, rtol=rtol, output_step=period / 40.0)
            q = run.modal_coordinates("rod")
            tip = q[:, 0] * LENGTH
            error = float(np.abs(tip - angle * np.cos(2.0 * math.pi * run.times / period)).max() / angle)
            # order 2 of generalised-alpha leaves its phase; others the tolerance of each step, and eight functions 1e-9
            limit = 2e-3 * span / period if method == "generalised-alpha" else 1e-6 * span / period
            what, note = f"rod twisted by {turns} turns, let go", f"{method}, {run.statistics['steps']} steps"
            yield Finding(
                what, len(tip), "turn of the tip over the first", error, limit, "phase of its vibration", note
            )
            bent = float(np.abs(q[:, count:]).max())
            yield Finding(what, len(tip), "curvature [1/m]", bent, 1e-9, "nothing bends it", note)


def whips(effort: Effort) -> Iterator[Finding]:
    """Swing tapered whips whose tips are forty times as soft as their handles."""

    def section(s: float) -> StiffnessSection:
        size = 1.0 - 0.4 * s
        stiffness = np.diag((1e5 * size**2,) * 3 + (1.5 * size**4, 2.0 * size**4, 2.0 * size**4))
        return Section.from_stiffness(stiffness=stiffness, rho_A=0.3 * size**2, rho_I=1e-4 * size**4)

    whip = exact_beam(1.5, section, theory="shear-rigid", basis=5, interfaces={"root": 0.0, "tip": 1.5})
    scene = System(gravity=(0.0, 0.0, -9.81))
    handle = scene.add_rigid_body("handle", 0.5, 1e-2, joint=Revolute("y", speed=25.0))
    scene.add_flexible_body("whip", whip, parent=handle)
    ends = {}
    for method, rtol in METHODS.items():
        run = scene.simulate((0.0, 0.5 if effort.is_quick else 5.0), method=method, rtol=rtol, output_step=0.01)
        ends[method] = run.position("whip", "tip")[min(50, len(run.times) - 1)]
        lost = float(np.abs(run.energy.balance_error).max() / run.energy.kinetic.max())
        limit = 1e-2 if method == "generalised-alpha" else 1e-6
        note = f"{method}, {run.statistics['steps']} steps, tip up to {_fastest(run.velocity('whip', 'tip')):.0f} m/s"
        yield Finding("whip swung at 25 rad/s", len(run.times), "energy over the largest", lost, limit, "rtol", note)
    apart = float(np.abs(ends["dop853"] - ends["radau5"]).max() / 1.5)
    yield Finding("whip after 0.5 s", 2, "places apart over its length", apart, 1e-5, "rtol of both", "dop853, radau5")


def _fastest(velocity: np.ndarray) -> float:
    return float(np.linalg.norm(velocity, axis=1).max())


def tethers(effort: Effort) -> Iterator[Finding]:
    """Let a strip fall into its tether again and again."""
    section = Section.from_stiffness(stiffness=np.diag((1e5, 1e5, 1e5, 1.5, 2.0, 2.0)), rho_A=0.3, rho_I=1e-4)
    strip = exact_beam(1.0, section, theory="shear-rigid", basis=4, interfaces={"root": 0.0, "tip": 1.0})
    scene = System(gravity=(0.0, 0.0, -9.81))
    member = scene.add_flexible_body("strip", strip)
    anchor = scene.ground.frame(at=(1.0, 0.0, 0.3))
    scene.add(Rope("tether", (anchor, member.interface("tip")), axial_stiffness=500.0, length=0.45))
    events = ("tether slack", "tether taut")
    for method, rtol in METHODS.items():
        span = 1.5 if effort.is_quick else 15.0
        run = scene.simulate((0.0, span), method=method, rtol=rtol, output_step=0.01, events=events)
        count = sum(len(run.events[name]) for name in events)
        lost = float(np.abs(run.energy.balance_error).max() / run.energy.kinetic.max())
        limit = 2e-2 if method == "generalised-alpha" else 1e-5
        note = f"{method}, {run.statistics['steps']} steps"
        yield Finding("strip on a tether", count, "energy over the largest", lost, limit, "rtol and kinks", note)
        yield Finding("strip on a tether", 1, "fewer than four events", float(count < 4), 0.0, "it goes on", note)


def arch(force: Callable[[float], tuple[float, float, float]] | tuple[float, float, float]) -> System:
    """Return a shallow arch, hinged at both feet, under a force beside its middle."""
    radius, angle = 1.25, 0.4
    section = Section.from_stiffness(EA=1e4, EI_z=2.0, rho_A=0.3)
    ends, bent = {"root": 0.0, "load": 0.48, "tip": 2.0 * radius * angle}, (0.0, 0.0, -1.0 / radius)
    damping = RayleighDamping(stiffness=2e-3)
    beam = exact_beam(ends["tip"], section, planar=True, curvature=bent, interfaces=ends, damping=damping)
    scene, reach = System(), radius * math.sin(angle)
    member = scene.add_flexible_body(
        "arch", beam, joint=Revolute("z"), at=(-reach, 0.0, 0.0), orientation=rotation_about("z", angle)
    )
    foot = scene.ground.frame(at=(reach, 0.0, 0.0))
    scene.add_loop_joint("foot", Revolute("z"), foot, member.interface("tip"))
    scene.add_force(member.interface("load"), force)
    return scene


def snaps(effort: Effort) -> Iterator[Finding]:
    """Press an arch through slowly, and back and forth."""
    with warnings.catch_warnings():  # the path ends behind the limit point
        warnings.filterwarnings("ignore", "equilibrium_path: the path ended after", SimulationWarning)
        (limit_point,) = equilibrium_path(arch((0.0, -1.0, 0.0)), to=100.0, points=30).limit_points
    largest, slow, period, periods = limit_point.factor, 20.0, 2.0, 1 if effort.is_quick else 10
    for method in ("auto", "generalised-alpha"):
        pressed = arch(lambda t: (0.0, -1.1 * largest * t / slow, 0.0))
        run = pressed.simulate((0.0, slow), method=method, output_step=slow / 1000)
        height = run.position("arch", "load")[:, 1]
        load = 1.1 * float(run.times[np.argmax(height < 0.0)]) / slow
        what, note = "arch pressed through slowly", f"{method}, {run.statistics['steps']} steps"
        # it falls for a while from the limit point, before it is through
        yield Finding(what, 1, "load over that of the limit point, less 1", abs(load - 1.0), 0.03, "time to fall", note)
        pushed = arch(lambda t: (0.0, -1.5 * largest * math.sin(2.0 * math.pi * t / period), 0.0))
        run = pushed.simulate((0.0, periods * period), method=method, output_step=0.005)
        height = run.position("arch", "load")[:, 1]
        missed = abs(int(np.count_nonzero(np.diff(np.sign(height)))) - 2 * periods)
        what, note = "arch pressed back and forth", f"{method}, {run.statistics['steps']} steps"
        yield Finding(what, 2 * periods, "snaps missed, or too many", float(missed), 0.0, "one each half period", note)
        energy = run.energy
        lost = float(np.abs(energy.balance_error).max() / (energy.kinetic + energy.elastic).max())
        limit = 1e-2 if method == "generalised-alpha" else 1e-5
        yield Finding(what, len(height), "energy over the largest", lost, limit, "rtol", note)


CASES = (
    StressCase("many turns of twist", "rods twisted by a hundred turns", twists),
    StressCase("whips", "tapered whips, fast tips", whips),
    StressCase("tethers", "a strip on a rope that goes slack and taut", tethers),
    StressCase("snap-through", "an arch pressed through, back and forth", snaps),
)
