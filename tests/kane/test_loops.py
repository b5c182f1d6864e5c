"""Loop joints and couplers: accelerations, forces, drift and energy, against trees, closed forms and differences."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.frames import euler_parameters_from_matrix, rotation_matrix
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.stepper import StepControl
from kanefe.kane.assemble import accelerations, assemble, held_accelerations
from kanefe.kane.energy import momenta
from kanefe.kane.reactions import joint_reactions, loop_forces
from kanefe.literal.loop_closure import project_positions, project_speeds
from kanefe.scene.scene import Frame
from kanefe.states.constraints import constraint_rates, constraint_residuals
from kanefe.states.kinematics import sweep_outward
from kanefe.states.state import State
from loop_scenes import four_bar, four_bars, marker_place, parallelogram, spatial_loop
from scenes import derivatives, lattice_body, random_inertia


@pytest.fixture
def _literal(monkeypatch):
    """Runs take the literal route: for those that are short, beside the long ones of compiled steps."""
    monkeypatch.setattr(Model, "route", Model.literal)


def residuals(model, t, q):
    return constraint_residuals(State(model, t, q))


def consistent_state(model, seed=0, size=0.1):
    """Return q and u off the start at which the loops are closed and stay closed."""
    rng = np.random.default_rng(seed)
    q = project_positions(
        model, 0.0, model.advance(model.initial_coordinates, size * rng.standard_normal(model.free_count))
    )
    return q, project_speeds(model, 0.0, q, rng.standard_normal(model.free_count))


@pytest.mark.parametrize("seed", range(3))
def test_accelerations_keep_the_loops_closed_to_second_order(seed):
    """Residuals along a motion with these speeds and accelerations: their value and two derivatives are zero."""
    model = spatial_loop(seed).freeze()
    q, u = consistent_state(model, seed)
    du = accelerations(State(model, 0.0, q, u))
    along = lambda s: residuals(model, s, model.advance(q, u * s + 0.5 * du * s * s))  # noqa: E731
    first, second = derivatives(along, 0.001)
    assert np.abs(along(0.0)).max() < 1e-12
    # round-off 4e-16 / 0.001 and / 0.001^2, times the weights of the differences; du is some hundreds
    assert np.abs(first).max() < 1e-11
    assert np.abs(second).max() < 1e-7


@pytest.mark.parametrize("seed", range(2))
def test_multipliers_do_what_the_equations_lack(seed):
    """M du - F = J^T lambda, and a force on every row does no work on speeds that keep the loops closed."""
    model = spatial_loop(seed).freeze()
    q, u = consistent_state(model, seed)
    du, multipliers = held_accelerations(State(model, 0.0, q, u))[:2]
    full = model.all_speeds(0.0, u)
    M, F = assemble(State(model, 0.0, q, u))
    rows = constraint_rates(State(model, 0.0, q, u))
    rates = np.concatenate((du, model.driven_speeds(0.0)[1]))
    n = model.free_count
    scale = np.abs(F).max()
    assert np.abs((M @ rates - F - rows.J.T @ multipliers)[:n]).max() < 1e-12 * scale * np.linalg.cond(M[:n, :n]) ** 0.5
    assert np.abs(rows.J @ full[: n + model.driven_count]).max() < 1e-12


JOINTS = [
    kf.Fixed(),
    kf.Revolute((1, 2, 3), position=0.4, speed=1.5),
    kf.Prismatic("y", position=0.2, speed=-0.7),
    kf.Cylindrical("x", position=(0.1, 0.5), speed=(0.4, 1.2)),
    kf.Universal("x", (0.3, 1, 0), position=(0.3, -0.4), speed=(1.0, 2.0)),
    kf.Spherical(orientation=(0.9, 0.2, -0.3, 0.1), angular_velocity=(1.0, -2.0, 0.5)),
    kf.Planar(position=(0.1, -0.2), angle=0.3, velocity=(0.5, 0.6), rate=1.1),
    kf.Screw("z", lead=0.3, position=2.0, speed=1.3),
    kf.Translation(position=(0.1, 0.2, 0.3), velocity=(0.4, 0.5, -0.6)),
]


def plain(joint):
    """Return the joint without its start, as a loop joint is."""
    names = {"axis", "first", "second", "lead"} & set(vars(joint))
    return type(joint)(**{name: getattr(joint, name) for name in names})


@pytest.mark.parametrize("joint", JOINTS, ids=lambda joint: joint.kind)
def test_a_free_body_on_a_loop_joint_moves_as_on_the_joint_of_a_tree(joint):
    """The same scene twice: accelerations of both bodies and the wrench of the joint are equal."""
    rng = np.random.default_rng(0)
    inertias, at, orientation = [random_inertia(rng) for _ in range(2)], rng.uniform(-1, 1, 3), rng.standard_normal(4)
    com = rng.uniform(-0.2, 0.2, 3)

    def base(scene):
        return scene.add_rigid_body(
            "base", 2.0, inertias[0], com=com, joint=kf.Free(angular_velocity=(0.3, 1.0, -0.5), velocity=(1, 2, 3))
        )

    tree = kf.System(gravity=(1.0, -2.0, 3.0))
    tree.add_rigid_body(
        "body", 1.0, inertias[1], com=com, parent=base(tree), joint=joint, at=at, orientation=orientation
    )
    tree_model = tree.freeze()
    q, u = tree_model.initial_coordinates, tree_model.initial_speeds
    frames = sweep_outward(tree_model, 0.0, q, u)
    e = euler_parameters_from_matrix(frames[1].A_NF)
    start = kf.Free(
        position=frames[1].p_NoFo_N, orientation=e, velocity=frames[1].A_NF @ frames[1].v, angular_velocity=frames[1].w
    )

    loop = kf.System(gravity=(1.0, -2.0, 3.0))
    carrier = base(loop)
    body = loop.add_rigid_body("body", 1.0, inertias[1], com=com, joint=start)
    loop.add_loop_joint("joint", plain(joint), carrier.frame(at=at, orientation=orientation), body)
    model = loop.freeze()
    np.testing.assert_allclose(model.initial_coordinates, np.concatenate((q[:7], frames[1].p_NoFo_N, e)), atol=1e-12)
    du_tree, _ = np.linalg.solve(*assemble(State(tree_model, 0.0, q, u))), None
    du = accelerations(State(model, 0.0, model.initial_coordinates, model.initial_speeds))
    found = sweep_outward(model, 0.0, model.initial_coordinates, model.initial_speeds)
    for a, b in zip(frames, found, strict=True):
        # 15 digits less those of the condition of the mass matrix
        np.testing.assert_allclose(b.V @ du + b.Z, a.V @ du_tree + a.Z, atol=1e-10)
        np.testing.assert_allclose(b.W @ du + b.Y, a.W @ du_tree + a.Y, atol=1e-10)
    wanted = joint_reactions(State(tree_model, 0.0, q, u), du_tree)[1]
    forces = loop_forces(State(model, 0.0, model.initial_coordinates, model.initial_speeds))
    np.testing.assert_allclose(forces["joint"], wanted, atol=1e-9)
    # the joints of the loop scene carry nothing of it: both bodies are free
    for reaction in joint_reactions(State(model, 0.0, model.initial_coordinates, model.initial_speeds), du):
        np.testing.assert_allclose(reaction, 0.0, atol=1e-10)


def test_a_loop_is_carried_by_interfaces_and_joints():
    """A flexible beam between two walls: what both ends carry is the force of gravity and inertia."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    arm = scene.add_flexible_body("arm", lattice_body(3), joint=kf.Revolute("z"))
    tip = arm.body.interface("tip").position
    scene.add_loop_joint("wall", kf.Spherical(), scene.ground.frame(at=tip), arm.interface("tip"))
    result = scene.simulate((0.0, 0.5), rtol=1e-9, output_step=0.1)
    force, root = result.loop_force("wall"), result.joint_reaction("arm")
    # sum of forces = rate of the momentum, by differences of a finer run
    model = result._channels.model
    for i, t in enumerate(result.times):
        du = result._channels.accelerations()[i]
        q, u = result._channels.trajectory.coordinates[i], result._channels.trajectory.speeds[i]

        def momentum(s, q=q, u=u, du=du, t=t):
            moved = model.advance(q, u * s + 0.5 * du * s * s)
            return momenta(State(model, t, moved, u + du * s))[0]

        total = derivatives(momentum, 0.001)[0] - arm.body.mass * np.array((0.0, -9.81, 0.0))
        A = rotation_matrix(result.rotation("arm")[i])
        A_tip = rotation_matrix(result.rotation("arm", "tip")[i])
        np.testing.assert_allclose(A @ root[i, :3] + A_tip @ force[i, :3], total, atol=1e-7)
    np.testing.assert_allclose(np.abs(result.position("arm", "tip") - tip).max(), 0.0, atol=1e-12)
    carried = result.coupling_force("arm", "tip")
    A_Gn = [
        rotation_matrix(a).T @ rotation_matrix(b)
        for a, b in zip(result.rotation("arm"), result.rotation("arm", "tip"), strict=True)
    ]
    np.testing.assert_allclose(carried[:, :3], [a @ f for a, f in zip(A_Gn, force[:, :3], strict=True)], atol=1e-9)


@pytest.mark.parametrize("method", ["dop853", "generalised-alpha"])
def test_loops_stay_closed_over_many_turns(method):
    """Turns of the crank, more than one a second: no drift but round-off; energy to what the method gives."""
    scene, is_explicit, stop = four_bar(speed=10.0), method == "dop853", 3.0
    result = scene.simulate((0.0, stop), method=method, rtol=1e-6 if is_explicit else 1e-5, output_step=0.5)
    model, run = result._channels.model, result._channels.trajectory
    assert abs(run.coordinates[-1, 0]) > 7.5 * stop
    for t, q, u in zip(run.times, run.coordinates, run.speeds, strict=True):
        assert np.abs(residuals(model, t, q)).max() < 1e-12
        full = model.all_speeds(t, u)
        rows = constraint_rates(State(model, t, q, u))
        assert np.abs(rows.J @ full).max() < 1e-11
    # without the projection dop853 loses 1e-3 m here; rtol 1e-6 times some thousand steps
    assert abs(result.energy.balance_error).max() < (1e-3 if is_explicit else 0.5) * result.energy.kinetic.max()


@pytest.mark.usefixtures("_literal")
def test_the_state_itself_does_not_drift():
    """Not only what is put out is closed: the state that the explicit method goes on from."""
    model = four_bar(speed=10.0).freeze()
    stepper = METHODS["dop853"].make(Dynamics(model), 0.0, 2.0, StepControl(1e-4, 1e-7, None))
    times, states = np.array([2.0]), np.empty((1, len(stepper.state())))
    while stepper.t < 2.0:
        stepper.integrate_through(times, states, 1)
        # without the projection some 1e-4 in as many steps
        assert np.abs(residuals(model, stepper.t, stepper.state()[: model.coordinate_count])).max() < 1e-13


@pytest.mark.usefixtures("_literal")
def test_both_methods_agree():
    ends = [
        four_bar().simulate((0.0, 0.3), method=method, rtol=rtol, output_step=0.3).joint_coordinates("crank")[-1, 0]
        for method, rtol in (("dop853", 1e-10), ("generalised-alpha", 1e-7))
    ]
    # order 2 with steps for a local error of 1e-7
    assert ends[1] == pytest.approx(ends[0], abs=2e-5)


@pytest.mark.parametrize("seed", range(2))
def test_energy_balances_with_drives_loops_and_flexible_bodies(seed):
    """The drive's work is what the energy gains: loops, struts and gears do none."""
    result = spatial_loop(seed).simulate((0.0, 0.3), rtol=1e-8, output_step=0.1)
    assert np.ptp(result.energy.total) > 1e-3
    assert abs(result.energy.balance_error).max() < 1e-7 * abs(result.energy.total).max()


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
def test_a_parallelogram_passes_the_flat_position_on_its_branch(rtol):
    """Both cranks stay parallel over several turns, whatever the steps: momentum decides, not round-off."""
    run = parallelogram().simulate((0.0, 6.0), method="dop853", rtol=rtol, output_step=0.25)
    first, second = (run.joint_coordinates(f"crank{i}")[:, 0] for i in range(2))
    assert abs(first[-1]) > 10
    np.testing.assert_allclose(second, first, atol=1e-6)


def test_what_has_no_mass_is_held_by_the_loop():
    """A slider-crank with a massless rod and slider: the mass matrix of the tree is singular, that of the loop not."""

    def scene(mass):
        made = kf.System(gravity=(0, -9.81, 0))
        crank = made.add_rigid_body("crank", 1, 0.1, com=(0.1, 0, 0), joint=kf.Revolute("z", position=0.5, speed=1.0))
        rod = made.add_rigid_body("rod", mass, 0.1 * mass, parent=crank, at=(0.2, 0, 0), joint=kf.Revolute("z"))
        slider = made.add_rigid_body("slider", mass, at=(0.7, 0, 0), joint=kf.Prismatic("x"))
        made.add_loop_joint("pin", kf.Revolute("z"), rod.frame(at=(0.5, 0, 0)), slider)
        return made.freeze()

    massless, light = scene(0.0), scene(1e-7)
    q, u = massless.initial_coordinates, massless.initial_speeds
    np.testing.assert_allclose(q, light.initial_coordinates, atol=1e-6)
    du = accelerations(State(massless, 0.0, q, u))
    expected = accelerations(State(light, 0.0, q, u))
    # a mass of 1e-7 of the others
    np.testing.assert_allclose(du, expected, rtol=1e-5)
    free = kf.System()
    free.add_rigid_body("nothing", 0.0, joint=kf.Revolute("z"))
    anchor = free.add_rigid_body("mass", 1.0, 1.0, joint=kf.Revolute("x"))
    free.add_gear("half", {anchor: 1.0})
    with pytest.raises(kf.SimulationError, match="nothing has inertia along nothing: rate"):
        free.simulate((0.0, 1.0))


def test_a_distance_is_a_pendulum():
    scene = kf.System(gravity=(0, -9.81, 0))
    point = scene.add_point("bob", 2.0, joint=kf.Translation(position=(0.6, -0.8, 0.0)))
    scene.add_distance("string", scene.ground, point, 1.0)
    swing = kf.System(gravity=(0, -9.81, 0))
    swing.add_rigid_body("bob", 2.0, com=(0.6, -0.8, 0), joint=kf.Revolute("z"))
    results = [s.simulate((0.0, 2.0), rtol=1e-10, output_step=0.1) for s in (scene, swing)]
    turn = results[1].joint_coordinates("bob")[:, 0]
    expected = np.column_stack((0.6 * np.cos(turn) + 0.8 * np.sin(turn), 0.6 * np.sin(turn) - 0.8 * np.cos(turn)))
    np.testing.assert_allclose(results[0].position("bob")[:, :2], expected, atol=1e-8)
    # at rest at the start the string pulls along itself with m g cos
    np.testing.assert_allclose(results[0].loop_force("string")[0, :3], [-9.41760, 12.5568, 0.0], rtol=1e-9, atol=1e-9)


def test_a_gear_pair_turns_with_the_inertia_of_both():
    scene = kf.System()
    small = scene.add_rigid_body("small", 1.0, 0.02, joint=kf.Revolute("z"))
    large = scene.add_rigid_body("large", 1.0, 0.5, at=(1, 0, 0), joint=kf.Revolute("z"))
    scene.add_gear("pair", {small: 10, large: 30})
    scene.add_motor(small, 0.3)
    model = scene.freeze()
    du, (multiplier,) = held_accelerations(State(model, 0.0, model.initial_coordinates, model.initial_speeds))[:2]
    expected = 0.3 / (0.02 + 0.5 / 9)
    np.testing.assert_allclose(du, [expected, -expected / 3], rtol=1e-13)
    assert 30 * multiplier == pytest.approx(-0.5 * expected / 3, rel=1e-13)


def test_a_gear_tells_its_torques(tmp_path):
    """Those with which the large wheel gains speed, and a third of it holds the small one back; off, there are none."""
    scene = kf.System()
    small = scene.add_rigid_body("small", 1.0, 0.02, joint=kf.Revolute("z"))
    large = scene.add_rigid_body("large", 1.0, 0.5, at=(1, 0, 0), joint=kf.Revolute("z"))
    scene.add_gear("pair", {small: 10, large: 30})
    scene.add_gear("open", {large: 1}, starts_on=False)
    scene.add_motor(small, 0.3)
    on_large = -0.5 * 0.3 / (0.02 + 0.5 / 9) / 3
    result = scene.simulate((0.0, 0.2), output_step=0.1)
    assert result.gears == {"pair": ("small angle [rad]", "large angle [rad]"), "open": ("large angle [rad]",)}
    np.testing.assert_allclose(result.gear_force("pair"), np.tile([on_large / 3, on_large], (3, 1)), rtol=1e-12)
    assert result.gear_force("open").tolist() == [[0.0]] * 3
    result.save(tmp_path / "run.h5")
    loaded = kf.load_result(tmp_path / "run.h5")
    np.testing.assert_array_equal(loaded.gear_force("pair"), result.gear_force("pair"))
    assert loaded.units("gear_force", "pair") == "N m"
    table = loaded.to_dataframe("gear_force pair")
    assert list(table.columns) == ["gear_force pair small_angle", "gear_force pair large_angle"]
    with pytest.raises(kf.ModelError, match=r"no gear or rack called 'pin'\. It has: pair, open$"):
        loaded.gear_force("pin")
    with pytest.raises(kf.ModelError, match=r"'pair' is a gear or rack: its force is gear_force\('pair'\)"):
        loaded.loop_force("pair")


def test_a_run_stops_at_a_torque_of_a_gear():
    scene = kf.System()
    small, large = (scene.add_rigid_body(name, 1.0, 0.1, joint=kf.Revolute("z")) for name in ("small", "large"))
    scene.add_gear("pair", {small: 1, large: 1})
    scene.add_motor(small, lambda t: 4.0 * t)
    worn = kf.Event("worn", lambda t, state: state.gear_force("pair")[1] + 1.0, terminal=True)
    assert scene.simulate((0.0, 2.0), events=worn).times[-1] == pytest.approx(0.5, abs=1e-8)  # half of 2 N m


def test_a_rack_falls_with_the_inertia_of_its_pinion():
    scene = kf.System(gravity=(0, -9.81, 0))
    pinion = scene.add_rigid_body("pinion", 1.0, 0.02, joint=kf.Revolute("z"))
    rack = scene.add_rigid_body("rack", 3.0, 0.0, at=(0.1, 0, 0), joint=kf.Prismatic("y"))
    scene.add_rack("teeth", pinion, rack, 0.1)
    model = scene.freeze()
    du = accelerations(State(model, 0.0, model.initial_coordinates, model.initial_speeds))
    a = -9.81 * 3.0 / (3.0 + 0.02 / 0.01)
    np.testing.assert_allclose(du, [a / 0.1, a], rtol=1e-13)


def test_a_redundant_loop_carries_its_load_with_least_norm():
    """A beam on three equal pins in a row, twice in the same place: two loops share what one would carry."""
    model = parallelogram(0.3).freeze()
    twice = parallelogram(0.3)
    bodies = {entry.name: i for i, entry in enumerate(twice._entries)}
    frame = lambda name: Frame(twice, bodies[name], name)  # noqa: E731
    twice.add_loop_joint(
        "copy", kf.Revolute("z"), frame("coupler").frame(at=(1, 0, 0)), frame("crank1").frame(at=(0, 1, 0))
    )
    double = twice.freeze()
    q, u = model.initial_coordinates, model.initial_speeds
    du, one = held_accelerations(State(model, 0.0, q, u))[:2]
    du_twice, two = held_accelerations(State(double, 0.0, q, u))[:2]
    np.testing.assert_allclose(du_twice, du, atol=1e-11)
    np.testing.assert_allclose(two, np.tile(0.5 * one, 2), atol=1e-11)
    report = double.constraint_report()
    assert (report.rows, report.rank, report.degrees_of_freedom) == (10, 2, 1)
    assert report.redundant_constraints == ("copy",)
    assert "wholly redundant: copy" in str(report)


def test_a_crank_rocker_does_not_leave_its_reach():
    """A rocker too long to turn over, driven through: the run ends at the dead centre and says so."""
    scene = four_bar(rocker=0.9, motion=kf.Motion.steady(2.0, 1.2))
    with pytest.warns(kf.SimulationWarning, match=r"at a singular position.*within its reach"):
        result = scene.simulate((0.0, 3.0), rtol=1e-4)
    assert result.status.kind == "failed"
    assert 0.5 < result.times[-1] < 1.5


@pytest.mark.usefixtures("_literal")
def test_marker_points_meet():
    result = four_bar().simulate((0.0, 1.0), rtol=1e-8, output_step=0.25)
    model, run = result._channels.model, result._channels.trajectory
    for t, q in zip(run.times, run.coordinates, strict=True):
        ends = marker_place(model, "coupler", t, q, (2, 0, 0)), marker_place(model, "rocker", t, q, (0, 1.8, 0))
        np.testing.assert_allclose(*ends, atol=1e-12)


@pytest.mark.usefixtures("_literal")
def test_loop_forces_are_saved(tmp_path):
    result = four_bar().simulate((0.0, 0.2), rtol=1e-6, output_step=0.1)
    result.save(tmp_path / "run.h5")
    loaded = kf.load_result(tmp_path / "run.h5")
    assert loaded.loops == result.loops == ("pin",)
    np.testing.assert_array_equal(loaded.loop_force("pin"), result.loop_force("pin"))
    assert result.units("loop_force", "pin") == "N, N m"
    with pytest.raises(kf.ModelError, match=r"no loop joint called 'pun'\. It has: pin$"):
        result.loop_force("pun")
    result.plot("loop_force", path=tmp_path / "loop.png")


def test_a_tower_of_loops_starts_with_the_speeds_that_are_given():
    """Bars at its foot move all of it: their inertia is a million times that of the last."""
    model = four_bars(60, "one on the other").freeze()
    # cranks turn with 1 rad/s and bars the other way, as in parallelograms; loops are closed to 1e-10 of such speeds
    np.testing.assert_allclose(np.abs(model.initial_speeds), 1.0, rtol=0, atol=1e-9)
