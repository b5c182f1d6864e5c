"""The outward sweep: pose, velocity and remainder accelerations of every link (Eq. 3, 13-16, 22, 24-26).

Where the rows are and how they move: for functions of the user that look at the state, and for views.
"""

import numpy as np

from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.bodies import BorderedBody, ModalBody
from kanefe.kernels.joints.by_kind import move
from kanefe.kernels.joints.motion import Relative, put_motion, put_three, three
from kanefe.kernels.language import IDENTITY, ZERO, RealBlocks, RealRows, Reals, Vector, entry, inlined, kernel
from kanefe.kernels.scene import FlexibleSizes, Scene, State, Work, bodies_of, links_of, state_in, work_in
from kanefe.kernels.sweeps.elastic import combined, modal_state, transposed_product
from kanefe.kernels.sweeps.exact_beams import is_as_before, move_sections
from kanefe.kernels.sweeps.slopes import slope_motion
from kanefe.kernels.tables import FlexibleTables
from kanefe.kernels.tree import Frame, InterfaceFrame, InterfaceLink, Kind


@kernel
def sweep_outward(scene: Scene, state: State, work: Work, keeps: bool) -> None:
    """Write pose, velocity and remainder accelerations of all links, and the state of the modes.

    With `keeps` the work is of the last evaluation of the scene: beams whose coordinates have not changed keep the
    motion of their sections, and their mass.
    """
    links, frames, bodies, modal = links_of(scene), work.frames, bodies_of(scene, work), work.modal
    q, u, flexible = state.q, state.u, scene.flexible
    put_ground(frames[-1], three(scene.tables.gravity, 0))
    for i in range(len(links)):
        link, frame = links[i], frames[i]
        parent = frames[link.parent]
        if link.kind == Kind.INTERFACE:
            move_interface(flexible, bodies[link.flexible], InterfaceLink(link), frame, parent, modal)
            continue
        move(link, frame, parent, state, scene.tables.numbers)
        if link.flexible >= 0:
            body = bodies[link.flexible]
            is_kept = keeps and body.is_exact and is_as_before(ExactBeam(body), q, u)
            modal_state(body, q, u)
            if body.is_exact:
                move_sections(ExactBeam(body), is_kept)


@inlined
def put_ground(ground: Frame, gravity: Vector) -> None:
    """Write how the ground moves: against gravity, which every link then feels."""
    ground.R, ground.p, ground.v, ground.w = IDENTITY, ZERO, ZERO, ZERO
    ground.Z, ground.Y = -gravity, ZERO
    ground.a, ground.alpha = ZERO, ZERO


@inlined
def _by_modes(
    flexible: FlexibleTables, link: InterfaceLink, body: ModalBody, modal: np.ndarray
) -> tuple[Vector, Vector, Vector, Vector, Vector, Vector]:
    """Return displacement, slopes, their rates and their remainders of an interface in G, from the modes."""
    k, eta, deta = body.k, body.eta, body.deta
    displacement = shift = slopes = rates = pull = twist = ZERO
    if k > 0:
        basis = flexible.pool[link.basis : link.basis + 6 * k].reshape(6, k)
        displacement, slopes = combined(basis, 0, eta), combined(basis, 3, eta)
        if link.bending < 0:
            shift, rates = combined(basis, 0, deta), combined(basis, 3, deta)
        else:
            bending = flexible.pool[link.bending : link.bending + 6 * k * k].reshape(k, 6 * k)
            bent = modal[link.bent : link.bent + 12 * k].reshape(12, k)
            transposed_product(bending, 0, eta, modal[link.bent : link.bent + 6 * k])
            transposed_product(bending, 0, deta, modal[link.bent + 6 * k : link.bent + 12 * k])
            displacement = displacement + 0.5 * combined(bent, 0, eta)
            slopes = slopes + 0.5 * combined(bent, 3, eta)
            pull, twist = combined(bent, 6, deta), combined(bent, 9, deta)
            for c in range(6):
                for j in range(k):
                    bent[c, j] += basis[c, j]
            shift, rates = combined(bent, 0, deta), combined(bent, 3, deta)
    return displacement, slopes, shift, rates, pull, twist


@kernel
def move_interface(
    flexible: FlexibleTables, body: BorderedBody, link: InterfaceLink, frame: Frame, parent: Frame, modal: np.ndarray
) -> None:
    """Write the motion of an interface frame n of a flexible body (Eq. 22, 24-26)."""
    T = IDENTITY
    if body.is_exact:
        section = ExactBeam(body).sections[link.basis]
        r, A, slide, spin, pull, bend = section.p, section.A @ link.axes, section.v, section.w, section.Z, section.Y
    else:
        displacement, slopes, slide, rates, pull, twist = _by_modes(flexible, link, body, modal)
        A, T, remainder = slope_motion(FlexibleSizes(flexible.sizes).measure, slopes, rates)
        r, spin, bend = link.place + displacement, T @ rates, remainder + T @ twist
    G = parent.R
    frame.R, InterfaceFrame(frame).tangent = G @ A, T
    put_motion(frame, parent, G @ r, Relative(G @ slide, G @ spin, G @ pull, G @ bend))


@entry()
def motions_of_rows(
    scene: Scene, drives: RealBlocks, states: RealRows, rates: RealRows, found: RealBlocks, memory: Reals
) -> None:
    """Write how every row moves in all of some states.

    Parameters
    ----------
    drives : ndarray, shape (T, driven, 3)
    states : ndarray, shape (T, state)
        Each begins with q and u.
    rates : ndarray, shape (T, free), or (0, free)
        du, where accelerations are asked for.
    found : ndarray, shape (T, rows, 18 or 24)
        Position, axes to N (9), velocity, angular velocity and, with rates, acceleration and angular acceleration of
        every row, in N.
    memory : ndarray
        For `Work`.
    """
    work, links, fall = work_in(scene, memory), links_of(scene), three(scene.tables.gravity, 0)
    frames = work.frames
    for k in range(len(states)):
        state = state_in(scene.tables, 0.0, states[k], drives[k], memory)
        sweep_outward(scene, state, work, False)
        for i in range(len(links)):
            moving, frame = found[k, i], frames[i]
            put_three(moving, 0, frame.p)
            rows = frame.R.T
            put_three(moving, 3, rows.x)
            put_three(moving, 6, rows.y)
            put_three(moving, 9, rows.z)
            put_three(moving, 12, frame.v)
            put_three(moving, 15, frame.w)
            if len(rates) > 0:
                put_three(moving, 18, frame.Z + fall)
                put_three(moving, 21, frame.Y)
        if len(rates) == 0:
            continue
        # a = V du + Z, alpha = W du + Y (Eq. 15, 16): the partial velocities times du are the velocities that du causes
        sweep_outward(scene, with_rates(state, rates[k], work.still), work, False)
        for i in range(len(links)):
            moving, frame = found[k, i], frames[i]
            put_three(moving, 18, three(moving, 18) + frame.v)
            put_three(moving, 21, three(moving, 21) + frame.w)


@inlined
def with_rates(state: State, du: np.ndarray, still: np.ndarray) -> State:
    """Return a state that moves by its accelerations as speeds, with drives that do not move: these are written."""
    still[:, :] = 0.0
    for i in range(len(still)):
        still[i, 0] = state.drives[i, 0]
    return State(state.t, state.q, du, state.z, still, state.inputs)
