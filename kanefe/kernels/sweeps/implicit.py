"""The linearly implicit sweep: ``(M + s C + r K) z = F + C a + K b`` in place of ``M du = F``.

C and K are the diagonals of the modes of unit mass, and springs, dampers and stops along joint coordinates,
each at the current state. An arm of a viscoelastic body, whose state z at the end of a step has a share p of its rate,
is eliminated by hand: ``z = (known + p rate pull eta) / (1 + p rate)`` leaves ``pull^2 / (1 + p rate)`` of its
stiffness. In modes of unit mass the block of a body becomes ``d = 1 + s c + r k``; with the modes
scaled by the root of d it is the identity again, so that the elimination of the modes is that of the plain sweep.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.bodies import ModalBody
from kanefe.kernels.language import copy, kernel
from kanefe.kernels.loads.coordinate_law import CoordinateLaws, coordinate_slopes
from kanefe.kernels.loads.joint_forces import JointForces
from kanefe.kernels.planar.layout import PlanarTables
from kanefe.kernels.scene import Scene, State, Work, bodies_of
from kanefe.kernels.sweeps.elastic import transposed_product
from kanefe.kernels.sweeps.exact_beam_inertia import stiffen_beam
from kanefe.kernels.tables import Tables


class Pushes(NamedTuple):
    """What a linearly implicit evaluation is given more.

    Attributes
    ----------
    damping, stiffness, rates : float
        s and r, and p of internal states: 0 where they stay.
    along_damping, along_stiffness : ndarray, shape (free,)
        a and b.
    """

    damping: float
    stiffness: float
    rates: float
    along_damping: np.ndarray
    along_stiffness: np.ndarray


@kernel
def stiffen_modes(scene: Scene, work: Work, pushes: Pushes) -> None:
    """Scale forces and coupling of all modes by ``1 / sqrt(d)``, after adding directional products, over the speeds."""
    bodies = bodies_of(scene, work)
    for f in range(len(bodies)):
        body = bodies[f]
        k, speed = body.k, body.first_deta
        along_damping = pushes.along_damping[speed : speed + k]
        along_stiffness = pushes.along_stiffness[speed : speed + k]
        if body.is_exact:
            own = Pushes(pushes.damping, pushes.stiffness, pushes.rates, along_damping, along_stiffness)
            stiffen_beam(ExactBeam(body), own)
            continue
        workspace = body.even.numbers
        of_damping, of_stiffness = workspace[:k], workspace[k : 2 * k]
        if body.transform < 0:
            copy(along_damping, of_damping)
            copy(along_stiffness, of_stiffness)
        else:
            transposed_product(body.to_modes, 0, along_damping, of_damping)
            transposed_product(body.to_modes, 0, along_stiffness, of_stiffness)
        p, scale, linear, angular, stiffness = body.p, body.scale, body.linear, body.angular, body.stiffness
        of_arms = workspace[2 * k : 3 * k]
        if body.arm_count > 0:
            _put_arms(body, pushes.rates, of_arms)
        for j in range(k):
            damping = 0.0
            if body.damped >= 0:
                damping = body.damping[j, j]
            resists = stiffness[j]
            if body.arm_count > 0:
                resists += of_arms[j].real
            s = 1.0 / np.sqrt(1.0 + pushes.damping * damping + pushes.stiffness * resists)
            scale[j] = s
            p[j] = s * (p[j] + damping * of_damping[j] + resists * of_stiffness[j])
            linear[j], angular[j] = s * linear[j], s * angular[j]


@kernel
def _put_arms(body: ModalBody, share_of_rates: float, stiffness: np.ndarray) -> None:
    """Write what the arms add to the stiffness of each mode."""
    arms = body.arms
    stiffness[:] = 0.0
    for i in range(len(arms)):
        arm = arms[i]
        stiffness[int(arm.mode)] += arm.pull * arm.pull / (1.0 + share_of_rates * arm.rate)


@kernel
def stiffen_joints(
    tables: Tables | PlanarTables, state: State, pushes: Pushes, applied: np.ndarray, added: np.ndarray
) -> None:
    """Write the inertia that ``s C + r K`` adds along each joint coordinate; add directional products to the forces."""
    added[:] = 0.0
    forces, laws = JointForces(tables.joint_forces), CoordinateLaws(tables.laws)
    for n in range(len(forces)):
        at, speed, law = forces[n].coordinate, forces[n].speed, forces[n].law
        if at >= 0 and law >= 0:
            stiffness, damping = coordinate_slopes(laws[law], state.q[at].real, state.u[speed].real)
            added[speed] += pushes.damping * damping + pushes.stiffness * stiffness
            applied[speed] += damping * pushes.along_damping[speed] + stiffness * pushes.along_stiffness[speed]
