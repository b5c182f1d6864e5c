"""Constraint rows against finite differences along smooth motions of their two markers."""

import numpy as np
import pytest

from kanefe.bodies.marker import Marker
from kanefe.constraints.loop_joints import across, loop_joint_rows
from kanefe.constraints.rows import (
    FIRST,
    NORMAL,
    SECOND,
    DirectionRow,
    DistanceRow,
    MarkerMotion,
    PointRow,
    RollingRow,
    ScrewRow,
)
from kanefe.frames import euler_parameters_from_rotation_vector, multiply, rotation_matrix
from kanefe.joints import (
    Cylindrical,
    Fixed,
    Free,
    Planar,
    Prismatic,
    Revolute,
    Screw,
    Spherical,
    Universal,
)
from scenes import derivatives

A, B = (Marker(number, None, np.zeros(3), np.eye(3), name) for number, name in ((0, "a"), (1, "b")))
X, Y, Z = np.eye(3)

# Central differences of order 8. The markers turn by some rad/s, a wheel's lowest point faster: with a step of 0.005
# truncation is below 1e-11, and round-off 2e-16 / 0.005 of a first and / 0.005^2 of a second derivative.
STEP = 0.005
TOLERANCE = 1e-10


class Motion:
    """A marker that moves smoothly: polynomial path, and a turn by the exponential of a polynomial."""

    def __init__(self, rng, turn=None):
        self.path, self.e = rng.standard_normal((3, 3)), rng.standard_normal(4)
        self.e /= np.linalg.norm(self.e)
        self.turn = rng.standard_normal((2, 3)) if turn is None else turn

    def p(self, s):
        return self.path[0] + self.path[1] * s + 0.5 * self.path[2] * s * s

    def A(self, s):
        step = self.turn[0] * s + 0.5 * self.turn[1] * s * s
        return rotation_matrix(multiply(self.e, euler_parameters_from_rotation_vector(step)))

    def at(self, s):
        return MarkerMotion(self.p(s), self.A(s), *np.zeros((4, 3)))

    @property
    def now(self):
        """Exact motion at s = 0: remainders are the whole accelerations, as if all du were zero."""
        A = self.A(0.0)
        w, alpha = A @ self.turn[0], A @ self.turn[1]
        return MarkerMotion(self.p(0.0), A, self.path[1], w, self.path[2], alpha)


def rate(row, a, b):
    force_a, moment_a, force_b, moment_b = row.wrenches(a, b)
    return force_a @ a.v + moment_a @ a.w + force_b @ b.v + moment_b @ b.w


def units(rng, count):
    v = rng.standard_normal((count, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def rows(rng):
    e, f = units(rng, 2)
    return [
        PointRow("", A, B, e),
        DirectionRow("", A, B, e, f, 0.3),
        DistanceRow("", A, B, 0.7),
        RollingRow("", A, B, 0.4, NORMAL, False),
        RollingRow("", A, B, 0.4, NORMAL, True),
    ]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("number", range(5))
def test_jacobian_and_remainder_are_the_derivatives_of_the_residual(number, seed):
    rng = np.random.default_rng(seed)
    row = rows(rng)[number]
    a, b = Motion(rng), Motion(rng)
    first, second = derivatives(lambda s: np.array(row.residual(a.at(s), b.at(s))), STEP)
    assert rate(row, a.now, b.now) == pytest.approx(float(first), abs=TOLERANCE)
    assert row.remainder(a.now, b.now) == pytest.approx(float(second), abs=100 * TOLERANCE)


@pytest.mark.parametrize("seed", range(3))
def test_a_screw_counts_the_turn_of_aligned_axes(seed):
    """The two axes stay parallel, as its other rows keep them: only then is the angle that of the angular velocity."""
    rng = np.random.default_rng(seed)
    axis = units(rng, 1)[0]
    row = ScrewRow("", A, B, axis, across(axis)[0], 0.25)
    a, b = Motion(rng), Motion(rng)
    rates = rng.standard_normal(2)
    # b carries a's turn and one about the common axis
    b.A = lambda s: a.A(s) @ Motion.A(_spin(axis, rates), s)
    w = a.now.A @ axis
    b_now = MarkerMotion(
        b.p(0.0),
        b.A(0.0),
        b.path[1],
        a.now.w + rates[0] * w,
        b.path[2],
        a.now.Y + rates[1] * w + rates[0] * np.cross(a.now.w, w),
    )
    first, second = derivatives(lambda s: np.array(row.residual(a.at(s), b.at(s))), STEP)
    assert rate(row, a.now, b_now) == pytest.approx(float(first), abs=TOLERANCE)
    assert row.remainder(a.now, b_now) == pytest.approx(float(second), abs=100 * TOLERANCE)


def _spin(axis, rates):
    spin = Motion(np.random.default_rng(0), turn=np.outer(rates, axis))
    spin.e = np.array([1.0, 0, 0, 0])
    return spin


def test_a_screw_has_no_seam_at_full_turns():
    row = ScrewRow("", A, B, Z, X, 0.1)
    rest = MarkerMotion(np.zeros(3), np.eye(3), *np.zeros((4, 3)))
    for turns in (-2.5, -0.5, 0.5, 1.0, 7.49, 7.51):
        angle = 2 * np.pi * turns
        turned = rotation_matrix(euler_parameters_from_rotation_vector(angle * Z))
        b = MarkerMotion((0.1 * turns + 1e-3) * Z, turned, *np.zeros((4, 3)))
        assert row.residual(rest, b) == pytest.approx(1e-3, abs=1e-12)


@pytest.mark.parametrize("is_ball", [False, True])
@pytest.mark.parametrize(("direction", "axis"), [(FIRST, X), (SECOND, Y), (NORMAL, Z)])
def test_rolling_is_about_the_material_point_at_the_contact(direction, axis, is_ball):
    """The point of b that touches at s = 0 is followed in a's axes: its speed there is the slip."""
    rng = np.random.default_rng(5)
    a, b = Motion(rng), Motion(rng)
    radius = 0.4
    row = RollingRow("", A, B, radius, direction, is_ball)

    def touching(s):
        """Contact point from the hub in b's axes: the lowest of many points of a ball or rim, refined."""
        n = b.A(s).T @ a.A(s)[:, 2]
        n = n if is_ball else n * [1, 1, 0]
        return -radius * n / np.linalg.norm(n)

    def slip(s0):
        point = touching(s0)
        place = lambda s: a.A(s0 + s).T @ (b.p(s0 + s) + b.A(s0 + s) @ point - a.p(s0 + s))  # noqa: E731
        return float(derivatives(place, STEP)[0] @ axis)

    assert rate(row, a.now, b.now) == pytest.approx(slip(0.0), abs=TOLERANCE)
    # the derivative of a derivative loses 1 / 0.02 more digits
    assert row.remainder(a.now, b.now) == pytest.approx(float(derivatives(slip, STEP)[0]), abs=1e-8)
    if direction != NORMAL:
        assert not row.holds_place


@pytest.mark.parametrize("seed", range(3))
def test_wrenches_on_both_ends_balance(seed):
    """Action is reaction: no resultant force, and no moment about any point."""
    rng = np.random.default_rng(seed)
    axis = units(rng, 1)[0]
    a, b = Motion(rng).now, Motion(rng).now
    screw = ScrewRow("", A, B, axis, across(axis)[0], 0.3)
    for row in [*rows(rng), screw, RollingRow("", A, B, 0.4, FIRST, False), RollingRow("", A, B, 0.4, SECOND, True)]:
        force_a, moment_a, force_b, moment_b = row.wrenches(a, b)
        assert np.abs(force_a + force_b).max() < 1e-14
        total = moment_a + moment_b + np.cross(a.p, force_a) + np.cross(b.p, force_b)
        assert np.abs(total).max() < 1e-13


JOINTS = [
    (Fixed(), 6),
    (Revolute((1, 2, 3)), 5),
    (Prismatic("y"), 5),
    (Cylindrical("x"), 4),
    (Universal("x", (0.3, 1, 0)), 4),
    (Spherical(), 3),
    (Planar(), 3),
    (Screw("z", lead=0.2), 5),
    (Screw("z"), 5),
]


@pytest.mark.parametrize(("joint", "count"), JOINTS, ids=lambda x: x.kind if hasattr(x, "kind") else str(x))
def test_loop_joints_hold_what_the_joint_of_the_tree_holds(joint, count):
    """Along any motion that the joint allows all residuals and their rates are zero; other motions are 6 - freedoms."""
    rng = np.random.default_rng(1)
    found = loop_joint_rows(joint, A, B)
    assert len(found) == count
    q = joint.advance(joint.initial_coordinates(), rng.standard_normal(len(joint.speed_names)))
    u = rng.standard_normal(len(joint.speed_names))
    carrier = Motion(rng).now
    p, turn = joint.pose(q)
    V, W = joint.partial_velocities(q)
    r = carrier.A @ p
    b = MarkerMotion(
        carrier.p + r,
        carrier.A @ turn,
        carrier.v + np.cross(carrier.w, r) + carrier.A @ (V @ u),
        carrier.w + carrier.A @ (W @ u),
        *np.zeros((2, 3)),
    )
    for row in found:
        assert row.residual(carrier, b) == pytest.approx(0.0, abs=1e-13), row.label
        assert rate(row, carrier, b) == pytest.approx(0.0, abs=1e-13), row.label
    J = np.array([np.concatenate(row.wrenches(carrier, b)[2:]) for row in found])
    assert np.linalg.matrix_rank(J, tol=1e-8) == count == 6 - len(joint.speed_names)


def test_a_free_joint_closes_no_loop():
    with pytest.raises(ValueError, match="free joint cannot close a loop"):
        loop_joint_rows(Free(), A, B)
