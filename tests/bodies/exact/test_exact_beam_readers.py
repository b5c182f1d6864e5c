"""What reads and draws exact beams: nodes, skins, files, forces at the root, loads along them, small motions."""

import pickle

import numpy as np
import pytest

import kanefe as kf
from kanefe.frames import euler_parameters_from_matrices, rotation_matrices, rotation_vectors
from kanefe.literal.run_forces import LiteralForces
from kanefe.loads.functions import CompiledCallback
from kanefe.tree.neighbours import parts_of
from kanefe.views.player import page
from kanefe.views.player.skins import PIECES, skin_of
from kanefe_fem import Material, Rectangle, exact_beam, recover
from kanefe_fem.recovery.fibre_stress import normal_stress
from player_pages import body_of, placed, read_page

RUBBER = Material(E=1e7, nu=0.3, rho=1000.0)
STRIP = Rectangle(0.02, 0.01)
EI = 1e7 * 0.02 * 0.01**3 / 12  # about y, N m2


def strip(**options: object) -> kf.FlexibleBody:
    return exact_beam(1.0, STRIP, RUBBER, basis=6, **options)


def curved() -> kf.FlexibleBody:
    return strip(curvature=(0.5, 1.0, 2.0), interfaces={"root": 0.0, "mid": 0.4, "tip": 1.0})


@pytest.fixture(scope="module")
def swing() -> kf.Result:
    scene = kf.System(gravity=(0, 0, -9.81))
    beam = scene.add_flexible_body("beam", curved(), joint=kf.Revolute("y"))
    scene.add_rigid_body("bob", 0.05, 1e-5, parent=beam.interface("root"), at=(0, 0, -0.1), joint=kf.Revolute("y"))
    scene.add_force(beam.interface("tip"), (0.0, 0.1, 0.05))
    scene.add_line_load(beam, "span", (0.2, 0.0, 0.1))
    return scene.simulate((0.0, 0.4), output_step=0.1)


def test_places_at_many_states_are_those_of_the_motion_at_each():
    line = curved().line
    etas = 2.0 * np.random.default_rng(1).normal(size=(4, line.count))
    A, p = line.places(etas)
    for eta, axes, places in zip(etas, A, p, strict=True):
        found = line.motion(eta, np.zeros_like(eta))
        assert np.abs(found.A - axes).max() < 1e-13  # round-off of the products
        assert np.abs(found.p - places).max() < 1e-13


def test_rotation_vectors_of_all_turns():
    vectors = np.array([(0, 0, 0), (1e-12, 0, 0), (0.3, -2.0, 1.0), (0, 3.14159, 0), (-1.5, 1.5, 1.5)])
    half = 0.5 * np.linalg.norm(vectors, axis=1)[:, None]
    e = np.hstack((np.cos(half), 0.5 * np.sinc(half / np.pi) * vectors))
    found = rotation_vectors(euler_parameters_from_matrices(rotation_matrices(e)))
    assert np.abs(found - vectors).max() < 1e-12


def test_nodes_are_where_the_interfaces_are(swing):
    nodes = swing.nodal_positions("beam")
    frame = swing.body("beam").flexible.interface("mid")
    assert np.abs(nodes[:, frame.station] - swing.position("beam", "mid")).max() < 1e-13
    assert np.abs(nodes[-1, -1] - swing.position("beam", "tip")[-1]).max() < 1e-13
    assert np.abs(swing.nodal_displacements("beam")[-1, -1]).max() > 0.1  # bent far


def test_skin_turns_with_the_sections(swing):
    shape, eta = swing.body("beam"), swing.modal_coordinates("beam")[-1:]
    skin = skin_of(shape)
    end = skin.nodes == skin.nodes.max()
    moved = (skin.points + skin.motion(shape, eta)[0])[end] @ rotation_matrices(swing.rotation("beam"))[-1].T
    tip = rotation_matrices(swing.rotation("beam", "tip"))[-1]
    assert (
        np.abs(moved + swing.position("beam")[-1] - swing.position("beam", "tip")[-1] - skin.arms[end] @ tip.T).max()
        < 1e-13
    )


def test_page_shows_the_beam_where_it_is(swing):
    told = read_page(page.page_of(swing, stress=[recover(swing, "beam")]).html)
    part, skin = body_of(told, "beam")["parts"][0], skin_of(swing.body("beam"))
    points = placed(told, part, 4)
    rings = np.array(
        [points[skin.nodes == PIECES * node].mean(axis=0) for node in range(len(swing.body("beam").nodes))]
    )
    assert np.abs(rings - swing.nodal_positions("beam")[4]).max() < 2e-4  # principal modes leave out 1e-4
    stress = np.tensordot(part["amplitudes"][4] * part["stress_factors"], part["stresses"].astype(float), axes=1)
    exact = normal_stress(swing.body("beam"), swing.modal_coordinates("beam")[4:5])[0]
    pieces = stress[:, :3].sum(axis=1).reshape(len(exact), PIECES, 2, -1)
    assert np.abs(pieces[:, [0, -1], [0, 1]] - exact).max() < 1e-3 * np.abs(exact).max()  # the trace; in 16 bits


def test_saved_results_have_the_line(swing, tmp_path):
    swing.save(tmp_path / "run.h5")
    read = kf.load_result(tmp_path / "run.h5")
    assert np.array_equal(read.nodal_positions("beam"), swing.nodal_positions("beam"))
    forces = [recover(result, "beam").section_forces(3).forces for result in (read, swing)]
    assert np.array_equal(forces[0][..., 3:], forces[1][..., 3:])
    assert np.isnan(forces[0][..., :3]).all()  # by balance only
    with pytest.raises(kf.ModelError, match=r"does not contain the loads.*inertia=False"):
        recover(read, "beam").section_forces(3, inertia=True)


def test_bodies_are_saved_and_pickled(tmp_path):
    body = curved()
    body.save(tmp_path / "beam.npz")
    for other in (kf.FlexibleBody.load(tmp_path / "beam.npz"), pickle.loads(pickle.dumps(body))):
        assert other.interface("tip").line is other.line is other.moments.line
        eta = np.linspace(-1.0, 2.0, body.free_count)
        assert np.array_equal(other.node_displacements(eta), body.node_displacements(eta))
        assert np.array_equal(other.interface("mid").moved(eta)[0], body.interface("mid").moved(eta)[0])


def test_force_at_the_root_is_that_of_the_joint_by_both_routes(swing):
    reaction, root = swing.joint_reaction("beam"), swing.body("beam").flexible.interface("root").position
    found = swing.coupling_force("beam", "root", of="ground")
    assert np.allclose(found[:, :3], reaction[:, :3], rtol=1e-12)
    assert np.allclose(found[:, 3:], reaction[:, 3:] - np.cross(root, reaction[:, :3]), rtol=1e-12, atol=1e-12)
    model = swing.run.model
    literal = LiteralForces.of_states(model.route, swing.times[-1:], swing.run.states[-1:])
    for number, part in enumerate(parts_of(model)):
        here = swing.coupling_force("beam", part.interface, of=part.name)[-1]
        assert np.allclose(literal.part(number)[0], here, rtol=1e-9, atol=1e-10)


def test_section_forces_are_in_balance_with_the_root(swing):
    found = recover(swing, "beam").section_forces(3, inertia=True).forces
    axes = swing.body("beam").line.axes
    root = swing.coupling_force("beam", "root")
    for columns in (slice(0, 3), slice(3, 6)):
        size = np.abs(root[:, columns]).max()
        assert np.abs(found[:, 0, 0, columns] + root[:, columns] @ axes).max() < 1e-9 * size
    assert np.abs(found[:, -1, -1, 3:]).max() < 1e-12  # free end
    assert np.abs(found[:, 0, -1] - found[:, 1, 0]).max() < 1e-12 * np.abs(found).max()  # nothing acts in the middle


def test_axes_within_steps_are_those_of_finer_steps():
    line, fine = (
        exact_beam(1.0, STRIP, RUBBER, basis=4, interfaces={"tip": 1.0, **b}, curvature=(0, 1, 2)).line
        for b in ({}, {"mid": 0.37})
    )
    eta = 0.2 * np.random.default_rng(2).normal(size=(3, line.count))
    for found, exact in zip(line.within(eta, np.array([0.0, 0.37, 1.0])), fine.places(eta), strict=True):
        ends = exact[:, [0, fine.end_node(0), fine.end_node(1)]]
        assert np.abs(found[:, 0] - ends).max() < 1e-6  # 2e-7 of the Magnus expansion


@pytest.mark.parametrize("theory", ["shear-rigid", "shear-deformable"])
def test_section_forces_of_a_tip_load_and_moment(theory):
    scene = kf.System()
    beam = scene.add_flexible_body("beam", exact_beam(1.0, STRIP, RUBBER, basis=10, theory=theory), joint=kf.Fixed())
    force, torque = np.array((-0.02, 0.0, -0.05)), np.array((0.0, -0.01, 0.0))
    scene.add_force(beam.interface("tip"), force)
    scene.add_torque(beam.interface("tip"), torque)
    rest = kf.equilibrium(scene)
    fields = recover(rest, "beam")
    line, eta = rest.body("beam").line, rest.modal_coordinates("beam")
    A, p = (of[0] for of in line.places(np.atleast_2d(eta)))
    for inertia in (False, True):
        found = fields.section_forces(2, inertia=inertia).forces[0, 0]
        for row, node in ((0, 0), (1, len(p) - 1)):
            exact = np.concatenate((force @ A[node], (torque + np.cross(p[-1] - p[node], force)) @ A[node]))
            # by strains as far as ten functions hold, which shear less than bending
            assert np.allclose(found[row], exact, atol=1e-9 if inertia else 2e-4)
    assert np.abs(p[-1] - (1, 0, 0)).max() > 0.5


def test_fibre_stress_of_a_circle():
    scene = kf.System()
    beam = scene.add_flexible_body("beam", strip(), joint=kf.Fixed())
    scene.add_torque(beam.interface("tip"), (0.0, -2.0 * EI, 0.0), follows=True)  # a radius of half a metre
    rest = kf.equilibrium(scene)
    stress = normal_stress(rest.body("beam"), np.atleast_2d(rest.modal_coordinates("beam")))
    assert np.abs(stress).max(axis=-1) == pytest.approx(1e7 * 2.0 * 0.005, rel=1e-9)  # E k h / 2


def test_line_load_of_its_weight_bends_as_gravity():
    bent = []
    for gravity, load in ((9.81, 0.0), (0.0, -0.2 * 9.81)):
        scene = kf.System(gravity=(0, 0, -gravity))
        beam = scene.add_flexible_body("beam", strip(), joint=kf.Fixed())
        scene.add_line_load(beam, "span", (0, 0, load) if load else lambda t: (0, 0, 0))
        bent.append(kf.equilibrium(scene).nodal_positions("beam"))
    assert np.abs(bent[0] - bent[1]).max() < 1e-9  # of the solver


def test_shapes_of_modes_about_a_bent_state_are_derivatives():
    scene = kf.System()
    body = strip()
    beam = scene.add_flexible_body("beam", body, joint=kf.Fixed())
    scene.add_force(beam.interface("tip"), (0, 0, -0.05))
    rest = kf.equilibrium(scene)
    modes, eta, h = rest.linearise().modes(), rest.modal_coordinates("beam"), 1e-6
    z = modes.tangents[:, 0].real
    moved = (body.node_displacements(eta + h * z) - body.node_displacements(eta - h * z)) / (2.0 * h)
    assert np.abs(modes.displacements("beam", 0).real - moved).max() < 1e-8 * np.abs(moved).max()


def test_buckling_is_eulers():
    scene = kf.System()
    beam = scene.add_flexible_body("beam", strip(), joint=kf.Fixed())
    scene.add_force(beam.interface("tip"), (-1.0, 0, 0))
    assert kf.buckling(scene).factors[0] == pytest.approx(np.pi**2 * EI / 4.0, rel=1e-7)  # of six functions


def test_what_exact_beams_do_not_have_is_refused(tmp_path):
    body, scene = strip(), kf.System()
    with pytest.raises(kf.ModelError, match=r"displacement of body 'beam': an exact beam.*modal_coordinates="):
        scene.add_flexible_body("beam", body, displacement=np.zeros((len(body.nodes), 3)))
    with pytest.raises(kf.ModelError, match=r"SID.*beam_body"):
        kf.write_sid(body, tmp_path / "beam.sid")
    beam = scene.add_flexible_body("beam", body, joint=kf.Fixed())
    with pytest.raises(kf.ModelError, match=r"no surfaces.*add_line_load"):
        scene.add_traction(beam, "span", (0, 0, 1))
    with pytest.raises(kf.ModelError, match=r"the line 'span' alone"):
        scene.add_line_load(beam, "top", (0, 0, 1))
    with pytest.raises(kf.ModelError, match=r"made of beams.*section_forces"):
        recover(kf.equilibrium(scene), "beam").stress_at_nodes()


def test_report_speaks_of_small_motions_and_the_root():
    text = str(strip().report())
    assert "for small motions about the undeformed body" in text
    assert "nodal form" not in text
    assert "x, y, z, rx, ry, rz" in text


def bent_to_a_quarter_circle() -> kf.System:
    scene = kf.System()
    beam = scene.add_flexible_body("beam", strip(), joint=kf.Fixed())
    scene.add_torque(beam.interface("tip"), (0.0, 0.5 * np.pi * EI, 0.0))
    return scene


def test_controllers_read_the_deflection_of_a_bent_beam_and_not_its_linear_part():
    scene = bent_to_a_quarter_circle()
    scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z"))
    scene.add_controller(
        "eye", lambda t, reads, memory: 0.0, every=0.1, reads="deflection beam/tip x", drives="motor hub"
    )
    run = scene.simulate((0.0, 0.05), start=kf.equilibrium(bent_to_a_quarter_circle()))
    # sin(t) / t - 1 at t = pi / 2; the linear part is zero
    assert run.controllers["eye"].reads[0, 0] == pytest.approx(2.0 / np.pi - 1.0, abs=1e-8)


def test_compiled_functions_of_loads_refuse_what_is_no_sum_of_the_state():
    scene = bent_to_a_quarter_circle()
    pull = kf.compiled(lambda t, reads: (-reads[0], 0.0, 0.0), reads="deflection beam/tip x")
    scene.add_force(scene.body("beam").interface("tip"), pull)
    with pytest.raises(kf.ModelError, match="deflection that is not linear in the modal coordinates"):
        scene.simulate((0.0, 0.01))


def test_compiled_line_loads_are_not_called_in_python(monkeypatch):
    scene, given = kf.System(), {"method": "rk4", "step": 1e-4}
    beam = scene.add_flexible_body("beam", strip(), joint=kf.Fixed())
    scene.add_line_load(beam, "span", lambda t: (0.0, 0.0, -t), follows=True)
    expected = scene.simulate((0.0, 0.01), **given).position("beam", "tip")
    scene, calls = kf.System(), []
    monkeypatch.setattr(CompiledCallback, "__call__", lambda *given: calls.append(given))
    beam = scene.add_flexible_body("beam", strip(), joint=kf.Fixed())
    scene.add_line_load(beam, "span", kf.compiled(lambda t: (0.0, 0.0, -t)), follows=True)
    found = scene.simulate((0.0, 0.01), **given).position("beam", "tip")
    assert not calls
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)  # round-off of 400 evaluations
    assert abs(expected[-1] - expected[0]).max() > 1e-9
