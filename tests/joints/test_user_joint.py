"""Joints from outside the package: what they must have, and that all routes see the same motion of them."""

import numpy as np
import pytest
from numba import cfunc, njit, types

import kanefe as kf
from joint_scenes import assert_routes_agree, scene_of
from scenes import derivatives

RADIUS, CLIMB, ROLL = 0.6, 0.25, 1.7


class Chute(kf.Joint):
    """A slide that winds about z, climbs with the square of the angle, and rolls about its way; from Python alone."""

    coordinate_names = ("angle [rad]",)
    speed_names = ("rate [rad/s]",)

    def __init__(self, position=0.4, speed=-0.7, motion=None, forces=None):
        self.start, self.motion, self.forces = (position, speed), motion, forces

    @property
    def motions(self):
        return (self.motion,)

    @property
    def coordinate_forces(self):
        return (self.forces,)

    def initial_coordinates(self):
        return np.array(self.start[:1])

    def initial_speeds(self):
        return np.array(self.start[1:])

    def pose(self, q):
        (c, s), (cr, sr) = ((np.cos(x), np.sin(x)) for x in (q[0], ROLL * q[0]))
        turn = np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
        roll = np.array(((1.0, 0.0, 0.0), (0.0, cr, -sr), (0.0, sr, cr)))
        return np.array((RADIUS * c, RADIUS * s, CLIMB * q[0] ** 2)), turn @ roll

    def partial_velocities(self, q):
        c, s = np.cos(q[0]), np.sin(q[0])
        V = np.array(((-RADIUS * s,), (RADIUS * c,), (2.0 * CLIMB * q[0],)))
        return V, np.array(((ROLL * c,), (ROLL * s,), (1.0,)))

    def remainders(self, q, u):
        c, s, square = np.cos(q[0]), np.sin(q[0]), u[0] ** 2
        Z = np.array((-RADIUS * c, -RADIUS * s, 2.0 * CLIMB))
        return square * Z, square * np.array((-ROLL * s, ROLL * c, 0.0))


@njit
def write_chute(numbers, q, out):
    radius, climb, roll = numbers[0], numbers[1], numbers[2]
    c, s, cr, sr = np.cos(q[0]), np.sin(q[0]), np.cos(roll * q[0]), np.sin(roll * q[0])
    out[0], out[1], out[2] = radius * c, radius * s, climb * q[0] * q[0]
    out[3], out[4], out[5] = c, -s * cr, s * sr
    out[6], out[7], out[8] = s, c * cr, -c * sr
    out[10], out[11] = sr, cr
    out[12], out[13], out[14] = -radius * s, radius * c, 2.0 * climb * q[0]
    out[15], out[16], out[17] = roll * c, roll * s, 1.0
    out[18], out[19], out[20] = -radius * c, -radius * s, 2.0 * climb
    out[21], out[22] = -roll * s, roll * c


def compiled(number):
    pointer = types.CPointer(number)
    return cfunc(types.void(types.CPointer(types.float64), pointer, pointer))(
        lambda numbers, q, out: write_chute(numbers, q, out)
    )


REAL, COMPLEX = compiled(types.float64), compiled(types.complex128)
NUMBERS = np.array((RADIUS, CLIMB, ROLL))


class CompiledChute(Chute):
    """The same with a function of C."""

    kernel = kf.LinkKernel(REAL.address, NUMBERS, COMPLEX.address)

    def links(self):
        return (kf.Link.given(self.kernel),)


class ChuteWithPin(CompiledChute):
    """A pin about y behind the slide: a joint of two links."""

    coordinate_names = ("angle [rad]", "pin [rad]")
    speed_names = ("rate [rad/s]", "pin rate [rad/s]")
    motions = (None, None)
    coordinate_forces = (None, None)

    def __init__(self):
        self.start = (0.4, 0.3, -0.7, 0.5)

    def initial_coordinates(self):
        return np.array(self.start[:2])

    def initial_speeds(self):
        return np.array(self.start[2:])

    def pose(self, q):
        p, A = super().pose(q)
        return p, A @ kf.Revolute("y").pose(q[1:])[1]

    def partial_velocities(self, q):
        V, W = super().partial_velocities(q)
        return np.hstack((V, np.zeros((3, 1)))), np.hstack((W, super().pose(q)[1][:, 1:2]))

    def remainders(self, q, u):
        Z, Y = super().remainders(q, u)
        W, axis = super().partial_velocities(q)[1][:, 0], super().pose(q)[1][:, 1]
        return Z, Y + u[0] * u[1] * np.cross(W, axis)

    def links(self):
        return *super().links(), kf.Link.turning(np.array((0.0, 1.0, 0.0)))


FORCES = kf.CoordinateForce(
    stiffness=20.0,
    damping=2.0,
    friction=0.3,
    friction_stiffness=1.0,
    friction_damping=0.1,
    limits=(-0.5, 0.5),
    limit_stiffness=300.0,
    limit_damping=1.0,
)
VARIANTS = {
    "free": ({}, {}),
    "with forces": ({"forces": FORCES}, {}),
    "driven": ({"position": 0.0, "speed": 0.0, "motion": kf.Motion(np.sin, np.cos, lambda t: -np.sin(t))}, {}),
    "flexible, in a loop": ({"forces": FORCES}, {"is_flexible": True}),
}


@pytest.mark.parametrize(("options", "around"), VARIANTS.values(), ids=VARIANTS)
def test_both_routes_agree_to_round_off(options, around):
    assert_routes_agree(scene_of(CompiledChute(**options), **around).freeze(), 0.4)


def test_links_behind_a_given_one():
    assert_routes_agree(scene_of(ChuteWithPin()).freeze())


def test_derivatives_come_from_the_complex_function_and_else_from_differences():
    model = scene_of(CompiledChute(forces=FORCES)).freeze()
    y = np.concatenate((model.initial_state, (0.0, 0.0)))
    y[-3] = 0.0  # the start is at the limit of friction, where it has two slopes
    directions = np.eye(len(y))[: len(y) - 2]
    found = model.route.derivatives(0.0, y, directions)
    for direction, row in zip(directions, found, strict=True):
        wanted, _ = derivatives(lambda s, d=direction: model.route.evaluate(0.0, y + s * d).rates, step=1e-3)
        # differences of order 8: round-off of rates of about 100 over the step
        np.testing.assert_allclose(row, wanted, rtol=0, atol=1e-9 * (1.0 + abs(wanted).max()))

    class Real(CompiledChute):
        kernel = CompiledChute.kernel._replace(complex_=None)

    assert scene_of(Real(forces=FORCES)).freeze().route.derivatives(0.0, y, directions) is None
    result = scene_of(Real(forces=FORCES)).simulate((0.0, 0.2), method="radau5", rtol=1e-8)
    other = scene_of(CompiledChute(forces=FORCES)).simulate((0.0, 0.2), method="radau5", rtol=1e-8)
    np.testing.assert_allclose(result.joint_coordinates("slider")[-1], other.joint_coordinates("slider")[-1], rtol=1e-6)


def test_a_joint_from_python_alone_takes_the_literal_route_and_the_result_says_why():
    results = [scene_of(kind()).simulate((0.0, 0.5), rtol=1e-9) for kind in (Chute, CompiledChute)]
    assert results[0].statistics["route"] == "literal"
    assert "'slider'" in results[0].statistics["route_reason"]
    assert results[1].statistics["route"] == "order n"
    # two runs with errors of rtol, and coordinates of about 1
    np.testing.assert_allclose(
        results[0].joint_coordinates("slider")[-1], results[1].joint_coordinates("slider")[-1], rtol=0, atol=1e-7
    )
    for result in results:
        assert abs(result.energy.balance_error).max() < 1e-6


def test_what_drives_it_needs_the_same_force_on_both_routes():
    motion = kf.Motion.steady(0.5)
    results = [scene_of(kind(0.0, 0.0, motion)).simulate((0.0, 0.3), rtol=1e-9) for kind in (Chute, CompiledChute)]
    forces = [result.driving_force("slider") for result in results]
    np.testing.assert_allclose(forces[0][-1], forces[1][-1], rtol=1e-6)  # two runs with errors of rtol


def changed(base=CompiledChute, **members):
    return type("Changed", (base,), members)


def wrong_kernel(at):
    @njit
    def write(numbers, q, out):
        write_chute(numbers, q, out)
        out[at] += 0.2 + 0.3 * q[0]

    pointer = types.CPointer(types.float64)
    function = cfunc(types.void(pointer, pointer, pointer))(lambda numbers, q, out: write(numbers, q, out))
    return function, changed(kernel=kf.LinkKernel(function.address, NUMBERS))


SEVERAL = kf.Link.given(CompiledChute.kernel), kf.Link.fixed()
FAULTS = [
    ({"coordinate_names": ["angle [rad]"]}, "coordinate_names of joint of body 'b'.*tuple of texts"),
    ({"coordinate_names": ("angle",)}, r"coordinate_names .*end in \[m\] or \[rad\]"),
    ({"speed_names": ("rate [rpm]",)}, r"speed_names .*\[m/s\] or \[rad/s\]"),
    ({"speed_names": ()}, "has 1 coordinates and 0 speeds; it must have one for each speed"),
    ({"rotation_at": 0}, "a fourth Euler parameter"),
    ({"initial_coordinates": lambda self: np.array((np.nan,))}, "initial_coordinates .* finite numbers"),
    ({"initial_coordinates": lambda self: np.zeros(2)}, r"initial_coordinates .* shape \(1,\)"),
    ({"initial_speeds": lambda self: 0.0}, "initial_speeds"),
    (
        {"given_start": lambda self: ([True], [1])},
        r"given_start\(\) .* must give a tuple of two lists, each of 1 times",
    ),
    ({"motions": (3.0,)}, "motions .* 1 of Motion or None"),
    ({"coordinate_forces": ()}, "coordinate_forces .* 1 of CoordinateForce or None"),
    ({"held": lambda self: "everything"}, r"held\(\) .* kanefe.Held"),
    ({"pose": lambda self, q: (np.zeros(2), np.eye(3))}, r"position .* shape \(3,\)"),
    ({"pose": lambda self, q: (np.zeros(3), np.eye(2))}, r"rotation .* shape \(3, 3\)"),
    ({"pose": lambda self, q: (np.zeros(3), -np.eye(3))}, "not a rotation matrix"),
    ({"pose": lambda self, q: (np.full(3, np.nan), np.eye(3))}, "position .* finite"),
    ({"partial_velocities": lambda self, q: (np.zeros(3), np.zeros(3))}, r"V of .* shape \(3, 1\)"),
    (
        {"partial_velocities": lambda self, q: (-Chute.partial_velocities(self, q)[0], np.ones((3, 1)))},
        r"column 0 of V .*position of pose\(\) changes by .*Remedy",
    ),
    (
        {"partial_velocities": lambda self, q: (Chute.partial_velocities(self, q)[0], np.ones((3, 1)))},
        r"column 0 of W .*rotation of pose\(\) changes",
    ),
    ({"remainders": lambda self, q, u: (np.zeros(3), np.zeros(3))}, r"Z of remainders\(\) .*V u changes"),
    (
        {"remainders": lambda self, q, u: (Chute.remainders(self, q, u)[0], np.zeros(3))},
        r"Y of remainders\(\) .*W u changes",
    ),
    ({"coordinate_rates": lambda self, q, u: 2.0 * u}, r"coordinate_rates .*advance\(\) moves"),
    ({"advance": lambda self, q, step: q + 2.0 * step}, "changes by"),
    ({"ranges": ()}, r"ranges .* 1 of \(low, high\) or None"),
    ({"ranges": ((1.0, 0.0),)}, "a smaller and a larger number"),
    ({"ranges": ((0.5, 1.0),)}, "starts at .* out of its ranges .*Remedy"),
    ({"links": lambda self: [kf.Link.fixed()]}, "tuple of kanefe.Link"),
    ({"links": lambda self: (kf.Link.free(),)}, "have 7 coordinates and 6 speeds, the joint has 1 and 1"),
    ({"links": lambda self: (kf.Link.turning(np.array((0, 0, 1.0))),)}, "links of .* give the position .*Remedy"),
    ({"kernel": 3.0}, "kanefe.LinkKernel"),
    ({"kernel": kf.LinkKernel(-1, NUMBERS)}, "address of a C function"),
    ({"kernel": kf.LinkKernel(REAL.address, np.full(3, np.nan))}, "numbers of a link"),
    ({"kernel": kf.LinkKernel(REAL.address, 1.1 * NUMBERS)}, "links of .* give the position"),
]


@pytest.mark.parametrize(("members", "message"), FAULTS, ids=lambda x: x if isinstance(x, str) else "")
def test_what_a_joint_lacks_is_named_when_it_is_added(members, message):
    with pytest.raises(kf.ModelError, match=message):
        kf.System().add_rigid_body("b", 1.0, 0.1, joint=changed(**members)())


@pytest.mark.parametrize(
    ("at", "message"),
    [
        (0, "position"),
        (5, "rotation"),
        (13, "dV/dq .*V changes"),
        (16, "dW/dq .*W changes"),
        (19, "dV/dq"),
        (22, "dW/dq"),
    ],
)
def test_a_function_that_contradicts_the_joint_is_named(at, message):
    kept, kind = wrong_kernel(at)
    with pytest.raises(kf.ModelError, match=f"{message}"):
        kf.System().add_rigid_body("b", 1.0, 0.1, joint=kind())
    del kept


def test_a_class_in_place_of_a_joint_is_refused_and_told_what_it_lacks():
    incomplete = type("Incomplete", (kf.Joint,), {"pose": Chute.pose})
    with pytest.raises(kf.ModelError, match="Remedy: an object of it, after it has initial_coordinates, initial_sp"):
        kf.System().add_rigid_body("b", 1.0, 0.1, joint=incomplete)
    with pytest.raises(kf.ModelError, match="joint of body 'b' must be a Joint"):
        kf.System().add_rigid_body("b", 1.0, 0.1, joint=object())


def test_a_joint_of_a_loop_is_checked_too():
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, 0.1, joint=kf.Free())
    with pytest.raises(kf.ModelError, match=r"joint of loop joint 'pin' \(Changed\)"):
        scene.add_loop_joint("pin", changed(kf.Revolute, speed_names=("rate",))(), scene.ground, body)
