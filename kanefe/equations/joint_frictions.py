"""Dry friction in joints, as loads of a frozen scene: with given limits, or proportional to the loads of the joints."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.bodies.marker import CoordinateMarker
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.loads.anchors import default_damping
from kanefe.tree.body_terms import BodyTerms
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import scene_length

if TYPE_CHECKING:
    from kanefe.joints.coordinate_force import CoordinateForce
    from kanefe.joints.joint_friction import JointFriction, RubbingSurfaces
    from kanefe.loads.coordinate_friction import CoordinateFriction
    from kanefe.states.state import State

YIELD = 1e-7
"""Default deflection of an anchor at the friction limit, relative to the scene's length, or in rad: a tenth of what a
run at the default tolerance, 1e-6, resolves. A smaller value costs implicit methods little, and explicit methods its
square root in steps: see the curves in docs/theory/contact.md."""

DAMPING_TIME = 1e-4
"""Damping over stiffness in scenes with unreduced bodies, s, where inertias along joints are not available. It is
critical where friction alone would move the scene by its length in a fifth of a second."""


def with_joint_frictions(model: Model, t: float) -> Model:
    """Return the scene with a load for each friction in a joint, called "friction of <body>".

    If a joint has several coordinates, the name of the coordinate follows. Default damping is critical for the inertia
    along the coordinate at the start of the scene, at time t (s); loads of joints are those at that start.

    Raises
    ------
    ModelError
        If another load has the name, or the stiffness of an anchor cannot be derived from the start.
    """
    found = (*_given_frictions(model, t), *_loaded_frictions(model, t))
    if not found:
        return model
    from kanefe.literal.bearing_loads import with_consistent_loads

    taken = {load.name for load in model.loads}
    for friction in found:
        if friction.name in taken:
            raise ModelError(
                f"a load is called {friction.name!r}, like the friction in that joint. Remedy: another name"
            )
    model = model.with_loads((*model.loads, *found))
    q, u, z = model.initial_coordinates, model.initial_speeds, model.initial_states
    z = with_consistent_loads(model, t, q, u, z)
    loads: list[Any] = list(model.loads)
    for number in model.bearings:
        load = model.following(number)
        loads[number] = load.with_first_load(float(z[model.load_states[number]][load.load_state]))
    return model.with_loads(loads)


def _given_frictions(model: ModelData, t: float) -> Sequence[CoordinateFriction]:
    rubbing = [
        (number, i, law)
        for number, body in enumerate(model.bodies)
        for i, law in enumerate(body.joint.coordinate_forces)
        if law is not None and law.friction > 0.0
    ]
    if not rubbing:
        return ()
    inertias, length = None, scene_length(model)
    if not model.has_unreduced and any(law.friction_damping is None for _, _, law in rubbing):
        from kanefe.literal.route import LiteralRoute

        inertias = np.diag(LiteralRoute(model).masses(_start(model, t)))
    return [_given_friction(model.bodies[number], number, i, law, inertias, length) for number, i, law in rubbing]


def _given_friction(
    body: BodyTerms, number: int, i: int, law: CoordinateForce, inertias: Vector | None, length: float
) -> CoordinateFriction:
    """Return the friction along a coordinate of a body's joint; `inertias` along all speeds."""
    from kanefe.loads.coordinate_friction import CoordinateFriction

    names, unit = body.joint.coordinate_names, body.joint.units[i]
    subject = body.name if len(names) == 1 else f"{body.name} {names[i].partition(' [')[0]}"
    static = law.friction if law.static_friction is None else law.static_friction
    stiffness = (
        static / (YIELD * (1.0 if unit == "rad" else length))
        if law.friction_stiffness is None
        else law.friction_stiffness
    )
    damping = law.friction_damping
    if damping is None and inertias is not None:
        damping = default_damping(stiffness, float(inertias[body.speeds[i]]))
    return CoordinateFriction(
        f"friction of {subject}",
        (_marker(body, number, i),),
        coordinate=subject,
        units=(unit,),
        sliding=law.friction,
        static=static,
        stiffness=stiffness,
        damping=damping or DAMPING_TIME * stiffness,
    )


def _loaded_frictions(model: ModelData, t: float) -> Sequence[CoordinateFriction]:
    rubbing = [
        (number, friction, bearing)
        for number, body in enumerate(model.bodies)
        if (friction := body.joint.friction) is not None
        and (friction.static or friction.mu) > 0.0
        and (bearing := body.joint.bearing()) is not None
    ]
    if not rubbing:
        return ()
    if model.has_unreduced:
        names = ", ".join(repr(model.bodies[number].name) for number, _, _ in rubbing)
        raise ModelError(
            f"friction from the load of the joint of {names} is not supported beside bodies that keep all degrees of "
            "freedom. Remedy: a reduction of these, or CoordinateForce(friction=...), which is given"
        )
    from kanefe.literal.route import LiteralRoute

    state, literal = _start(model, t), LiteralRoute(model)
    inertias, reactions = np.diag(literal.masses(state)), literal.reactions(state)
    carried = _carried_masses(model)
    found = []
    length = scene_length(model)
    for number, friction, bearing in rubbing:
        weight = float(carried[number] * np.linalg.norm(model.gravity))
        load = max(bearing.load(reactions[number], 0.0), weight)
        found.append(_loaded_friction(model.bodies[number], number, friction, bearing, inertias, load, length))
    return found


def _loaded_friction(
    body: BodyTerms,
    number: int,
    friction: JointFriction,
    bearing: RubbingSurfaces,
    inertias: Vector,
    load: float,
    length: float,
) -> CoordinateFriction:
    """Return the friction in a body's joint; `load` (N) is a large load of it."""
    from kanefe.loads.coordinate_friction import CoordinateFriction

    large = load + friction.preload
    static = friction.mu if friction.static is None else friction.static
    stiffness = friction.stiffness
    if stiffness is None and large == 0.0:
        raise ModelError(
            f"nothing loads the joint of {body.name!r} at the start, so that the stiffness of its friction cannot be "
            "derived from that load. Remedy: JointFriction(stiffness=...), N/m at the sliding surface"
        )
    slips = [abs(arm) for arm in bearing.arms]
    if stiffness is None:
        ways = [arm if unit == "rad" else length for arm, unit in zip(slips, body.joint.units, strict=True)]
        stiffness = static * large / (YIELD * min(ways))
    pairs = zip(body.speeds[: len(slips)].tolist(), slips, strict=True)
    mass = min(float(inertias[speed]) / arm**2 for speed, arm in pairs)
    damping = friction.damping or default_damping(stiffness, mass)
    return CoordinateFriction(
        f"friction of {body.name}",
        tuple(_marker(body, number, i) for i in range(len(slips))),
        coordinate=body.name,
        units=body.joint.units,
        sliding=friction.mu,
        static=static,
        stiffness=stiffness,
        damping=damping or DAMPING_TIME * stiffness,
        arms=bearing.arms,
        base=friction.preload,
        bearing=bearing,
        load_time=friction.load_time or sqrt(mass / stiffness),
        load_scale=large or 1.0,
        stribeck_speed=friction.stribeck_speed or 0.0,
    )


def _start(model: ModelData, t: float) -> State:
    from kanefe.states.state import State

    return State(model, t, model.initial_coordinates, model.initial_speeds)


def _marker(body: BodyTerms, number: int, i: int) -> CoordinateMarker:
    return CoordinateMarker.of(number, i, f"the {body.joint.coordinate_names[i].partition(' [')[0]} of {body.name!r}")


def _carried_masses(model: ModelData) -> Vector:
    """Return the mass of each body with all its descendants, kg."""
    masses = np.zeros(len(model.bodies))
    for number, body in reversed(list(enumerate(model.bodies))):
        masses[number] += body.rigid.mass if body.rigid is not None else 0.0
        masses[number] += body.flexible.body.mass if body.flexible is not None else 0.0
        if body.parent >= 0:
            masses[body.parent] += masses[number]
    return masses
