"""Good calls of finite elements."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

import kanefe as kf
import kanefe_fem as fem
from good_call import CALLS, FILES, Call, call, on
from good_results import result
from repository import ROOT
from steel_beams import STEEL, steel_beam
from step_files import hinge, write_step

call("kanefe_fem.Material", fem.Material, E=210e9, nu=0.3, rho=7850.0, name="steel")
call(
    "kanefe_fem.Orthotropic",
    fem.Orthotropic,
    E1=1e11,
    E2=1e10,
    E3=1e10,
    nu12=0.3,
    nu13=0.3,
    nu23=0.3,
    G12=5e9,
    G13=5e9,
    G23=4e9,
    rho=1600.0,
    name="cfrp",
)
call(
    "kanefe_fem.Orthotropic.transversely_isotropic",
    fem.Orthotropic.transversely_isotropic,
    E1=1e11,
    E2=1e10,
    nu12=0.3,
    nu23=0.3,
    G12=5e9,
    rho=1600.0,
    name="cfrp",
)
call("kanefe_fem.Anisotropic", fem.Anisotropic, stiffness=np.eye(6) * 1e9, rho=1000.0, name="a")
LOSSY = fem.Material(E=3e6, nu=0.45, rho=1000.0, loss_factor=0.2)
call("kanefe_fem.Material.viscoelastic", LOSSY.viscoelastic, band=(5.0, 500.0))
call("kanefe_fem.prony_of_loss_factor", fem.prony_of_loss_factor, loss_factor=0.2, band=(5.0, 500.0))
call("kanefe_fem.Ply", fem.Ply, material=STEEL, thickness=0.01, angle=0.1)
call("kanefe_fem.Laminate", fem.Laminate, plies=[fem.Ply(STEEL, 0.01)], name="l")
call("kanefe_fem.Strengths", fem.Strengths, Xt=1.5e9, Xc=1.2e9, Yt=5e7, Yc=2e8, S=7e7, interaction=-0.5)
call("kanefe_fem.ShellFace", fem.ShellFace, side="bottom", of="body")
call("kanefe_fem.Oriented", fem.Oriented, material=STEEL, axes=np.eye(3))


def energy(strain: Any) -> Any:
    import ufl

    return 1e9 * ufl.inner(strain, strain)


call("kanefe_fem.UserEnergy", fem.UserEnergy, energy=energy, rho=1000.0, of="strain", name="u")


def mass(f: Any) -> Any:
    return f.mass


call("kanefe_fem.Forms", fem.Forms, mass=mass)
call(
    "kanefe_fem.PotentialFlow",
    fem.PotentialFlow,
    mesh=fem.box_mesh((1.0, 0.1, 0.1), (2, 1, 1)),
    wet="root",
    density=1000.0,
    far=["tip"],
    center=(0.0, 0.0, 0.0),
    thickness=1.0,
)
call("kanefe_fem.axes_at_angle", fem.axes_at_angle, angle=0.1, axis=(0, 0, 1), along=(1, 0, 0))
call("kanefe_fem.cylindrical_axes", fem.cylindrical_axes, origin=(0, 0, 0), axis=(0, 0, 1), first="outward")
call("kanefe_fem.spherical_axes", fem.spherical_axes, origin=(0, 0, 0), pole=(0, 0, 1), first="outward")
call("kanefe_fem.Box", fem.Box, width=0.1, height=0.1, thickness=0.01, nu=0.3)
call("kanefe_fem.Rectangle", fem.Rectangle, width=0.1, height=0.1, nu=0.3)
call("kanefe_fem.SolidCircle", fem.SolidCircle, diameter=0.1, nu=0.3)
call("kanefe_fem.Tube", fem.Tube, outer_diameter=0.1, thickness=0.01, nu=0.3)
call("kanefe_fem.Section", fem.Section, A=1e-4, I_y=1e-9, I_z=1e-9, J=1e-9, shear_y=0.8, shear_z=0.8)
call(
    "kanefe_fem.Section.from_stiffness",
    fem.Section.from_stiffness,
    EA=1e7,
    EI_y=1e3,
    EI_z=1e3,
    GJ=1e3,
    GA_y=1e7,
    GA_z=1e7,
    rho_A=1.0,
    rho_I=1e-4,
    centre_of_mass=(0.0, 0.0),
)
call("kanefe_fem.LumpedMass", fem.LumpedMass, at="tip", mass=1.0, inertia=(1.0, 1.0, 1.0), position=None)
call("kanefe_fem.LumpedSpring", fem.LumpedSpring, at="tip", stiffness=(1.0,) * 6, to=None, position=None)
call("kanefe_fem.attach", fem.attach, model=steel_beam(4), lumped=[fem.LumpedMass("tip", 1.0)])
BEAM = {"theory": "timoshenko", "planar": False, "orientation": None, "rotary_inertia": True}
SECTION = fem.Rectangle(0.02, 0.02)
call(
    "kanefe_fem.straight_beam",
    fem.straight_beam,
    length=1.0,
    section=SECTION,
    material=STEEL,
    elements=2,
    direction=(1, 0, 0),
    start=(0, 0, 0),
    **BEAM,
)
call(
    "kanefe_fem.beam_model",
    fem.beam_model,
    nodes=[(0, 0, 0), (1, 0, 0), (2, 0, 0)],
    elements=[(0, 1), (1, 2)],
    section=SECTION,
    material=STEEL,
    **BEAM,
    groups={"root": 0, "tip": -1},
    lines=None,
)
call(
    "kanefe_fem.beam_body",
    fem.beam_body,
    model=steel_beam(4),
    interfaces={"root": "clamped"},
    reduction=kf.CraigBampton(modes=2),
    damping=kf.ModalDamping(0.01),
    stiffening="none",
    lines=None,
)
SEGMENTS = {
    "interfaces": {"root": "clamped", "tip": "rigid"},
    "materials": None,
    "segments": 2,
    "accuracy": None,
    "loads": None,
    "along": None,
    "line": None,
    "reduction": kf.CraigBampton(modes=1),
    "damping": kf.RayleighDamping(0.0, 1e-5),
    "stiffening": "none",
    "cuts": "average",
}
call("kanefe_fem.segmented", fem.segmented, body=steel_beam(4), **SEGMENTS)
chain = cache(lambda: fem.segmented(steel_beam(4), **SEGMENTS))
on("kanefe.SegmentedBody.segment_of", chain, interface="tip")
on("kanefe.SegmentedBody.place_of_node", chain, node=1)
on("kanefe.SegmentedBody.rebuilt", chain, reduction=None, stiffening="none", refined=1, order=None, segments=2)
call(
    "kanefe_fem.exact_beam",
    fem.exact_beam,
    length=1.0,
    section=SECTION,
    material=STEEL,
    theory="shear-rigid",
    planar=False,
    basis=2,
    curvature=(0.0, 0.1, 0.0),
    axes=((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    interfaces={"tip": 1.0},
    damping=kf.ModalDamping(0.01),
)
call(
    "kanefe_fem.box_mesh",
    fem.box_mesh,
    size=(1.0, 1.0, 1.0),
    counts=(1, 1, 1),
    kind="hexahedron",
    start=(0.0, 0.0, 0.0),
)
call("kanefe_fem.cylinder_mesh", fem.cylinder_mesh, length=1.0, radius=0.5, counts=(1, 1, 8), inner_radius=0.2, order=2)
call("kanefe_fem.rectangle_mesh", fem.rectangle_mesh, length=1.0, height=1.0, counts=(1, 1), start=(0.0, 0.0))
box = cache(lambda: fem.box_mesh((1.0, 1.0, 1.0), (1, 1, 1)))
on("kanefe_fem.Mesh.with_groups", box, places={"a": kf.OnPlane((0, 0, 0), (1, 0, 0))})
on("kanefe_fem.Mesh.with_order", box, order=2)
call("kanefe_fem.refined_mesh", fem.refined_mesh, mesh=box(), times=1)
call("kanefe_fem.read_mesh", fem.read_mesh, path=ROOT / "meshes" / "arm.msh", order=None, names=None, cells=None)
STEP = cache(lambda: write_step(FILES / "hinge.step", hinge, names=("fork", "arm", "pin")))
DENSITY = {"materials": {"*": 1e3}, "flexible": (), "order": 2, "overlaps": False}
CALLS["kanefe_fem.read_step"] = Call(lambda: (fem.read_step, {"path": STEP(), **DENSITY}))
hinged = cache(lambda: fem.read_step(STEP(), **DENSITY))
SCENE = {"ground": "fork", "joints": ["pin in fork"]}
on("kanefe_fem.Assembly.scene", hinged, **SCENE, without=["arm"], gravity=(0, 0, -9.81), reduction=None, damping=None)
on("kanefe_fem.Assembly.unreached", hinged, **SCENE)
on("kanefe_fem.ProposedJoint.joint", lambda: hinged().joints["pin in fork"], kind="revolute")
call("kanefe_fem.rosette_principal", fem.rosette_principal, strains=np.zeros((2, 3)), angles=(0.0, 0.8, 1.6))
call("kanefe_fem.recover", fem.recover, result=result(), name="beam", times=None, frames=None, material=None)
SOLID = {
    "order": 1,
    "plane": None,
    "thickness": None,
    "surfaces": (),
    "cells": None,
    "densities": None,
    "lumped": (),
    "preload": None,
    "forms": None,
}
call("kanefe_fem.solid_model", fem.solid_model, mesh=box(), materials=STEEL, **SOLID)
call(
    "kanefe_fem.solid_body",
    fem.solid_body,
    mesh=box(),
    materials=STEEL,
    interfaces={"left": "clamped"},
    reduction=kf.CraigBampton(modes=2),
    damping=kf.ModalDamping(0.01),
    stiffening="none",
    **SOLID,
    cache=False,
    progress=None,
)
call(
    "kanefe_fem.Preload",
    fem.Preload,
    held={"left": ("x", "y", "z")},
    forces={"right": (1.0, 0, 0)},
    tractions={},
    pressures={},
    acceleration=(0, 0, 0),
    angular_velocity=(0, 0, 0),
    center=(0, 0, 0),
    thermal_strain=0.0,
)

SHELL = {
    "thickness": 0.01,
    "offset": 0.0,
    "fold": 0.35,
    "shear_factor": None,
    "cells": None,
    "beams": None,
    "lumped": (),
}
SHEET = fem.surface_mesh(lambda s, r: (s, r, 0.0 * s), (2, 1))
call("kanefe_fem.surface_mesh", fem.surface_mesh, place=lambda s, r: (s, r, 0.0 * s), counts=(2, 1))
call(
    "kanefe_fem.Stiffener",
    fem.Stiffener,
    section=SECTION,
    material=STEEL,
    offset=(0.0, 0.0, 0.01),
    orientation=(0.0, 0.0, 1.0),
)
DECK = FILES / "sheet.bdf"
DECK.write_text(
    "BEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nCQUAD4,1,7,1,2,3,4\n"
    "PSHELL,7,1,0.02,1\nMAT1,1,7.E10,,0.33,2700.\nENDDATA\n"
)
call("kanefe_fem.shell_properties", fem.shell_properties, path=DECK, names=None)
call("kanefe_fem.shell_model", fem.shell_model, mesh=SHEET, materials=STEEL, **SHELL)
call(
    "kanefe_fem.shell_body",
    fem.shell_body,
    mesh=SHEET,
    materials=STEEL,
    interfaces={"root": "clamped"},
    reduction=kf.CraigBampton(modes=2),
    damping=None,
    stiffening="none",
    **SHELL,
    cache=False,
    progress=None,
)
