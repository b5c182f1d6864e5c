"""What a step of the energy-momentum method keeps: the memory of the method, and corrections of a step by what is not.

Letters are those of `kanefe.kernels.steppers.energy_momentum`.
"""

from typing import Annotated

import numpy as np

from kanefe.kernels.language import Array, Vector, copy, cross, dot, inlined, kernel
from kanefe.kernels.steppers.mixing import ROWS_OF_MIXING
from kanefe.kernels.steppers.moves import move
from kanefe.kernels.steppers.step_commands import BalancedStep, Row

# Places in rows of unknowns: b, and r where momenta are kept, which takes a free body of seven coordinates; z is in the
# places of the speeds
SHARE, PUSH = 0, 1

CLOSE = 1e-13
"""Accuracy to which quantities are conserved, relative to speeds and to the largest energies so far."""


class KeepingStep(BalancedStep):
    """A step of the energy-momentum method."""

    sweeps: int  # of the step
    corrections: int
    has_directions: bool  # those of the step are known
    kept_energy: float  # what is kept, since when
    kept_time: float
    kept_centre: Vector
    kept_momentum: Vector
    kept_spin: Vector
    shift: Vector  # d, which has no turns
    v: Vector  # parts of u' and z as of one rigid body, the second with g
    w: Vector
    v_of_z: Vector
    w_of_z: Vector
    last_v: Vector  # the last changes of r and d
    last_w: Vector
    last_shift: Vector
    turn: Vector  # g
    growth: float  # by how much b changes the energy
    largest_energy: float  # sum of the sizes of all energies, the largest so far
    change_left: float  # by the last iteration
    begun_at: float  # start of the step, while its end is closed
    directions: Annotated[np.ndarray, Array(6, "size")]  # rigid motions in the middle of the step
    tried: Row  # unknowns as they are tried
    found: Row  # as they follow from that
    old: Row  # of the last step
    residual: Row  # the weighted difference of the first two
    memory: Annotated[np.ndarray, Array(ROWS_OF_MIXING, "size")]
    new: Row
    way: Row  # move of the coordinates
    frequencies: Row  # of modes in rad/s
    begun: Row  # state at the start of the step, while its end is closed


@inlined
def along_and_about(directions: np.ndarray, i: int) -> tuple[Vector, Vector]:
    """Return how a speed takes part in the rigid motions: in translations, and in turns."""
    first = Vector(directions[0, i], directions[1, i], directions[2, i])
    return first, Vector(directions[3, i], directions[4, i], directions[5, i])


@inlined
def _total(step: KeepingStep, state: np.ndarray) -> float:
    """Return energy + dissipated - work."""
    return step.energy + state[len(state) - 2] - state[len(state) - 1]


@inlined
def _rigid_part(step: KeepingStep) -> tuple[Vector, Vector, float]:
    """Return v and w of the motion as of one rigid body, and twice the kinetic energy beyond."""
    spin = step.spin - step.rotors
    v, w = (1.0 / step.mass) * step.momentum, step.locked.inverse @ spin
    return v, w, max(2.0 * step.kinetic - dot(v, step.momentum) - dot(w, spin), 0.0)


@kernel
def put_middle(step: KeepingStep) -> None:
    """Take over directions in the middle of the step; the turn g is added to what j leaves of z later."""
    step.growth = 2.0 * step.kinetic
    if step.keeps_momenta:
        step.v, step.w, step.growth = _rigid_part(step)
        for k in range(6):
            copy(step.rigid[k], step.directions[k])
        steepest = cross(step.w, step.spin)
        step.turn = step.locked.inverse @ steepest
        step.growth += 0.25 * step.h**2 * dot(step.turn, steepest)


@kernel
def put_z(step: KeepingStep) -> None:
    """Take over the part of z as of one rigid body."""
    beyond = 2.0 * step.kinetic
    if step.keeps_momenta:
        step.v_of_z, w, beyond = _rigid_part(step)
        step.w_of_z = w + step.turn
    step.growth += 0.25 * step.h**2 * beyond


@kernel
def _correct_momenta(step: KeepingStep) -> tuple[float, float]:
    """Correct r and d; return by how much the energy grows by the first, as planned and in truth."""
    found, residual, size = step.found, step.residual, step.largest_energy
    momentum, spin = step.kept_momentum - step.momentum, step.kept_spin - step.spin
    v, w = (1.0 / step.mass) * momentum, step.locked.inverse @ spin
    flown = ((step.time + step.h - step.kept_time) / step.mass) * step.kept_momentum
    shift = step.kept_centre + flown - step.centre
    step.last_v, step.last_w, step.last_shift = v, w, shift
    step.shift += shift
    inertia, slip = step.locked.full, 0.0
    pushes = (v.x, v.y, v.z, w.x, w.y, w.z)
    inertias = (step.mass, step.mass, step.mass, inertia.x.x, inertia.y.y, inertia.z.z)
    for k in range(6):
        found[PUSH + k] += pushes[k]
        residual[PUSH + k] = pushes[k] * np.sqrt(inertias[k] / size) / CLOSE if size > 0.0 else 0.0
        slip = max(slip, abs(residual[PUSH + k]))
    step.change_left = max(step.change_left, slip)
    left = dot(v, step.momentum) + dot(w, step.spin - step.rotors) + 0.5 * (dot(v, momentum) + dot(w, spin))
    return dot(step.v, momentum) + dot(step.w, spin), left


@kernel
def correct(step: KeepingStep) -> float:
    """Correct the unknowns beside z by what is not kept; return how much energy that is, of what is round-off.

    That is what would be left after `finish`.
    """
    size = step.largest_energy = max(step.energy_size, step.largest_energy)
    excess = left = _total(step, step.new) - step.kept_energy
    if step.keeps_momenta:
        planned, gained = _correct_momenta(step)
        excess += planned
        left += gained
    step.residual[SHARE] = 0.0
    if abs(excess) > CLOSE * size and step.growth > 0.0:
        change = min(max(excess / step.growth, -0.1), 0.1)
        step.found[SHARE] -= change
        step.residual[SHARE] = -change * np.sqrt(step.growth / size) / CLOSE
    return abs(left) / (CLOSE * size) if left != 0.0 else 0.0


@kernel
def finish(step: KeepingStep) -> None:
    """Take off what is left of momenta and of straight flight: far from N's origin it would weigh in those about it."""
    n, new, way, rigid = step.coordinates, step.new, step.way, step.rigid
    v, w, shift = step.last_v, step.last_w, step.last_shift
    for i in range(n, n + step.speeds):
        along, about = along_and_about(rigid, i)
        new[i] += dot(v, along) + dot(w, about)
        way[i] += dot(shift, along)
    move(step, step.state, way, n, new)


@kernel
def keep(step: KeepingStep) -> None:
    """Take over what is to be kept from here on."""
    step.kept_energy, step.kept_time = _total(step, step.state), step.time
    step.kept_centre, step.kept_momentum, step.kept_spin = step.centre, step.momentum, step.spin
    step.largest_energy, step.shift = step.energy_size, Vector(0.0, 0.0, 0.0)
    step.found[:] = step.old[:] = step.residual[:] = 0.0
