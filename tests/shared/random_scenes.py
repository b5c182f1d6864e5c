"""Random scenes of everything a scene may hold, described by a few numbers that hypothesis can shrink.

Every part of a scene has its own random numbers, drawn from the seed and its own number: a recipe with fewer parts is
the same scene without the last ones, so that a failure shrinks to few bodies.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import scipy.sparse as sp
from hypothesis import strategies as st

import kanefe as kf
from bent_bodies import bent
from kanefe.equations.model import Model
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.pressure_change import PressureChange
from kanefe.frames import euler_parameters_from_matrix, rotation_matrix
from kanefe.joints.base import ScalarJoint
from kanefe.reduction import flexible_body
from kanefe.scene.scene import Frame
from loaded_scenes import force_of, place
from scenes import lattice_model, random_inertia, swing, unit_axis

JOINTS = (
    "revolute",
    "prismatic",
    "screw",
    "cylindrical",
    "universal",
    "planar",
    "translation",
    "fixed",
    "spherical",
    "free",
)

TIP = {"root": "clamped", "tip": "rigid"}
FLOATING = {"root": "rigid", "tip": "rigid"}
HINGE = kf.Interface(fixed=("x", "y", "z", "rx", "ry"))
ROLLER = kf.Interface(fixed=("rx", "y", "z"))
SLIDER = kf.Interface(fixed=("y",))
BODIES: dict[str, dict[str, Any]] = {
    "unreduced": {"interfaces": TIP, "interior": 1},
    "damped modes": {"interfaces": TIP, "reduction": kf.CraigBampton(modes=2), "damping": kf.ModalDamping(0.05)},
    "floating": {"interfaces": FLOATING, "reduction": kf.CraigBampton(modes=3)},
    "without interfaces that move": {"interfaces": {"root": "clamped"}, "reduction": kf.CraigBampton(modes=5)},
    "hinged at both ends": {"interfaces": {"root": "hinged", "tip": ROLLER}, "reduction": kf.CraigBampton(modes=1)},
    "on a hinge, with a node": {"interfaces": {"root": HINGE, "tip": SLIDER, "middle": "rigid"}, "interior": 1},
    "planar mesh": {"interfaces": TIP, "planar": True, "interior": 2},
    "floating unreduced": {"interfaces": {"tip": "rigid"}, "interior": 1, "damping": kf.RayleighDamping(0.1, 0.001)},
    "no modes": {"interfaces": {"root": "clamped", "tip": "clamped"}, "reduction": kf.CraigBampton(modes=0)},
    "stiffened": {"interfaces": TIP, "reduction": kf.CraigBampton(modes=4), "is_bent": True},
    "floating, stiffened": {"interfaces": {"tip": "rigid"}, "interior": 1, "is_bent": True},
    "in a fluid": {"interfaces": TIP, "reduction": kf.CraigBampton(modes=3), "in_fluid": True},
    "floating in a fluid, stiffened": {"interfaces": FLOATING, "interior": 1, "is_bent": True, "in_fluid": True},
    "no modes, in a fluid": {
        "interfaces": {"root": "clamped", "tip": "clamped"},
        "reduction": kf.CraigBampton(modes=0),
        "in_fluid": True,
    },
}


def any_change(size: int) -> PressureChange:
    """Return how a pressure changes with the displacements of a model with so many: any numbers will do."""
    rng = np.random.default_rng(size)
    across, motion, second = (
        sp.csr_matrix(0.3 * rng.standard_normal(shape)) for shape in ((12, 12), (12, size), (size, size))
    )
    return PressureChange(rng.standard_normal((4, 3)), rng.standard_normal((4, 3)), across, motion, second)


@cache
def elastic_body(kind: str, seed: int) -> kf.FlexibleBody:
    """Return a lattice of one of the kinds, whose nodes share a "side" with an outside, and an "edge"."""
    options = dict(BODIES[kind])
    is_bent = options.pop("is_bent", False)
    ours = {name: options.pop(name) for name in ("interfaces", "reduction", "damping") if name in options}
    model = lattice_model(seed, **options)
    rng = np.random.default_rng(seed)
    shares, normals = rng.uniform(0.1, 1.0, len(model.nodes)), rng.standard_normal((len(model.nodes), 3))
    normals[:, len([c for c in model.components if c in "xyz"]) :] = 0.0
    patterns = {
        "side": NodalPattern.of_nodes(
            model.nodes, model.components, shares, normals, pressure_change=any_change(model.size)
        ),
        "edge": NodalPattern.of_nodes(model.nodes, model.components, shares[::-1].copy(), kind="line"),
    }
    body = flexible_body(replace(model, load_patterns=patterns), **ours)
    return bent(body, seed, 0.1) if is_bent else body


@dataclass(frozen=True)
class Recipe:
    """What a random scene holds; `loads` and so on count what is added to a tree of `bodies`.

    Attributes
    ----------
    elastic : float
        Share of flexible bodies.
    is_autonomous : bool
        Nothing calls back into Python: no drive, no function of the user.
    has_fluid : bool
        Some flexible bodies are in a fluid, and some balls have rotors.
    """

    seed: int
    bodies: int
    elastic: float = 0.0
    loads: int = 0
    between: int = 0
    is_autonomous: bool = False
    slopes: str = "rotation-vector"
    has_fluid: bool = False


def recipes(
    bodies: int = 30,
    elastic: float = 0.0,
    loads: int = 8,
    between: int = 0,
    autonomous: st.SearchStrategy[bool] | None = None,
    has_fluid: bool = False,
) -> st.SearchStrategy[Recipe]:
    """Return recipes of trees of up to `bodies` bodies, of loads, and of springs and bushings (at least one)."""
    return st.builds(
        Recipe,
        seed=st.integers(0, 10**6),
        bodies=st.integers(1, bodies),
        elastic=st.just(elastic),
        loads=st.integers(0, loads),
        between=st.integers(1, between) if between else st.just(0),
        is_autonomous=st.booleans() if autonomous is None else autonomous,
        slopes=st.sampled_from(["rotation-vector", "tait-bryan"]) if elastic else st.just("rotation-vector"),
        has_fluid=st.just(has_fluid),
    )


class RandomScene:
    """A scene made from a recipe.

    Attributes
    ----------
    scene : System
    bodies : list of Frame
        Rigid and flexible bodies, in the order of adding.
    carriers : list of Frame
        What can carry bodies: rigid bodies and interfaces.
    points : list of Frame
        Nodes and interfaces without a rotation of their own.
    """

    def __init__(self, recipe: Recipe) -> None:
        self.recipe = recipe
        rng = self._random(0)
        self.scene = kf.System(gravity=rng.standard_normal(3), slopes=recipe.slopes)
        self.bodies: list[Any] = []
        self.carriers: list[Frame] = [self.scene.ground]
        self.points: list[Frame] = []
        self.joints: dict[str, kf.Joint] = {}
        self.needs_child: Frame | None = None
        for i in range(recipe.bodies):
            self._add_body(self._random(1, i), f"b{i}", is_last=i == recipe.bodies - 1)
        for i in range(recipe.loads):
            self._add_load(self._random(2, i))
        for i in range(recipe.between):
            self._add_between(self._random(3, i), f"c{i}")

    def _random(self, *numbers: int) -> np.random.Generator:
        return np.random.default_rng((self.recipe.seed, *numbers))

    def frame(self, rng: np.random.Generator, points: bool = False, ground: bool = True) -> Frame:
        """Return a frame somewhere in the scene; of nodes too if points will do."""
        found = [*self.carriers[0 if ground else 1 :], *(self.points if points else ())]
        if not found:
            return self.scene.ground
        chosen = found[int(rng.integers(len(found)))]
        moved = place(rng)
        return chosen.frame(at=moved["at"]) if chosen.is_node else chosen.frame(**moved)

    def joint(self, rng: np.random.Generator, kind: str, driven: float = 0.15) -> kf.Joint:
        """Return a joint; some of its coordinates driven, some with springs, friction and stops."""

        def motion() -> kf.Motion | None:
            return swing(rng) if not self.recipe.is_autonomous and rng.uniform() < driven else None

        def forces() -> kf.CoordinateForce | None:
            return force_of(rng, limited=bool(rng.integers(2))) if rng.uniform() < 0.3 else None

        def each(count: int) -> dict[str, Any]:
            return {
                "motion": tuple(motion() for _ in range(count)),
                "forces": tuple(forces() for _ in range(count)),
            }

        axis = "xyz"[int(rng.integers(3))] if rng.uniform() < 0.3 else unit_axis(rng)
        if kind in ("revolute", "prismatic", "screw"):
            lead = {"lead": rng.uniform(-0.5, 0.5)} if kind == "screw" else {}
            made = {"revolute": kf.Revolute, "prismatic": kf.Prismatic, "screw": kf.Screw}[kind]
            return made(axis, motion=motion(), forces=forces(), **lead)
        if kind == "cylindrical":
            return kf.Cylindrical(axis, **each(2))
        if kind == "universal":
            first = unit_axis(rng)
            across = np.cross(first, unit_axis(rng))  # at an angle of its own to the first axis
            return kf.Universal(first, across / np.linalg.norm(across) + 0.3 * first, **each(2))
        if kind == "planar":
            return kf.Planar(**each(3))
        if kind == "translation":
            return kf.Translation(forces=each(3)["forces"])
        rotor = float(rng.choice((0.0, 0.1))) if self.recipe.has_fluid else 0.0
        return {"fixed": kf.Fixed(), "spherical": kf.Spherical(armature=rotor), "free": kf.Free()}[kind]

    def _add_body(self, rng: np.random.Generator, name: str, is_last: bool) -> None:
        near = self.carriers[-4:] if rng.uniform() < 0.7 else self.carriers
        parent: Frame = near[int(rng.integers(len(near)))]
        kind = JOINTS[int(rng.integers(len(JOINTS)))]
        weightless = rng.uniform() < 0.1 and not is_last
        is_held = self.needs_child is not None
        if self.needs_child is not None:  # a frame without mass moves with what it carries
            parent, self.needs_child, weightless = self.needs_child, None, False
            kind = "fixed" if rng.uniform() < 0.5 else "revolute"
        if rng.uniform() < 0.5:
            parent = parent.frame(**place(rng))
        where = {"parent": parent, "gravity": bool(rng.uniform() < 0.8), **place(rng)}
        if rng.uniform() < self.recipe.elastic and not weightless:
            self._add_flexible(rng, name, kind, where, is_held)
            return
        joint = self.joint(rng, kind)
        if weightless and kind in ("fixed", "revolute", "prismatic"):
            where.pop("gravity")
            body = self.scene.add_frame(name, joint=joint, **where)
            self.needs_child = body
        elif kind == "translation":
            body = self.scene.add_point(name, rng.uniform(0.5, 2.0), joint=joint, **where)
        else:
            inertia = random_inertia(rng)
            com = rng.uniform(-0.2, 0.2, 3)
            body = self.scene.add_rigid_body(name, rng.uniform(0.5, 2.0), inertia, com=com, joint=joint, **where)
            if rng.uniform() < 0.2:
                self.scene.add_rotor(body, unit_axis(rng), 0.02, 30.0)
        self.bodies.append(body)
        self.carriers.append(body)
        self.joints[name] = joint

    def _add_flexible(
        self, rng: np.random.Generator, name: str, kind: str, where: dict[str, Any], is_held: bool
    ) -> None:
        kinds = [name for name in BODIES if not (is_held and name.startswith("floating"))]
        kinds = [name for name in kinds if self.recipe.has_fluid or "fluid" not in name]
        body = elastic_body(kinds[int(rng.integers(len(kinds)))], int(rng.integers(3)))
        if body.is_floating:
            kind = "free" if rng.uniform() < 0.8 else "planar"
        self.joints[name] = joint = self.joint(rng, kind)
        member = self.scene.add_flexible_body(name, body, joint=joint, **where)
        self.bodies.append(member)
        for interface in body.interfaces:
            frame = member.interface(interface.name)
            (self.points if frame.is_node else self.carriers).append(frame)
        self.points.append(member.node(int(rng.integers(len(body.nodes)))))

    def _vector(self, rng: np.random.Generator) -> Any:
        """Return a vector: constant, a function of time, or one of the state."""
        value, kind = rng.standard_normal(3), 0 if self.recipe.is_autonomous else int(rng.integers(3))
        name = self.bodies[int(rng.integers(len(self.bodies)))].name
        if kind == 1:
            return lambda t: value * np.cos(t)
        if kind == 2:
            return lambda t, state: value - 0.3 * state.velocity(name) + state.rotation(name) @ value * t
        return value

    def _add_load(self, rng: np.random.Generator) -> None:
        kind = rng.choice(["force", "torque", "motor", "field"])
        follows = bool(rng.integers(2))
        if kind == "field":
            members = [body for body in self.bodies if hasattr(body, "body")]
            if members:
                self._add_field_load(rng, members[int(rng.integers(len(members)))], follows)
                return
        if kind == "motor" and self._add_motor(rng):
            return
        if kind == "force":
            target = self.frame(rng, points=True, ground=False)
            point = np.zeros(3) if target.is_node else rng.uniform(-0.2, 0.2, 3)
            if target.number >= 0:
                self.scene.add_force(target, self._vector(rng), point=point, follows=follows)
            return
        target = self.frame(rng, ground=False)
        if target.number >= 0:
            self.scene.add_torque(target, self._vector(rng), follows=follows)

    def _add_field_load(self, rng: np.random.Generator, member: Any, follows: bool) -> None:
        kind = int(rng.integers(3))
        if kind == 0:
            self.scene.add_traction(member, "side", self._vector(rng), follows=follows)
        elif kind == 1:
            self.scene.add_line_load(member, "edge", self._vector(rng), follows=follows)
        else:
            pressure = 0.7 if self.recipe.is_autonomous else lambda t: 0.5 + t
            self.scene.add_pressure(member, "side", pressure, follows=follows)

    def _add_motor(self, rng: np.random.Generator) -> bool:
        body = self.bodies[int(rng.integers(len(self.bodies)))]
        joint = self.joints[body.name]
        free = [i for i, motion in enumerate(joint.motions) if motion is None] if isinstance(joint, ScalarJoint) else []
        if not free:
            return False
        at, value = free[int(rng.integers(len(free)))], float(rng.standard_normal())
        kind = 0 if self.recipe.is_autonomous else int(rng.integers(3))
        laws = (
            value,
            lambda t: value * np.sin(t),
            lambda t, state: -(value**2) * state.joint_coordinates(body.name)[at] - state.joint_speeds(body.name)[at],
        )
        self.scene.add_motor(body, laws[kind], coordinate=at)
        return True

    def _add_between(self, rng: np.random.Generator, name: str) -> None:
        kind = int(rng.integers(5))
        is_spring = kind < 3
        a = self.frame(rng, points=is_spring)
        b = self.frame(rng, points=is_spring, ground=False)
        stiffness, damping = rng.uniform(0.5, 3.0, 6), rng.uniform(0.0, 1.0, 6)
        if kind == 1:
            lengths = np.sort(rng.uniform(0.1, 4.0, 4))
            force = (lengths, rng.standard_normal(4))
            self.scene.add_spring(name, a, b, force=force, damping=damping[0])
        elif kind == 2 and not self.recipe.is_autonomous:
            law = lambda length, rate: length**2 + 0.5 * rate * abs(rate)  # noqa: E731
            self.scene.add_spring(name, a, b, force=law)
        elif is_spring:
            rest = rng.uniform(0.1, 1.0)
            self.scene.add_spring(name, a, b, stiffness=stiffness[0], damping=damping[0], rest_length=rest)
        elif kind == 3 and not self.recipe.is_autonomous:
            self.scene.add_bushing(name, a, b, law=lambda d, rate: -d * abs(d) - 0.3 * rate, damping=damping[:3])
        else:
            self.scene.add_bushing(name, a, b, stiffness=stiffness, damping=damping)


def random_model(recipe: Recipe) -> Model:
    """Return the frozen scene of a recipe."""
    return RandomScene(recipe).scene.freeze()


def planar_model(recipe: Recipe) -> Model:
    """Return a frozen tree that moves in a plane, though its normal and the frames of its bodies point anywhere."""
    rng = np.random.default_rng((recipe.seed, 5))
    normal = np.eye(3)[recipe.seed] if recipe.seed < 3 else unit_axis(rng)
    scene = kf.System(gravity=3.0 * rng.standard_normal(3))
    carriers: list[tuple[Frame, np.ndarray]] = [(scene.ground, np.eye(3))]  # with their axes at zero coordinates
    motors: list[Frame] = []
    for i in range(recipe.bodies):
        rng = np.random.default_rng((recipe.seed, 6, i))
        parent, axes = carriers[int(rng.integers(max(0, len(carriers) - 4), len(carriers)))]
        kind = "turn" if i == 0 else rng.choice(["turn", "turn", "slide", "fixed", "float"])
        up = rng.choice([-1.0, 1.0]) * normal
        here = rotation_matrix(rng.standard_normal(4)) if kind != "float" else _axes_about(up, rng)
        inward = here.T @ up
        motion = swing(rng) if i > 0 and not recipe.is_autonomous and rng.uniform() < 0.2 else None
        force = force_of(rng, limited=bool(rng.integers(2))) if rng.uniform() < 0.4 else None
        joint: kf.Joint = kf.Fixed()
        if kind == "turn":
            joint = kf.Revolute(inward, motion=motion, forces=force)
        elif kind == "slide":
            joint = kf.Prismatic(np.cross(inward, rng.standard_normal(3)), motion=motion, forces=force)
        elif kind == "float":
            joint = kf.Planar(motion=(motion, None, None), forces=(None, force, None))
        body = scene.add_rigid_body(
            f"b{i}",
            rng.uniform(0.5, 2.0),
            random_inertia(rng),
            com=rng.uniform(-0.3, 0.3, 3),
            parent=parent,
            joint=joint,
            at=rng.uniform(-0.5, 0.5, 3),
            orientation=euler_parameters_from_matrix(axes.T @ here),
            gravity=bool(rng.uniform() < 0.7),
        )
        carriers.append((body, here))
        if kind in ("turn", "slide") and motion is None:
            motors.append(body)
    scene.add_rotor(carriers[1][0], unit_axis(rng), 0.1, 20.0)
    for i in range(recipe.loads):
        rng = np.random.default_rng((recipe.seed, 7, i))
        body = carriers[int(rng.integers(1, len(carriers)))][0]
        value, follows = rng.standard_normal(3), bool(rng.integers(2))
        if rng.uniform() < 0.3 and motors:
            torque = float(value[0]) if recipe.is_autonomous else lambda t, state, v=value[0]: v * np.cos(t)
            scene.add_motor(motors[int(rng.integers(len(motors)))], torque)
        elif rng.uniform() < 0.5:
            scene.add_torque(body, value, follows=follows)
        elif recipe.is_autonomous:
            scene.add_force(body, value, point=rng.uniform(-0.3, 0.3, 3), follows=follows)
        else:
            scene.add_force(body, lambda t, state, v=value, n=body.name: v * np.cos(t) - 0.2 * state.velocity(n))
    return scene.freeze()


def _axes_about(normal: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return random axes of which the third is `normal`."""
    x = np.cross(normal, rng.standard_normal(3))
    x /= np.linalg.norm(x)
    return np.column_stack((x, np.cross(normal, x), normal))
