"""Good calls of bodies from matrices, and readers of robots."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

import kanefe as kf
from good_call import CALLS, Call, Good, call, files, on
from good_scenes import beam, cantilever, loaded_body
from repository import ROOT
from steel_beams import steel_beam

call("kanefe.ModalDamping", kf.ModalDamping, ratio=0.01)
call("kanefe.SceneDamping", kf.SceneDamping, ratio=0.01)
CALLS["kanefe.SceneDamping.put_on"] = Call(
    lambda: (kf.SceneDamping(0.01).put_on, {"scene": cantilever(), "start": None})
)
call("kanefe.RayleighDamping", kf.RayleighDamping, mass=0.1, stiffness=1e-5)
call("kanefe.RayleighDamping.fit", kf.RayleighDamping.fit, frequencies=(1.0, 10.0), ratios=(0.01, 0.01))
on("kanefe.RayleighDamping.ratio", lambda: kf.RayleighDamping(0.1, 0.1), frequency=1.0)
on("kanefe.ModalDamping.ratios", lambda: kf.ModalDamping(0.1), count=3)
call("kanefe.Legendre", kf.Legendre, count=4)
call("kanefe.BSpline", kf.BSpline, degree=2, knots=3)
call("kanefe.InBox", kf.InBox, low=(0, 0, 0), high=(1, 1, 1))
call("kanefe.InCylinder", kf.InCylinder, start=(0, 0, 0), end=(1, 0, 0), radius=1.0, inner_radius=0.5)
call("kanefe.Near", kf.Near, point=(0, 0, 0), distance=1.0)
ON_SURFACE = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], float)
call("kanefe.LoadShape", kf.LoadShape, of="top", over=lambda x: 1.0 + x[:, 0])
call("kanefe.MappedField", kf.MappedField, points=ON_SURFACE, values=(1, 2, 3), reach=1.0)
on("kanefe.MappedField.__call__", lambda: kf.MappedField(ON_SURFACE, (1, 2, 3)), places=ON_SURFACE)
HISTORY = {"points": ON_SURFACE, "times": (0, 1), "values": ((1, 2, 3), (3, 2, 1)), "reach": 1.0}
call("kanefe.MappedHistory", kf.MappedHistory, **HISTORY)
on("kanefe.MappedHistory.__call__", lambda: kf.MappedHistory(**HISTORY), places=ON_SURFACE, t=0.5)
files("kanefe.MappedField.read", kf.MappedField.read, path="map.csv", length=1.0, value=1.0, reach=1.0)
call("kanefe.OnPlane", kf.OnPlane, point=(0, 0, 0), normal=(0, 0, 1), distance=0.1)
call(
    "kanefe.Interface",
    kf.Interface,
    fixed=("x",),
    kind="rigid",
    weights=None,
    position=None,
    axes=None,
    released=(),
    groups=None,
    at=None,
)
on("kanefe.Interface.group_names", kf.Interface, name="root")
call("kanefe.CraigBampton", kf.CraigBampton, modes=2, tol=1e-3, loads=(), error_up_to=None)
CALLS["kanefe.CraigBampton (frequency)"] = Call(lambda: (kf.CraigBampton, {"up_to_frequency": 100.0}))
call("kanefe.FreeInterface", kf.FreeInterface, modes=2, attachment=True, loads=(), error_up_to=None)
call("kanefe.Krylov", kf.Krylov, frequencies=(0.0,), order=2, loads=(), error_up_to=None)
call("kanefe.LoadCase", kf.LoadCase, name="l", forces=np.ones(30))
call("kanefe.PatchCase", kf.PatchCase, place="tip", most=4)
call(
    "kanefe.flexible_body",
    kf.flexible_body,
    model=steel_beam(4),
    interfaces={"root": "clamped"},
    reduction=kf.CraigBampton(modes=2),
    damping=kf.ModalDamping(0.01),
    stiffening="none",
)
on("kanefe.FiniteElementModel.group", lambda: steel_beam(4), name="root")
on("kanefe.FiniteElementModel.rigid_modes", lambda: steel_beam(4), about=(0.0, 0.0, 0.0))
on("kanefe.FlexibleBody.interface", beam, name="tip")
on("kanefe.FlexibleBody.load_pattern", loaded_body, name="right")
on("kanefe.FlexibleBody.node_displacements", beam, eta=np.zeros(2 + 6))
on("kanefe.FlexibleBody.node_velocities", beam, eta=np.zeros(2 + 6), deta=np.zeros(2 + 6))
on("kanefe.FlexibleBody.node_frame", beam, node=0)
on("kanefe.FlexibleBody.save", beam, path="body.h5")
files("kanefe.FlexibleBody.load", kf.FlexibleBody.load, path="body.h5")
call("kanefe.FlexibleLink", kf.FlexibleLink, body=beam(), at=(0, 0, 0), orientation=(1, 0, 0, 0), interfaces={})

SPRING = np.array([[1.0, -1.0], [-1.0, 1.0]])
EXPECTED = {"expected_mass": None, "expected_center": None, "expected_inertia": None}


def small_matrices() -> Good:
    model = steel_beam(2)
    return kf.model_from_matrices, {
        "mass": model.mass,
        "stiffness": model.stiffness,
        "nodes": model.nodes,
        "components": model.components,
        "damping": None,
        "groups": {"root": 0},
        "cells": (),
        "load_patterns": None,
        "geometric_stiffness": None,
        "stress_stiffness": None,
        "mass_field": None,
        "added_mass": None,
        "stresses": None,
        "order": "nodes",
        "generalised": 0,
        **EXPECTED,
        "source": "test",
    }


CALLS["kanefe.model_from_matrices"] = Call(small_matrices)
call(
    "kanefe.model_from_elements",
    kf.model_from_elements,
    elements=SimpleNamespace(nodes=[[0, 0, 0], [1, 0, 0]], mass=np.eye(2), stiffness=SPRING, components=("x",)),
    **EXPECTED,
)
call("kanefe.write_matrices", kf.write_matrices, model=steel_beam(2), path="m.npz")
call("kanefe.write_sid", kf.write_sid, body=beam(), path="b.sid", nodes=())
call(
    "kanefe.write_superelement",
    kf.write_superelement,
    body=beam(),
    path="b.bdf",
    form="nastran",
    boundary=None,
    modes=None,
)
files("kanefe.read_matrices", kf.read_matrices, path="model.npz", **EXPECTED)
files("kanefe.read_sid", kf.read_sid, path="body.sid", names=None, fixed=None, expected_mass=None)
files(
    "kanefe.read_matrix_market",
    kf.read_matrix_market,
    nodes=steel_beam(2).nodes,
    stiffness="stiffness.mtx",
    mass="mass.mtx",
    components=("x", "y", "z", "rx", "ry", "rz"),
    order="nodes",
    damping=None,
    groups=None,
    units="m, kg, s",
    **EXPECTED,
)
URDF = ROOT / "tests" / "robots" / "arm.urdf"
call(
    "kanefe.read_urdf",
    kf.read_urdf,
    path=URDF,
    base=None,
    gravity=(0, 0, -9.81),
    flexible=None,
    positions=None,
    limit_stiffness=None,
    limit_damping=0.0,
    joint_forces=True,
)
files(
    "kanefe.read_mjcf",
    kf.read_mjcf,
    path="robot.xml",
    gravity=None,
    flexible=None,
    positions=None,
    key=None,
    limit_stiffness=None,
    limit_damping=0.0,
    joint_forces=True,
)
