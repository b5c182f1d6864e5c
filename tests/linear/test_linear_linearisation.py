"""Linearisation about any state, against differences of the equations and of runs, and closed forms."""

import numpy as np
import pytest
import scipy.linalg

import kanefe as kf
from kanefe.errors import ModelError
from linear_scenes import GRAVITY, cart_and_rod, governor, rates_of_run, run_beside
from loop_scenes import four_bar, parallelogram, spatial_loop
from scenes import chain_scene, flexible_scene, floating_scene, lattice_body, random_state

ROUND_OFF = 3e-9
"""Of the differences, over the largest entry of A: 1e-16 of the rates over a step of 1e-3, and its fourth power."""


def random_linearisation(make):
    model = make().freeze()
    q, u = random_state(model, 5, amplitude=0.02, speed=0.5)
    return kf.linearise(model, t=0.3, start=np.concatenate((q, u)))


@pytest.mark.parametrize(
    "make",
    [
        lambda: random_linearisation(lambda: chain_scene(1)),
        lambda: random_linearisation(lambda: flexible_scene(2)),
        lambda: random_linearisation(lambda: floating_scene(3)),
        lambda: kf.linearise(four_bar(speed=2.0)),
        lambda: kf.linearise(spatial_loop(3)),
    ],
    ids=["chain", "flexible", "floating", "planar loop, redundant rows", "spatial loops, driven, flexible"],
)
def test_rates_are_those_of_the_equations_beside_a_moving_state(make):
    small = make()
    rows = small.A[small.position_count :]
    np.testing.assert_allclose(rows, rates_of_run(small), rtol=0, atol=ROUND_OFF * np.abs(rows).max())
    assert small.is_exact


def test_the_second_order_form_is_the_same_motion():
    """M, C + G and K of a moving state give the eigenvalues of a first-order form made from them, those of A."""
    small = kf.equilibrium(governor(None), speeds={"shaft": 6.0}).linearise()
    M, K, C = small.mass, small.stiffness, small.damping + small.gyroscopic
    n = len(M)
    again = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    np.testing.assert_allclose(again, small.A, atol=1e-12)
    np.testing.assert_allclose(M, M.T, atol=1e-15)
    np.testing.assert_allclose(small.gyroscopic, -small.gyroscopic.T)


def test_a_loop_under_load_has_a_symmetric_stiffness():
    """The forces of the loop have a geometric stiffness, without which it would not be symmetric."""
    found = kf.equilibrium(spatial_rig())
    K = found.linearise().stiffness
    np.testing.assert_allclose(K, K.T, atol=1e-9 * np.abs(K).max())
    assert len(K) > 3


def spatial_rig() -> kf.System:
    """Return a flexible arm and two rods that hang in a loop."""
    scene = kf.System(gravity=GRAVITY)
    arm = scene.add_flexible_body("arm", lattice_body(1), joint=kf.Universal("y", "z"))
    rod = scene.add_rigid_body("rod", 2.0, (0.01, 0.2, 0.2), com=(0.4, 0, 0), at=(0.0, 0.8, 0), joint=kf.Spherical())
    scene.add_distance("rope", arm.interface("tip"), rod.frame(at=(0.8, 0, 0)), 0.7)
    return scene


def test_a_run_follows_the_exponential_of_a():
    """Two runs from either side of a steady state: half their difference is exp(A T) x, to second order in x."""
    small = kf.equilibrium(governor(None), speeds={"shaft": 6.0}).linearise()
    stop, size = 0.7, 1e-4
    expected = scipy.linalg.expm(small.A * stop)
    for i in range(len(small.A)):
        x = size * np.eye(len(small.A))[i]
        beside = 0.5 * (run_beside(small, x, stop) - run_beside(small, -x, stop)) / size
        np.testing.assert_allclose(beside, expected[:, i], atol=1e-6)  # x^2 = 1e-8, times derivatives of some 10


def test_a_loop_runs_as_the_exponential_of_a_says():
    small = kf.equilibrium(four_bar(speed=0.0)).linearise()
    stop, size = 0.5, 1e-4
    lead = small.small.positions.leading
    expected = scipy.linalg.expm(small.A * stop)
    for i in range(2):
        x = size * np.eye(2)[i]
        beside = 0.5 * (run_beside(small, x, stop) - run_beside(small, -x, stop)) / size
        rows = np.concatenate((lead, small.model.coordinate_count + lead))
        np.testing.assert_allclose(beside[rows], expected[:, i], atol=1e-6)


def test_inputs_and_outputs_of_a_cart():
    """By hand: (M + m) x'' + m l a'' = F - k x - c x' and so on, about the hanging rod."""
    small = kf.linearise(
        cart_and_rod(),
        inputs={"push": "force cart x", "motor": "motor rod", "shake": "gravity x"},
        outputs={"cart": "position cart x", "felt": "acceleration cart x", "angle": "joint_coordinates rod"},
    )
    M = np.array(((3.0, -0.5), (-0.5, 0.1 + 0.25)))  # the angle about y takes the rod to -x
    K, C = np.diag((200.0, 0.5 * 9.81)), np.diag((1.0, 0.05))
    np.testing.assert_allclose(small.mass, M, atol=1e-14)
    np.testing.assert_allclose(small.stiffness, K, atol=1e-11)
    np.testing.assert_allclose(small.damping, C, atol=1e-13)
    np.testing.assert_allclose(small.gyroscopic, 0.0, atol=1e-14)
    forces = np.array(((1.0, 0.0, 3.0), (0.0, 1.0, -0.5)))
    np.testing.assert_allclose(small.B, np.vstack((np.zeros((2, 3)), np.linalg.solve(M, forces))), atol=1e-13)
    np.testing.assert_allclose(small.C[0], (1, 0, 0, 0), atol=1e-11)
    np.testing.assert_allclose(small.C[1], small.A[2], atol=1e-9)  # differences of rates of up to 90
    np.testing.assert_allclose(small.C[2], (0, 1, 0, 0), atol=1e-11)
    np.testing.assert_allclose(small.D[[0, 2]], 0.0)
    np.testing.assert_allclose(small.D[1], small.B[2], rtol=1e-10)
    assert small.input_names == ("push [N]", "motor [N m]", "shake [m/s2]")
    assert small.output_names == ("cart [m]", "felt [m/s2]", "angle [rad]")
    assert small.state_names == ("cart: distance [m]", "rod: angle [rad]", "cart: rate [m/s]", "rod: rate [rad/s]")


def test_a_drive_as_an_input():
    """A driven cart under a hanging rod: its acceleration is the input, its place and rate are states."""
    small = kf.linearise(
        cart_and_rod(kf.Motion.steady(0.0)), inputs="drive cart", outputs=["position cart x", "joint_speeds rod"]
    )
    names = (
        "rod: angle [rad]",
        "cart: driven distance [m]",
        "rod: rate [rad/s]",
        "cart: driven rate [m/s]",
    )
    assert small.state_names == names
    assert small.input_names == ("drive cart [m/s2]",)
    expected = np.zeros((4, 4))
    expected[0, 2] = expected[1, 3] = 1.0
    expected[2, 0], expected[2, 2] = -0.5 * 9.81 / 0.35, -0.05 / 0.35
    np.testing.assert_allclose(small.A, expected, atol=1e-9)
    np.testing.assert_allclose(small.B[:, 0], (0, 0, 0.5 / 0.35, 1), atol=1e-10)
    np.testing.assert_allclose(small.C, ((0, 1, 0, 0), (0, 0, 1, 0)), atol=1e-11)
    assert len(small.modes().eigenvalues) == 1  # drives are held


def test_the_speed_of_a_drive_as_an_input():
    """A governor that speeds up: the arm feels 2 W sin cos of it."""
    small = kf.equilibrium(governor(6.0)).linearise(inputs="drive shaft")
    lean = np.arccos(9.81 / 0.5 / 36)
    row = small.A[small.state_names.index("arm: rate [rad/s]")]
    change = row[small.state_names.index("shaft: driven rate [rad/s]")]
    lean *= np.sign(small.state[0])
    assert change == pytest.approx(2 * 6.0 * np.sin(lean) * np.cos(lean), rel=1e-8)


def test_a_drive_of_a_loop_moves_all_of_it():
    """With the crank driven, the other angles follow its place as they do in the closed loop."""
    driven = kf.linearise(
        four_bar(motion=kf.Motion.steady(0.0, 1.0)), inputs="drive crank", outputs="joint_coordinates rocker"
    )
    free = kf.linearise(four_bar(speed=0.0), outputs="joint_coordinates rocker")
    np.testing.assert_allclose(driven.C, free.C, rtol=1e-8)
    assert driven.state_names == ("crank: driven angle [rad]", "crank: driven rate [rad/s]")


def test_a_controller_is_differentiated():
    """A motor that is a spring in a function of the user gives what the spring gives."""
    scenes = []
    for controlled in (False, True):
        scene = kf.System(gravity=GRAVITY)
        forces = None if controlled else kf.CoordinateForce(stiffness=7.0, damping=0.3)
        rod = scene.add_rigid_body("rod", 1.0, 0.1, com=(0, 0, -0.5), joint=kf.Revolute("y", forces=forces))
        bob = scene.add_rigid_body("bob", 0.5, 0.1, at=(0, 0, -1), parent=rod, joint=kf.Spherical())
        stiffness = 0.0 if controlled else 40.0
        anchor = scene.ground.frame(at=(0.4, 0.3, -1.5))
        law = {"force": lambda length, rate: 40.0 * (length - 0.5)} if controlled else {"stiffness": stiffness}
        scene.add_spring("spring", anchor, bob, **law, **({} if controlled else {"rest_length": 0.5}))
        bushing = {"law": lambda d, rate: -3.0 * d - 0.1 * rate}
        if not controlled:
            bushing = {"stiffness": [3.0] * 6, "damping": [0.1] * 6}
        scene.add_bushing("bushing", scene.ground.frame(at=(0, 0, -1)), bob, **bushing)
        if controlled:
            scene.add_motor(rod, lambda t, s: -7.0 * s.joint_coordinates("rod")[0] - 0.3 * s.joint_speeds("rod")[0])
        scenes.append(kf.equilibrium(scene).linearise())
    plain, given = scenes
    np.testing.assert_allclose(given.state, plain.state, atol=1e-8)
    np.testing.assert_allclose(given.A, plain.A, atol=1e-7 * np.abs(plain.A).max())
    assert plain.modes().is_stable


def test_loads_of_the_scene_are_inputs_by_default():
    scene = cart_and_rod()
    body = scene.add_rigid_body("hand", 0.1, 0.01, joint=kf.Free())
    scene.add_force(body, lambda t: (0.0, 0.0, 0.981))
    scene.add_force(body, (0.0, 0.0, 0.0), follows=True)
    small = kf.linearise(scene)
    assert small.input_names[0] == "the force on 'hand' x [N]"
    assert small.input_names[3:] == tuple(f"the force on 'hand' #2 {axis} [N]" for axis in "xyz")
    place = small.state_names.index("hand: vz [m/s]")
    assert small.B[place, 2] == pytest.approx(10.0)
    one = kf.linearise(small.model, inputs=["load the force on 'hand' #2"])
    np.testing.assert_allclose(one.B, small.B[:, 3:])


def test_outputs_of_a_flexible_body():
    """A turned arm: its own axes, the mesh frame, and N."""
    scene = kf.System()
    arm = scene.add_flexible_body("arm", lattice_body(1), joint=kf.Revolute("z", position=np.pi / 2))
    scene.add_rigid_body("tool", 0.1, 0.01, parent=arm.interface("tip"))
    outputs = ["position arm/tip y", "position arm/tip x'", "deflection arm/tip x", "velocity tool", "rotation tool z"]
    small = kf.linearise(scene, outputs=[*outputs, "modal_coordinates arm 0", "angular_velocity tool z"])
    eta = small.state_names.index("arm: eta 0")
    assert small.output_names[3:6] == ("velocity tool x [m/s]", "velocity tool y [m/s]", "velocity tool z [m/s]")
    # what stretches the arm along its own x moves the tip along N's y; the rates are those of the positions
    assert small.C[0, eta] == pytest.approx(small.C[2, eta], rel=1e-9)
    n = small.position_count
    np.testing.assert_allclose(small.C[4, n:], small.C[0, :n], atol=1e-9)
    np.testing.assert_allclose(small.C[8, n:], small.C[6, :n], atol=1e-9)
    assert small.C[7, eta] == pytest.approx(1.0)


def test_the_nodal_form_is_differentiated_by_differences():
    scene = kf.System(gravity=GRAVITY)
    body = lattice_body(1, rotations=True, reduction=kf.CraigBampton(modes=1))
    scene.add_flexible_body("arm", body, joint=kf.Revolute("y"))
    model = scene.freeze()
    small = kf.linearise(model)
    assert not small.is_exact
    rows = small.A[small.position_count :]
    np.testing.assert_allclose(rows, rates_of_run(small, 3e-4), rtol=0, atol=1e-6 * np.abs(rows).max())


def test_the_exact_jacobian_sees_loops_of_which_some_rows_say_nothing():
    """In the plane a spatial pin has rows that nothing moves; they must not take others with them."""
    model = four_bar(speed=2.0).freeze()
    y = model.initial_state
    J = model.jacobian(0.0, y)
    for i in range(len(y)):
        step = 1e-3 * np.eye(len(y))[i]
        found = (8 * (model.rhs(0, y + step) - model.rhs(0, y - step))) / 12e-3
        found -= (model.rhs(0, y + 2 * step) - model.rhs(0, y - 2 * step)) / 12e-3
        np.testing.assert_allclose(J[:, i], found, atol=1e-8)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"inputs": "push rod"}, "there is no 'push'. Remedy: one of force, torque"),
        ({"inputs": "force wheel x"}, "no body called 'wheel x'. It has: cart, rod"),
        ({"inputs": "force rod w"}, "'w' is not an axis"),
        ({"inputs": "drive rod"}, "no such driven coordinate. There are: none"),
        ({"inputs": "motor rod 3"}, r"no such free coordinate. There are: 0 \(angle\)"),
        ({"inputs": "load nothing"}, "no such load. It has: none"),
        ({"inputs": "gravity up"}, "'up' is not an axis"),
        ({"inputs": [3]}, "must be a text"),
        ({"outputs": "position rod/tip"}, "no interface 'tip'"),
        ({"outputs": "position rod/tip x"}, "no interface 'tip'"),
        ({"outputs": "strain rod"}, "there is no 'strain'"),
        ({"start": [0.0]}, "has 4 entries: cart: distance"),
    ],
)
def test_what_is_wrong_is_named(options, words):
    with pytest.raises(ModelError, match=words):
        kf.linearise(cart_and_rod(), **options)


def test_singular_and_open_loops_are_refused():
    with pytest.raises(ModelError, match=r"loops are singular.*Remedy: a state beside"):
        kf.linearise(parallelogram(np.pi / 2))
    model = four_bar(speed=0.0).freeze()
    y = model.initial_state
    y[0] += 0.1
    with pytest.raises(ModelError, match=r"'pin'.*open"):
        kf.linearise(model, start=y)


def test_nothing_that_moves_is_refused():
    scene = kf.System()
    scene.add_rigid_body("block", 1.0)
    with pytest.raises(ModelError, match="nothing in the scene can move"):
        kf.linearise(scene)
