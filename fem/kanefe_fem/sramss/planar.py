"""SRAMSS-2D: airframe, gear and deck in the ship's transverse plane, with x to port and y up.

Rotations are about z here, the ship's longitudinal axis: port side up is positive.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple, Unpack

import numpy as np
from scipy.optimize import brentq

from kanefe.contact import Coulomb, HuntCrossley
from kanefe.contact.shapes import Plane
from kanefe.errors import ModelError
from kanefe.joints import Motion, Planar, Revolute
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe.linear.equilibrium.rest import Equilibrium
from kanefe.loads import Rope
from kanefe.system import System
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.gear import SKIDS, GearKeywords, Saddles, gear_body

STEPS_A_SECOND = 500
"""Samples per second in the table of the deck's motion: the relative error of its accelerations is 1e-6."""

SIDES = {"starboard": -1.0, "port": 1.0}

Held = Literal["smooth", "pinned", "rough"]


class Deck(NamedTuple):
    """Roll of the deck: ``tilt + amplitude s(t / rise) sin(2 pi t / period)``, ``s = 10x^3 - 15x^4 + 6x^5`` to x = 1.

    Attributes
    ----------
    amplitude, tilt : float
        Angles in rad.
    period, rise, span : float
        Times in s; `span` is the duration of the motion.
    """

    amplitude: float = 0.0
    tilt: float = 0.0
    period: float = 10.0
    rise: float = 10.0
    span: float = 30.0

    def angle(self, t: np.ndarray) -> np.ndarray:
        """Return the angle at times t (s), rad."""
        x = np.clip(t / self.rise, 0.0, 1.0)
        s = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
        return np.asarray(self.tilt + self.amplitude * s * np.sin(2.0 * math.pi * t / self.period))

    def motion(self) -> Motion:
        """Return the motion of the deck's joint."""
        if self.amplitude == 0.0:
            return Motion.steady(0.0, self.tilt)
        times = np.linspace(0.0, self.span, round(STEPS_A_SECOND * self.span) + 1)
        return Motion.table(times.tolist(), self.angle(times).tolist())


LEVEL = Deck()


def planar_scene(
    deck: Deck = LEVEL,
    *,
    skids: Held = "smooth",
    half_track: float = 0.0,
    mu: float = 0.3,
    lashed: float = 0.0,
    start: tuple[float, float, float] | None = None,
    velocity: float = 0.0,
    lift: float = 0.0,
    **gear: Unpack[GearKeywords],
) -> System:
    """Return the aircraft on the deck.

    Parameters
    ----------
    deck : Deck
    skids : {"smooth", "pinned", "rough"}
        Without friction; held across the deck by springs and dampers; or with Coulomb friction.
    half_track : float
        Distance from the middle of the deck at which the springs of pinned skids are unloaded, m.
    mu : float
        Coefficient of friction of rough skids.
    lashed : float
        Unstretched length of the lashings from the saddles to the deck, m; zero for none.
    start : (float, float, float), optional
        x and y (m) and the angle (rad) of the airframe. Default: the undeformed skids touch the deck.
    velocity : float
        Downward speed of the whole aircraft at the start, m/s.
    lift : float
        Upward force at the airframe's centre of mass, N.
    **gear
        saddles, damping and is_planar, as for `gear_body`.
    """
    if skids not in ("smooth", "pinned", "rough"):
        raise ModelError(f"skids are 'smooth', 'pinned' or 'rough', not {skids!r}")
    scene = System(gravity=(0.0, -given.GRAVITY, 0.0))
    on_deck = scene.add_frame("deck", joint=Revolute("z", motion=deck.motion()))
    x, y, angle = (0.0, given.DECK_HEIGHT + given.CG_HEIGHT, 0.0) if start is None else start
    airframe = scene.add_rigid_body(
        "airframe",
        given.AIRFRAME_MASS,
        given.AIRFRAME_INERTIA,
        joint=Planar(position=(x, y), angle=angle, velocity=(0.0, -velocity)),
    )
    body = gear_body(**gear)
    member = scene.add_flexible_body("gear", body, parent=airframe)
    surface = scene.add_surface("deck", on_deck, Plane("y"), at=(0.0, given.DECK_HEIGHT, 0.0))
    normal = HuntCrossley(given.NORMAL_STIFFNESS, given.NORMAL_DAMPING)
    friction = Coulomb(mu, stiffness=given.TANGENTIAL_STIFFNESS, damping=given.TANGENTIAL_DAMPING)
    for side, sign in SIDES.items():
        node = int(np.argmin(np.linalg.norm(body.nodes[:, :2] - given.CORNERS[-1] * (sign, 1.0), axis=1)))
        skid, name = member.node(node), SKIDS[side]
        scene.add_contact(name, skid, surface, normal=normal, friction=friction if skids == "rough" else None)
        if skids == "pinned":
            scene.add_bushing(
                f"{name} pin",
                on_deck.frame((sign * half_track, given.DECK_HEIGHT, 0.0)),
                skid,
                stiffness=(given.TANGENTIAL_STIFFNESS, 0.0, 0.0),
                damping=(given.TANGENTIAL_DAMPING, 0.0, 0.0),
            )
        if lashed > 0.0:
            at_saddle = (*(given.CORNERS[2] * (sign, 1.0)), 0.0)
            ends = airframe.frame(at_saddle), on_deck.frame((sign * given.LASHING_POINT, given.DECK_HEIGHT, 0.0))
            stiffness = given.LASHING_STIFFNESS * lashed
            scene.add(Rope(f"{side} lashing", ends, axial_stiffness=stiffness, length=lashed))
    if lift:
        scene.add_force(airframe, (0.0, lift, 0.0))
    return scene


def level_rest(saddles: Saddles = "fixed", lashed: float = 0.0, *, is_planar: bool = True) -> tuple[Equilibrium, float]:
    """Return the equilibrium on the level deck with frictionless skids, and half the track there, m.

    Nothing holds the aircraft across the deck: its first coordinate is arbitrary.
    """
    rest = equilibrium(planar_scene(saddles=saddles, lashed=lashed, is_planar=is_planar))
    return rest, float(given.CORNERS[-1, 0] + rest.nodal_displacements("gear")[-1, 0])


def from_level(scene: System, rest: Equilibrium) -> np.ndarray:
    """Return the initial state at the level equilibrium in the middle of the deck, with unloaded friction springs."""
    state = by_names(scene, rest)
    state[0] = 0.0
    return state


def by_names(scene: System, rest: Equilibrium) -> np.ndarray:
    """Return the initial state of a scene, with values of the same names from the equilibrium of another one."""
    model, found = scene.freeze(), dict(zip(rest.model.state_names, rest.state, strict=True))
    named = zip(model.state_names, model.initial_state, strict=True)
    return np.array([found.get(name, value) for name, value in named])


def lashing_length(saddles: Saddles = "fixed", *, tension: float = given.LASHING_PRELOAD) -> float:
    """Return the unstretched length of the lashings, m, that gives a tension (N) at the level equilibrium.

    Raises
    ------
    ModelError
        If the tension is not above zero.
    """
    if not tension > 0.0:
        raise ModelError(f"the tension of lashings at rest must be above zero N, not {tension!r}")

    def excess(length: float) -> float:
        return float(level_rest(saddles, length)[0].load("port lashing", "tension")) - tension

    unloaded = math.hypot(given.LASHING_POINT - given.CORNERS[2, 0], given.CG_HEIGHT + given.CORNERS[2, 1])
    slack = tension / given.LASHING_STIFFNESS
    # the gear deforms by some millimetres, also under the lashings, and longer lashings are slack
    return float(brentq(excess, unloaded - 10.0 * slack, unloaded - slack, xtol=1e-12))
