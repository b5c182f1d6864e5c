"""Forces of rigid contacts that can be shared in several ways: compiled code finds some that can be where there are."""

from __future__ import annotations

import numpy as np

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.literal.contact_forces import probe_forces
from robustness.rocking import stack

FAR = 1e-6
"""Margin, relative to the largest force, from which on both routes have to agree about its sign: the least room that is
looked for is 1e-9."""


def table(seed: int) -> tuple[Model, np.ndarray]:
    """Return a table on five to nine legs, pressed somewhere along some line, and a state in which all legs stick."""
    rng, scene = np.random.default_rng(seed), kf.System()
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    top = scene.add_rigid_body("table", 1.0, 0.1, joint=kf.Free(position=(0.0, 0.0, 0.7)))
    scene.add_force(top, (*rng.uniform(-3.0, 3.0, 2), -9.81), point=(*rng.uniform(-0.3, 0.3, 2), 0.0))
    legs = [(*rng.uniform(-0.4, 0.4, 2), -0.7) for _ in range(int(rng.integers(5, 10)))]
    feet = scene.add_surface("feet", top, kf.shapes.Points(legs))
    scene.add_contact("stands", feet, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.4))
    model = scene.freeze()
    q, u, z = (part.copy() for part in model.parts(model.initial_state))
    for leg in range(len(legs)):
        model.rigid_contact(0).with_status(z, leg, 1, np.zeros(3), np.zeros(3))
    return model, np.concatenate((q, u, z))


def least_margins(model: Model, y: np.ndarray) -> tuple[float, float]:
    """Return the least margin by compiled code, and that which linear programs find, of the largest force."""
    watching = model.route.watching
    assert watching is not None
    columns = [watching.contact_columns[kind] for kind in ("lift", "slip")]
    own = watching.values(np.zeros(1), y[None])[0, columns].min()
    forces = probe_forces(model.literal.view(0.0, y))
    margins = [(f.normal, 0.4 * f.normal - float(np.linalg.norm(f.friction))) for f in forces]
    return own, float(np.min(margins)) / max(abs(f.normal) for f in forces)


def test_forces_that_can_be_are_found() -> None:
    """Some of these tables stand and some do not, whatever forces of least norm say."""
    stands = []
    for seed in range(40):
        own, best = least_margins(*table(seed))
        if abs(best) > FAR:
            stands.append(best > 0.0)
            assert (own > 0.0) == stands[-1], seed
    assert 10 < sum(stands) < len(stands) - 5


def test_what_nothing_presses_is_left_so() -> None:
    """Two blocks of this stack float off together, and the rest stands: its forces have spare ways, and round-off.

    None are made up that do nothing together: those would have no margin, however large they are.
    """
    scene, _ = stack(2)
    result = scene.simulate((0.0, 0.07))
    assert result.status.is_finished
