"""Cases of rotors: small motions about a steady spin, as modes in the frame that spins."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.equations.model import Model
from kanefe.joints import CoordinateForce, Motion, Prismatic, Revolute
from kanefe.linear import linearise
from kanefe.system import System

TOLERANCE = 1e-4

Rotor = Callable[[float], Model]
"""Spin (rad/s) -> the rotor in a frame that spins with it."""

MASS = 2.0
"""Of the point, kg: it drops out."""


def spin_eigenvalues(model: Model) -> np.ndarray:
    """Return those eigenvalues of a scene about its start, 1/s, whose real and imaginary parts are not negative.

    Of the four that belong to one motion of an undamped scene, ``+-a +- i b``, one is listed; lowest frequency first.
    """
    modes = linearise(model).modes()
    values = modes.eigenvalues
    return values[~modes.is_rigid & (values.real >= -1e-9 * np.abs(values).max())]


def asymmetric_rotor_checks(
    values: dict[str, dict[str, list[list[float]]]], rotor: Rotor, label: str
) -> Iterator[Check]:
    """Yield the checks of D04b for one kind of rotor."""
    spins = [float(spin) for spin in values["lam"]]
    expected = np.array([sorted(pairs, key=lambda pair: pair[1]) for pairs in values["lam"].values()])
    found = np.array([spin_eigenvalues(rotor(spin))[:2] for spin in spins])
    parts = np.stack((found.real, found.imag), axis=-1)
    of, whole = f"at {spins[0]:g} ... {spins[-1]:g} rad/s, {label}", expected != 0.0
    yield Check.relative(f"growth and whirl {of} [1/s]", parts[whole], expected[whole], TOLERANCE)
    rest = (parts / np.abs(found)[..., None])[~whole]
    yield Check.absolute(f"parts that vanish, over the modulus, {of}", rest, np.zeros(len(rest)), TOLERANCE)
    swept = np.arange(80.5, 140.0)
    grows = [spin_eigenvalues(rotor(spin))[:2].real.max() > 1e-3 for spin in swept]
    yield Check.absolute(
        f"whether the rotor is unstable at 80.5 ... 139.5 rad/s, {label}", grows, (swept > 100) & (swept < 120), 0.0
    )


def point_on_springs(spin: float) -> Model:
    """Return a point on two springs across each other, of 100 and 120 rad/s, on a shaft that spins about z."""
    scene = System()
    shaft = scene.add_frame("shaft", joint=Revolute("z", motion=Motion.steady(spin)))
    slide = scene.add_frame("slide", parent=shaft, joint=Prismatic("x", forces=CoordinateForce(MASS * 100.0**2)))
    scene.add_point("point", MASS, parent=slide, joint=Prismatic("y", forces=CoordinateForce(MASS * 120.0**2)))
    return scene.freeze()


def asymmetric_rotor(reference: Reference) -> Iterator[Check]:
    """D04b: two modes of different frequency across the axis of a spinning shaft."""
    yield from asymmetric_rotor_checks(reference.values, point_on_springs, "point on springs")


CASES = (Case("D04b", asymmetric_rotor),)
