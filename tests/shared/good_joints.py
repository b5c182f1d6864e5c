"""Good calls of frames, joints and motions."""

from __future__ import annotations

import numpy as np

import kanefe as kf
from good_call import call

call("kanefe.rotation_about", kf.rotation_about, axis="z", angle=1.0)
call("kanefe.euler_angles", kf.euler_angles, order="XYZ", angles=(0.1, 0.2, 0.3))
call("kanefe.Guess", kf.Guess, value=0.3)
AXIS = {"axis": "z", "position": 0.0, "speed": 0.0, "motion": None, "forces": None}
call("kanefe.Revolute", kf.Revolute, **AXIS, friction=None)
call("kanefe.Prismatic", kf.Prismatic, **AXIS, friction=None)
call("kanefe.Screw", kf.Screw, **AXIS, friction=None, lead=0.01)
call(
    "kanefe.Cylindrical",
    kf.Cylindrical,
    axis="z",
    position=(0, 0),
    speed=(0, 0),
    motion=(None, None),
    forces=(None, None),
    friction=None,
)
call(
    "kanefe.Free",
    kf.Free,
    position=(0, 0, 0),
    orientation=(1, 0, 0, 0),
    velocity=(0, 0, 0),
    angular_velocity=(0, 0, 0),
    motion=None,
    armature=0.1,
)
call(
    "kanefe.Spherical",
    kf.Spherical,
    orientation=(1, 0, 0, 0),
    angular_velocity=(0, 0, 0),
    motion=None,
    friction=None,
    armature=0.1,
)
call(
    "kanefe.Planar",
    kf.Planar,
    position=(0, 0),
    angle=0.0,
    velocity=(0, 0),
    rate=0.0,
    motion=(None,) * 3,
    forces=(None,) * 3,
)
call(
    "kanefe.Translation", kf.Translation, position=(0, 0, 0), velocity=(0, 0, 0), motion=(None,) * 3, forces=(None,) * 3
)
call(
    "kanefe.Universal",
    kf.Universal,
    first="x",
    second="y",
    position=(0, 0),
    speed=(0, 0),
    motion=(None, None),
    forces=(None, None),
)
call(
    "kanefe.PointOnCurve",
    kf.PointOnCurve,
    points=[(0, 0, 0), (1, 0, 0), (2, 1, 0)],
    closed=False,
    turns=False,
    up=None,
    position=0.0,
    speed=0.0,
    motion=None,
    forces=None,
)
call(
    "kanefe.CoordinateForce",
    kf.CoordinateForce,
    stiffness=1.0,
    damping=1.0,
    rest=0.0,
    friction=0.1,
    static_friction=0.2,
    friction_stiffness=10.0,
    friction_damping=1.0,
    limits=(-1.0, 1.0),
    limit_stiffness=1e3,
    limit_damping=1.0,
)
call(
    "kanefe.CoordinateForce.backlash",
    kf.CoordinateForce.backlash,
    play=0.1,
    stiffness=1e3,
    damping=1.0,
    rest=0.0,
    friction=0.0,
)
call(
    "kanefe.JointFriction",
    kf.JointFriction,
    mu=0.1,
    radius=0.01,
    static=0.2,
    preload=0.0,
    stiffness=1e6,
    damping=10.0,
    load_time=0.01,
)
call(
    "kanefe.Motion",
    kf.Motion,
    position=lambda t: t,
    velocity=lambda t: 1.0,
    acceleration=lambda t: 0.0,
    span=(0.0, 1.0),
)
call("kanefe.Motion.steady", kf.Motion.steady, rate=1.0, start=0.0)
call("kanefe.Motion.table", kf.Motion.table, times=[0, 1, 2, 3], positions=[0, 1, 0, 1])
call("kanefe.PoseTable", kf.PoseTable, times=[0, 1, 2, 3], positions=np.zeros((4, 3)))
call(
    "kanefe.PoseMotion",
    kf.PoseMotion,
    position=lambda t: (t, 0, 0),
    velocity=lambda t: (1.0, 0, 0),
    acceleration=lambda t: (0.0, 0, 0),
    span=(0.0, 1.0),
)
call("kanefe.Event", kf.Event, name="e", function=lambda t, s: t - 1.0, direction=0, terminal=False, action=None)
