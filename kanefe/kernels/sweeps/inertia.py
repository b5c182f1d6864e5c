"""Inertia of every row and the force that keeps it moving with du = 0 (Eq. 12, 17, 20, 37, 38)."""

from typing import Any

from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.bodies import ModalBody
from kanefe.kernels.joints.motion import three
from kanefe.kernels.language import Vector, cross, dot, inlined, kernel
from kanefe.kernels.scene import Scene, Work, bodies_of, links_of
from kanefe.kernels.sweeps.body_inertia import clear, first_moment, put_rigid
from kanefe.kernels.sweeps.elastic import set_flexible, set_stiff
from kanefe.kernels.sweeps.exact_beam_inertia import set_exact
from kanefe.kernels.sweeps.fluid import add_fluid
from kanefe.kernels.tree import Frame, Kind


@kernel
def set_inertia(scene: Scene, work: Work) -> None:
    """Write inertia, force and moment of all rows: those of their bodies alone."""
    links, frames, bodies, fall = links_of(scene), work.frames, bodies_of(scene, work), three(scene.tables.gravity, 0)
    for i in range(len(links)):
        link, frame = links[i], frames[i]
        if link.kind != Kind.INTERFACE and link.flexible >= 0:
            body = bodies[link.flexible]
            if body.is_exact:
                set_exact(ExactBeam(body), frame)
            elif body.k > 0:
                set_flexible(body, frame)
            else:
                set_stiff(body, frame)
            if not link.has_gravity:
                _lift(body, frame, fall)
            if body.wet >= 0:
                add_fluid(body, frame, fall)
        elif link.mass == 0.0:
            clear(frame)
        else:
            put_rigid(frame, link.mass, link.first, link.second, link.rotor)
            if not link.has_gravity:
                take_gravity_off(frame, link.mass, fall)


@inlined
def take_gravity_off(frame: Frame, mass: Any, fall: Vector) -> None:
    """Undo gravity, which is part of Z, for a body without gravity."""
    frame.f += mass * fall
    frame.n += cross(first_moment(frame.H), fall)


@kernel
def _lift(body: ModalBody, frame: Frame, fall: Vector) -> None:
    """Undo gravity for a flexible body without gravity."""
    take_gravity_off(frame, body.mass, fall)
    g, p, linear = frame.R.T @ fall, body.p, body.linear
    for j in range(len(p)):
        p[j] -= dot(g, linear[j])
