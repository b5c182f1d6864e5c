"""Exact beams as bodies: free flight, frequencies, linearisation about a bent state, and a frame of planar pieces."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import kanefe as kf
import kanefe_fem as fem
from kanefe.bodies.exact.beam import ExactBeam
from kanefe.frames import rotation_about

SLENDER = fem.Section.from_stiffness(EA=1e4, GA_y=1e4, GA_z=1e4, EI_y=50.0, EI_z=60.0, GJ=40.0, rho_A=1.0, rho_I=0.1)


@pytest.mark.parametrize("steps", [2000, pytest.param(100_000, marks=pytest.mark.stress)])
def test_free_flight_keeps_energy_and_momenta(steps: int) -> None:
    """By the method energy-momentum; generalised-alpha loses a tenth of both within 2000 steps."""
    beam = fem.exact_beam(3.0, SLENDER, basis=4)
    scene = kf.System()
    eta = 0.3 * np.random.default_rng(0).normal(size=12) / (1.0 + np.arange(12) % 4) ** 2
    joint = kf.Free(velocity=(1.0, 0.3, -0.2), angular_velocity=(0.7, 1.5, -0.4))
    scene.add_flexible_body("beam", beam, joint=joint, modal_coordinates=eta)
    run = scene.simulate(
        (0.0, 0.02 * steps), method="energy-momentum", step=0.02, output_step=0.001 * steps, progress=False
    )
    energy = run.energy
    assert np.ptp(energy.elastic) > 0.1 * energy.total[0]  # it does swing
    # 1e5 steps: 1e-8 is asked for; round-off and the tolerance of the iteration leave some 1e-12
    assert np.ptp(energy.total) < 1e-10 * energy.total[0]
    for momentum in (run.momentum.linear, run.momentum.angular):
        assert np.ptp(momentum, axis=0).max() < 1e-10 * np.linalg.norm(momentum[0])


def bernoulli_roots(is_clamped: bool, count: int) -> list[float]:
    """Return the roots of cos x cosh x = -1 (clamped) or 1 (free): wave numbers times the length."""
    sign = 1.0 if is_clamped else -1.0

    def f(x: float) -> float:
        return float(np.cos(x) + sign / np.cosh(x))

    shift = 0.0 if is_clamped else 1.0
    return [brentq(f, (i + shift) * np.pi, (i + 1.0 + shift) * np.pi) for i in range(count)]


@pytest.mark.parametrize("is_clamped", [True, False])
def test_frequencies_of_bending(is_clamped: bool) -> None:
    """Euler and Bernoulli's: no shear, no rotary inertia. With 10 functions the third of the free beam errs by 2e-5."""
    section = fem.Section.from_stiffness(EA=1.0, EI_z=2.0, rho_A=0.5, rho_I=0.0)
    beam = fem.exact_beam(3.0, section, planar=True, basis=15)
    scene = kf.System()
    scene.add_flexible_body("beam", beam, joint=kf.Fixed() if is_clamped else kf.Planar())
    found = np.sort(kf.linearise(scene).modes().frequencies)
    found = 2.0 * np.pi * found[found > 1e-3][:3]
    expected = [root**2 * np.sqrt(2.0 / 0.5) / 9.0 for root in bernoulli_roots(is_clamped, 3)]
    np.testing.assert_allclose(found, expected, rtol=1e-8)


def test_frequencies_of_stretch_and_twist() -> None:
    """Rods clamped at one end: odd multiples of a quarter wave."""
    section = fem.Section.from_stiffness(EA=300.0, GJ=2.0, EI_y=1e-3, EI_z=1e-3, rho_A=0.5, rho_I=(0.02, 0.03))
    beam = fem.exact_beam(3.0, section, theory="stretching", basis=12)
    scene = kf.System()
    scene.add_flexible_body("beam", beam)
    found = 2.0 * np.pi * np.sort(kf.linearise(scene).modes().frequencies)
    for speed in (np.sqrt(300.0 / 0.5), np.sqrt(2.0 / 0.05)):
        for i in range(3):
            omega = (i + 0.5) * np.pi * speed / 3.0
            assert np.abs(found / omega - 1.0).min() < 1e-8


def test_linearisation_about_a_bent_state() -> None:
    """Against differences of the rates, at a rest that is bent by a dead force to 0.8 radians."""
    beam = fem.exact_beam(3.0, SLENDER, theory="shear-deformable", basis=4)
    scene = kf.System()
    tip = scene.add_flexible_body("beam", beam).interface("tip")
    scene.add_force(tip, (0.0, 8.0, 5.0))
    rest = kf.equilibrium(scene)
    assert abs(rest.position("beam", "tip")[1]) > 0.3 * 3.0
    model = rest.model
    found, h = rest.linearise(), 1e-5
    y = model.initial_state.copy()
    y[: len(rest.modal_coordinates("beam"))] = rest.modal_coordinates("beam")
    A = np.empty((len(y), len(y)))
    for i, step in enumerate(h * np.eye(len(y))):
        A[:, i] = (model.rhs(0.0, y + step) - model.rhs(0.0, y - step))[: len(y)] / (2.0 * h)
    # third derivatives times 1e-10, and round-off of rates of the size of A over 1e-5
    np.testing.assert_allclose(found.A, A, rtol=0, atol=1e-7 * np.abs(A).max())


def frame_of_lee(load: float) -> kf.System:
    """Return Lee's frame: two legs of 120, hinged at both far ends; the load is at 24 from the corner on the beam."""
    A, inertia, E, nu = 6.0, 2.0, 7.2e6, 0.3
    GA = 5.0 / 6.0 * E / (2.0 * (1.0 + nu)) * A
    section = fem.Section.from_stiffness(EA=E * A, GA_y=GA, EI_z=E * inertia, rho_A=1.0)

    def piece(length: float) -> ExactBeam:
        return fem.exact_beam(length, section, theory="shear-deformable", planar=True, basis=6)

    scene = kf.System()
    up = rotation_about("z", 0.5 * np.pi)
    column = scene.add_flexible_body("column", piece(120.0), joint=kf.Revolute("z"), orientation=up)
    short = scene.add_flexible_body(
        "short", piece(24.0), parent=column.interface("tip"), orientation=rotation_about("z", -0.5 * np.pi)
    )
    long = scene.add_flexible_body("long", piece(96.0), parent=short.interface("tip"))
    scene.add_loop_joint("pin", kf.Revolute("z"), scene.ground.frame(at=(120.0, 120.0, 0.0)), long.interface("tip"))
    scene.add_force(short.interface("tip"), (0.0, -load, 0.0))
    return scene


def test_lees_frame_under_a_small_load_is_that_of_beam_theory() -> None:
    """The pieces are joined at the corner and at the load; the pins are a joint of the tree and a loop joint."""
    load = 0.1
    rest = kf.equilibrium(frame_of_lee(load))
    sag = -(rest.position("short", "tip")[1] - 120.0)
    assert sag == pytest.approx(load * linear_sag(), rel=1e-5)  # second order: over the limit load of 18,500
    more = kf.equilibrium(frame_of_lee(2000.0))
    assert -(more.position("short", "tip")[1] - 120.0) > 1.05 * 2000.0 * linear_sag()  # it softens


def linear_sag() -> float:
    """Return the sag under a unit load by virtual work: one redundant, the horizontal force H of the pins."""
    a, b, L = 24.0, 96.0, 120.0
    E, A, inertia = 7.2e6, 6.0, 2.0
    GA = 5.0 / 6.0 * E / 2.6 * A
    x, w = np.polynomial.legendre.leggauss(8)

    def along(start: float, end: float):
        return 0.5 * (end - start) * (x + 1.0) + start, 0.5 * (end - start) * w

    def integral(one, other) -> float:
        """Virtual work of moments, axial and shear forces of two states."""
        total = 0.0
        for part, (start, end) in (("column", (0.0, L)), ("short", (0.0, a)), ("long", (a, L))):
            s, weights = along(start, end)
            M1, N1, V1 = one(part, s)
            M2, N2, V2 = other(part, s)
            total += float(np.sum(weights * (M1 * M2 / (E * inertia) + N1 * N2 / (E * A) + V1 * V2 / GA)))
        return total

    def by_load(part, s):
        """Simply supported beam on a column that only carries its share; no horizontal force."""
        zero = 0.0 * s
        if part == "column":
            return zero, zero - b / L, zero
        return (b / L * s, zero, zero + b / L) if part == "short" else (a / L * (L - s), zero, zero - a / L)

    def by_push(part, s):
        """Unit horizontal forces at the pins: a moment in the column, which falls to zero along the beam."""
        zero = 0.0 * s
        if part == "column":
            return -s, zero - 1.0, zero - 1.0
        return -(L - s), zero - 1.0, zero + 1.0

    force = -integral(by_load, by_push) / integral(by_push, by_push)
    return integral(by_load, by_load) + force * integral(by_load, by_push)
