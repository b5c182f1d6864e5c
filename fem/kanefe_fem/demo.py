"""The demonstration ``kanefe demo``: a rigid hub with a motor, a flexible arm from a mesh, a tip mass."""

from __future__ import annotations

import math
import os
import time
from contextlib import ExitStack
from dataclasses import dataclass
from enum import StrEnum
from importlib.resources import as_file, files
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import kanefe as kf
from kanefe_fem.beams.body import beam_body, beam_model
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.recovery.recovery import recover
from kanefe_fem.solids.body import solid_body

ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0, name="aluminium")
END = 2.0  # s
TORQUE, PULSE = 40.0, 0.6  # N m, s; one period of a sine, so that the arm swings and stops
REDUCTION = kf.CraigBampton(modes=12)
DAMPING = kf.ModalDamping(0.01)
INTERFACES = {"root": "clamped", "tip": "rigid"}


@dataclass(frozen=True)
class ArmGeometry:
    """The arm of `meshes/arm.py`: a tapered bar along x with round holes through its thickness, lengths in m."""

    length: float = 1.0
    root_width: float = 0.08
    tip_width: float = 0.05
    thickness: float = 0.04
    holes: tuple[tuple[float, float], ...] = ((0.2, 0.022), (0.4, 0.020), (0.6, 0.018), (0.8, 0.016))

    def width(self, x: float) -> float:
        """Return the width at x in m."""
        return self.root_width + (self.tip_width - self.root_width) * x / self.length

    def mass_properties(self, rho: float) -> tuple[float, float, float]:
        """Return mass (kg), x of the centre of mass (m) and J_zz about the origin (kg m2), in closed form."""
        b, slope, L = self.root_width, (self.tip_width - self.root_width) / self.length, self.length
        area = b * L + slope * L**2 / 2
        first = b * L**2 / 2 + slope * L**3 / 3
        second = b * L**3 / 3 + slope * L**4 / 4  # int x^2 w dx
        # int w^3 / 12 dx of a linear width
        across = L * (self.root_width**2 + self.tip_width**2) * (self.root_width + self.tip_width) / 48
        for x, r in self.holes:
            hole = math.pi * r**2
            area, first = area - hole, first - hole * x
            second, across = second - hole * (x**2 + r**2 / 4), across - hole * r**2 / 4
        scale = rho * self.thickness
        return scale * area, first / area, scale * (second + across)


GEOMETRY = ArmGeometry()


class ArmKind(StrEnum):
    """Kind of elements of the arm."""

    solid = "solid"
    beam = "beam"


def demo(
    body: Annotated[
        ArmKind, typer.Option(help="solid: the mesh through dolfinx; beam: tapered beam elements.")
    ] = ArmKind.solid,
    mesh: Annotated[Path | None, typer.Option(help="Another mesh with groups arm, root and tip.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for plots, VTK series and run.h5.")] = Path("out"),
    ship: Annotated[bool, typer.Option("--ship", help="A helicopter on a moving deck instead.")] = False,
) -> None:
    """Swing a flexible arm with a tip mass by a motor at its hub; print a table, write plots and files."""
    began = time.perf_counter()
    if body is ArmKind.beam and mesh is not None:
        raise kf.ModelError("--mesh has no meaning with --body beam. Remedy: leave one of them out")
    if ship and (body is not ArmKind.solid or mesh is not None):
        raise kf.ModelError("--body and --mesh have no meaning with --ship. Remedy: leave them out")
    _check_folder(out)
    if ship:
        from kanefe_fem.ship_demo import ship_demo

        return ship_demo(out)
    print("kanefe demo: rigid hub with a motor, flexible arm, tip mass\n")
    with ExitStack() as stack:
        path = mesh or stack.enter_context(as_file(files("kanefe_fem") / "data" / "arm.msh"))
        arm = solid_arm(path) if body is ArmKind.solid else beam_arm()
    built = time.perf_counter()
    result = swing_scene(arm).simulate((0.0, END), rtol=1e-6)
    simulated = time.perf_counter()
    forces = result.coupling_force("arm", "root")
    recovered = time.perf_counter()
    names = write_outputs(result, out)
    written = time.perf_counter()
    _print_body(arm, is_known=mesh is None)
    _print_run(result, forces)
    stages = {
        "arm built": built - began,
        "simulated": simulated - built,
        "coupling force": recovered - simulated,
        "files written": written - recovered,
    }
    _row("time", ", ".join(f"{name} {seconds:.2f} s" for name, seconds in stages.items()))
    print(f"\nwritten under {out}/: " + ", ".join(names))


def _check_folder(out: Path) -> None:
    """Make the folder; raise a FileError if nothing could be written to it."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise kf.FileError(f"cannot make the folder {out}: {error.strerror}. Remedy: --out another one") from error
    if not os.access(out, os.W_OK | os.X_OK):
        raise kf.FileError(f"cannot write to the folder {out}. Remedy: --out another one")


def solid_arm(mesh: str | Path) -> kf.FlexibleBody:
    """Return the arm from its mesh: quadratic tetrahedra, 12 normal modes."""
    return solid_body(mesh, {"arm": ALUMINIUM}, INTERFACES, reduction=REDUCTION, damping=DAMPING)


def beam_arm(elements: int = 20) -> kf.FlexibleBody:
    """Return the arm as beam elements with the width at their middles, reduced by the share of the holes."""
    x = np.linspace(0.0, GEOMETRY.length, elements + 1)
    share = GEOMETRY.mass_properties(1.0)[0] / ArmGeometry(holes=()).mass_properties(1.0)[0]
    sections = [Rectangle(share * GEOMETRY.width(0.5 * (a + b)), GEOMETRY.thickness) for a, b in pairwise(x)]
    nodes = np.column_stack((x, np.zeros((elements + 1, 2))))
    lines = np.column_stack((np.arange(elements), np.arange(1, elements + 1)))
    model = beam_model(nodes, lines, sections, ALUMINIUM, groups={"root": 0, "tip": elements})
    return beam_body(model, INTERFACES, reduction=REDUCTION, damping=DAMPING)


def motor_torque(t: float) -> float:
    """Return the torque of the motor in N m."""
    return TORQUE * math.sin(2 * math.pi * t / PULSE) if t < PULSE else 0.0


def swing_scene(body: kf.FlexibleBody) -> kf.System:
    """Return the scene: a hub on a hinge about z, the arm clamped to it, and a mass on the arm's tip."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_rigid_body("hub", mass=4.0, inertia=(0.02, 0.02, 0.03), joint=kf.Revolute("z"))
    arm = scene.add_flexible_body("arm", body, parent=hub, at=(0.1, 0.0, 0.0))
    scene.add_rigid_body("tip", mass=0.5, inertia=(2e-4, 2e-4, 2e-4), parent=arm.interface("tip"))
    scene.add_torque(hub, motor_torque)
    return scene


def write_outputs(result: kf.Result, out: Path) -> list[str]:
    """Write plots, VTK series and run.h5 into a folder; return their names."""
    result.plot(path=out / "overview.png")
    result.plot("energy", path=out / "energy.png")
    result.plot("coupling_force", "arm", "root", path=out / "root_force.png")
    result.to_vtk(out / "arm.pvd", every=5)
    result.save(out / "run.h5")
    moduli = result.body("arm").elasticity
    is_known = moduli is not None and (moduli.axes is None or moduli.fibres is not None)
    stress = [recover(result, "arm")] if is_known else []
    result.to_html(out / "run.html", stress=stress, title="kanefe demo")
    pages = ["arm.pvd (open it in ParaView)", "run.h5", "run.html (open it in a browser)"]
    return ["overview.png", "energy.png", "root_force.png", *pages]


def _print_body(arm: kf.FlexibleBody, is_known: bool) -> None:
    source = arm.provenance
    _row("arm", f"{source.get('element', source.get('source'))}, {len(arm.nodes)} nodes, {arm.basis.shape[0]} dofs")
    _row("reduced to", f"{arm.free_count} modes, {arm.fixed_count} coupling coordinates at the root")
    values = (arm.mass, arm.center_of_mass[0], arm.inertia[2, 2])
    exact = GEOMETRY.mass_properties(ALUMINIUM.rho)
    for name, unit, value, reference in zip(
        ("mass", "centre of mass x", "inertia J_zz"), ("kg", "m", "kg m2"), values, exact, strict=True
    ):
        against = f"   geometry {reference:.6f}   ({100 * abs(value / reference - 1):.4f} % apart)" if is_known else ""
        _row(name, f"{value:.6f} {unit}{against}")
    _row("first frequencies", ", ".join(f"{f:.1f}" for f in arm.frequencies[:5]) + " Hz (root clamped, tip free)")


def _print_run(result: kf.Result, forces: np.ndarray) -> None:
    run, energy = result.statistics, result.energy
    _row("run", f"{END:g} s by {run['method']} ({run['reason']})")
    _row("", f"{run['steps']} steps, {run['rejected']} rejected, {run['evaluations']} evaluations")
    angle = math.degrees(result.joint_coordinates("hub")[-1, 0])
    _row("hub angle at the end", f"{angle:.3f} deg")
    flow = max(float(np.abs(energy.work).max()), float(np.ptp(energy.kinetic)))
    worst = float(np.abs(energy.balance_error).max())
    _row(
        "energy",
        f"motor up to {energy.work.max():.3f} J, elastic up to {energy.elastic.max():.3f} J, "
        f"damping took {energy.dissipated[-1]:.4f} J",
    )
    _row("energy balance", f"error at most {worst:.2e} J, {100 * worst / flow:.3f} % of the largest flow")
    force, moment = np.linalg.norm(forces[:, :3], axis=1).max(), np.linalg.norm(forces[:, 3:], axis=1).max()
    _row("root coupling force", f"at most {force:.1f} N and {moment:.1f} N m")


def _row(name: str, text: str) -> None:
    print(f"  {name:<22} {text}")
