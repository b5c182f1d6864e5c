"""SR1 to SR6: a helicopter on skids on a deck, in the plane (SRAMSS-2D), against values of several programs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.fe_model.damping import RayleighDamping
from kanefe.joints import Planar, Revolute
from kanefe.kane.coupling import accelerations_and_coupling_forces
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe.linear.equilibrium.rest import Equilibrium
from kanefe.linear.linearisation import linearise
from kanefe.result import Result
from kanefe.states.state import State
from kanefe.system import System
from kanefe_fem.recovery.free_body_loads import inertia_forces
from kanefe_fem.sramss import Deck, from_level, gear_body, lashing_length, level_rest, planar_scene
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.gear import SADDLES, SKIDS, Saddles
from kanefe_fem.sramss.planar import SIDES

ROLL = Deck(amplitude=math.radians(8.0))
HEIGHT = given.DECK_HEIGHT + given.CG_HEIGHT
KINDS: tuple[Saddles, ...] = ("fixed", "hinged")
RTOL = 1e-7


def statics(reference: Reference) -> Iterator[Check]:
    """SR1: equilibrium on the level deck, and on a deck of increasing tilt."""
    values = reference.values
    rest, half = level_rest()
    moved = rest.nodal_displacements("gear")[-1]
    yield Check.absolute("N of a skid, level [N]", rest.contact(SKIDS["port"]).normal, values["N"], 5e-4)
    yield Check.absolute("gear deflection [mm]", 1e3 * moved[1], values["deflection_mm"], 1e-5)
    yield Check.absolute("wider track [mm]", 2e3 * moved[0], values["wider_mm"], 1e-5)
    moment = -rest.coupling_force("gear", SADDLES["port"])[5]
    yield Check.absolute("saddle moment [N m]", moment, values["saddle_moment"], 5e-4)
    held = equilibrium(planar_scene(skids="pinned", half_track=float(given.CORNERS[-1, 0])))
    thrust = -_thrust(held, "port")
    yield Check.absolute("thrust at the unloaded track [N]", thrust, values["thrust"], 1e-3)
    drop = 1e3 * (HEIGHT - held.position("airframe")[1])
    yield Check.absolute("its drop [mm]", drop, values["drop_mm"], 1e-5)

    hinged, _ = level_rest("hinged")
    moved = hinged.nodal_displacements("gear")[-1]
    yield Check.absolute(
        "gear deflection, hinged saddles [mm]", 1e3 * moved[1], values["hinged"]["deflection_mm"], 1e-5
    )
    yield Check.absolute("wider track, hinged saddles [mm]", 2e3 * moved[0], values["hinged"]["wider_mm"], 1e-5)

    slip = values["first_slip_deg"]
    tilted = _tilted(slip, half)
    ratio = abs(_thrust(tilted, "port")) / float(tilted.contact(SKIDS["port"]).normal)
    yield Check.absolute("T / N of the uphill skid at its first slip", ratio, values["mu"], 1e-6)
    # the aircraft tips where N of the uphill skid is zero, extrapolated by a cubic through four smaller angles
    angles = np.array((36.5, 37.0, 37.5, 38.0))
    normal = [float(_tilted(angle, half).contact(SKIDS["port"]).normal) for angle in angles]
    roots = np.roots(np.polyfit(angles - slip, normal, 3))
    tip = slip + float(np.real(roots[np.argmin(np.abs(roots - (values["tip_deg"] - slip)))]))
    yield Check.absolute("tips at [deg]", tip, values["tip_deg"], 1e-4)


def _tilted(degrees: float, half: float) -> Equilibrium:
    angle = math.radians(degrees)
    start = (-HEIGHT * math.sin(angle), HEIGHT * math.cos(angle), angle)
    return equilibrium(planar_scene(Deck(tilt=angle), skids="pinned", half_track=half, start=start))


def _thrust(rest: Equilibrium, side: str) -> float:
    return float(rest.load(f"{SKIDS[side]} pin")[6])


def small_motions(reference: Reference) -> Iterator[Check]:
    """SR2: frequencies without damping and gravity, with the skids held exactly or by springs."""
    for saddles in KINDS:
        values = reference.values if saddles == "fixed" else reference.values[saddles]
        for held in ("held", "springs"):
            wanted = values[held]
            found = linearise(_without_gravity(saddles, held)).modes().frequencies[: len(wanted)]
            quantity = f"frequencies, {saddles} saddles, skids {held} [Hz]"
            yield Check.absolute(quantity, found, wanted, 5e-5)


def _without_gravity(saddles: Saddles, held: str) -> System:
    """Return the aircraft without gravity and damping, its skids held at their places or by springs."""
    scene = System()
    start = Planar(position=(0.0, HEIGHT))
    airframe = scene.add_rigid_body("airframe", given.AIRFRAME_MASS, given.AIRFRAME_INERTIA, joint=start)
    body = gear_body(saddles, damping=RayleighDamping(0.0, 0.0))
    gear = scene.add_flexible_body("gear", body, parent=airframe)
    for node, sign in ((0, -1.0), (3 * given.ELEMENTS, 1.0)):
        mark = scene.ground.frame((sign * given.CORNERS[-1, 0], given.DECK_HEIGHT, 0.0))
        if held == "held":
            scene.add_loop_joint(f"skid {node}", Revolute("z"), mark, gear.node(node))
        else:
            stiffness = (given.TANGENTIAL_STIFFNESS, given.NORMAL_STIFFNESS, 0.0)
            scene.add_bushing(f"skid {node}", mark, gear.node(node), stiffness=stiffness)
    return scene


def _rolled(saddles: Saddles, span: float = 30.0, rtol: float = RTOL, **options: Any) -> Result:
    """Return the run of a scene on the rolling deck from the level equilibrium."""
    shared = {key: options[key] for key in ("lashed", "is_planar") if key in options}
    rest, half = level_rest(saddles, **shared)
    scene = planar_scene(ROLL, saddles=saddles, half_track=half, **options)
    return scene.simulate((0.0, span), start=from_level(scene, rest), rtol=rtol, output_step=0.1)


def pinned(reference: Reference) -> Iterator[Check]:
    """SR3: 30 s of roll with skids on springs and dampers; the reference is at 12.5 s."""
    values = reference.values
    result, row = _rolled("fixed", skids="pinned"), 125
    angle = ROLL.amplitude
    coordinates = result.joint_coordinates("airframe")[row]
    yield Check.absolute("roll on the deck [deg]", math.degrees(coordinates[2] - angle), values["roll_deg"], 1e-6)
    across = math.cos(angle) * coordinates[0] + math.sin(angle) * coordinates[1]
    yield Check.absolute("cg across, to starboard [m]", -across, values["across"], 1e-8)
    normal = [result.contact(SKIDS[side]).normal[row] for side in SIDES]
    yield Check.absolute("N [N]", normal, values["N"], 0.02)
    reactions = -_reactions(result, row)
    yield Check.absolute("reactions of the saddle nodes [N, N m]", reactions, values["saddles"], 0.02)
    for saddles in KINDS:
        run = result if saddles == "fixed" else _rolled(saddles, 15.0, skids="pinned")
        yield Check.absolute(f"order n against Eq. 39, {saddles} saddles", _between_routes(run, row), 0.0, 1e-12)
        yield Check.absolute(f"balance of the airframe, {saddles} saddles [N, N m]", _left_over(run, row), 0.0, 2e-5)


def _between_routes(result: Result, row: int) -> float:
    """Return the difference of the accelerations from those of the paper's equations with F_u, as relative forces.

    They are relative to the largest sum of absolute elastic forces, which determines the round-off.
    """
    if result.run is None:
        raise TypeError("a run in memory")
    model, trajectory = result.run.model, result.run.trajectory
    t, q, u, z = (x[row] for x in (result.times, trajectory.coordinates, trajectory.speeds, trajectory.internal))
    y = np.concatenate((q, u, z))
    du, _ = accelerations_and_coupling_forces(State(model, t, q, u, z))
    inertia = model.mass_matrix(t, y) @ (model.parts(model.rhs(t, y))[1] - du)
    stiffness = np.abs(model.flexible_terms("gear").body.stiffness)
    elastic = stiffness[: len(du), : len(du)][:, : len(q) - 3] @ np.abs(q[3:])
    return float(np.abs(inertia).max() / elastic.max())


def _reactions(result: Result, row: int) -> np.ndarray:
    """Return the reactions of the saddle nodes in the linear equations of the mesh, (2, 3), from K q, M and gravity.

    Their moments are about undeformed positions and neglect the sum of u x f of the contacts, which `coupling_force`
    includes.
    """
    body = result.body("gear").flexible
    if body is None:
        raise TypeError("the gear is a flexible body")
    k = body.free_count
    forces, _ = inertia_forces(result, "gear", body, np.array([row]))
    eta = result.modal_coordinates("gear")[row]
    held = np.asarray(body.stiffness)[k:, :k] @ eta - forces[0].ravel() @ np.asarray(body.inertia_basis)[:, k:]
    return np.asarray(held.reshape(2, -1))


def _left_over(result: Result, row: int, is_lashed: bool = False) -> float:
    """Return the residual of Newton's and Euler's equations of the airframe with the forces at its saddles."""
    x, y, angle = (float(q) for q in result.joint_coordinates("airframe")[row])
    to_body = _turned(angle).T
    force = given.AIRFRAME_MASS * to_body @ (result.acceleration("airframe")[row, :2] + (0.0, given.GRAVITY))
    moment = given.AIRFRAME_INERTIA * float(result.angular_acceleration("airframe")[row, 2])
    on_deck = _turned(float(ROLL.angle(result.times[row : row + 1])[0]))
    for side, sign in SIDES.items():
        place = given.CORNERS[2] * (sign, 1.0)
        wrench = -result.coupling_force("gear", SADDLES[side])[row]
        pull = wrench[:2]
        if is_lashed:
            eye = on_deck @ np.array((sign * given.LASHING_POINT, given.DECK_HEIGHT))
            way = to_body @ (eye - (x, y)) - place
            pull = pull + float(result.load(f"{side} lashing")[row, 2]) * way / np.linalg.norm(way)
        force = force - pull
        moment -= wrench[5] + place[0] * pull[1] - place[1] * pull[0]
    return float(max(abs(force).max(), abs(moment)))


def _turned(angle: float) -> np.ndarray:
    return np.array(((math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))))


def rough(reference: Reference) -> Iterator[Check]:
    """SR4: the same with Coulomb friction: with 0.3 the skids stick, with 0.15 they slide."""
    values = reference.values
    for saddles in KINDS:
        history = _rolled(saddles, skids="rough", mu=0.3)
        slip = [history.contact(SKIDS[side]).slip[-1] for side in SIDES]
        yield Check.absolute(f"slip in 30 s, mu 0.3, {saddles} saddles [m]", slip, [0.0, 0.0], values["anchor"])
    loose, tight = (_rolled("fixed", skids="rough", mu=0.15, rtol=rtol) for rtol in (1e-6, 1e-8))
    slid, wanted = ([run.contact(SKIDS[side]).slip[-1] for side in SIDES] for run in (loose, tight))
    yield Check.relative("slip in 30 s, mu 0.15, rtol 1e-6 [m]", slid, wanted, 1e-5)
    first, last = (float(run.events[f"{SKIDS['port']} slip"][0]) for run in (loose, tight))
    yield Check.absolute("first slip of port, mu 0.15, rtol 1e-6 [s]", first, last, 1e-5)


def lashed(reference: Reference) -> Iterator[Check]:
    """SR5: mu 0.15 with lashings, equally tensioned on the level deck, on the rolling deck."""
    values = reference.values
    for saddles in KINDS:
        length = lashing_length(saddles)
        rest, _ = level_rest(saddles, length)
        pull = [float(rest.load(f"{side} lashing")[2]) for side in SIDES]
        yield Check.absolute(f"lashings on the level deck, {saddles} saddles [N]", pull, [values["preload"]] * 2, 1e-3)
        loose, tight = (_rolled(saddles, 15.0, rtol, skids="rough", mu=0.15, lashed=length) for rtol in (1e-6, 1e-8))
        largest, wanted = ([run.load(f"{side} lashing")[:, 2].max() for side in SIDES] for run in (loose, tight))
        yield Check.relative(f"largest pull in 15 s, {saddles} saddles, rtol 1e-6 [N]", largest, wanted, 1e-5)
        left = _left_over(tight, 125, is_lashed=True)
        yield Check.absolute(f"balance of the airframe, {saddles} saddles [N, N m]", left, 0.0, 2e-5)


def drop(reference: Reference) -> Iterator[Check]:
    """SR6: a drop with a lift of two thirds of the weight, by two methods, and the energy."""
    values = reference.values
    weight = (given.AIRFRAME_MASS + gear_body().mass) * given.GRAVITY
    speed = math.sqrt(2.0 * given.GRAVITY * values["height"])
    for saddles in KINDS:
        peaks: list[list[float]] = []
        for method in ("radau5", "dop853"):
            scene = planar_scene(saddles=saddles, velocity=speed, lift=2.0 / 3.0 * weight)
            result = scene.simulate((0.0, 0.5), method=method, rtol=1e-9, output_step=1e-3)
            peaks.append([result.contact(SKIDS["port"]).normal.max(), result.position("airframe")[:, 1].min()])
            worst = abs(result.energy.balance_error).max() / (0.5 * weight / given.GRAVITY * speed**2)
            yield Check.absolute(f"energy, {saddles} saddles, {method}, of that of the drop", worst, 0.0, 1e-7)
        quantity = f"peak N and lowest cg, {saddles} saddles, radau5 against dop853 [N, m]"
        yield Check.relative(quantity, peaks[0], peaks[1], 1e-6)


def in_space(reference: Reference) -> Iterator[Check]:
    """SR3 with a gear of beams in space that is held in the plane, with the same result."""
    for saddles in KINDS:
        runs = [_rolled(saddles, 2.0, 1e-9, skids="pinned", is_planar=is_planar) for is_planar in (True, False)]
        found = [run.joint_coordinates("airframe")[:, :3] for run in runs]
        yield Check.absolute(f"airframe, {saddles} saddles, 3D against 2D [m, rad]", found[1], found[0], 1e-9)


CASES = (
    Case("SR1", statics),
    Case("SR2", small_motions),
    Case("SR3", pinned),
    Case("SR3", in_space),
    Case("SR4", rough),
    Case("SR5", lashed),
    Case("SR6", drop),
)
