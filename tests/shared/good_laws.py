"""Good calls of laws, shapes and loads."""

from __future__ import annotations

import numpy as np

import kanefe as kf
from good_call import call, files

LAW = {"stiffness": 1e5, "damping": 1.0}
for law in (kf.HuntCrossley, kf.Hertz):
    call(f"kanefe.{law.__name__}", law, **LAW, exponent=1.5)
call("kanefe.KelvinVoigt", kf.KelvinVoigt, **LAW)
call(
    "kanefe.Hertz.of_sphere", kf.Hertz.of_sphere, radius=0.1, E=210e9, nu=0.3, other_E=210e9, other_nu=0.3, damping=0.0
)
call("kanefe.Restitution", kf.Restitution, stiffness=1e5, restitution=0.5, exponent=1.0, least_speed=1e-3)
call("kanefe.Rigid", kf.Rigid, restitution=0.5, impact="distributing", stiffness=2.0, exponent=1.5)
call(
    "kanefe.Coulomb",
    kf.Coulomb,
    mu=0.3,
    static=0.4,
    stribeck_speed=0.1,
    stiffness=1e5,
    damping=1.0,
    along="x",
    torsional=0.0,
    rolling=0.0,
)
call("kanefe.LuGre", kf.LuGre, sigma0=1e5, sigma1=1.0, sigma2=0.1, coulomb=0.3, static=0.4, stribeck_speed=0.1)
call(
    "kanefe.Stribeck",
    kf.Stribeck,
    mu=0.3,
    breakaway=0.4,
    stribeck_speed=0.1,
    exponent=1.0,
    viscous=0.1,
    stiffness=1e5,
    damping=1.0,
)
call("kanefe.BumpStop", kf.BumpStop, depths=[0, 0.1, 0.2], forces=[0, 1, 3], hysteresis=0.2, turning=1e-3)
call("kanefe.TableLaw", kf.TableLaw, depths=[0, 0.1, 0.2], forces=[0, 1, 3], damping=0.0)
S = kf.shapes
call("kanefe.shapes.Box", S.Box, size=(1, 1, 1), inside=False)
call("kanefe.shapes.Capsule", S.Capsule, radius=0.1, length=1.0, axis="x")
call("kanefe.shapes.Convex", S.Convex, points=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
call("kanefe.shapes.Cylinder", S.Cylinder, radius=0.1, length=1.0, axis="z", inside=False)
call("kanefe.shapes.HeightField", S.HeightField, x=[0, 1, 2], y=[0, 1, 2], heights=np.zeros((3, 3)))
call(
    "kanefe.shapes.Mesh",
    S.Mesh,
    vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    triangles=[(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)],
)
TETRAHEDRON = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
LOOK = {"vertices": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], "triangles": TETRAHEDRON}
call("kanefe.shapes.Look", S.Look, **LOOK)
call("kanefe.shapes.Look.weighed", S.Look(**LOOK).weighed, density=1.0)
call("kanefe.shapes.Plane", S.Plane, normal="z")
call("kanefe.shapes.Points", S.Points, points=[(0, 0, 0), (1, 0, 0)], radius=0.0, share=0.5)
call("kanefe.shapes.Sphere", S.Sphere, radius=0.1, inside=False)
call("kanefe.shapes.Torus", S.Torus, radius=0.5, tube=0.1, axis="y")
for shape in (S.Box((1, 1, 1)), S.Capsule(0.1, 1.0), S.Cylinder(0.1, 1.0), S.Torus(0.5, 0.1)):
    call(f"kanefe.shapes.{type(shape).__name__}.sampled", shape.sampled, spacing=0.2)
files("kanefe.shapes.Mesh.from_stl", S.Mesh.from_stl, path="solid.stl", scale=1.0)
files("kanefe.shapes.Look.from_file", S.Look.from_file, path="solid.stl", scale=1.0)
files("kanefe.shapes.Convex.from_stl", S.Convex.from_stl, path="solid.stl", scale=1.0)
G = kf.System().ground
ENDS = (G, G.frame((1, 0, 0)))
call("kanefe.Rope", kf.Rope, name="r", ends=ENDS, axial_stiffness=1e5, damping=1.0, length=1.0, breaking_load=1e5)
call("kanefe.Rope", kf.Rope, name="r", ends=ENDS, axial_stiffness=1e5, length=([0.0, 1.0], [2.0, 1.0]))
RUNNER = (G.frame((0.5, 0, 0)), *ENDS)
call("kanefe.Guide", kf.Guide, name="g", ends=RUNNER, stiffness=1e5, damping=1.0, drag=1.0, stations=[0.0, 1.0])
BEARING = {"stiffness": [np.eye(2), 2.0 * np.eye(2)], "damping": [np.eye(2), np.eye(2)], "speeds": [0.0, 1.0]}
call("kanefe.Bearing", kf.Bearing, name="b", ends=ENDS, **BEARING, axis="x")
call("kanefe.Bearing.coefficients", kf.Bearing("b", ENDS, **BEARING).coefficients, speed=0.5)
call(
    "kanefe.Winch", kf.Winch, name="w", ends=ENDS, tension=1e3, stiffness=1e4, speed=1.0, damping=1.0, breaking_load=1e5
)
call(
    "kanefe.Oleo",
    kf.Oleo,
    name="o",
    ends=ENDS,
    area=0.01,
    pressure=1e6,
    volume=0.01,
    orifice=1.0,
    rebound=2.0,
    exponent=1.3,
    ambient=1e5,
    extended=1.0,
)
call(
    "kanefe.Oleo.orifice_coefficient",
    kf.Oleo.orifice_coefficient,
    density=850.0,
    area=0.01,
    orifice=1e-4,
    discharge=0.7,
)
call(
    "kanefe.PeriodicLoad",
    kf.PeriodicLoad,
    name="p",
    on=G,
    rate=10.0,
    mean=[0.0] * 6,
    harmonics={1: ([1.0] * 6, [0.0] * 6)},
    azimuth=0.0,
    share=None,
)
WIND = kf.Wind((10.0, 0.0, 0.0))
call("kanefe.Wind", kf.Wind, velocity=(10, 0, 0), gusts=(), turbulence=None)
call("kanefe.Gust", kf.Gust, velocity=(1, 0, 0), start=1.0, duration=2.0)
call("kanefe.Turbulence", kf.Turbulence, intensity=0.1, length=100.0, seed=0, count=10)
call(
    "kanefe.Aerodynamics",
    kf.Aerodynamics,
    name="a",
    on=G,
    wind=WIND,
    angles=np.linspace(-3.1, 3.1, 9),
    areas=np.ones((9, 6)),
    is_symmetric=False,
    flat_area=0.0,
    density=1.2,
)


def opposed(t: float, reads: np.ndarray) -> float:
    return -reads[0]


opposed.is_compiled = True  # objects that are called are not
call("kanefe.compiled", kf.compiled, function=opposed, reads="joint_speeds hub", memory=0)
