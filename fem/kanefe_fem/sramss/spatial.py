"""The helicopter in space: a gear from a mesh, eight shoes on a deck that moves in six directions, lashings.

Axes of aircraft and deck: x forward, y to port, z up. All parameters are assumed.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.contact import Coulomb, HuntCrossley
from kanefe.contact.shapes import Plane
from kanefe.errors import ModelError
from kanefe.fe_model.damping import ModalDamping
from kanefe.fe_model.interface import Interface
from kanefe.frames import euler_parameters_from_matrix, rotation_matrix
from kanefe.joints import Free
from kanefe.joints.given_pose import GivenPose
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe.linear.equilibrium.rest import Equilibrium
from kanefe.loads import Rope
from kanefe.reduction import CraigBampton, flexible_body
from kanefe.system import System
from kanefe_fem.beams.from_mesh import beam_model_from_mesh
from kanefe_fem.beams.sections import Tube
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.solids.body import solid_body
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.gear import ALUMINIUM, Saddles
from kanefe_fem.sramss.planar import by_names

CLOSE, ENOUGH, MOST_RESTS = 1e-8, 0.01, 20
"""Search for the lengths of lashings: tolerance relative to their stretch; tolerance if friction holds an asymmetric
gear, so that lengths change its position and not the tension; largest number of equilibria."""

SADDLES = tuple(f"{tube} {side} saddle" for tube in ("aft", "forward") for side in ("starboard", "port"))
SHOES = tuple(f"{side} shoe {number}" for side in ("starboard", "port") for number in range(1, 5))

INERTIA = (given.AIRFRAME_INERTIA, 2400.0, 2600.0)
"""Principal inertias of the airframe about its centre of mass, kg m2."""

LASHING_OUT = 0.60
"""Distance of a lashing's fastening on the deck outboard of its saddle, m."""

SHOE_POINTS = 4
"""Number of contact points of a shoe with a face: its corners."""


def spatial_gear(mesh: Mesh | str | Path, modes: int = 16, *, saddles: Saddles = "fixed") -> FlexibleBody:
    """Return the gear from the mesh of beams of ``meshes/skid_gear.py``, held in the airframe by its saddles.

    Parameters
    ----------
    mesh : Mesh, str or Path
        Mesh with groups of lines "cross tubes" and "skid tubes", and groups of points for saddles and shoes.
    modes : int
        Number of normal modes with the saddles held.
    saddles : {"fixed", "hinged"}
        Held in all directions, or free to rotate about x.

    Raises
    ------
    ModelError
        If `saddles` is unknown.
    """
    tube = Tube(given.DIAMETER, given.WALL)
    held = _held(saddles)
    model = beam_model_from_mesh(mesh, {"cross tubes": tube, "skid tubes": tube}, ALUMINIUM)
    return flexible_body(model, held, reduction=CraigBampton(modes=modes), damping=ModalDamping(given.DAMPING_RATIO))


def solid_gear(mesh: Mesh | str | Path, modes: int = 16, *, saddles: Saddles = "fixed") -> FlexibleBody:
    """Return the gear from the mesh of solids of ``meshes/skid_gear_solid.py``, held in the airframe by its saddles.

    The first call takes half a minute; then the body is in the cache. The saddles hold rings of the tubes, which stay
    circular there, and the shoes have faces.

    Parameters
    ----------
    mesh : Mesh, str or Path
        Mesh with groups of facets for saddles and shoes.
    modes : int
        Number of normal modes with the saddles held.
    saddles : {"fixed", "hinged"}
        Held in all directions, or free to rotate about the axis of the tube, along x.

    Raises
    ------
    ModelError
        If `saddles` is unknown.

    Examples
    --------
    >>> gear = solid_gear("meshes/skid_gear_solid.py")                   # doctest: +SKIP
    >>> scene = spatial_scene(gear, lashings=lashing_lengths(gear, 2000.0))  # doctest: +SKIP
    """
    return solid_body(
        mesh,
        ALUMINIUM,
        _held(saddles),
        reduction=CraigBampton(modes=modes),
        damping=ModalDamping(given.DAMPING_RATIO),
        surfaces=SHOES,
    )


def _held(saddles: Saddles) -> dict[str, Interface]:
    """Return the interfaces at which the airframe holds the gear."""
    if saddles not in ("fixed", "hinged"):
        raise ModelError(f"saddles are 'fixed' or 'hinged', not {saddles!r}")
    return dict.fromkeys(SADDLES, Interface("all" if saddles == "fixed" else ("x", "y", "z", "ry", "rz")))


def spatial_scene(
    gear: FlexibleBody,
    motion: GivenPose | None = None,
    *,
    mu: float = 0.3,
    lashings: Mapping[str, float] | None = None,
    at: tuple[float, float] = (0.0, 0.0),
    lift: float = 0.0,
    sink: float = 0.0,
    shoe_points: int = SHOE_POINTS,
) -> System:
    """Return the aircraft on the deck, with the skids undeformed.

    Parameters
    ----------
    gear : FlexibleBody
        Gear of `spatial_gear` or `solid_gear`.
    motion : GivenPose, optional
        Motion of the deck: `kanefe.PoseTable`, or the motion of a ship. Default: none.
    mu : float
        Coefficient of friction of the shoes on the deck; zero for none.
    lashings : mapping of str to float, optional
        Unstretched length of the lashing of each saddle, m: see `lashing_lengths`. Default: no lashings.
    at : (float, float)
        x and y of the aircraft on the deck, m.
    lift : float
        Lift of the rotor along the airframe's z, N.
    sink : float
        Initial speed towards the deck, m/s.
    shoe_points : int
        Number of contact points of each shoe of a solid gear. With two, at opposite corners, a run is three times as
        fast as with all four.
    """
    scene = System(gravity=(0.0, 0.0, -given.GRAVITY))
    deck = scene.add_frame("deck", joint=Free(motion=motion)) if motion is not None else scene.ground
    place = np.array((*at, given.CG_HEIGHT))
    airframe = scene.add_rigid_body("airframe", given.AIRFRAME_MASS, INERTIA, joint=started_on(motion, place, sink))
    member = scene.add_flexible_body("gear", gear, parent=airframe)
    surface = scene.add_surface("deck", deck, Plane("z"))
    share = 4.0  # shoes of a skid
    normal = HuntCrossley(given.NORMAL_STIFFNESS / share, given.NORMAL_DAMPING)
    rough = Coulomb(mu or 1.0, stiffness=given.TANGENTIAL_STIFFNESS / share, damping=given.TANGENTIAL_DAMPING / share)
    missing = {*SHOES, *SADDLES} - {group.name for group in gear.groups}
    if missing:
        raise ModelError(
            f"the gear has no group of points or facets {min(missing)!r}. Remedy: the mesh meshes/skid_gear.py or "
            "meshes/skid_gear_solid.py"
        )
    for name in SHOES:
        patch = member.patch(name, most=shoe_points)
        scene.add_contact(name, patch, surface, normal=normal, friction=rough if mu else None)
    for name, length in (lashings or {}).items():
        if name not in SADDLES:
            raise ModelError(f"there is no saddle {name!r} for a lashing. There are: {', '.join(SADDLES)}")
        point = saddle_place(gear, name)
        ends = airframe.frame(tuple(point)), deck.frame(tuple(place + point + _way_down(point)))
        stiffness = given.LASHING_STIFFNESS * length
        scene.add(Rope(f"{name} lashing", ends, axial_stiffness=stiffness, length=length))
    if lift:
        scene.add_force(airframe, (0.0, 0.0, lift), follows=True)
    return scene


def resting_on(scene: System, rest: Equilibrium, motion: GivenPose) -> np.ndarray:
    """Return the initial state of an aircraft that moves with the deck, deformed as at rest on a level deck.

    Parameters
    ----------
    scene : System
        Scene with a moving deck.
    rest : Equilibrium
        Equilibrium of the same aircraft on a fixed deck.
    motion : GivenPose
        Motion of the deck.
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
    """Return the joint of an airframe that starts above the deck with the deck's motion and a sink speed.

    Parameters
    ----------
    motion : GivenPose or None
        Motion of the deck; None if it is fixed.
    place : ndarray, shape (3,)
        Position of the airframe's centre of mass, in axes of the deck, m.
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


def saddle_place(gear: FlexibleBody, name: str) -> np.ndarray:
    """Return the middle of a saddle in axes of the undeformed aircraft, from its centre of mass, m."""
    group = next(group for group in gear.groups if group.name == name)
    return np.asarray(group.shares @ gear.nodes[group.nodes])


def _way_down(point: np.ndarray) -> np.ndarray:
    """Return the vector from a saddle to the lower end of its lashing, in axes of the undeformed aircraft, m."""
    return np.array((0.0, np.sign(point[1]) * LASHING_OUT, -given.CG_HEIGHT - point[2]))


def lashing_lengths(gear: FlexibleBody, tension: float, *, shoe_points: int = SHOE_POINTS) -> dict[str, float]:
    """Return unstretched lengths of the lashings, m, that give all a tension (N) at rest on the level deck.

    The lengths depend on each other, because each lashing deforms the gear. For an asymmetric gear the tensions are
    within one per cent: friction carries the difference.

    Raises
    ------
    ModelError
        If there are no such lengths, or the tension is not above zero.
    """
    if not tension > 0.0:
        raise ModelError(f"the tension of lashings at rest must be above zero N, not {tension!r}")
    slack = tension / given.LASHING_STIFFNESS

    def lacks(lengths: np.ndarray) -> np.ndarray:
        lashings = dict(zip(SADDLES, lengths.tolist(), strict=True))
        rest = equilibrium(spatial_scene(gear, lashings=lashings, shoe_points=shoe_points))
        return np.asarray(lengths + slack - [float(rest.load(f"{name} lashing")[0]) for name in SADDLES])

    lengths = np.array([np.linalg.norm(_way_down(saddle_place(gear, name))) for name in SADDLES]) - slack
    left, inverse = lacks(lengths), np.eye(len(SADDLES))  # exact for a rigid gear
    for _ in range(MOST_RESTS):
        step = -inverse @ left
        before, lengths = left, lengths + step
        left = lacks(lengths)
        change, off = left - before, np.abs(left).max()
        if off <= CLOSE * slack or (off <= ENOUGH * slack and off > 0.5 * np.abs(before).max()):
            return dict(zip(SADDLES, lengths.tolist(), strict=True))
        # Broyden's method: each equilibrium is expensive and improves the inverse Jacobian
        inverse += np.outer(step - inverse @ change, step @ inverse) / (step @ inverse @ change)
    raise ModelError(f"no lengths of the lashings were found with which all pull by {tension:g} N")
