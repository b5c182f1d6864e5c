"""Motion of sections: derivatives against differences, shapes and inertia against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kanefe as kf
import kanefe_fem as fem
from exact_lines import random_beam
from kanefe.bodies.exact.beam_line import BeamLine
from kanefe.bodies.exact.doubt import doubt
from kanefe.frames import skew

STEP = 1e-5
"""Of central differences: they err by 1e-10 of the third derivatives, and round-off is 1e-11."""

ROUND = fem.Section.from_stiffness(EA=1.0, GA_y=1.0, GA_z=1.0, GJ=1.0, EI_y=1.0, EI_z=1.0, rho_A=2.0, rho_I=(0.3, 0.5))


@pytest.mark.parametrize(
    ("theory", "basis"),
    [
        ("shear-deformable", "mixed"),
        ("shear-deformable", "splines"),
        ("stretching", "numbers"),
        ("shear-rigid", "mixed"),
    ],
)
def test_motion_is_that_of_the_map(theory: str, basis: str) -> None:
    line = random_beam(1, theory, basis).line
    q, u = 0.3 * np.random.default_rng(2).normal(size=(2, line.count))
    now, later, before = line.motion(q, u), line.motion(q + STEP * u, u), line.motion(q - STEP * u, u)

    def rate(what: str) -> np.ndarray:
        return np.asarray((getattr(later, what) - getattr(before, what)) / (2.0 * STEP))

    np.testing.assert_allclose(rate("p"), now.v, rtol=0, atol=1e-9)
    np.testing.assert_allclose(rate("v"), now.z, rtol=0, atol=1e-9)
    np.testing.assert_allclose(rate("w"), now.y, rtol=0, atol=1e-9)
    for turned, A, w in zip(rate("A"), now.A, now.w, strict=True):
        np.testing.assert_allclose(turned @ A.T, skew(w), rtol=0, atol=1e-9)
    # to round-off: sums of some hundred terms of size one
    np.testing.assert_allclose(now.V @ u, now.v, rtol=0, atol=1e-13)
    np.testing.assert_allclose(now.W @ u, now.w, rtol=0, atol=1e-13)
    np.testing.assert_allclose(now.A @ now.A.swapaxes(1, 2), np.broadcast_to(np.eye(3), now.A.shape), atol=1e-13)


def test_constant_curvature_is_a_circle() -> None:
    """7 Gauss points err by 4e-12 at the end of an arc of 3.4 radians, and their polynomial by 1e-5 within."""
    beam = fem.exact_beam(2.0, ROUND, planar=True, basis=3)
    bend = np.array((1.7, 0.0, 0.0))
    found = beam.line.motion(bend, np.zeros(3))
    s = beam.nodes[:, 0]
    circle = np.column_stack((np.sin(1.7 * s), 1.0 - np.cos(1.7 * s), 0.0 * s)) / 1.7
    np.testing.assert_allclose(found.p[-1], circle[-1], rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.p, circle, rtol=0, atol=2e-5)


def test_constant_twist_and_curvature_are_a_helix() -> None:
    """The axis turns about ``kappa`` at a constant rate."""
    beam = fem.exact_beam(2.0, ROUND, basis=3, curvature=(0.4, 0.0, 0.0))
    kappa = np.array((0.4 + 0.5, -0.3, 1.1))
    found = beam.line.motion(np.array((0.5, 0.0, 0.0, -0.3, 0.0, 0.0, 1.1, 0.0, 0.0)), np.zeros(9))
    s, rate = 2.0, np.linalg.norm(kappa)
    n = kappa / rate
    along, across = n * n[0], np.array((1.0, 0.0, 0.0)) - n * n[0]
    turned = np.sin(rate * s) * across + (1.0 - np.cos(rate * s)) * np.cross(n, across)
    np.testing.assert_allclose(found.p[-1], s * along + turned / rate, rtol=0, atol=1e-11)
    # a rotation by a constant curvature is exact
    one = np.eye(3) + np.sin(2.0 * rate) * skew(n) + (1.0 - np.cos(2.0 * rate)) * skew(n) @ skew(n)
    np.testing.assert_allclose(found.A[-1], one, rtol=0, atol=1e-14)


def test_angles_in_a_plane_are_integrals_of_the_curvature() -> None:
    """However high the degree: the vectors of the Magnus expansion are exact moments."""
    beam = fem.exact_beam(1.0, ROUND, planar=True, basis=12)
    q = 2.0 * np.random.default_rng(0).normal(size=12)
    found = beam.line.motion(q, np.zeros(12))
    angle = q[0]  # of Legendre polynomials only the first has an integral
    np.testing.assert_allclose(found.A[-1, :2, 0], (np.cos(angle), np.sin(angle)), rtol=0, atol=1e-14)


def test_a_line_in_space_solves_its_equations() -> None:
    """A' = A kappa~, p' = A e_x, integrated independently, turn by two radians; steps of half the size err by 2^-6."""
    q = np.array((0.2, 0.1, 0.05, -0.3, 0.2, 0.1, 0.5, -0.1, 0.1))

    def slope(s: float, y: np.ndarray) -> np.ndarray:
        A = y[3:].reshape(3, 3)
        values = kf.Legendre(3).values(np.array([s / 2.0]))[0]
        kappa = np.array((0.3, 0.5 * s, 0.4)) + q.reshape(3, 3) @ values
        return np.concatenate((A[:, 0], (A @ skew(kappa)).ravel()))

    start = np.concatenate((np.zeros(3), np.eye(3).ravel()))
    end = solve_ivp(slope, (0.0, 2.0), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    errors = []
    for places in ({"tip": 2.0}, {"middle": 1.0, "tip": 2.0}):
        beam = fem.exact_beam(2.0, ROUND, basis=3, curvature=lambda s: (0.3, 0.5 * s, 0.4), interfaces=places)
        found = beam.line.motion(q, np.zeros(9))
        errors.append(np.abs(np.concatenate((found.p[-1], found.A[-1].ravel())) - end).max())
    assert errors[0] < 1e-6
    assert errors[1] < errors[0] / 32.0


@pytest.mark.parametrize("turns", [2.0, 4.0])
def test_the_error_of_turns_is_told(turns: float) -> None:
    """A curve in space of several turns, by long steps: its last functions are zero, and places have 12 points."""
    q = np.zeros(24)
    q[:2], q[8:10], q[16:18] = (2.0, 1.5), (0.7 * turns, 2.0), (turns * np.pi, -3.0)

    def of(pieces: int) -> BeamLine:
        places = {f"at {i}": 2.0 * i / pieces for i in range(1, pieces)} | {"tip": 2.0}
        return fem.exact_beam(2.0, ROUND, basis=8, interfaces=places).line

    one, many = of(1), of(8)
    error = float(np.linalg.norm(one.motion(q, 0.0 * q).p[-1] - many.motion(q, 0.0 * q).p[-1]))
    assert error > 1e-6
    # that of half the steps is 2^-6 of it, so that their difference is nearly all; elsewhere it may be larger
    assert 0.9 * error < doubt(one, q) < 10.0 * error


def test_mass_and_inertia_of_a_rod() -> None:
    section = fem.Section.from_stiffness(
        EA=1, GJ=1, EI_y=1, EI_z=1, rho_A=2.0, rho_I=(0.3, 0.5), centre_of_mass=(0.1, -0.2)
    )
    body = fem.exact_beam(3.0, section, basis=4)
    assert body.mass == pytest.approx(6.0, rel=1e-14)
    centre = np.array((1.5, 0.1, -0.2))
    np.testing.assert_allclose(body.center_of_mass, centre, rtol=1e-14)
    own = np.diag((3.0 * 0.8, 6.0 * 9.0 / 12.0 + 3.0 * 0.3, 6.0 * 9.0 / 12.0 + 3.0 * 0.5))
    steiner = 6.0 * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    np.testing.assert_allclose(body.inertia, own + steiner, rtol=0, atol=1e-12)


def test_mass_and_inertia_of_an_arc_and_a_cone() -> None:
    arc = fem.exact_beam(np.pi, ROUND, basis=8, curvature=(0.0, 0.0, 1.0))
    assert arc.mass == pytest.approx(2.0 * np.pi, rel=1e-14)
    # half a circle of radius one: its centre of mass is 2/pi from the chord's middle
    np.testing.assert_allclose(arc.center_of_mass, (2.0 / np.pi, 1.0, 0.0), rtol=0, atol=1e-10)

    def cone(s: float) -> fem.Section:
        return fem.Section.from_stiffness(EA=1, GJ=1, EI_y=1, EI_z=1, rho_A=(1.0 - 0.5 * s) ** 2, rho_I=0.0)

    body = fem.exact_beam(1.0, cone, basis=2)
    assert body.mass == pytest.approx(7.0 / 12.0, rel=1e-14)
    assert body.center_of_mass[0] == pytest.approx(11.0 / 28.0, rel=1e-13)


def test_an_interface_within_is_where_the_axis_is() -> None:
    body = random_beam(3, "shear-deformable", "numbers")
    q = 0.3 * np.random.default_rng(1).normal(size=body.free_count)
    whole = body.line.motion(q, np.zeros_like(q))
    frame = body.interface("middle")
    moved, slopes = frame.moved(q)
    inner = frame.inner_motion(q, np.zeros_like(q), None)
    np.testing.assert_allclose(inner.p, frame.position + moved[:3], rtol=0, atol=1e-14)
    # the same beam, cut there, has the same place
    at = int(np.abs(whole.p - inner.p).sum(axis=1).argmin())
    np.testing.assert_allclose(whole.p[at], inner.p, rtol=0, atol=1e-14)
    along = np.linalg.norm(np.diff(body.nodes[: at + 1], axis=0), axis=1).sum()
    assert along == pytest.approx(0.5, abs=5e-3)  # chords of a curved line
    # and its twist and translation change as their derivatives tell
    h = 1e-6
    for i in range(len(q)):
        step = h * np.eye(len(q))[i]
        difference = (frame.moved(q + step)[0] - frame.moved(q - step)[0]) / (2.0 * h)
        np.testing.assert_allclose(slopes[:, i], difference, rtol=0, atol=1e-8)
