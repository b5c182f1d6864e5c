"""V, W, Z, Y of every frame of a scene against finite differences of where it is (Eq. 3, 13-16, 22, 24-26)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.frames import axial
from kanefe.kane.inertia import body_partial_velocities, nodal_partial_velocities
from kanefe.states.kinematics import FrameMotion, interface_motion, sweep_outward
from scenes import (
    chain_scene,
    derivatives,
    flexible_scene,
    floating_scene,
    path,
    planar_scene,
    random_state,
    rigid_scene,
)

T = 0.4
CB = kf.CraigBampton(modes=3)
SCENES: dict[str, Callable[[str], kf.System]] = {
    "rigid": lambda slopes: rigid_scene(1, slopes),
    "flexible": lambda slopes: flexible_scene(2, slopes=slopes),
    "flexible, reduced": lambda slopes: flexible_scene(3, slopes=slopes, reduction=CB),
    "driven, flexible on an interface": lambda slopes: chain_scene(4, slopes, reduction=CB),
    "floating": lambda slopes: floating_scene(5, slopes),
    "planar": lambda slopes: planar_scene(6),
    "nodal form": lambda slopes: flexible_scene(7, slopes=slopes, rotations=True, reduction=CB),
}
SLOPES = ("rotation-vector", "tait-bryan")

# Order-8 differences with steps of 0.01 of functions whose rates are of order 1 to 10: truncation below 1e-10;
# round-off of the second derivative 1e-15 / 0.01^2 times lengths of order 1.
STEP, TOLERANCE = 0.01, 2e-9


def frames_of(model: Model, t: float, q: np.ndarray, u: np.ndarray) -> list[FrameMotion]:
    """Return the motion of all bodies and all interfaces."""
    full = model.all_speeds(t, u)
    motions = sweep_outward(model, t, q, full)
    for body, G in zip(model.bodies, list(motions), strict=True):
        if body.flexible:
            frames = (*body.flexible.body.interfaces, body.flexible.body.node_frame(1))
            motions += [interface_motion(G, n, body.flexible, q, full, model.slopes) for n in frames]
    return motions


@pytest.mark.parametrize("slopes", SLOPES)
@pytest.mark.parametrize("scene", SCENES)
def test_frames_move_as_their_partial_velocities_and_remainders_say(scene: str, slopes: str) -> None:
    model = SCENES[scene](slopes).freeze()
    # slopes of some tenths of a radian: finite rotations, short of the 90 degrees of Tait-Bryan angles
    q, u = random_state(model, 8, amplitude=0.15)
    du = np.random.default_rng(9).standard_normal(model.free_count)
    moved = path(model, q, u, du)
    driven, driven_rates = model.driven_speeds(T)
    speeds, rates = np.concatenate((u, driven)), np.concatenate((du, driven_rates))

    def at(s: float) -> list[FrameMotion]:
        return frames_of(model, T + s, moved(s), u + s * du)

    now = at(0.0)
    v, a = derivatives(lambda s: np.array([f.p_NoFo_N for f in at(s)]), STEP)
    dA, _ = derivatives(lambda s: np.array([f.A_NF for f in at(s)]), STEP)
    # w of the code is checked against dA first, so that its own rate is a fair reference of alpha
    alpha, _ = derivatives(lambda s: np.array([f.A_NF @ f.w for f in at(s)]), STEP)
    for i, f in enumerate(now):
        w = -0.5 * axial(dA[i] @ f.A_NF.T)
        assert f.A_NF @ f.v == pytest.approx(v[i], abs=TOLERANCE)
        assert f.A_NF @ f.w == pytest.approx(w, abs=TOLERANCE)
        assert f.V @ speeds == pytest.approx(f.v, abs=1e-13)
        assert f.W @ speeds == pytest.approx(f.w, abs=1e-13)
        assert f.A_NF @ (f.V @ rates + f.Z) == pytest.approx(a[i], abs=TOLERANCE * (1 + abs(a[i]).max()))
        assert f.A_NF @ (f.W @ rates + f.Y) == pytest.approx(alpha[i], abs=TOLERANCE * (1 + abs(alpha[i]).max()))


@pytest.mark.parametrize("scene", ["flexible", "driven, flexible on an interface", "floating", "planar"])
def test_mass_points_move_as_nodal_partial_velocities_say(scene: str) -> None:
    model = SCENES[scene]("rotation-vector").freeze()
    q, u = random_state(model, 8, amplitude=0.15)
    du = np.random.default_rng(9).standard_normal(model.free_count)
    moved = path(model, q, u, du)
    driven, driven_rates = model.driven_speeds(T)
    speeds, rates = np.concatenate((u, driven)), np.concatenate((du, driven_rates))
    for number, body in enumerate(model.bodies):
        if body.flexible is None:
            continue
        terms = body.flexible
        k = terms.body.free_count

        def points(s: float, number: int = number, terms=terms, k: int = k) -> np.ndarray:
            q_s = moved(s)
            G = sweep_outward(model, T + s, q_s, model.all_speeds(T + s, u))[number]
            r = terms.body.inertia_points + (terms.body.inertia_basis[:, :k] @ q_s[terms.eta]).reshape(-1, 3)
            return G.p_NoFo_N + r @ G.A_NF.T

        G = sweep_outward(model, T, q, model.all_speeds(T, u))[number]
        V, Z = nodal_partial_velocities(terms.body, body_partial_velocities(terms, G), G, q[terms.eta], u[terms.speeds])
        v, a = derivatives(points, STEP)
        assert (V @ speeds).reshape(-1, 3) @ G.A_NF.T == pytest.approx(v, abs=TOLERANCE)
        assert (V @ rates + Z).reshape(-1, 3) @ G.A_NF.T == pytest.approx(a, abs=TOLERANCE * (1 + abs(a).max()))


def test_interface_rotations_are_finite() -> None:
    # A slope of 1 rad is a rotation by 1 rad: the linear form I + theta~ would be no rotation matrix.
    model = flexible_scene(2).freeze()
    q, u = random_state(model, 8, amplitude=0.6)
    for frame in frames_of(model, T, q, u):
        assert frame.A_NF.T @ frame.A_NF == pytest.approx(np.eye(3), abs=1e-13)
    terms = model.flexible_terms("arm")
    theta = terms.body.interface("tip").motion[3:, : terms.body.free_count] @ q[terms.eta]
    assert np.linalg.norm(theta) > 0.3  # else this test would show nothing


def test_planar_motion_stays_in_the_plane() -> None:
    model = planar_scene(6).freeze()
    q, u = random_state(model, 3)
    for frame in sweep_outward(model, T, q, model.all_speeds(T, u)):
        assert not frame.V[2].any()
        assert not frame.W[:2].any()
        assert frame.Z[2] == 0.0
        assert not frame.Y[:2].any()


def test_driven_speeds_are_no_whole_numbers_beside_such() -> None:
    """A state may be given by whole numbers."""
    scene = kf.System()
    cart = scene.add_rigid_body("cart", 1.0, joint=kf.Prismatic("x", motion=kf.Motion.steady(0.5)))
    scene.add_rigid_body("arm", 1.0, 1.0, parent=cart, joint=kf.Revolute("z"))
    assert scene.freeze().all_speeds(0.0, np.array([2])).tolist() == [2.0, 0.5]
