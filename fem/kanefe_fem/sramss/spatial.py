"""The helicopter in space: a gear from a mesh of beams, eight shoes on a deck that moves in six directions, lashings.

Axes of aircraft and deck: x forward, y to port, z up. All parameters are assumed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.contact import Coulomb, HuntCrossley
from kanefe.contact.shapes import Plane
from kanefe.errors import ModelError
from kanefe.fe_model.damping import ModalDamping
from kanefe.frames import euler_parameters_from_matrix, rotation_matrix
from kanefe.joints import Free
from kanefe.joints.given_pose import GivenPose
from kanefe.linear import Equilibrium, equilibrium
from kanefe.loads import Rope
from kanefe.reduction import CraigBampton, flexible_body
from kanefe.system import System
from kanefe_fem.beams.from_mesh import beam_model_from_mesh
from kanefe_fem.beams.sections import Tube
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.gear import ALUMINIUM
from kanefe_fem.sramss.planar import by_names

ROUNDS, CLOSE, LEAST_RATE = 20, 1e-9, 0.1
"""Of the search for the lengths of lashings: how often at most, how close, and what of a change helps at least."""

SADDLES = tuple(f"{tube} {side} saddle" for tube in ("aft", "forward") for side in ("starboard", "port"))
SHOES = tuple(f"{side} shoe {number}" for side in ("starboard", "port") for number in range(1, 5))

INERTIA = (given.AIRFRAME_INERTIA, 2400.0, 2600.0)
"""Of the airframe about its centre of mass, kg m2."""

LASHING_OUT = 0.60
"""How far outboard of a saddle, and below it, its lashing is fastened to the deck, m."""


def spatial_gear(mesh: Mesh | str | Path, modes: int = 16) -> FlexibleBody:
    """Return the gear from the mesh of ``meshes/skid_gear.py``, with its saddles fixed in the airframe.

    Parameters
    ----------
    mesh : Mesh, str or Path
        With groups of lines "cross tubes" and "skid tubes", and of points for saddles and shoes.
    modes : int
        Normal modes with the saddles held.
    """
    tube = Tube(given.DIAMETER, given.WALL)
    model = beam_model_from_mesh(mesh, {"cross tubes": tube, "skid tubes": tube}, ALUMINIUM)
    return flexible_body(
        model,
        dict.fromkeys(SADDLES, "clamped"),
        reduction=CraigBampton(modes=modes),
        damping=ModalDamping(given.DAMPING_RATIO),
    )


def spatial_scene(
    gear: FlexibleBody,
    motion: GivenPose | None = None,
    *,
    mu: float = 0.3,
    lashings: Mapping[str, float] | None = None,
    at: tuple[float, float] = (0.0, 0.0),
    lift: float = 0.0,
) -> System:
    """Return the aircraft on the deck, over a spot of it, with the skids undeformed.

    Parameters
    ----------
    gear : FlexibleBody
        See `spatial_gear`.
    motion : GivenPose, optional
        Of the deck: `kanefe.PoseTable`, or what a ship gives. None: it stays.
    mu : float
        Of the shoes on the deck; zero: they slide.
    lashings : mapping of str to float, optional
        Unstretched length of the lashing of each saddle, m: see `lashing_lengths`. None: there are none.
    at : (float, float)
        x and y of the spot, m.
    lift : float
        Of the rotor, along the airframe's z, N.
    """
    scene = System(gravity=(0.0, 0.0, -given.GRAVITY))
    deck = scene.add_frame("deck", joint=Free(motion=motion)) if motion is not None else scene.ground
    place = np.array((*at, given.CG_HEIGHT))
    airframe = scene.add_rigid_body("airframe", given.AIRFRAME_MASS, INERTIA, joint=started_on(motion, place))
    member = scene.add_flexible_body("gear", gear, parent=airframe)
    surface = scene.add_surface("deck", deck, Plane("z"))
    share = 4.0  # shoes of a skid
    normal = HuntCrossley(given.NORMAL_STIFFNESS / share, given.NORMAL_DAMPING)
    rough = Coulomb(mu or 1.0, stiffness=given.TANGENTIAL_STIFFNESS / share, damping=given.TANGENTIAL_DAMPING / share)
    nodes = {group.name: int(group.nodes[0]) for group in gear.groups}
    missing = [name for name in (*SHOES, *SADDLES) if name not in nodes]
    if missing:
        raise ModelError(f"the gear has no group of points {missing[0]!r}. Remedy: the mesh meshes/skid_gear.py")
    for name in SHOES:
        scene.add_contact(name, member.node(nodes[name]), surface, normal=normal, friction=rough if mu else None)
    for name, length in (lashings or {}).items():
        point = gear.nodes[nodes[name]]
        ends = airframe.frame(tuple(point)), deck.frame(tuple(place + point + _out(point)))
        stiffness = given.LASHING_STIFFNESS * length
        scene.add(Rope(f"{name} lashing", ends, axial_stiffness=stiffness, length=length))
    if lift:
        scene.add_force(airframe, (0.0, 0.0, lift), follows=True)
    return scene


def resting_on(scene: System, rest: Equilibrium, motion: GivenPose) -> np.ndarray:
    """Return the start of a scene whose aircraft rests on the deck as it does on a level one, and moves with it.

    Parameters
    ----------
    scene : System
        With a deck that moves.
    rest : Equilibrium
        Of the same aircraft on a deck that stays.
    motion : GivenPose
        Of the deck.
    """
    state, begun = by_names(scene, rest), motion.at(0.0)
    names = scene.freeze().state_names
    first, rates = names.index("airframe: x [m]"), names.index("airframe: vx [m/s]")
    place, turn = state[first : first + 3].copy(), rotation_matrix(state[first + 3 : first + 7])
    spin = begun.axes @ begun.angular_velocity
    state[first : first + 3] = begun.position + begun.axes @ place
    state[first + 3 : first + 7] = euler_parameters_from_matrix(begun.axes @ turn)
    state[rates : rates + 3] = begun.velocity + np.cross(spin, begun.axes @ place)
    state[rates + 3 : rates + 6] = turn.T @ begun.angular_velocity
    return state


def started_on(motion: GivenPose | None, place: np.ndarray, sink: float = 0.0) -> Free:
    """Return the joint of an airframe that starts at a place over the deck, moves with it, and sinks towards it.

    Parameters
    ----------
    motion : GivenPose or None
        Of the deck; None: it stays.
    place : ndarray, shape (3,)
        Of the airframe's centre of mass, in axes of the deck, m.
    sink : float
        Speed towards the deck, m/s.
    """
    down = np.array((0.0, 0.0, -sink))
    if motion is None:
        return Free(position=tuple(place), velocity=tuple(down))
    begun = motion.at(0.0)
    return Free(
        position=tuple(begun.position + begun.axes @ place),
        orientation=begun.axes,
        velocity=tuple(begun.velocity + begun.axes @ (np.cross(begun.angular_velocity, place) + down)),
        angular_velocity=tuple(begun.angular_velocity),
    )


def _out(point: np.ndarray) -> np.ndarray:
    """Return the way from a saddle to where its lashing is fastened, in axes of the undeformed aircraft, m."""
    return np.array((0.0, np.sign(point[1]) * LASHING_OUT, -LASHING_OUT))


def lashing_lengths(gear: FlexibleBody, tension: float) -> dict[str, float]:
    """Return unstretched lengths of the lashings, of which all pull by a tension (N) at rest on the level deck, m.

    Each is changed by what it lacks, over the rate at which its last change helped: the gear gives way too.
    """
    slack = tension / given.LASHING_STIFFNESS
    lengths = np.full(len(SADDLES), math.sqrt(2.0) * LASHING_OUT - slack)
    changes, lacked = np.zeros(0), np.zeros(0)
    for _ in range(ROUNDS):
        rest = equilibrium(spatial_scene(gear, lashings=dict(zip(SADDLES, lengths.tolist(), strict=True))))
        lacks = lengths + slack - [float(rest.load(f"{name} lashing")[0]) for name in SADDLES]
        if np.abs(lacks).max() < CLOSE * slack:
            break
        rates = (lacked - lacks) / changes if len(lacked) else np.ones(len(SADDLES))
        changes, lacked = -lacks / np.maximum(np.abs(rates), LEAST_RATE), lacks
        lengths = lengths + changes
    return dict(zip(SADDLES, lengths.tolist(), strict=True))
