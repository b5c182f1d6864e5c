"""Which rigid motions of a body its supports leave, and whether its stiffness leaves them free."""

from __future__ import annotations

import numpy as np
import scipy.sparse.linalg as spla

from kanefe.errors import ModelError
from kanefe.finite_element_model import FiniteElementModel
from kanefe.interface_ties import InterfaceTies


def unrestrained_motions(model: FiniteElementModel, ties: InterfaceTies) -> int:
    """Return how many rigid motions must be taken out: all of a floating body, none of one held in G."""
    modes, _ = model.unit_rigid_modes()
    total = int(np.linalg.matrix_rank(modes, tol=1e-9))
    if not len(ties.fixed):
        _check_rigid_motions(model, modes)
        _check_interfaces_hold(ties, modes, total)
        return total
    held = ties.coordinates(model.rigid_modes(about=model.nodes.mean(axis=0)))[ties.fixed]
    length = np.ptp(model.nodes, axis=0).max() or 1.0
    held[:, 3:] /= length
    restrained = int(np.linalg.matrix_rank(held, tol=1e-9))
    if restrained < total:
        names = ", ".join(t.name for t in ties.ties if t.fixed)
        raise ModelError(
            f"the interfaces fixed in G ({names}) leave {total - restrained} rigid motion(s) of the body free. "
            "Remedy: make one of them 'clamped', fix more components, or fix none and give the body a free joint"
        )
    return 0


def _check_interfaces_hold(ties: InterfaceTies, modes: np.ndarray, total: int) -> None:
    """Check that the interfaces of a floating body, all held, leave none of its rigid motions (unit columns)."""
    if not ties.ties:
        return
    frames = ties.coordinates(modes)[ties.interior_count :]
    held = int(np.linalg.matrix_rank(frames / np.maximum(np.linalg.norm(frames, axis=0), 1e-300), tol=1e-9))
    if held < total:
        raise ModelError(
            f"the body floats, and its interfaces ({', '.join(tie.name for tie in ties.ties)}) follow only {held} of "
            f"its {total} rigid motions. Remedy: add an interface of facets; loads and springs need none, they go to "
            "member.node(number)"
        )


def _check_rigid_motions(model: FiniteElementModel, modes: np.ndarray) -> None:
    """Check that the stiffness of a floating body does not resist rigid motions (unit columns) of its nodes."""
    resistance = np.linalg.norm(model.stiffness @ modes, axis=0).max() / spla.norm(model.stiffness, np.inf)
    if resistance > 1e-6:  # matrices exported with seven digits pass
        raise ModelError(
            f"K resists rigid motions of the nodes ({resistance:.2g} of its largest row), but the body floats. "
            "Remedy: check the order of the nodes and that the model is unsupported, or clamp an interface"
        )
