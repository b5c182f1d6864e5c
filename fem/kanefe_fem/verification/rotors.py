"""Shafts of beams in a frame that spins with them."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import scipy.linalg

from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.rotors import TOLERANCE, asymmetric_rotor_checks, spin_eigenvalues
from kanefe.equations.model import Model
from kanefe.fe_model.interface import Interface
from kanefe.joints import Motion, Revolute
from kanefe.reduction import CraigBampton
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, beam_model, straight_beam
from kanefe_fem.beams.sections import Rectangle, SolidCircle
from kanefe_fem.materials.isotropic import Material

YOUNG, DENSITY, DIAMETER, LENGTH = 210e9, 7850.0, 0.05, 1.0
"""Round shaft of D04a: Young's modulus, Pa; density, kg/m3; diameter and length, m."""

SLICES = 12
"""Number of slices of the round shaft: errors decrease with their fourth power, and are 6e-6 for the third pair of
modes."""


def rayleigh_shaft(spin: float) -> Model:
    """Return a simply supported round shaft in a frame that spins with it.

    Half of its mass is in Bernoulli beams; the other half and all rotary inertia is in rigid slices on them, which
    rotate by finite angles. The field of a flexible body is of first order in its coordinates and neglects the change
    of the moment of inertia of a tilted section about the axis, a stiffness of rho I k^2 Omega^2. With the rotary
    inertia in the beams the slowest whirl at 500 rad/s would be 0.2 % too low.
    """
    places = np.linspace(0.0, LENGTH, 2 * SLICES + 1)
    nodes = np.column_stack((places, np.zeros((len(places), 2))))
    names = [f"slice {i}" for i in range(SLICES + 1)]
    bending = Interface(fixed=("x", "rx"))
    supports = dict.fromkeys((names[0], names[-1]), Interface(fixed=("x", "y", "z", "rx")))
    beams = beam_model(
        nodes,
        [(i, i + 1) for i in range(2 * SLICES)],
        SolidCircle(DIAMETER),
        Material(E=YOUNG, nu=0.3, rho=0.5 * DENSITY),
        theory="euler-bernoulli",
        rotary_inertia=False,
        groups={name: 2 * i for i, name in enumerate(names)},
    )
    body = beam_body(beams, dict.fromkeys(names, bending) | supports, reduction=CraigBampton(modes=4))
    scene = System()
    shaft = scene.add_flexible_body("shaft", body, joint=Revolute("x", motion=Motion.steady(spin)))
    area, second_moment = math.pi * DIAMETER**2 / 4, math.pi * DIAMETER**4 / 64
    for name in names:
        volume_share = LENGTH / SLICES * (0.5 if name in supports else 1.0)
        J = DENSITY * second_moment * volume_share
        scene.add_rigid_body(name, 0.5 * DENSITY * area * volume_share, (2 * J, J, J), parent=shaft.interface(name))
    return scene.freeze()


def whirling_shaft(reference: Reference) -> Iterator[Check]:
    """D04a: whirl of a spinning Rayleigh shaft in the frame that spins with it, and critical speeds."""
    for spin, pairs in reference.values["whirl"].items():
        expected = np.sort(np.concatenate([pair["rotframe"] for pair in pairs]))
        found = spin_eigenvalues(rayleigh_shaft(float(spin)))[: len(expected)].imag
        quantity = f"whirl in the spinning frame at {float(spin):g} rad/s, {SLICES} slices [rad/s]"
        yield Check.relative(quantity, found, expected, TOLERANCE)
    critical = np.array(reference.values["critical"])
    found = critical_speeds(rayleigh_shaft(0.0), rayleigh_shaft(500.0), 500.0)[: 2 * len(critical)]
    yield Check.relative(f"critical speeds, {SLICES} slices [rad/s]", found, np.repeat(critical, 2), TOLERANCE)


def critical_speeds(still: Model, spinning: Model, spin: float) -> np.ndarray:
    """Return the speeds at which a shaft has no stiffness in the frame that spins with it, rad/s, lowest first.

    The derivative of the accelerations is ``-M^-1 (K - spin^2 N)``, whose two parts follow from two speeds.
    """
    n = still.free_count
    rest, moved = (model.jacobian(0.0, model.initial_state)[n:, :n] for model in (still, spinning))
    squares = scipy.linalg.eig(-rest, (moved - rest) / spin**2, right=False)
    real = squares[np.isfinite(squares) & (np.abs(squares.imag) < 1e-6 * np.abs(squares))].real
    return np.sqrt(np.sort(real[real > 0.0]))


def flat_shaft(spin: float) -> Model:
    """Return a simply supported shaft, 1.2 times as wide as thick, with first modes at 100 and 120 rad/s."""
    steel = Material(E=YOUNG, nu=0.3, rho=DENSITY)
    thickness = 100.0 * math.sqrt(12.0 * DENSITY / YOUNG) / math.pi**2  # of a shaft of 1 m
    section = Rectangle(width=thickness, height=1.2 * thickness)
    beams = straight_beam(1.0, section, steel, elements=16, theory="euler-bernoulli", rotary_inertia=False)
    supports = {"root": Interface(fixed=("x", "y", "z", "rx")), "tip": Interface(fixed=("x", "y", "z", "rx"))}
    scene = System()
    shaft = beam_body(beams, supports, reduction=CraigBampton(modes=8))
    scene.add_flexible_body("shaft", shaft, joint=Revolute("x", motion=Motion.steady(spin)))
    return scene.freeze()


def asymmetric_shaft(reference: Reference) -> Iterator[Check]:
    """D04b: the two modes are those of a flat shaft in the two planes."""
    yield from asymmetric_rotor_checks(reference.values, flat_shaft, "flat shaft of 16 elements")


CASES = (Case("D04a", whirling_shaft), Case("D04b", asymmetric_shaft))
