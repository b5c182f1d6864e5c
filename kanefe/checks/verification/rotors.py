"""Cases of rotors: small motions about a steady spin, critical speeds, and limits of stability."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.equations.model import Model
from kanefe.joints import CoordinateForce, Free, Motion, Prismatic, Revolute
from kanefe.linear.linearisation import linearise
from kanefe.linear.over_speed.campbell_diagram import campbell
from kanefe.loads import Bearing
from kanefe.system import System

TOLERANCE = 1e-4

Rotor = Callable[[float], Model]
"""Function of the spin (rad/s) that returns the rotor in a frame that spins with it."""

MASS = 2.0
"""Mass of the point, kg: results do not depend on it."""

DISC, STIFFNESS, INTERNAL, EXTERNAL = 5.0, 2e5, 40.0, 25.0
"""Jeffcott rotor: mass of the disc, kg; stiffness of the shaft, N/m; damping of the shaft (rotating) and of the
bearings (stationary), N s/m."""

REACH, BENDING = 0.5, 8e3
"""Length (m) and bending stiffness (N m2) of the shaft that carries an overhung disc."""


def spin_eigenvalues(model: Model) -> np.ndarray:
    """Return the eigenvalues of a scene at its initial state, 1/s, without negative real and imaginary parts.

    Of the four eigenvalues ``+-a +- i b`` of a motion of an undamped scene, one is listed; lowest frequency first.
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
    """Return a point on two perpendicular springs (100 and 120 rad/s) on a shaft that spins about z."""
    scene = System()
    shaft = scene.add_frame("shaft", joint=Revolute("z", motion=Motion.steady(spin)))
    slide = scene.add_frame("slide", parent=shaft, joint=Prismatic("x", forces=CoordinateForce(MASS * 100.0**2)))
    scene.add_point("point", MASS, parent=slide, joint=Prismatic("y", forces=CoordinateForce(MASS * 120.0**2)))
    return scene.freeze()


def asymmetric_rotor(reference: Reference) -> Iterator[Check]:
    """D04b: two lateral modes of different frequency on a spinning shaft."""
    yield from asymmetric_rotor_checks(reference.values, point_on_springs, "point on springs")


def jeffcott_seen_from_the_shaft(speed: float) -> System:
    """Return a disc on a massless shaft, modelled in a frame that spins with the shaft."""
    scene = System()
    shaft = scene.add_frame("shaft", joint=Revolute("x", motion=Motion.steady(speed)))
    spring = CoordinateForce(STIFFNESS, damping=INTERNAL)
    slide = scene.add_frame("slide", parent=shaft, joint=Prismatic("y", forces=spring))
    disc = scene.add_rigid_body("disc", DISC, 0.01, parent=slide, joint=Prismatic("z", forces=spring))
    scene.add(Bearing("film", (scene.ground, disc), np.zeros((2, 2)), EXTERNAL * np.eye(2)))
    return scene


def jeffcott_seen_from_the_ground(speed: float) -> System:
    """Return the same rotor, modelled in N: the shaft damping gives circulatory forces proportional to the speed."""
    scene = System()
    slide = scene.add_frame("slide", joint=Prismatic("y"))
    disc = scene.add_point("disc", DISC, parent=slide, joint=Prismatic("z"))
    shaft = scene.add_rigid_body("shaft", 1.0, 0.01, joint=Revolute("x", motion=Motion.steady(speed)))
    circulates, speeds = INTERNAL * np.array(((0.0, 1.0), (-1.0, 0.0))), (0.0, 150.0, 600.0)
    stiffness = [STIFFNESS * np.eye(2) + at * circulates for at in speeds]
    damping = 3 * [(INTERNAL + EXTERNAL) * np.eye(2)]
    scene.add(Bearing("shaft and film", (scene.ground, disc, shaft), stiffness, damping, speeds=speeds))
    return scene


def jeffcott_rotor(reference: Reference) -> Iterator[Check]:
    """R01: internal damping makes the forward whirl unstable above a speed; seen from the ground and from the shaft."""
    values = reference.values
    speeds = np.array([float(speed) for speed in values["forward"]])
    expected = np.array(list(values["forward"].values()))
    for build, turned, where in (
        (jeffcott_seen_from_the_ground, 0.0, "seen from the ground"),
        (jeffcott_seen_from_the_shaft, 1.0, "seen from the shaft"),
    ):
        diagram = campbell(build, speeds)
        parts = np.stack((diagram.eigenvalues.real, diagram.eigenvalues.imag + turned * speeds[:, None]), axis=-1)
        errors = np.abs(parts - expected[:, None]).max(axis=(0, 2))
        forward = parts[:, int(errors.argmin())]
        yield Check.absolute(f"growth and whirl at 0 ... 600 rad/s, {where} [1/s]", forward, expected, 1e-6)
        limits = [one.speed for one in diagram.stability_limits() if one.begins]
        yield Check.relative(f"limit of stability, {where} [rad/s]", limits, [values["limit"]], 1e-9)
    standing = [one.speed for one in diagram.critical_speeds(order=0.0)]
    yield Check.relative("critical speed, seen from the shaft [rad/s]", standing, [values["standing"]], 1e-9)


def overhung(speed: float) -> System:
    """Return a disc at the end of a massless cantilever, which is modelled by the stiffness at its end."""
    scene = System()
    end = scene.add_frame("end", joint=Free())
    spin = Revolute("x", motion=Motion.steady(speed))
    scene.add_rigid_body("disc", 10.0, (0.2, 0.1, 0.1), parent=end, joint=spin)
    a, b, c = BENDING * np.array((12.0 / REACH**3, 6.0 / REACH**2, 4.0 / REACH))
    K = np.diag((1e9, a, a, 1e7, c, c))
    K[1, 5] = K[5, 1] = -b
    K[2, 4] = K[4, 2] = b
    scene.add_bushing("shaft", scene.ground, end, stiffness=K)
    return scene


def overhung_disc(reference: Reference) -> Iterator[Check]:
    """R02: forward and backward whirl of an overhung disc with gyroscopic moments, and its critical speeds."""
    speeds = np.array([float(speed) for speed in reference.values["whirl"]])
    diagram = campbell(overhung, np.append(0.0, speeds))
    found = np.sort(np.abs(diagram.eigenvalues[1:, :4].imag))
    expected = np.sort(np.abs(list(reference.values["whirl"].values())))
    yield Check.relative("whirl at 300 ... 1500 rad/s [rad/s]", found, expected, 1e-9)
    for damped in (True, False):
        critical = [(one.speed, one.whirl) for one in diagram.critical_speeds(order=1.0, damped=damped)]
        (at, sense), (wanted, way) = np.transpose(critical), np.transpose(reference.values["critical"])
        label = "" if damped else ", of the scene without damping"
        yield Check.relative(f"critical speeds{label} [rad/s]", at, wanted, 1e-9)
        yield Check.absolute(f"whirl there{label}, forward 1, backward -1", sense, way, 1e-6)


def jeffcott_in_an_anisotropic_bearing(speed: float) -> System:
    """Return a disc in a bearing 1.5 times as stiff along z as along y; the spinning shaft is a separate body."""
    scene = System()
    disc = scene.add_rigid_body("disc", DISC, 0.01, joint=Free())
    scene.add_rigid_body("shaft", 1.0, 0.01, joint=Revolute("x", motion=Motion.steady(speed)))
    stiffness = STIFFNESS * np.diag((1.0, 1.5))
    scene.add(Bearing("film", (scene.ground, disc), stiffness, EXTERNAL * np.eye(2)))
    return scene


def anisotropic_bearing(reference: Reference) -> Iterator[Check]:
    """R03: in an anisotropic bearing the unbalance response whirls backward between the critical speeds."""
    diagram = campbell(jeffcott_in_an_anisotropic_bearing, np.linspace(50.0, 400.0, 8))
    critical = [one.speed for one in diagram.critical_speeds()]
    yield Check.relative("critical speeds [rad/s]", critical, reference.values["critical"], 1e-9)
    responses = reference.values["response"]
    speeds = np.array([float(speed) for speed in responses])
    forces, places = ("force disc y", "force disc z"), ("position disc y", "position disc z")
    small = linearise(jeffcott_in_an_anisotropic_bearing(speeds[0]), inputs=forces, outputs=places)
    turning = np.array((1.0, -1j))  # Re (force exp(i w t)): turns from y to z, with the shaft
    y, z = (small.frequency_response(speeds / (2.0 * np.pi)).response @ turning).T
    sizes = np.abs(np.stack((y, z), axis=1))
    wanted = np.array([one["sizes"] for one in responses.values()])
    yield Check.relative("response at 100, 220, 400 rad/s [m/N]", sizes, wanted, 1e-9)
    way = [one["sense"] for one in responses.values()]
    # of y = Re Y exp(i w t) and z, y dz/dt - z dy/dt = w Im (Y conj Z)
    yield Check.absolute("sense of its orbit, forward 1", np.sign((y * z.conj()).imag), way, 0.0)


CASES = (
    Case("D04b", asymmetric_rotor),
    Case("R01", jeffcott_rotor),
    Case("R02", overhung_disc),
    Case("R03", anisotropic_bearing),
)
