"""Wrong values through the public constructors of laws, motions, joints, loads, seas and damping: refused by name."""

import math
import warnings
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import kanefe as kf

TIMES = np.linspace(0.0, 1.0, 11)
ZERO: Callable[[float], float] = lambda t: 0.0  # noqa: E731

RIGHT: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "HuntCrossley": (kf.HuntCrossley, {"stiffness": 1e5, "damping": 0.3, "exponent": 1.5}),
    "KelvinVoigt": (kf.KelvinVoigt, {"stiffness": 1e5, "damping": 0.3}),
    "Hertz": (kf.Hertz, {"stiffness": 1e5, "damping": 0.3}),
    "of_sphere": (
        kf.Hertz.of_sphere,
        {"radius": 0.1, "E": 210e9, "nu": 0.3, "other_E": 7e10, "other_nu": 0.3, "damping": 0.1},
    ),
    "Restitution": (kf.Restitution, {"stiffness": 1e5, "restitution": 0.5, "exponent": 1.5, "least_speed": 1e-3}),
    "Rigid": (kf.Rigid, {"restitution": 0.5}),
    "TableLaw": (kf.TableLaw, {"depths": (0.0, 0.1), "forces": (0.0, 1.0), "damping": 0.1}),
    "Coulomb": (
        kf.Coulomb,
        {"mu": 0.3, "static": 0.4, "stribeck_speed": 0.01, "stiffness": 1e5, "damping": 10.0, "torsional": 0.01,
         "rolling": 0.01},
    ),
    "LuGre": (
        kf.LuGre,
        {"sigma0": 1e5, "sigma1": 100.0, "sigma2": 0.1, "coulomb": 0.1, "static": 0.2, "stribeck_speed": 0.01},
    ),
    "Sphere": (kf.shapes.Sphere, {"radius": 0.1}),
    "Capsule": (kf.shapes.Capsule, {"radius": 0.1, "length": 1.0, "axis": (0.0, 0.0, 1.0)}),
    "Cylinder": (kf.shapes.Cylinder, {"radius": 0.1, "length": 1.0, "axis": (0.0, 0.0, 1.0)}),
    "Box": (kf.shapes.Box, {"size": (1.0, 1.0, 1.0)}),
    "Torus": (kf.shapes.Torus, {"radius": 1.0, "tube": 0.1}),
    "Plane": (kf.shapes.Plane, {"normal": (0.0, 0.0, 1.0)}),
    "HeightField": (kf.shapes.HeightField, {"x": (0.0, 1.0, 2.0), "y": (0.0, 1.0, 2.0), "heights": np.zeros((3, 3))}),
    "Points": (kf.shapes.Points, {"points": np.zeros((1, 3)), "radius": 0.1, "share": 0.5}),
    "sampled": (kf.shapes.Box((1.0, 1.0, 1.0)).sampled, {"spacing": 0.5}),
    "steady": (kf.Motion.steady, {"rate": 1.0, "start": 0.0}),
    "table": (kf.Motion.table, {"times": TIMES, "positions": TIMES}),
    "Motion": (
        kf.Motion, {"position": ZERO, "velocity": ZERO, "acceleration": ZERO, "span": (0.0, 1.0)},
    ),
    "PoseTable": (kf.PoseTable, {"times": TIMES, "positions": np.zeros((11, 3))}),
    "PoseMotion": (kf.PoseMotion, {"position": ZERO, "velocity": ZERO, "acceleration": ZERO, "span": (0.0, 1.0)}),
    "Revolute": (kf.Revolute, {"axis": (0.0, 0.0, 1.0), "position": 0.1, "speed": 0.1}),
    "Screw": (kf.Screw, {"position": 0.1, "speed": 0.1, "lead": 0.01}),
    "Cylindrical": (kf.Cylindrical, {"position": (0.1, 0.1), "speed": (0.1, 0.1)}),
    "Universal": (kf.Universal, {"position": (0.1, 0.1), "speed": (0.1, 0.1)}),
    "Planar": (kf.Planar, {"position": (0.1, 0.1), "angle": 0.1, "velocity": (0.1, 0.1), "rate": 0.1}),
    "Translation": (kf.Translation, {"position": (0.1, 0.1, 0.1), "velocity": (0.1, 0.1, 0.1)}),
    "Free": (
        kf.Free,
        {"position": (0.1, 0.1, 0.1), "orientation": (1.0, 0.0, 0.0, 0.0), "velocity": (0.1, 0.1, 0.1),
         "angular_velocity": (0.1, 0.1, 0.1)},
    ),
    "Spherical": (kf.Spherical, {"orientation": (1.0, 0.0, 0.0, 0.0), "angular_velocity": (0.1, 0.1, 0.1)}),
    "PointOnCurve": (kf.PointOnCurve, {"points": np.column_stack((TIMES, TIMES**2, 0.0 * TIMES)), "position": 0.1,
                                       "speed": 0.1}),
    "CoordinateForce": (
        kf.CoordinateForce,
        {"stiffness": 1.0, "damping": 1.0, "rest": 0.1, "friction": 0.1, "static_friction": 0.2,
         "friction_stiffness": 1e3, "friction_damping": 1.0, "limits": (-1.0, 1.0), "limit_stiffness": 1e3,
         "limit_damping": 1.0},
    ),
    "backlash": (
        kf.CoordinateForce.backlash,
        {"play": 0.1, "stiffness": 1e3, "damping": 1.0, "rest": 0.1, "friction": 0.1},
    ),
    "JointFriction": (
        kf.JointFriction,
        {"mu": 0.1, "radius": 0.1, "static": 0.2, "length": 0.1, "collar": 0.1, "preload": 1.0, "stiffness": 1e5,
         "damping": 10.0, "load_time": 1e-3, "stribeck_speed": 0.01},
    ),
    "Rope": (
        kf.Rope, {"name": "r", "ends": (1, 2), "axial_stiffness": 1e5, "damping": 1.0, "length": 1.0,
                  "breaking_load": 1e3},
    ),
    "Winch": (
        kf.Winch, {"name": "w", "ends": (1, 2), "tension": 1.0, "stiffness": 1e5, "speed": 1.0, "damping": 1.0,
                   "breaking_load": 1e3},
    ),
    "Oleo": (
        kf.Oleo,
        {"name": "o", "ends": (1, 2), "area": 0.01, "pressure": 1e6, "volume": 1e-3, "orifice": 1.0, "rebound": 1.0,
         "exponent": 1.3, "ambient": 1e5, "extended": 0.1},
    ),
    "orifice_coefficient": (
        kf.Oleo.orifice_coefficient, {"density": 870.0, "area": 0.01, "orifice": 1e-4, "discharge": 0.7},
    ),
    "PeriodicLoad": (kf.PeriodicLoad, {"name": "p", "on": 1, "rate": 1.0, "mean": np.zeros(6), "azimuth": 0.1}),
    "Gust": (kf.Gust, {"velocity": (1.0, 0.0, 0.0), "start": 0.0, "duration": 1.0}),
    "Turbulence": (kf.Turbulence, {"intensity": 1.0, "length": 100.0, "seed": 1, "count": 10}),
    "Wind": (kf.Wind, {"velocity": (1.0, 0.0, 0.0)}),
    "bretschneider": (
        kf.Sea.bretschneider,
        {"Hs": 2.0, "Tp": 10.0, "spreading": 2.0, "seed": 1, "duration": 60.0, "frequency_range": (0.3, 1.5),
         "depth": 100.0, "gravity": 9.81, "count": 200},
    ),
    "jonswap": (kf.Sea.jonswap, {"Hs": 2.0, "Tp": 10.0, "gamma": 3.3, "spreading_deg": 10.0}),
    "pierson_moskowitz": (kf.Sea.pierson_moskowitz, {"wind": 10.0}),
    "state": (kf.Sea.state, {"number": 5}),
    "measured": (kf.Sea.measured, {"frequencies": (0.2, 0.5, 1.0), "densities": (0.0, 1.0, 0.0)}),
    "Ship": (
        lambda **given: kf.Ship(kf.example_rao(), kf.Sea.state(5), **given),
        {"speed": 0.0, "heading_deg": 30.0, "slowest_hz": 0.03},
    ),
    "RollDamping": (kf.RollDamping, {"ratio": 0.1, "frequency": 1.0, "ratio_of_rao": 0.05}),
    "ModalDamping": (kf.ModalDamping, {"ratio": 0.05}),
    "RayleighDamping": (kf.RayleighDamping, {"mass": 0.1, "stiffness": 1e-4}),
    "fit": (kf.RayleighDamping.fit, {"frequencies": (10.0, 100.0), "ratios": (0.02, 0.02)}),
}  # fmt: skip

LARGE = 10**400

WRONG: tuple[Any, ...] = (
    "1", "", 1 + 1j, True, math.nan, np.array("x"), {}, object(), [[1.0], [1.0, 2.0]], LARGE, np.zeros((2, 3, 4)),
    np.array([1j, 0.0, 0.0]), b"1", [None], np.full(3, math.nan), kf.Motion, lambda: 0.0,
)  # fmt: skip

MEANT = {
    ("Motion", "position"), ("Motion", "velocity"), ("Motion", "acceleration"), ("PoseMotion", "position"),
    ("PoseMotion", "velocity"), ("PoseMotion", "acceleration"), ("Rope", "name"), ("Winch", "name"), ("Oleo", "name"),
    ("PeriodicLoad", "name"), ("PeriodicLoad", "on"), ("Rope", "ends"), ("Winch", "ends"), ("Oleo", "ends"),
}  # fmt: skip
"""Arguments that are no numbers: functions, names and frames."""


@pytest.mark.parametrize("name", RIGHT)
def test_what_is_no_number_is_refused_by_a_message_that_names_it(name: str) -> None:
    make, given = RIGHT[name]
    make(**given)
    faults = []
    for argument in given:
        for wrong in WRONG:
            if (name, argument) in MEANT or (argument == "seed" and wrong is LARGE):
                continue
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("error")
                    make(**{**given, argument: wrong})
                faults.append(f"{argument}={wrong!r} is taken")
            except kf.ModelError as error:
                stem = argument.partition("_deg")[0].rstrip("s")
                if not any(word in str(error) for word in (stem, stem.replace("_", " "), *ALSO.get(argument, ()))):
                    faults.append(f"{argument}={wrong!r}: {error}")
            except Exception as error:  # noqa: BLE001  what ends bare is asked here
                faults.append(f"{argument}={wrong!r} ends in {type(error).__name__}: {error}")
    assert not faults, "\n".join(faults)


ALSO = {"size": ("size",), "points": ("curve",), "number": ("sea states",), "velocity": ("wind",), "play": ("limits",)}
"""Other words that messages name an argument by."""


def test_fractions_and_whole_numbers_are_numbers() -> None:
    assert float(kf.Coulomb(Fraction(1, 2)).sliding) == 0.5
    assert kf.HuntCrossley(100000).stiffness == 100000
    assert kf.HuntCrossley(np.float32(2.0)).stiffness == 2.0
