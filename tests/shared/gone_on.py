"""What a user does next with what a call returned: into a scene, run it, find its rest and modes, save it."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import traceback
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import kanefe as kf
import kanefe_fem as fem
from bad_input import Hang, ended, raw
from good_scenes import small
from steel_beams import STEEL, steel_beam

SPAN = 0.01
"""s, of a run."""


def bodies() -> tuple[kf.System, Any]:
    scene = small()
    return scene, scene.body("rod")


def of_joint(joint: Any) -> kf.System:
    scene, _ = bodies()
    scene.add_rigid_body("next", 1.0, 0.1, com=(0.1, 0.2, 0.0), joint=joint)
    return scene


def of_laws(**laws: Any) -> kf.System:
    scene, rod = bodies()
    ball = scene.add_surface("ball", rod, kf.shapes.Sphere(0.1), at=(0.5, 0.0, 0.0))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("y"), at=(0.0, -0.099, 0.0))
    scene.add_contact("c", ball, floor, **{"normal": kf.HuntCrossley(1e5), **laws})
    return scene


def of_shape(shape: Any) -> kf.System:
    scene, rod = bodies()
    one = scene.add_surface("one", rod, shape, at=(0.5, 0.0, 0.0))
    try:
        floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("y"), at=(0.0, -0.099, 0.0))
        scene.add_contact("c", one, floor, normal=kf.HuntCrossley(1e5))
    except kf.ModelError:
        ball = scene.add_surface("ball", scene.ground, kf.shapes.Sphere(0.1), at=(0.5, -0.19, 0.0))
        scene.add_contact("c", one, ball, normal=kf.HuntCrossley(1e5))
    return scene


def of_body(body: Any) -> kf.System:
    scene, _ = bodies()
    scene.add_flexible_body("next", body, joint=kf.Revolute("z"))
    return scene


def of_model(model: Any) -> kf.System:
    return of_body(
        kf.flexible_body(model, {next(iter(model.groups), "root"): "clamped"}, reduction=kf.CraigBampton(modes=1))
    )


def of_wind(wind: Any) -> kf.System:
    scene, rod = bodies()
    angles = np.linspace(-np.pi, np.pi, 9)
    scene.add(kf.Aerodynamics("a", rod, wind, angles=angles, areas=np.ones((9, 6))))
    return scene


def of_load(load: Any) -> kf.System:
    scene, _ = bodies()
    scene.add(load)
    return scene


def reduced(**options: Any) -> kf.System:
    made = {"interfaces": {"root": "clamped", "tip": "rigid"}, "reduction": kf.CraigBampton(modes=2), **options}
    return of_body(kf.flexible_body(steel_beam(4), **made))


def of_material(material: Any, section: Any = None) -> kf.System:
    section = fem.Rectangle(0.02, 0.02) if section is None else section
    return of_model(fem.straight_beam(1.0, section, material, elements=2))


def of_sea(sea: Any) -> kf.System:
    return of_ship(kf.Ship(kf.example_rao(), sea, speed=0.0, heading_deg=30.0))


def of_ship(ship: Any) -> kf.System:
    return of_joint(kf.Free(motion=ship.at((1.0, 0.0, 0.0), duration=1.0)))


NEXT: dict[str, Callable[[Any], kf.System]] = {
    "System": lambda scene: scene,
    "CoordinateForce": lambda force: of_joint(kf.Revolute("z", forces=force)),
    "JointFriction": lambda friction: of_joint(kf.Revolute("z", friction=friction)),
    "Motion": lambda motion: of_joint(kf.Revolute("z", motion=motion)),
    "PoseTable": lambda motion: of_joint(kf.Free(motion=motion)),
    "PoseMotion": lambda motion: of_joint(kf.Free(motion=motion)),
    "Guess": lambda guess: of_joint(kf.Revolute("z", position=guess)),
    "Joint": of_joint,
    "NormalLaw": lambda law: of_laws(normal=law),
    "FrictionLaw": lambda law: of_laws(friction=law),
    "Rigid": lambda law: of_laws(normal=law, friction=kf.Coulomb(0.3)),
    "Shape": of_shape,
    "FlexibleBody": of_body,
    "FiniteElementModel": of_model,
    "Wind": of_wind,
    "Gust": lambda gust: of_wind(kf.Wind((1.0, 0.0, 0.0), gusts=[gust])),
    "Turbulence": lambda gusts: of_wind(kf.Wind((10.0, 0.0, 0.0), turbulence=gusts)),
    "CraigBampton": lambda one: reduced(reduction=one),
    "FreeInterface": lambda one: reduced(reduction=one),
    "Krylov": lambda one: reduced(reduction=one),
    "ModalDamping": lambda one: reduced(damping=one),
    "RayleighDamping": lambda one: reduced(damping=one),
    "Interface": lambda one: reduced(interfaces={"root": "clamped", "tip": one}),
    "Material": of_material,
    "Section": lambda section: of_material(STEEL, section),
    "Rectangle": lambda section: of_material(STEEL, section),
    "Tube": lambda section: of_material(STEEL, section),
    "Box": lambda section: of_material(STEEL, section),
    "SolidCircle": lambda section: of_material(STEEL, section),
    "Sea": of_sea,
    "Ship": of_ship,
    "Load": of_load,
}
"""Scenes with a thing, by the name of its class or of a base of it."""


def scene_with(function: Callable[..., Any], found: Any) -> kf.System | None:
    """Return a scene with what was made, where there is one."""
    owner = getattr(function, "__self__", None)
    if isinstance(owner, kf.System) and not isinstance(found, (kf.Result, kf.Simulation, kf.Model)):
        return owner
    for base in type(found).__mro__:
        if base.__name__ in NEXT and base.__module__.startswith("kanefe"):
            return NEXT[base.__name__](found)
    return None


def arrays_in(thing: Any, depth: int = 0) -> Iterator[np.ndarray]:
    """Yield the numbers of what was returned: arrays, also those of fields and lists."""
    if isinstance(thing, (float, complex, np.ndarray, np.generic)):
        if np.asarray(thing).dtype.kind in "fc":
            yield np.asarray(thing)
    elif isinstance(thing, (list, tuple)) and depth < 2:
        for one in itertools.islice(thing, 20):
            yield from arrays_in(one, depth + 1)
    elif isinstance(thing, dict) and depth < 2:
        for one in itertools.islice(thing.values(), 20):
            yield from arrays_in(one, depth + 1)
    elif isinstance(thing, (kf.Result, kf.Instant)):
        for name in thing.bodies:
            yield np.asarray(thing.position(name))
            yield np.asarray(thing.velocity(name))
    elif (
        dataclasses.is_dataclass(thing)
        and depth < 2
        and isinstance(thing, (kf.Linearisation, kf.Modes, kf.Buckling, kf.Campbell, kf.FloquetModes, kf.FlexibleBody))
    ):
        for field in dataclasses.fields(thing):
            if field.name not in ("model", "nodes"):
                yield from arrays_in(getattr(thing, field.name, None), depth + 1)


def digest(thing: Any) -> str:
    """Return a text of the numbers of a thing, which differs where they do."""
    return " ".join(f"{np.abs(numbers[np.isfinite(numbers)]).sum():.5g}" for numbers in arrays_in(thing))


def has_nan(thing: Any) -> bool:
    return any(np.isnan(numbers).any() for numbers in arrays_in(thing))


def run_of(scene: kf.System, seconds: float) -> kf.Result:
    return scene.simulate((0.0, SPAN), output_step=SPAN / 5, most_seconds=seconds, most_steps=20_000)


def saved(result: kf.Result) -> kf.Result:
    result.save("gone_on.h5")
    return kf.load_result("gone_on.h5")


def gone_on(function: Callable[..., Any], _: dict[str, Any], found: Any, *, seconds: float) -> tuple[str, str, str]:
    """Return the last stage, its verdict, and what was said, or the numbers that were found."""
    error, scene = ended(scene_with, {"function": function, "found": found})
    if error is not None:
        return stopped("scene", error)
    if scene is None:
        error, nan = ended(has_nan, {"thing": found})
        if error is not None:
            return stopped("read", error)
        if nan and not isinstance(found, (kf.Result, kf.Instant)):
            return "call", "SILENT", "NaN is returned"
        if isinstance(found, kf.Result) and nan and found.status.finished:
            return "call", "SILENT", "a finished run has NaN"
        return "call", "fine", digest(found)
    said: list[str] = []
    result: Any = None
    for stage, step in (
        ("run", lambda: run_of(scene, seconds)),
        ("report", lambda: str(scene.start_report())),
        ("equilibrium", lambda: kf.equilibrium(scene)),
        ("linearise", lambda: kf.linearise(scene)),
        ("modes", lambda: kf.linearise(scene).modes()),
        ("save", lambda: saved(result)),  # noqa: B023 (called within the loop)
    ):
        if stage == "save" and result is None:
            continue
        error, now = ended(step, {})
        if error is not None:
            verdict = stopped(stage, error)
            if verdict[1] not in ("clear", "failed"):
                return verdict
            said.append(f"{stage}: {type(error).__name__}")
            continue
        if stage == "run":
            result = now
        with contextlib.suppress(kf.KanefeError):
            if has_nan(now) and (stage not in ("run", "save") or now.status.finished):
                return stage, "SILENT", f"NaN in {stage}"
            if stage not in ("report",):
                said.append(f"{stage}: {digest(now)}")
    return "end", "fine", "; ".join(said)


def stopped(stage: str, error: BaseException) -> tuple[str, str, str]:
    """Return what an error of a stage says."""
    if isinstance(error, Hang):
        return stage, "HANG", str(traceback.extract_tb(error.__traceback__)[-3:])
    if isinstance(error, kf.KanefeError):
        return stage, "failed", str(error)
    return stage, *raw(error)
