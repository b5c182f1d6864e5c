"""Section forces of beams: equilibrium, closed forms, the mode-acceleration method."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem.beams.body import beam_body, beam_model
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.recovery.recovery import recover
from result_scenes import at_rest, beam_arm, robot, turntable

WEIGHT = 1200.0 * 0.02 * 0.04 * 9.81  # N/m, of result_scenes.beam_arm


def test_a_heavy_cantilever_has_the_closed_form_by_mode_acceleration_with_one_mode():
    forces = recover(at_rest(), "arm", frames=[-1]).section_forces(5, inertia=True)
    rest = 1.0 - forces.positions[..., 0]
    # local z is G's z: gravity pulls the part beyond a section along -z
    np.testing.assert_allclose(forces["Vz"][0], -WEIGHT * rest, atol=1e-9)
    np.testing.assert_allclose(forces["My"][0], WEIGHT * rest**2 / 2, atol=1e-9)
    for name in ("N", "Vy", "T", "Mz"):
        np.testing.assert_allclose(forces[name], 0.0, atol=1e-9)


def test_the_kept_modes_alone_miss_what_the_dropped_ones_carry():
    forces = recover(at_rest(), "arm", frames=[-1]).section_forces()
    assert forces["My"][0, 0, 0] == pytest.approx(WEIGHT / 2, rel=0.25)
    assert forces["My"][0, 0, 0] < 0.9 * WEIGHT / 2


@pytest.mark.parametrize("inertia", [False, True])
def test_a_driven_arm_is_in_balance_with_what_carries_it_and_what_it_carries(inertia):
    result, frames = robot(), [5, 20, 33]
    forces = recover(result, "arm", frames=frames).section_forces(3, inertia=inertia)
    assert forces.forces.shape == (3, 6, 3, 6)
    root, tip = (result.coupling_force("arm", name)[frames] for name in ("root", "tip"))
    scale = abs(root).max()
    if not inertia:
        np.testing.assert_allclose(forces.forces[:, 0, 0, 4:], -root[:, 4:], atol=0.3 * scale)
        return
    # axes of the elements are those of G; moments of the deformed body differ by forces times deflections, of second
    # order, which is all there is of twist at the root
    np.testing.assert_allclose(forces.forces[:, 0, 0, :3], -root[:, :3], atol=1e-9 * scale)
    np.testing.assert_allclose(forces.forces[:, 0, 0, 4:], -root[:, 4:], atol=3e-4 * scale)
    np.testing.assert_allclose(forces.forces[:, -1, -1], tip, atol=1e-9 * scale)
    np.testing.assert_allclose(forces.forces[:, 1:, 0], forces.forces[:, :-1, -1], atol=1e-9 * scale)


def test_static_loads_at_the_tip_of_a_bent_frame():
    """An L of two beams with a heavy body at its end: bending, then torsion and bending, by statics."""
    steel = Material(E=210e9, nu=0.3, rho=1e-3)  # nearly without weight
    a, b, load = 0.4, 0.3, 5.0 * 9.81
    model = beam_model(
        [[0, 0, 0], [a / 2, 0, 0], [a, 0, 0], [a, b, 0]], [[0, 1], [1, 2], [2, 3]], Rectangle(0.03, 0.02), steel
    )
    body = beam_body(model, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=0))

    def scene(eta: np.ndarray | None) -> kf.System:
        system = kf.System(gravity=(0, 0, -9.81))
        arm = system.add_flexible_body("arm", body, modal_coordinates=eta)
        system.add_rigid_body("weight", mass=5.0, parent=arm.interface("tip"))
        return system

    k = body.free_count
    tip = body.interface("tip").motion[2, :k]
    sag = np.linalg.solve(body.stiffness[:k, :k], -load * tip)
    result = scene(sag).simulate((0.0, 1e-4), output_step=1e-4, method="generalised-alpha")
    forces = recover(result, "arm", frames=[0]).section_forces()
    np.testing.assert_allclose(forces["Vz"][0], -load, rtol=1e-8)
    # along the first beam, x: My falls to zero at the corner, T is the weight's arm b about x
    np.testing.assert_allclose(forces["My"][0, :2], load * np.array([[a, a / 2], [a / 2, 0]]), atol=1e-7)
    np.testing.assert_allclose(forces["T"][0, :2], -load * b, rtol=1e-8)
    # the second beam, along y, bends and does not twist
    np.testing.assert_allclose(forces["T"][0, 2], 0.0, atol=1e-7)
    np.testing.assert_allclose(np.hypot(forces["My"], forces["Mz"])[0, 2], [load * b, 0.0], atol=1e-7)


def test_a_distributed_load_is_noticed():
    scene = kf.System()
    nodes = np.linspace((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 4)
    elements = np.column_stack((range(3), range(1, 4)))
    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    model = beam_model(nodes, elements, Rectangle(0.02, 0.02), steel, lines={"all": [0, 1, 2]}, groups={"root": [0]})
    body = beam_body(model, {"root": "clamped"}, kf.CraigBampton(modes=3), lines=["all"])
    arm = scene.add_flexible_body("arm", body)
    scene.add_line_load(arm, "all", (0.0, 5.0, 0.0))
    result = scene.simulate((0.0, 0.02), output_step=0.02, method="generalised-alpha")
    with pytest.raises(kf.ModelError, match=r"not in balance.*distributed loads.*inertia=False"):
        recover(result, "arm").section_forces(inertia=True)


@pytest.mark.parametrize("at", ["node", "interface", "spring at the interface"])
def test_forces_at_nodes_and_interfaces_are_among_the_loads(at):
    scene = kf.System()
    body = beam_arm()
    arm = scene.add_flexible_body("arm", body)
    end = body.interface("tip").position
    where = body.nodes[3] if at == "node" else end
    if at == "spring at the interface":
        above = scene.ground.frame(at=end + np.array((0, 0, 1)))
        scene.add_spring("spring", arm.interface("tip"), above, stiffness=50.0, rest_length=0.9)
    else:
        scene.add_force(arm.node(3) if at == "node" else arm.interface("tip"), (0.0, 0.0, 5.0))
    rest = kf.equilibrium(scene)
    forces = recover(rest, "arm").section_forces(inertia=True)
    lift = rest.load_force("spring", 0)[2] if "spring" in at else 5.0
    assert lift > 4.0
    # of the clamp; the arm sags across x alone, so that the lever stays
    assert abs(forces["My"][0, 0, 0]) == pytest.approx(lift * where[0], rel=1e-6)
    assert rest.coupling_force("arm", "root")[2] == pytest.approx(-lift, rel=1e-6)


def test_the_force_of_a_contact_is_among_the_loads():
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    body = beam_arm()
    arm = scene.add_flexible_body("arm", body)
    end = int(np.argmax(body.nodes[:, 0]))
    stop = scene.add_surface("stop", scene.ground, kf.shapes.Plane("z"), at=(0, 0, body.nodes[end, 2] - 1e-5))
    scene.add_contact("end", arm.node(end), stop, normal=kf.KelvinVoigt(1e5, damping=50.0))
    rest = kf.equilibrium(scene)
    forces = recover(rest, "arm").section_forces(inertia=True)
    weight, reach = body.mass * 9.81, body.nodes[end, 0]
    # of the clamp: half the weight's moment, less that of the stop
    wanted = weight * body.center_of_mass[0] - float(rest.contact("end").normal) * reach
    assert abs(forces["My"][0, 0, 0]) == pytest.approx(abs(wanted), rel=1e-6)


def test_what_has_no_section_forces_is_refused(tmp_path):
    with pytest.raises(kf.ModelError, match="rigid"):
        recover(turntable(), "table")
    fields = recover(robot(), "arm")
    with pytest.raises(kf.ModelError, match="at least 2"):
        fields.section_forces(1)
    with pytest.raises(kf.ModelError, match="N, Vy, Vz, T, My, Mz"):
        fields.section_forces()["Q"]
    robot().save(tmp_path / "run.h5")
    again = recover(kf.load_result(tmp_path / "run.h5"), "arm", frames=[3])
    mine = fields.section_forces().forces[3]
    np.testing.assert_allclose(again.section_forces().forces[0], mine, atol=1e-12 * abs(mine).max())
    with pytest.raises(kf.ModelError, match=r"read from a file.*inertia=False"):
        again.section_forces(inertia=True)
