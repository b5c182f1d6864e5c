"""A strip that bends far, by every kind of body that kanefe has for it: a link that slews, and an elastica."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.run import integrate
from kanefe.result import Result
from kanefe.scene.scene import Frame
from kanefe_fem import Material, Rectangle, beam_body, exact_beam, segmented, straight_beam

LENGTH, THICKNESS, WIDTH = 1.0, 0.001, 0.02
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = Rectangle(THICKNESS, WIDTH)
AREA, SECOND = THICKNESS * WIDTH, WIDTH * THICKNESS**3 / 12.0
BENDING, STRETCHING = STEEL.E * SECOND, STEEL.E * AREA
LINE_MASS, LINE_INERTIA = STEEL.rho * AREA, STEEL.rho * SECOND

ANGLE, SLEWED, END = 0.5 * np.pi, 1.0, 1.5
"""Angle of the motor, rad; when it has come to rest and when the run ends, s."""

TIMES = np.linspace(0.0, END, 31)[1:]
FINE = 64
"""Elements of bodies that are not cut; chains have the next multiple of their segments below, or one a segment."""

ENDS = {"root": "clamped", "tip": "rigid"}
NAME = "strip"


@dataclass(frozen=True)
class Kind:
    """A kind of body.

    Attributes
    ----------
    name : str
    sizes : tuple of int
        Normal modes, segments, or functions of the curvature.
    methods : tuple of str
        Methods of integration that are tried.
    stiffening : str
    """

    name: str
    sizes: tuple[int, ...]
    methods: tuple[str, ...] = ("radau5", "generalised-alpha")
    stiffening: Any = "none"


EXPLICIT = ("radau5", "generalised-alpha", "dop853")
LINEAR = Kind("linear", (0, 2, 4), EXPLICIT)
INERTIAL = Kind("linear, stiffening inertial", (0, 2, 4), EXPLICIT, "inertial")
FULL = Kind("linear, stiffening full", (0, 2, 4), EXPLICIT, "full")
SEGMENTS = Kind("segments", (2, 4, 8, 16, 32))
STIFF_SEGMENTS = Kind("segments, stiffening full", (2, 4, 8, 16, 32), stiffening="full")
IECS = Kind("IECS: one element a segment", (2, 4, 8, 16, 32))
LEGENDRE = Kind("exact, Legendre", (2, 3, 4, 5, 6, 8, 10), EXPLICIT)
SPLINES = Kind("exact, B-splines", (4, 5, 6, 8, 10, 14), EXPLICIT)
KINDS = (LINEAR, INERTIAL, FULL, SEGMENTS, STIFF_SEGMENTS, IECS, LEGENDRE, SPLINES)

DEGREE, FINE_DEGREE = 3, 5
"""Of splines; of those of the reference."""


def basis(kind: Kind, size: int, degree: int = DEGREE) -> Any:
    """Return so many functions of the curvature."""
    return kf.BSpline(degree, size - degree) if kind is SPLINES else size


def added(scene: kf.System, kind: Kind, size: int, degree: int = DEGREE, **place: Any) -> tuple[Frame, int]:
    """Add the strip to a scene; return its tip and the number of its coordinates."""
    if kind in (LEGENDRE, SPLINES):
        exact = exact_beam(LENGTH, SECTION, STEEL, planar=True, basis=basis(kind, size, degree))
        return scene.add_flexible_body(NAME, exact, **place).interface("tip"), exact.free_count
    is_whole = kind in (LINEAR, INERTIAL, FULL)
    elements = FINE if is_whole else size if kind is IECS else size * max(2, FINE // size)
    beam = straight_beam(LENGTH, SECTION, STEEL, elements=elements, planar=True, theory="euler-bernoulli")
    if is_whole:
        body = beam_body(beam, ENDS, reduction=kf.CraigBampton(modes=size), stiffening=kind.stiffening)
        return scene.add_flexible_body(NAME, body, **place).interface("tip"), body.free_count
    chain = segmented(beam, ENDS, segments=size, stiffening=kind.stiffening)
    count = sum(segment.body.free_count for segment in chain.segments)
    return scene.add_segmented_body(NAME, chain, **place).interface("tip"), count


@cache
def slew(angle: float) -> kf.Motion:
    """Return a turn by an angle within SLEWED, whose acceleration has no kink."""

    def position(t: float) -> float:
        x = min(t / SLEWED, 1.0)
        return angle * x**4 * (35.0 - 84.0 * x + 70.0 * x**2 - 20.0 * x**3)

    def speed(t: float) -> float:
        x = min(t / SLEWED, 1.0)
        return angle / SLEWED * 140.0 * x**3 * (1.0 - x) ** 3

    def acceleration(t: float) -> float:
        x = min(t / SLEWED, 1.0)
        return angle / SLEWED**2 * 420.0 * x**2 * (1.0 - x) ** 2 * (1.0 - 2.0 * x)

    return kf.Motion(position, speed, acceleration).compiled()


def link(kind: Kind, size: int, angle: float = ANGLE, degree: int = DEGREE) -> tuple[Model, int]:
    """Return the strip on a motor that slews it, and the number of coordinates."""
    scene = kf.System()
    _, count = added(scene, kind, size, degree, joint=kf.Revolute("z", motion=slew(angle)))
    return scene.freeze(), count


def run(model: Model, method: str, rtol: float) -> tuple[np.ndarray, float]:
    """Return x, y and angle of the tip at TIMES, (n, 3), and the CPU time of the run, s."""
    with warnings.catch_warnings():  # of bodies that bend beyond their range, and of few functions: the error tells
        warnings.simplefilter("ignore")
        start = time.process_time()
        found = integrate(model, (0.0, END), method=method, rtol=rtol, output_times=TIMES, progress=False)
        seconds = time.process_time() - start
        result = Result(model, found)
        result.raise_for_status()
    real, *_, imaginary = result.rotation(NAME, "tip").T
    return np.column_stack((result.position(NAME, "tip")[:, :2], 2.0 * np.arctan2(imaginary, real))), seconds


def turned(tip: np.ndarray, angle: float = ANGLE) -> float:
    """Return by how much the tip turns against the root at most, rad."""
    root = np.array([slew(angle).position(t) for t in TIMES])
    return float(np.abs((tip[:, 2] - root + np.pi) % (2.0 * np.pi) - np.pi).max())


def elastica(kind: Kind, size: int, load: float) -> tuple[Model, int]:
    """Return the strip clamped under a dead load across its tip, P L^2 / EI, and the number of coordinates."""
    scene = kf.System()
    tip, count = added(scene, kind, size)
    scene.add_force(tip, (0.0, load * BENDING / LENGTH**2, 0.0))
    with warnings.catch_warnings():  # of stiffening by inertia alone
        warnings.simplefilter("ignore")
        return scene.freeze(), count


def rest(model: Model) -> tuple[np.ndarray, float]:
    """Return the place of the tip at rest, (2,), and the CPU time of the search, s."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        start = time.process_time()
        found = kf.equilibrium(model)
        seconds = time.process_time() - start
        x, y = found.deflection(NAME, "tip")[:2]
    return np.array([LENGTH + x, y]), seconds


def shot(load: float) -> np.ndarray:
    """Return the tip of the inextensible elastica (2,), by shooting with the bending moment at the root."""

    def curve(moment: float) -> np.ndarray:
        def slopes(s: float, y: np.ndarray) -> list[float]:
            return [y[1], -load * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

        return np.asarray(solve_ivp(slopes, (0.0, 1.0), [0.0, moment, 0.0, 0.0], "DOP853", rtol=1e-13, atol=1e-14).y)

    # the arm of the load is at least 0 and at most 1
    root = brentq(lambda moment: curve(moment)[1, -1], 1e-3, min(load, np.sqrt(2.0 * load)), xtol=1e-14)
    return LENGTH * curve(root)[2:, -1]
