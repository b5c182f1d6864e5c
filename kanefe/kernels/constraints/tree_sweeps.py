"""The sweeps of the tree, and of the loops that it holds: inward over inertias and forces, outward over accelerations.

Inward, each body's own speeds, elastic and of its joint, are eliminated from its articulated inertia. The row's parent
sees ``force = M a + H alpha + f`` and ``moment = H^T a + J alpha + n`` with a and alpha the share of du in the parent's
acceleration. (Featherstone 1983 for rigid bodies; the elastic border: `eliminate_modes`; loops: `holding`.)
"""

from typing import Any

import numpy as np

from kanefe.kernels.constraints.holding import carries_loops, close_at, exert_at, hold_at
from kanefe.kernels.constraints.loop_tables import Held
from kanefe.kernels.joints.by_kind import accelerate, eliminate, hand_across, hand_through
from kanefe.kernels.joints.handing import hand_force_inward
from kanefe.kernels.language import inlined, kernel
from kanefe.kernels.scene import Scene, Work, links_of
from kanefe.kernels.sweeps.modal_elimination import eliminate_modal_forces, eliminate_modes, modal_accelerations
from kanefe.kernels.tree import Kind, Links

GROUND = -1
"""Number of the row of the ground, which carries loops too."""


@inlined
def is_link_at(links: Links, i: int) -> bool:
    """Return whether a row has a joint: not the ground, nor an interface, whose body moves what it carries."""
    return i > GROUND and links[i].kind != Kind.INTERFACE


@kernel
def sweep_inward(scene: Scene, work: Work, is_implicit: bool, held: Held | None) -> tuple[bool, Any]:
    """Eliminate all rows, children before parents, and loops where they close.

    Parameters
    ----------
    is_implicit : bool
        Whether the modes are scaled and `Work.added` counts, see `kanefe.kernels.sweeps.implicit`.
    held : Held or None
        None: of the tree alone.

    Returns
    -------
    is_regular : bool
        Whether every joint has inertia along it.
    weakest : float
        The least pivot of loops that counts, of the largest.
    """
    links, frames, applied = links_of(scene), work.frames, work.applied
    is_regular, weakest, largest = True, np.inf, 0.0
    for i in range(len(links) - 1, GROUND - 1, -1):
        is_link = is_link_at(links, i)
        if is_link and links[i].flexible >= 0:
            eliminate_modes(scene, work, links[i].flexible, is_implicit)
        if held is not None and carries_loops(scene, i):
            least, most = close_at(scene, work, held, i, is_implicit)
            weakest, largest = min(weakest, least), max(largest, most)
        if is_link:
            link, frame = links[i], frames[i]
            is_regular = eliminate(link, frame, applied, is_implicit, work.added) and is_regular
            if link.parent > GROUND:
                hand_across(link, frame, frames[link.parent], applied)
    return is_regular, min(1.0, weakest / largest) if largest > 0.0 else 1.0


@kernel
def sweep_forces_inward(scene: Scene, work: Work, is_implicit: bool, held: Held | None) -> None:
    """Hand other forces inward, and other needs of loops, over what `sweep_inward` has left."""
    links, frames, applied = links_of(scene), work.frames, work.applied
    for i in range(len(links) - 1, GROUND - 1, -1):
        is_link = is_link_at(links, i)
        if is_link and links[i].flexible >= 0:
            eliminate_modal_forces(scene, work, links[i].flexible, is_implicit)
        if held is not None and carries_loops(scene, i):
            hold_at(scene, work, held, i)
        if is_link:
            link, frame = links[i], frames[i]
            f, n = hand_through(link, frame, applied)
            if link.parent > GROUND:
                hand_force_inward(frames[link.parent], frame.r, f, n)


@kernel
def sweep_accelerations(scene: Scene, work: Work, is_implicit: bool, held: Held | None, du: np.ndarray) -> None:
    """Write du of the free speeds (Eq. 18), the share of du in the acceleration of every row, and the multipliers.

    What links need from their parents counts the multipliers then. `Work.applied` has what couplers exert on drives.
    """
    links, frames, applied = links_of(scene), work.frames, work.applied
    for i in range(GROUND, len(links)):
        is_link = is_link_at(links, i)
        if is_link:
            accelerate(links[i], frames[i], frames[links[i].parent], applied, du)
        if held is not None:
            exert_at(scene, work, held, i)
        if is_link and links[i].flexible >= 0:
            modal_accelerations(scene, work, links[i].flexible, is_implicit, du)
