"""Rotations and their parameters (Eq. 4-8)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

import kanefe as kf
from kanefe import frames
from kanefe.errors import ModelError
from scenes import derivatives, unit_axis

# Products of a few numbers of size one: round-off of a dozen operations.
ROUND_OFF = 1e-14
SEEDS = range(8)


def random_parameters(rng: np.random.Generator) -> np.ndarray:
    e = rng.standard_normal(4)
    return e / np.linalg.norm(e)


@pytest.mark.parametrize("seed", SEEDS)
def test_skew_and_axial_are_the_cross_product(seed: int) -> None:
    a, b = np.random.default_rng(seed).standard_normal((2, 3))
    assert frames.skew(a) @ b == pytest.approx(np.cross(a, b), abs=ROUND_OFF)
    assert frames.skew(a) @ b == pytest.approx(-frames.skew(b) @ a, abs=ROUND_OFF)
    assert frames.cross(a, b) == pytest.approx(np.cross(a, b), abs=ROUND_OFF)
    assert frames.axial(np.outer(a, b)) == pytest.approx(np.cross(a, b), abs=ROUND_OFF)


@pytest.mark.parametrize("seed", SEEDS)
def test_rotation_matrix_turns_about_the_axis(seed: int) -> None:
    rng = np.random.default_rng(seed)
    axis, angle = unit_axis(rng), rng.uniform(-6, 6)
    A = frames.rotation_matrix(frames.euler_parameters(2.5 * axis, angle))
    assert pytest.approx(expm(frames.skew(angle * axis)), abs=1e-13) == A  # expm itself is good to some 1e-14
    assert A.T @ A == pytest.approx(np.eye(3), abs=ROUND_OFF)
    assert np.linalg.det(A) == pytest.approx(1.0, abs=ROUND_OFF)


def test_rotation_matrix_maps_the_turned_axes_to_the_frame_they_are_seen_from() -> None:
    # b is a turned by 90 degrees about z: b's x axis is a's y axis.
    A_ab = frames.rotation_matrix(frames.euler_parameters((0, 0, 1), np.pi / 2))
    assert A_ab @ (1, 0, 0) == pytest.approx((0, 1, 0), abs=ROUND_OFF)


@pytest.mark.parametrize("seed", SEEDS)
def test_rotation_matrix_ignores_the_length_of_the_parameters(seed: int) -> None:
    e = random_parameters(np.random.default_rng(seed))
    assert frames.rotation_matrix(1.7 * e) == pytest.approx(frames.rotation_matrix(e), abs=ROUND_OFF)


@pytest.mark.parametrize("seed", SEEDS)
def test_multiply_composes_rotations(seed: int) -> None:
    rng = np.random.default_rng(seed)
    e_ab, e_bc = random_parameters(rng), random_parameters(rng)
    A_ac = frames.rotation_matrix(frames.multiply(e_ab, e_bc))
    assert pytest.approx(frames.rotation_matrix(e_ab) @ frames.rotation_matrix(e_bc), abs=ROUND_OFF) == A_ac


HALF_TURNS = [np.eye(4)[i] for i in range(4)] + [np.array([1e-9, 0.6, 0.8, 0.0]), np.array([0.5, 0.5, -0.5, 0.5])]


@pytest.mark.parametrize("e", [random_parameters(np.random.default_rng(s)) for s in SEEDS] + HALF_TURNS)
def test_parameters_come_back_from_the_matrix(e: np.ndarray) -> None:
    back = frames.euler_parameters_from_matrix(frames.rotation_matrix(e))
    # up to the sign of all four, which is the same rotation
    assert abs(back @ e) == pytest.approx(1.0, abs=ROUND_OFF)
    assert frames.rotation_matrix(back) == pytest.approx(frames.rotation_matrix(e), abs=ROUND_OFF)
    assert back[0] >= 0


@pytest.mark.parametrize("seed", SEEDS)
def test_rates_match_finite_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    e, w = random_parameters(rng), rng.standard_normal(3)

    def turned(t: float) -> np.ndarray:
        return frames.multiply(e, frames.euler_parameters_from_rotation_vector(w * t))

    # order-8 differences of functions of unit size: 2e-16 / 0.02 of round-off
    rate, _ = derivatives(turned)
    assert frames.euler_parameter_rates(e, w) == pytest.approx(rate, abs=1e-12)
    rate, _ = derivatives(lambda t: frames.rotation_matrix(turned(t)))
    A = frames.rotation_matrix(e)
    assert frames.rotation_matrix_rate(A, w) == pytest.approx(rate, abs=1e-12)
    assert frames.rotation_matrix_rate(A, w) == pytest.approx(frames.skew(A @ w) @ A, abs=1e-13)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 9.9e-5, 1.01e-4, 0.3, 2.0, 3.1, np.pi])
def test_rotation_vector_is_the_inverse_of_the_exponential(angle: float) -> None:
    theta = angle * unit_axis(np.random.default_rng(3))
    e = frames.euler_parameters_from_rotation_vector(theta)
    assert np.linalg.norm(e) == pytest.approx(1.0, abs=ROUND_OFF)
    assert Rotation.from_rotvec(theta).as_matrix() == pytest.approx(frames.rotation_matrix(e), abs=ROUND_OFF)
    assert frames.rotation_vector(e) == pytest.approx(theta, rel=1e-13, abs=1e-25)
    assert frames.rotation_vector(-e) == pytest.approx(theta, rel=1e-13, abs=1e-25) or angle == np.pi


@pytest.mark.parametrize("axis", [(0, 0, 0), (1, 0), (np.nan, 0, 1), (np.inf, 0, 0)])
def test_an_axis_without_direction_is_refused(axis: tuple[float, ...]) -> None:
    with pytest.raises(ModelError, match=r"axis of a rotation must be three finite numbers with a length above zero"):
        frames.euler_parameters(axis, 1.0)


def test_orientations_are_taken_in_every_form_alike() -> None:
    rotation = Rotation.from_euler("ZXZ", (0.3, -1.1, 2.0))
    expected = rotation.as_matrix()
    given = (rotation, expected, expected.tolist(), kf.euler_angles("ZXZ", (0.3, -1.1, 2.0)))
    given += (
        2.0 * kf.euler_angles("zxz", (2.0, -1.1, 0.3)),
        kf.rotation_about(rotation.as_rotvec(), rotation.magnitude()),
    )
    for form in given:
        scene = kf.System()
        frame = scene.ground.frame(orientation=form)
        np.testing.assert_allclose(frame.axes, expected, atol=1e-15)
        np.testing.assert_allclose(kf.Interface(axes=form).rotation, expected, atol=1e-15)
        start = kf.Spherical(orientation=form).initial_coordinates()
        np.testing.assert_allclose(frames.rotation_matrix(start), expected, atol=1e-15)


@pytest.mark.parametrize(
    "make",
    [
        lambda: kf.Free(orientation=np.diag((1.0, 1.0, -1.0))),
        lambda: kf.Spherical(orientation=2.0 * np.eye(3)),
        lambda: kf.System().add_frame("a", orientation=(0, 0, 0, 0)),
        lambda: kf.rotation_about("w", 1.0),
        lambda: kf.rotation_about("z", np.inf),
        lambda: kf.euler_angles("xYz", (1, 2, 3)),
        lambda: kf.euler_angles("xyz", (1, 2)),
    ],
)
def test_what_is_no_orientation_is_refused(make: Callable[[], object]) -> None:
    with pytest.raises(kf.ModelError):
        make()
