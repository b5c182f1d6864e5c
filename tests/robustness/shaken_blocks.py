"""Blocks on shaken plates, rigid and with friction, against an exact solution by pieces that is made here.

Seen from the plate, with its accelerations A along it and a_n across it, the block moves by

    dw/dt = f(t) - mu n(t) w / |w|,    f = g_T - A,    n = g_n + a_n,

and stays where it is as long as |f| <= mu n. In one direction w is integrated in closed form, and its ends are roots;
in two a slip is integrated to 1e-12 from just after its start, where it has the direction of f, to just before its end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import follow
from kanefe.contact import Coulomb, Rigid
from kanefe.contact.shapes import Plane
from kanefe.frames import Vector, rotation_about
from kanefe.joints import Free, Motion, Prismatic
from kanefe.kernels.events.event_search import crossing_between
from kanefe.result import Result
from kanefe.storage.scipy_later import scipy
from kanefe.system import System

GRAVITY = 9.81

LOOKS = 4000
"""Number of samples of the run in which events are searched for; two events lie further apart than one sample."""

EARLY, LATE = 1e-5, 1e-9
"""Time after the start of a slip in two directions from which it is integrated (relative to 1 / frequency), and speed
down to which it is integrated (m/s): the remaining errors are the third power of the first, and the second divided by
the acceleration."""

DEFAULT_RTOL = 1e-6


@dataclass(frozen=True)
class Shaken:
    """A block at rest on a plate that is shaken in one or two directions.

    Attributes
    ----------
    strokes, frequencies, phases : tuple of 2 floats
        Along x and y, m, Hz and rad; the second stroke is zero where the plate moves in one direction.
    mu : float
    slope : float
        Angle about y by which the plate is inclined, rad.
    span : float
        s.
    rtol : float
    output_step : float
        s.
    """

    strokes: tuple[float, float]
    frequencies: tuple[float, float]
    phases: tuple[float, float]
    mu: float
    slope: float
    span: float
    rtol: float
    output_step: float

    def scene(self) -> System:
        """Return the scene: plate "plate", block "block", contact "c"."""
        scene = System(gravity=(0.0, 0.0, -GRAVITY))
        motions = [self._motion(i) for i in (0, 1)]
        plate = scene.add_rigid_body("carriage", 1.0, 1.0, joint=Prismatic("x", motion=motions[0]))
        if self.strokes[1]:
            plate = scene.add_rigid_body("plate", 1.0, 1.0, parent=plate, joint=Prismatic("y", motion=motions[1]))
        turned = rotation_about("y", self.slope)
        top = scene.add_surface("top", plate, Plane("z"), orientation=turned)
        start = Free(
            position=(motions[0].at("position", 0.0, "plate"), motions[1].at("position", 0.0, "plate"), 0.0),
            velocity=(motions[0].at("velocity", 0.0, "plate"), motions[1].at("velocity", 0.0, "plate"), 0.0),
        )
        block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
        scene.add_contact("c", block, top, normal=Rigid(), friction=Coulomb(self.mu))
        return scene

    def _motion(self, i: int) -> Motion:
        s, w, p = self.strokes[i], 2.0 * math.pi * self.frequencies[i], self.phases[i]
        return Motion(
            lambda t: s * math.sin(w * t + p),
            lambda t: s * w * math.cos(w * t + p),
            lambda t: -s * w * w * math.sin(w * t + p),
        )

    def plate(self, t: float, rate: int) -> Vector:
        """Return place (rate 0), velocity or acceleration (2) of the plate along x and y."""
        w = 2.0 * math.pi * np.array(self.frequencies)
        return np.array(self.strokes) * w**rate * np.sin(w * t + np.array(self.phases) + 0.5 * math.pi * rate)

    def pull(self, t: float) -> Vector:
        """Return f, along the slope and across it, m/s2."""
        a = self.plate(t, 2)
        return np.array((GRAVITY * math.sin(self.slope) - a[0] * math.cos(self.slope), -a[1]))

    def held(self, t: float) -> float:
        """Return mu n, m/s2."""
        n = GRAVITY * math.cos(self.slope) + float(self.plate(t, 2)[0]) * math.sin(self.slope)
        return self.mu * n


class Exact(NamedTuple):
    """What happens to a block.

    Attributes
    ----------
    slips, sticks : list of float
        Times, s.
    moved : ndarray, shape (2,)
        Way on the plate in the end, along the slope and across it, m.
    """

    slips: list[float]
    sticks: list[float]
    moved: Vector


def random_block(seed: int, cycles: float = 2.0) -> Shaken:
    """Return a block of which all numbers are random; on planes that it does not leave."""
    rng = np.random.default_rng(seed)
    mu, is_turning, is_inclined = rng.uniform(0.1, 0.8), bool(seed % 2), bool(seed // 2 % 2)
    slope = rng.uniform(0.1, 0.6) * math.atan(mu) if is_inclined else 0.0
    frequency = 10.0 ** rng.uniform(0.0, 1.7)
    w = 2.0 * math.pi * frequency
    strokes = rng.uniform(0.5, 3.0, 2) * mu * GRAVITY / w**2
    if slope:
        strokes[0] = min(strokes[0], 0.8 * GRAVITY / math.tan(slope) / w**2)
    span = rng.uniform(0.3, cycles) / frequency
    return Shaken(
        (float(strokes[0]), float(strokes[1]) * is_turning),
        (frequency, frequency * float(rng.choice((0.5, 1.0, 1.0)))),
        (float(rng.uniform(0.0, 2.0 * math.pi)), float(rng.uniform(0.0, 2.0 * math.pi))),
        float(mu),
        slope,
        float(span),
        float(rng.choice((DEFAULT_RTOL, 1e-7, 1e-8))),
        float(span / rng.integers(3, 60)),
    )


def exact(block: Shaken) -> Exact:
    """Return what the block does, by pieces."""
    found, t, moved = Exact([], [], np.zeros(2)), 0.0, np.zeros(2)
    slip_margin = _slip_margin(block)
    while t < block.span:
        if slip_margin(t) >= 0.0 or (t == 0.0 and slip_margin(0.0) > -1e-13):
            t = _first_fall(slip_margin, t, block.span)
            if t >= block.span:
                break
            found.slips.append(t)
        elif t == 0.0 or (found.sticks and t == found.sticks[-1]):
            if found.sticks:  # it turns round in no time
                found.sticks.pop()
            else:
                found.slips.append(t)
        slide = _slide_across if block.strokes[1] else _slide_along
        t, way = slide(block, t)
        moved += way
        if t < block.span:
            found.sticks.append(t)
    return Exact(found.slips, found.sticks, moved)


def _slip_margin(block: Shaken) -> Callable[[float], float]:
    return lambda t: block.held(t) - float(np.linalg.norm(block.pull(t)))


def _first_fall(f: Callable[[float], float], start: float, stop: float) -> float:
    """Return where a function that begins at zero or above falls below it; the end if it does not."""
    # what begins to slip at a root is on its falling side: the first sample tells
    times = np.linspace(start, stop, max(3, round(LOOKS * (stop - start)) if stop - start > 1.0 else LOOKS))
    for a, b in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
        if f(b) < 0.0:
            return crossing_between(lambda of, t: of(t), f, (a, max(f(a), 0.0)), (b, f(b)), 1e-15)
    return stop


def _slide_along(block: Shaken, start: float) -> tuple[float, Vector]:
    """Return when a slip in one direction ends, and its way: in closed form."""
    middle = 0.5 * EARLY / block.frequencies[0]
    way = math.copysign(1.0, float(block.pull(start + middle)[0]))
    c, s = math.cos(block.slope), math.sin(block.slope)
    # dw/dt = g sin - a cos - way mu (g cos + a sin), with a the acceleration of the plate
    constant, factor = GRAVITY * (s - way * block.mu * c), -(c + way * block.mu * s)
    place, speed = float(block.plate(start, 0)[0]), float(block.plate(start, 1)[0])

    def forward(t: float) -> float:
        return way * (constant * (t - start) + factor * (float(block.plate(t, 1)[0]) - speed))

    first = start + middle
    end = first if forward(first) <= 0.0 else _first_fall(forward, first, block.span)
    moved = float(block.plate(end, 0)[0]) - place - speed * (end - start)
    return end, np.array((0.5 * constant * (end - start) ** 2 + factor * moved, 0.0))


def _slide_across(block: Shaken, start: float) -> tuple[float, Vector]:
    """Return when a slip in two directions ends, and its way: by a method of order 8."""
    early = EARLY / max(block.frequencies)
    pull = block.pull(start + early)
    direction = pull / np.linalg.norm(pull)
    gained = [float(np.linalg.norm(block.pull(start + x))) - block.held(start + x) for x in (0.0, early)]
    speed = 0.5 * (max(gained[0], 0.0) + gained[1]) * early

    # in numbers: a slip that ends slowly takes tens of thousands of looks
    sx, sy = block.strokes
    wx, wy = (2.0 * math.pi * f for f in block.frequencies)
    px, py = block.phases
    c, s, mu = math.cos(block.slope), math.sin(block.slope), block.mu

    def rate(t: float, y: Vector) -> tuple[float, float, float, float]:
        ax, ay = -sx * wx * wx * math.sin(wx * t + px), -sy * wy * wy * math.sin(wy * t + py)
        u, v = float(y[2]), float(y[3])
        drag = mu * (GRAVITY * c + ax * s) / math.hypot(u, v)
        return u, v, GRAVITY * s - ax * c - drag * u, -ay - drag * v

    def left(t: float, y: Vector) -> float:
        return float(np.linalg.norm(y[2:])) - LATE

    left.terminal = True  # type: ignore[attr-defined]
    left.direction = -1  # type: ignore[attr-defined]
    y = np.concatenate((np.zeros(2), speed * direction))
    run = scipy.integrate.solve_ivp(
        rate, (start + early, block.span), y, method="DOP853", rtol=1e-12, atol=1e-14, events=left
    )
    t, y = float(run.t[-1]), run.y[:, -1]
    if run.status == 1:
        along = y[2:] / np.linalg.norm(y[2:])
        t += float(np.linalg.norm(y[2:])) / (block.held(t) - float(along @ block.pull(t)))
    return t, y[:2]


class Compared(NamedTuple):
    """How far a run is from the exact solution.

    Attributes
    ----------
    instants : float
        Largest error of an event, s; infinite where there is another number of them. That of an end of a slip counts
        by the deceleration there, at most 1 m/s2: when a slip ends that hardly slows down is known as well as speeds.
    drift : float
        Error of the way on the plate, m.
    friction : float
        Largest share of friction beyond mu N.
    """

    instants: float
    drift: float
    friction: float


def compared(block: Shaken) -> Compared:
    """Run a block, and compare it."""
    known = exact(block)
    model = block.scene().freeze()
    options = {} if block.rtol == DEFAULT_RTOL else {"rtol": block.rtol}
    result = Result(model, follow(model, block.span, output_step=block.output_step, **options))
    instants = 0.0
    for name, times in (("slip", known.slips), ("stick", known.sticks)):
        told = result.events[f"c {name}"]
        times = [t for t in times if t > 0.0]
        if len(told) != len(times):
            instants = math.inf
            continue
        slowing = [min(_slip_margin(block)(t), 1.0) if name == "stick" else 1.0 for t in times]
        instants = max(instants, float(np.abs((told - times) * slowing).max(initial=0.0)))
    off = result.position("block")[-1] - np.append(block.plate(block.span, 0), 0.0)
    along = np.array((math.cos(block.slope), 0.0, -math.sin(block.slope)))
    drift = float(np.hypot(along @ off - known.moved[0], off[1] - known.moved[1]))
    history = result.contact("c")
    excess = np.array(history.tangential) / (block.mu * np.array(history.normal)) - 1.0
    return Compared(instants, drift, float(excess.max()))


def shaken(effort: Effort) -> Iterator[Finding]:
    """Compare random blocks with the exact solution."""
    count = effort.count(10, 2)
    found = [(block, compared(block)) for block in map(random_block, range(count))]
    what = "blocks on shaken plates, at random"
    late = max(one.instants / (1e-4 if block.rtol == DEFAULT_RTOL else 1e-6) for block, one in found)
    yield Finding(what, count, "instants, of 1e-4 s by default and 1e-6 s below", late, 1.0, "exact by pieces")
    yield Finding(what, count, "way on the plate, error [m]", max(one.drift for _, one in found), 1e-6, "exact")
    beyond = max(one.friction for _, one in found)
    yield Finding(what, count, "friction beyond mu N, relative", beyond, 1e-6, "Coulomb's law")


CASES = (StressCase("shaken-blocks", "stick and slip on plates shaken in one and two directions", shaken),)
