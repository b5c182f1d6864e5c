"""Fields of displacement and velocity at the start: what the modes can show comes back, and what not is told."""

import warnings

import numpy as np
import pytest

import kanefe as kf
from scenes import lattice_body


def added(body: kf.FlexibleBody, **field: object) -> np.ndarray:
    """Return the modal coordinates and speeds at the start of a scene of one body."""
    scene = kf.System()
    scene.add_flexible_body("body", body, **field)
    model = scene.freeze()
    return np.concatenate((model.initial_coordinates, model.initial_speeds))


def test_the_shape_of_a_mode_is_that_mode():
    body = lattice_body(0)
    eta = np.linspace(-1.0, 1.0, body.free_count)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = added(body, displacement=body.node_displacements(eta), velocity=body.node_displacements(-eta))
    np.testing.assert_allclose(found, np.concatenate((eta, -eta)), atol=1e-9)


def test_the_momentum_of_a_field_that_modes_cannot_show_is_told():
    """Of all coordinates those are taken whose rest has no mass along any mode."""
    body = lattice_body(1)
    field = lambda x: np.column_stack((0.0 * x[:, 0], np.sin(40.0 * x[:, 0]), x[:, 0] ** 2))  # noqa: E731
    with pytest.warns(kf.AccuracyWarning, match=r"velocity of body 'body': .* but for \d+ %.*more modes"):
        found = added(body, velocity=field)[body.free_count :]
    k, points = body.free_count, body.inertia_points
    psi = body.inertia_basis[:, :k]
    left = (field(points).ravel() - psi @ found).reshape(len(points), -1)
    weighted = (body.inertia_mass @ left).ravel() if body.is_exact else body.inertia_mass @ left.ravel()
    np.testing.assert_allclose(psi.T @ weighted, 0.0, atol=1e-10 * np.abs(psi.T).max() * body.mass)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"displacement": np.zeros((2, 3))}, "displacement of body 'body' must be finite and of shape"),
        ({"velocity": lambda x: x[:, 0]}, "velocity of body 'body' must be .*for which the function is called"),
        ({"velocity": lambda x: x, "modal_speeds": []}, "Remedy: one of them"),
    ],
)
def test_a_field_that_is_none_is_refused(given, words):
    with pytest.raises(kf.ModelError, match=words):
        added(lattice_body(0), **given)
