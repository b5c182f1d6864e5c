"""Free and spherical joints that follow a given pose: closed forms, chains of scalar joints, orders, routes."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from joint_scenes import assert_routes_agree, scene_of
from kanefe.errors import ModelError
from random_scenes import elastic_body
from scenes import derivatives

SIZE, RATE = np.array((0.3, -0.2, 0.5)), np.array((1.1, 0.7, 1.9))
FIRST, SECOND = (0.8, 1.3), (0.6, 0.9)  # amplitudes and rates of two successive angles, about x and y
GRAVITY = np.array((0.3, -1.0, -9.81))


def swing(size: float, rate: float, t: float) -> tuple[float, float, float]:
    return size * np.sin(rate * t), size * rate * np.cos(rate * t), -size * rate**2 * np.sin(rate * t)


def orientation(t: float) -> np.ndarray:
    return kf.euler_angles("XY", (swing(*FIRST, t)[0], swing(*SECOND, t)[0]))


def spin(t: float) -> np.ndarray:
    (_, da, _), (b, db, _) = swing(*FIRST, t), swing(*SECOND, t)
    return np.array((da * np.cos(b), db, da * np.sin(b)))


def twist(t: float) -> np.ndarray:
    (_, da, dda), (b, db, ddb) = swing(*FIRST, t), swing(*SECOND, t)
    return np.array((dda * np.cos(b) - da * db * np.sin(b), ddb, dda * np.sin(b) + da * db * np.cos(b)))


def functions(*, moves: bool = True) -> kf.PoseMotion:
    along = (
        lambda t: SIZE * np.sin(RATE * t),
        lambda t: SIZE * RATE * np.cos(RATE * t),
        lambda t: -SIZE * RATE**2 * np.sin(RATE * t),
    )
    return kf.PoseMotion(*(along if moves else (None,) * 3), orientation, spin, twist)


def zero(t: float) -> np.ndarray:
    return np.zeros(3)


PICKLED = kf.PoseMotion(zero, zero, zero, orientation, spin, twist)

TIMES = np.linspace(0.0, 3.0, 121)
TABLE = functions().table(TIMES)


def shaken(joint: kf.Joint) -> kf.System:
    """Return a body off its driven frame, which carries an arm."""
    scene = kf.System(gravity=GRAVITY)
    base = scene.add_rigid_body("base", 2.0, (0.1, 0.2, 0.3), com=(0.1, 0.2, -0.1), joint=joint)
    scene.add_rigid_body("arm", 1.0, 0.1, com=(0.3, 0, 0), parent=base, joint=kf.Revolute("y", position=0.4))
    return scene


@pytest.mark.parametrize("motion", [functions(), TABLE], ids=["functions", "table"])
def test_what_drives_a_body_off_its_frame_is_newtons_and_eulers(motion: Any) -> None:
    mass, c, inertia = 2.0, np.array((0.3, -0.2, 0.4)), np.diag((0.1, 0.2, 0.3))
    scene = kf.System(gravity=GRAVITY)
    scene.add_rigid_body("base", mass, inertia, com=c, joint=kf.Free(motion=motion))
    result = scene.simulate((0.0, 2.0), output_step=0.1)
    powers = []
    for t, wrench in zip(result.times, result.joint_reaction("base"), strict=True):
        _, v, a, A, w, alpha = motion.at(t)
        force = mass * (A.T @ (a - GRAVITY) + np.cross(alpha, c) + np.cross(w, np.cross(w, c)))
        moment = inertia @ alpha + np.cross(w, inertia @ w) + np.cross(c, force)
        # sums of some tens of products
        np.testing.assert_allclose(wrench, (*force, *moment), rtol=0, atol=1e-12 * np.linalg.norm(force))
        powers.append(force @ (A.T @ v) + moment @ w)
    np.testing.assert_allclose(result.driving_force("base"), powers, rtol=0, atol=1e-12 * abs(np.array(powers)).max())
    assert result.units("driving_force", "base") == "W"


def test_the_work_of_the_drive_is_what_the_energy_changes_by() -> None:
    for motion, tolerances in ((functions(), (1e-6, 1e-10)), (TABLE, (1e-6, 1e-9))):
        for rtol in tolerances:
            result = shaken(kf.Free(motion=motion)).simulate((0.0, 2.0), rtol=rtol)
            energy = result.energy
            # a few tens of steps, each to the tolerance; in the table the change of acceleration jumps at its points
            assert abs(energy.balance_error).max() < 30 * rtol * abs(energy.work).max()
            assert abs(energy.work).max() > 5.0


def test_it_is_the_same_as_a_chain_of_scalar_joints() -> None:
    def scalar(size: float, rate: float) -> kf.Motion:
        return kf.Motion(*(lambda t, k=k: float(swing(size, rate, t)[k]) for k in range(3)))

    chain = kf.System(gravity=GRAVITY)
    moved = [scalar(*pair) for pair in zip(SIZE, RATE, strict=True)]
    carriage = chain.add_frame("carriage", joint=kf.Translation(motion=moved))
    turned = kf.Universal("x", "y", motion=(scalar(*FIRST), scalar(*SECOND)))
    base = chain.add_rigid_body("base", 2.0, (0.1, 0.2, 0.3), com=(0.1, 0.2, -0.1), parent=carriage, joint=turned)
    chain.add_rigid_body("arm", 1.0, 0.1, com=(0.3, 0, 0), parent=base, joint=kf.Revolute("y", position=0.4))
    wanted = chain.simulate((0.0, 2.0), rtol=1e-11)
    for motion, error in ((functions(), 1e-9), (TABLE, 1e-7)):  # of the runs; of the table, 40 points a second
        result = shaken(kf.Free(motion=motion)).simulate((0.0, 2.0), rtol=1e-11)
        for quantity in ("position", "velocity", "acceleration", "angular_acceleration"):
            found, same = (getattr(r, quantity)("arm") for r in (result, wanted))
            np.testing.assert_allclose(found, same, rtol=0, atol=error * (1.0 + abs(same).max()), err_msg=quantity)


def test_a_flight_that_is_imposed_needs_no_force() -> None:
    scene = kf.System(gravity=GRAVITY)
    c, inertia = np.array((0.1, -0.05, 0.2)), (0.1, 0.25, 0.3)
    start = {"velocity": (1.0, -2.0, 5.0), "angular_velocity": (3.0, 2.0, 1.0)}
    scene.add_rigid_body("stone", 2.0, inertia, com=c, joint=kf.Free(**start))
    flight = scene.simulate((0.0, 1.0), rtol=1e-12, atol=1e-13, output_step=0.005)
    coordinates, speeds = flight.joint_coordinates("stone"), flight.joint_speeds("stone")
    record = kf.PoseTable(
        flight.times, coordinates[:, :3], coordinates[:, 3:], velocities=speeds[:, :3], angular_velocities=speeds[:, 3:]
    )
    driven = kf.System(gravity=GRAVITY)
    driven.add_rigid_body("stone", 2.0, inertia, com=c, joint=kf.Free(motion=record))
    wrench = driven.simulate((0.0, 1.0), output_step=0.007).joint_reaction("stone")
    # of 20 N: accelerations from rates by the third power of 5 ms
    assert abs(wrench).max() < 2e-4


@pytest.mark.parametrize(
    ("given", "orders"),
    [((), (4, 3, 2)), (("velocities",), (5, 4, 3)), (("velocities", "accelerations"), (6, 5, 4))],
    ids=["poses", "rates", "accelerations"],
)
def test_a_table_of_a_known_motion_converges(given: tuple[str, ...], orders: tuple[int, ...]) -> None:
    exact = functions()

    def errors(count: int) -> np.ndarray:
        times = np.linspace(0.0, 3.0, count)
        found = [exact.at(t) for t in times]
        rates = {}
        if "velocities" in given:
            rates |= {"velocities": [f.velocity for f in found], "angular_velocities": [spin(t) for t in times]}
        if "accelerations" in given:
            rates |= {"accelerations": [f.acceleration for f in found]}
            rates |= {"angular_accelerations": [twist(t) for t in times]}
        table = kf.PoseTable(times, [f.position for f in found], [f.axes for f in found], **rates)
        between = np.linspace(0.0, 3.0, 1009)
        misses = [[np.abs(a - b).max() for a, b in zip(table.at(t), exact.at(t), strict=True)] for t in between]
        p, v, a, A, w, dw = np.max(misses, axis=0)
        return np.array(((p, v, a), (A, w, dw)))

    found = np.log2(errors(31) / errors(61))
    # the spline through rates loses a power at the ends only where the fourth derivative leads; half a power for noise
    assert np.all(found > np.array(orders) - 0.5), found


@pytest.mark.parametrize("is_flexible", [False, True], ids=["rigid", "flexible"])
@pytest.mark.parametrize("kind", ["free", "spherical"])
def test_the_routes_agree_to_round_off(kind: str, is_flexible: bool) -> None:
    # so few points that the Euler parameters between them are not of unit length
    times = np.linspace(0.0, 3.0, 9)
    places = [SIZE * np.sin(RATE * t) for t in times] if kind == "free" else None
    table = kf.PoseTable(times, places, [orientation(t) for t in times])
    joint = kf.Free(motion=table) if kind == "free" else kf.Spherical(motion=table)
    model = scene_of(joint, is_flexible=is_flexible).freeze()
    for t in (0.0, 0.7321, 3.0):
        assert_routes_agree(model, t)


@pytest.mark.parametrize("is_flexible", [False, True], ids=["rigid", "flexible"])
@pytest.mark.parametrize("kind", ["free", "spherical"])
def test_functions_in_python_give_the_routes_the_same(kind: str, is_flexible: bool) -> None:
    motion = functions(moves=kind == "free")
    joint = kf.Free(motion=motion) if kind == "free" else kf.Spherical(motion=motion)
    model = scene_of(joint, is_flexible=is_flexible).freeze()
    assert (model.route.name, model.route.is_autonomous) == ("order n", False)
    for t in (0.0, 0.7321, 3.0):
        assert_routes_agree(model, t)


def test_functions_in_python_survive_copies_and_pickles() -> None:
    model = shaken(kf.Free(motion=PICKLED)).freeze()
    rates = model.rhs(0.3, model.initial_state)
    for other in (copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
        assert np.array_equal(other.rhs(0.3, other.initial_state), rates)


@pytest.mark.parametrize("stops", [ZeroDivisionError, KeyboardInterrupt])
def test_errors_of_functions_in_python_end_the_run_as_others_do(stops: type[BaseException]) -> None:
    """Kernels call the function, which cannot raise through them: it is raised where Python goes on."""
    asked: list[float] = []

    def heave(t: float) -> tuple[float, float, float]:
        if is_running and t > 0.5:
            asked.append(t)
            if stops is ZeroDivisionError or len(asked) == 1:  # Ctrl-C comes once
                raise stops("here")
        return 0.0, 0.0, 0.1 * np.sin(t)

    is_running = False
    motion = kf.PoseMotion(heave, lambda t: (0, 0, 0.1 * np.cos(t)), lambda t: (0, 0, -0.1 * np.sin(t)))
    scene = shaken(kf.Free(motion=motion))

    def begin(t: float, state: kf.SceneState) -> float:
        nonlocal is_running
        is_running = t > 0.0
        return 1.0

    with pytest.warns(kf.SimulationWarning):
        result = scene.simulate((0.0, 1.0), method="dop853", events=kf.Event("begins", begin))
    expected = {ZeroDivisionError: "raised ZeroDivisionError: here (heave, line", KeyboardInterrupt: "by Ctrl-C"}
    assert expected[stops] in result.status.reason
    assert 0.0 < result.times[-1] <= 0.5 + 1e-9


def test_euler_parameters_of_either_sign_and_any_length_are_one_rotation() -> None:
    given = np.array([orientation(t) for t in TIMES])
    factors = np.random.default_rng(0).uniform(0.5, 2.0, len(TIMES)) * np.where(np.arange(len(TIMES)) % 3, 1.0, -1.0)
    ours, wanted = (kf.PoseTable(TIMES, None, e) for e in (given * factors[:, None], given))
    for a, b in zip(ours.at(1.234), wanted.at(1.234), strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-10)  # of round-off over the square of 25 ms


def test_exact_derivatives_are_those_of_differences() -> None:
    model = scene_of(kf.Free(motion=TABLE)).freeze()
    y = np.concatenate((model.initial_state, (0.0, 0.0)))
    for at in range(len(model.initial_state)):
        row = model.route.derivatives(0.4, y, np.eye(len(y))[at : at + 1])[0]
        wanted, _ = derivatives(lambda s, at=at: model.route.evaluate(0.4, y + s * np.eye(len(y))[at]).rates)
        # round-off of the rates over the step of the differences
        np.testing.assert_allclose(row, wanted, rtol=0, atol=1e-7 * (1.0 + abs(wanted).max()))


def test_a_beam_on_a_base_that_accelerates_is_one_under_more_weight() -> None:
    pull = np.array((0.4, -0.3, 2.0))

    def run(joint: kf.Joint, gravity: np.ndarray) -> np.ndarray:
        scene = kf.System(gravity=gravity)
        base = scene.add_frame("base", joint=joint)
        scene.add_flexible_body("beam", elastic_body("damped modes", 1), parent=base)
        return np.asarray(scene.simulate((0.0, 0.5), rtol=1e-9, method="dop853").modal_coordinates("beam"))

    motion = kf.PoseMotion(lambda t: 0.5 * pull * t**2, lambda t: pull * t, lambda t: pull).table((0.0, 0.3, 1.0))
    ours, wanted = run(kf.Free(motion=motion), GRAVITY), run(kf.Fixed(), GRAVITY - pull)
    np.testing.assert_allclose(ours, wanted, rtol=0, atol=1e-7 * abs(wanted).max())  # the runs' steps may differ
    assert abs(wanted).max() > 0.0


def test_a_scene_in_a_plane_on_such_a_base_is_the_one_with_a_driven_slider() -> None:
    def run(joint: kf.Joint) -> kf.Result:
        scene = kf.System(gravity=(0, 0, -9.81))
        base = scene.add_frame("base", joint=joint)
        scene.add_rigid_body("arm", 1.0, 0.1, com=(0.3, 0, 0), parent=base, joint=kf.Revolute("y"))
        return scene.simulate((0.0, 2.0), rtol=1e-10)

    height = 0.3 * TIMES**2 * (1.0 - 0.2 * TIMES)  # a cubic, which the spline is
    ours = run(kf.Free(motion=kf.PoseTable(TIMES, np.outer(height, (0.0, 0.0, 1.0)))))
    wanted = run(kf.Prismatic("z", motion=kf.Motion.table(TIMES, height)))
    # 10 times the tolerance of the runs
    np.testing.assert_allclose(ours.joint_coordinates("arm"), wanted.joint_coordinates("arm"), rtol=0, atol=1e-9)


def test_a_surface_on_a_driven_frame_carries_and_drags() -> None:
    lift = kf.PoseMotion(
        lambda t: np.array((0.1 * t**2, 0.0, 0.2 * t**2)),
        lambda t: np.array((0.2 * t, 0.0, 0.4 * t)),
        lambda t: np.array((0.2, 0.0, 0.4)),
    )
    scene = kf.System(gravity=(0, 0, -9.81))
    deck = scene.add_frame("deck", joint=kf.Free(motion=lift.table((0.0, 1.0, 2.0))))
    weight, stiffness = 9.81 + 0.4, 1e5
    box = scene.add_point("box", 1.0, joint=kf.Translation(position=(0.0, 0.0, -weight / stiffness)))
    floor = scene.add_surface("floor", deck, kf.shapes.Plane("z"))
    friction = kf.Coulomb(0.5, stiffness=1e5, damping=300.0)
    skin = scene.add_surface("skin", box, kf.shapes.Sphere(1e-3), at=(0, 0, 1e-3))
    scene.add_contact("foot", skin, floor, normal=kf.HuntCrossley(stiffness, damping=1.0), friction=friction)
    result = scene.simulate((0.0, 1.5), rtol=1e-8)
    contact = result.contact("foot")
    late = result.times > 1.0
    np.testing.assert_allclose(np.ravel(contact.normal[late]), weight, rtol=1e-5)
    # carried along: the spring of the anchor is longer by 0.2 N over its stiffness, 2 um
    np.testing.assert_allclose(result.position("box")[late, 0], 0.1 * result.times[late] ** 2, rtol=0, atol=3e-6)
    assert abs(result.energy.balance_error).max() < 1e-6 * abs(result.energy.work).max()


NO_POSITION = {"orientation": orientation, "angular_velocity": spin, "angular_acceleration": twist}
FOUR = np.arange(4.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kf.PoseTable(FOUR[::-1], np.zeros((4, 3))), "times of a PoseTable must increase, but 3 s is followed"),
        (lambda: kf.PoseTable(FOUR[:3], np.zeros((3, 3))), "3 times has too few for a spline, which needs 4"),
        (lambda: kf.PoseTable(0.0, np.zeros((4, 3))), "times of a PoseTable must be finite numbers of shape"),
        (lambda: kf.PoseTable(FOUR), "needs positions or orientations; neither is given"),
        (lambda: kf.PoseTable(FOUR, np.zeros((3, 3))), r"positions of a PoseTable with 4 times .* shape \(3, 3\)"),
        (lambda: kf.PoseTable(FOUR, np.full((4, 3), np.nan)), "positions of a PoseTable .* not finite"),
        (lambda: kf.PoseTable(FOUR, None, np.zeros((4, 3))), r"orientations of a PoseTable .* shape \(4, 3\)"),
        (lambda: kf.PoseTable(FOUR, None, np.zeros((4, 4))), "orientation 0 of a PoseTable must be a rotation"),
        (lambda: kf.PoseTable(FOUR, None, np.eye(4)), "turns by 180 degrees from 0 to 1 s.* more points"),
        (lambda: kf.PoseTable(FOUR, velocities=np.zeros((4, 3)), orientations=np.ones((4, 4))), "needs positions too"),
        (lambda: kf.PoseTable(FOUR, np.zeros((4, 3)), accelerations=np.zeros((4, 3))), "needs velocities too"),
        (
            lambda: kf.PoseTable(
                TIMES,
                None,
                [orientation(t) for t in TIMES],
                angular_velocities=[np.degrees(spin(t)) for t in TIMES],
            ),
            "angular_velocities of a PoseTable are not those of its values.*rad/s",
        ),
        (lambda: kf.PoseMotion(), "needs position or orientation as functions of time"),
        (lambda: kf.PoseMotion(orientation=orientation), "angular_velocity and angular_acceleration is missing"),
        (lambda: kf.PoseMotion(*(np.zeros(3),) * 3), "position of a PoseMotion must be a function of time"),
        (lambda: kf.Free(motion=kf.PoseMotion(*(lambda t: 1.0,) * 3)), r"position of a PoseMotion at .* shape \(3,\)"),
        (
            lambda: kf.Free(motion=kf.PoseMotion(**{**NO_POSITION, "angular_velocity": lambda t: -spin(t)})),
            "the angular_velocity of a PoseMotion is .* changes at",
        ),
        (lambda: kf.Free(motion=kf.Motion.steady(1.0)), "motion of a free joint must be a PoseMotion, a PoseTable or"),
        (lambda: kf.Free(motion=TABLE, position=(1, 0, 0)), "takes its start from it. Remedy: leave out position"),
        (lambda: kf.Free(motion=TABLE, orientation=np.eye(3)), "Remedy: leave out orientation"),
        (lambda: kf.Spherical(motion=TABLE), "gives positions, but its point stays"),
    ],
)
def test_bad_input_is_named(make: Callable[[], object], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()


def test_what_a_scene_cannot_do_with_it_is_named() -> None:
    with pytest.raises(ModelError, match="motion of body 'base' is given from 0 to 3 s"):
        shaken(kf.Free(motion=TABLE)).simulate((0.0, 4.0))
    scene = shaken(kf.Free(motion=TABLE))
    with pytest.raises(ModelError, match="is not one that a motor can drive"):
        scene.add_motor(scene.body("base"), 1.0)
    pin = kf.Spherical(motion=functions(moves=False))
    with pytest.raises(ModelError, match="loop joint 'pin' cannot be driven by a motion"):
        scene.add_loop_joint("pin", pin, scene.ground, scene.body("arm"))
    with pytest.raises(ModelError, match="the free joint follows a given pose as a whole"):
        kf.linearise(shaken(kf.Free(motion=TABLE)), inputs=["drive base"])
