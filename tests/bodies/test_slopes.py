"""Slopes as finite rotations: both measures, their tangents and remainders (Eq. 22, 23)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kanefe.bodies.slopes import (
    SLOPE_MEASURES,
    SlopeMeasure,
    slope_measure,
    tait_bryan_angles,
    tait_bryan_euler_parameters,
)
from kanefe.errors import ModelError
from kanefe.frames import axial, rotation_matrix
from scenes import derivatives, unit_axis

# the closed forms and the series of the exponential meet at 1 rad: both sides of it are tried
SIZES = [0.0, 1e-9, 1e-3, 0.5, 0.999999, 1.000001, 1.4]


def angular_velocity(rate: np.ndarray, A: np.ndarray) -> np.ndarray:
    """Return w in the fixed frame from ``dA/dt A^T = w~``."""
    return -0.5 * axial(rate @ A.T)


@pytest.mark.parametrize("measure", SLOPE_MEASURES.values(), ids=SLOPE_MEASURES.keys())
@pytest.mark.parametrize("size", SIZES)
def test_tangent_and_remainder_match_finite_differences(measure: SlopeMeasure, size: float) -> None:
    rng = np.random.default_rng(1)
    theta, rate, rate2 = size * unit_axis(rng), rng.standard_normal(3), rng.standard_normal(3)

    def along(t: float) -> np.ndarray:
        return theta + rate * t + 0.5 * rate2 * t * t

    dA, _ = derivatives(lambda t: measure.rotation(along(t)))
    w = measure.tangent(theta) @ rate
    # order-8 differences with steps of 0.02: round-off 1e-14, truncation below 1e-11 for these rates
    assert w == pytest.approx(angular_velocity(dA, measure.rotation(theta)), abs=1e-10)
    alpha, _ = derivatives(lambda t: measure.tangent(along(t)) @ (rate + rate2 * t))
    assert measure.tangent(theta) @ rate2 + measure.remainder(theta, rate) == pytest.approx(alpha, abs=1e-10)


@pytest.mark.parametrize("measure", SLOPE_MEASURES.values(), ids=SLOPE_MEASURES.keys())
@pytest.mark.parametrize("seed", range(5))
def test_slopes_come_back_from_euler_parameters(measure: SlopeMeasure, seed: int) -> None:
    e = np.random.default_rng(seed).standard_normal(4)
    e /= np.linalg.norm(e)
    # a few operations at angles of order 1
    assert measure.rotation(measure.from_euler_parameters(e)) == pytest.approx(rotation_matrix(e), abs=1e-14)


@pytest.mark.parametrize("measure", SLOPE_MEASURES.values(), ids=SLOPE_MEASURES.keys())
def test_small_slopes_are_the_rotation_vector(measure: SlopeMeasure) -> None:
    theta = 1e-5 * np.array([1.0, -2.0, 3.0])
    # measures differ in second order: 3e-5 squared
    assert measure.rotation(theta) == pytest.approx(Rotation.from_rotvec(theta).as_matrix(), abs=1e-9)
    assert measure.tangent(theta) == pytest.approx(np.eye(3), abs=5e-5)


@pytest.mark.parametrize("angle", [1.0, 1.001, 0.999, 2.5])
def test_the_exponential_is_smooth_where_series_and_closed_form_meet(angle: float) -> None:
    measure, axis = SLOPE_MEASURES["rotation-vector"], unit_axis(np.random.default_rng(0))
    near, far = angle * axis * (1 - 1e-9), angle * axis * (1 + 1e-9)
    rate = np.array([0.3, -1.0, 0.7])
    # a relative step of 2e-9 moves smooth functions by as much; a jump of series against closed form would show
    assert measure.tangent(near) == pytest.approx(measure.tangent(far), abs=1e-8)
    assert measure.remainder(near, rate) == pytest.approx(measure.remainder(far, rate), abs=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_tait_bryan_angles_agree_with_scipy(seed: int) -> None:
    rotation = Rotation.random(random_state=seed)
    x, y, z, w = rotation.as_quat()
    assert tait_bryan_angles(np.array([w, x, y, z])) == pytest.approx(rotation.as_euler("xyz"), abs=1e-13)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-9, -np.pi / 2 + 1e-7])
def test_tait_bryan_angles_reproduce_the_rotation_at_and_near_the_singularity(pitch: float) -> None:
    e = tait_bryan_euler_parameters(np.array([0.3, pitch, -0.8]))
    back = tait_bryan_angles(e)
    # the angles themselves are not determined there, the rotation is: to round-off over the distance where it matters
    assert rotation_matrix(tait_bryan_euler_parameters(back)) == pytest.approx(rotation_matrix(e), abs=1e-13)
    assert back[1] == pytest.approx(pitch, abs=1e-13)


def test_unknown_slopes_are_refused_by_name() -> None:
    with pytest.raises(ModelError, match=r"no slopes called 'euler'\. Remedy: one of rotation-vector, tait-bryan"):
        slope_measure("euler")
