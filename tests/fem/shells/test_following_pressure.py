"""Pressures that follow the faces of shells: forces on deformed faces, turns, a ring that buckles, both routes."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.frames import skews
from kanefe.kane.assemble import accelerations
from kanefe.kane.energy import load_power
from kanefe.states.state import State
from kanefe.tree.stiffening_check import StiffeningWarning
from kanefe_fem import Material, ShellFace, shell_body, shell_model, surface_mesh
from kanefe_fem.mesh.surface_grid import joined_surfaces
from kanefe_fem.verification.loaded_shells import exact_forces
from kanefe_fem.verification.stiffened_shells import tube_under_pressure
from order_n_rates import order_n
from shell_meshes import grid

pytestmark = pytest.mark.fenicsx

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SIDES = {name: ShellFace(name) for name in ("top", "middle", "bottom")}


def change_of(pattern):
    """Return the change of resultant, moment and forces on all components with these, (6 + N, N)."""
    return pattern.pressure_change.over(np.eye(len(pattern.traction)))


@pytest.mark.filterwarnings("ignore:.*:kanefe_fem.mesh.checks.MeshWarning", "ignore:the thickness")
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(
    ("surface", "kind"), [("saddle", "quad9"), ("half cylinder", "triangle6"), ("twisted", "quad9")]
)
def test_forces_change_as_those_on_the_deformed_face_do(surface, kind, side):
    mesh = grid(surface, 4, 3, distort=0.2, kind=kind)
    model = shell_model(mesh, STEEL, lambda x: 0.03 + 0.01 * x[:, 0], offset=0.2, surfaces=SIDES)
    pattern = model.load_patterns[side]
    unmoved = np.concatenate((pattern.pressure_force, pattern.pressure_moment, pattern.pressure))
    np.testing.assert_allclose(exact_forces(model, side, np.zeros(model.size)), unmoved, atol=1e-14)
    along, change = np.random.default_rng(2).standard_normal(model.size), change_of(pattern)
    step = 1e-3  # the error of fourth order is below 1e-9, round-off below 1e-12
    rates = [
        (exact_forces(model, side, h * along) - exact_forces(model, side, -h * along)) / (2.0 * h)
        for h in (step, 2.0 * step)
    ]
    expected = (4.0 * rates[0] - rates[1]) / 3.0
    for part in (slice(0, 3), slice(3, 6), slice(6, None)):
        np.testing.assert_allclose(
            (change @ along)[part], expected[part], rtol=0, atol=1e-8 * abs(expected[part]).max()
        )


@pytest.mark.filterwarnings("ignore:.*:kanefe_fem.mesh.checks.MeshWarning")
@pytest.mark.parametrize("side", SIDES)
def test_forces_turn_with_a_shell(side):
    """As vectors; on rotation vectors, moments of forces that turn too have half of that."""
    model = shell_model(grid("saddle", 4), STEEL, 0.02, offset=0.3, surfaces=SIDES)
    pattern, rigid, a = model.load_patterns[side], model.rigid_modes(), np.array([0.3, -0.7, 0.4])
    forces = pattern.pressure.reshape(-1, 6)
    turned = np.hstack((np.cross(a, forces[:, :3]), 0.5 * np.cross(a, forces[:, 3:])))
    resultants = np.cross(a, [pattern.pressure_force, pattern.pressure_moment])
    change = change_of(pattern) @ (rigid[:, 3:] @ a)
    np.testing.assert_allclose(change, np.concatenate((resultants.ravel(), turned.ravel())), atol=1e-14)
    moved = (change_of(pattern) @ rigid[:, :3])[:6]
    np.testing.assert_allclose(moved, np.vstack((np.zeros((3, 3)), -skews(pattern.pressure_force))), atol=1e-14)


@pytest.mark.filterwarnings("ignore:.*:kanefe_fem.mesh.checks.MeshWarning")
def test_a_closed_shell_has_no_resultant_however_it_deforms_and_a_potential():
    change = change_of(shell_model(grid("saddle", 2), STEEL, 0.02, surfaces=SIDES).load_patterns["top"])
    assert abs(change[6:] - change[6:].T).max() > 0.1 * abs(change[6:]).max()  # its edges are free
    sides = [surface_mesh(lambda s, r, i=i, z=z: _on_cube(s, r, i, z), (2, 2)) for i in range(3) for z in (1.0, -1.0)]
    model = shell_model(joined_surfaces(sides), STEEL, 0.02, offset=0.2, surfaces=SIDES)
    for side in SIDES:
        change = change_of(model.load_patterns[side])
        assert abs(change[6:] - change[6:].T).max() < 1e-14
        assert abs(change[:6] @ np.random.default_rng(1).standard_normal((model.size, 4))).max() < 1e-13


def _on_cube(s, r, axis, sign):
    """Return a side of a ball, by its place on a cube."""
    p = [np.zeros_like(s)] * 3
    p[axis], p[(axis + 1) % 3] = sign * np.ones_like(s), sign * np.tan((s - 0.5) * np.pi / 2.0)
    p[(axis + 2) % 3] = np.tan((r - 0.5) * np.pi / 2.0)
    length = np.sqrt(p[0] ** 2 + p[1] ** 2 + p[2] ** 2)
    return tuple(x / length for x in p)


@pytest.mark.parametrize("side", SIDES)
def test_a_ring_buckles_at_3_EI_over_R3_by_a_pressure_that_follows(side):
    """On either face: of one beside the middle, moments of the faces balance that the radius there is another."""
    body = tube_under_pressure(4, 0.01, side)
    scene = kf.System()
    pressure = -1.0 if side == "bottom" else 1.0
    scene.add_pressure(scene.add_flexible_body("tube", body), "wall", pressure, follows=True)
    factors = kf.buckling(scene).factors / (3.0 * 70e9 * 0.01**3 / 12.0)
    # 4 cells a quarter are 0.4 and 1.2 % stiff; with 8 it is 0.05 and 0.1 %, see SH25
    np.testing.assert_allclose(factors[:4], [1.0, 1.0, 8.0 / 3.0, 8.0 / 3.0], rtol=1.5e-2)
    assert np.ptp(factors[:2]) < 1e-6
    fixed = kf.System()
    fixed.add_pressure(fixed.add_flexible_body("tube", body), "wall", pressure)
    with pytest.raises(ModelError, match=r"turns with the frame of its body, .* Remedy: add_pressure.*follows=True"):
        kf.buckling(fixed)


def panel_on_a_hinge(follows=True, **options):
    """Return a curved panel on a hinge, under a pressure on its top that grows; its edges but one are free."""
    soft = Material(E=2e8, nu=0.3, rho=1200.0)
    mesh = surface_mesh(lambda s, r: (s, 0.5 * (r - 0.5), 0.1 * s**2 + 0.2 * r**2), (3, 2))
    statics = kf.CraigBampton(modes=3)
    body = shell_body(mesh, soft, {"root": "clamped"}, 0.02, statics, surfaces=SIDES, **options)
    scene = kf.System(gravity=(0.0, 0.0, -1.0))
    panel = scene.add_flexible_body("panel", body, joint=kf.Revolute("y"))
    scene.add_pressure(panel, "top", lambda t: 400.0 + 600.0 * t, follows=follows)
    return scene


@pytest.mark.parametrize("stiffening", ["none", "full"])
def test_both_routes_have_the_same_accelerations_and_powers(stiffening):
    model = panel_on_a_hinge(stiffening=stiffening).freeze()
    rng, count = np.random.default_rng(3), model.coordinate_count
    q, u = 0.01 * rng.standard_normal(count), rng.standard_normal(model.free_count)
    literal = accelerations(State(model, 0.5, q, u))
    found = order_n(model).held_rates(0.5, np.concatenate((q, u, np.zeros(2))))[0][count:]
    np.testing.assert_allclose(found[: len(u)], literal, rtol=0, atol=1e-11 * abs(literal).max())
    assert found[-1] == pytest.approx(load_power(State(model, 0.5, q, u)), rel=1e-12)
    fixed = panel_on_a_hinge(False, stiffening=stiffening).freeze()
    assert abs(accelerations(State(fixed, 0.5, q, u)) - literal).max() > 1e-3 * abs(literal).max()


def test_a_run_keeps_its_balance_of_energy_although_the_load_has_no_potential():
    energy = panel_on_a_hinge().simulate((0.0, 0.3), rtol=1e-9).energy
    total = energy.kinetic + energy.elastic + energy.gravity
    error = total - total[0] - (energy.work - energy.work[0])
    assert np.ptp(energy.work) > 0.1
    assert abs(error).max() < 1e-6 * np.ptp(energy.work)


def test_rest_and_stiffness_have_the_change_of_the_pressure():
    """A clamped panel: ``(K - p K_p) eta = p f``, and that matrix in the linearisation."""
    scene = panel_on_a_hinge()
    body = scene.freeze().bodies[0].flexible.body
    held = kf.System()
    held.add_pressure(held.add_flexible_body("panel", body), "top", 400.0, follows=True)
    pattern, k = body.load_pattern("top"), body.free_count
    stiffness = body.stiffness[:k, :k] - 400.0 * pattern.pressure_change[6 : 6 + k, :k]
    rest = kf.equilibrium(held)
    expected = np.linalg.solve(stiffness, 400.0 * pattern.pressure_elastic[:k])
    np.testing.assert_allclose(rest.q, expected, rtol=0, atol=1e-9 * abs(expected).max())
    small = rest.linearise()
    assert abs(stiffness - stiffness.T).max() > 1e-6 * abs(stiffness).max()
    np.testing.assert_allclose(small.stiffness, stiffness, rtol=0, atol=1e-8 * abs(stiffness).max())


def test_a_body_keeps_the_change_in_a_file_and_one_without_reduction_has_none(tmp_path):
    body = panel_on_a_hinge(stiffening="full").freeze().bodies[0].flexible.body
    body.save(tmp_path / "panel.npz")
    read = kf.FlexibleBody.load(tmp_path / "panel.npz").load_pattern("top")
    np.testing.assert_array_equal(read.pressure_change, body.load_pattern("top").pressure_change)
    mesh = surface_mesh(lambda s, r: (s, r, 0.0 * s), (6, 6))
    whole = shell_body(mesh, STEEL, {"root": "clamped"}, 0.02, None, surfaces=SIDES)
    scene = kf.System()
    member = scene.add_flexible_body("plate", whole)
    with pytest.raises(ModelError, match=r"on 'top' of 'plate' cannot follow its surface: the body is unreduced"):
        scene.add_pressure(member, "top", 1.0, follows=True)


def test_what_a_free_edge_and_a_stiffening_by_inertia_alone_leave_open_is_told():
    scene = kf.System()
    body = panel_on_a_hinge(stiffening="full").freeze().bodies[0].flexible.body
    scene.add_pressure(scene.add_flexible_body("panel", body), "top", 1.0, follows=True)
    with pytest.raises(ModelError, match=r"pressure on 'top' of 'panel' has no potential.*stability_limit"):
        kf.buckling(scene)
    assert kf.stability_limit(scene).path.turning == ("the pressure on 'top' of 'panel'",)
    with pytest.warns(
        StiffeningWarning, match="stiffening='inertial', which leaves out what the forces of the pressure"
    ):
        panel_on_a_hinge(stiffening="inertial").freeze()
