"""The gear of SRAMSS-2D: two tubes as one frame of straight beams, with a mass at each skid."""

from __future__ import annotations

from typing import Literal, TypedDict

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.errors import ModelError
from kanefe.fe_model.damping import Damping, ModalDamping
from kanefe.fe_model.interface import Interface
from kanefe.reduction import flexible_body
from kanefe_fem.beams.body import beam_model
from kanefe_fem.beams.sections import Section
from kanefe_fem.lumped.parts import LumpedMass, attach
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.sramss import parameters as given

Saddles = Literal["fixed", "hinged"]

SKIDS = {"starboard": "starboard skid", "port": "port skid"}
SADDLES = {"starboard": "starboard saddle", "port": "port saddle"}


class GearKeywords(TypedDict, total=False):
    """Keywords of `gear_body`."""

    saddles: Saddles
    damping: Damping
    is_planar: bool


ALUMINIUM = Material(E=given.YOUNG, nu=0.33, rho=given.DENSITY)


def gear_body(saddles: Saddles = "fixed", *, damping: Damping = None, is_planar: bool = True) -> FlexibleBody:
    """Return the gear with all its degrees of freedom, in axes of the airframe with the origin at its centre of mass.

    Parameters
    ----------
    saddles : {"fixed", "hinged"}
        Held in the airframe in x, y and the rotation about z; or in x and y only, with a rotation that is continuous
        through them (the zero columns of section IV.C).
    damping : Damping
        Default: `parameters.DAMPING_RATIO` in every mode with the saddles held and the skids free.
    is_planar : bool
        Whether the beams are planar; beams in space are for a scene that is held in the plane by its joints.

    Raises
    ------
    ModelError
        If `saddles` is unknown.
    """
    if saddles not in ("fixed", "hinged"):
        raise ModelError(f"saddles are 'fixed' or 'hinged', not {saddles!r}")
    nodes = [given.CORNERS[0]]
    for a, b in zip(given.CORNERS[:-1], given.CORNERS[1:], strict=True):
        nodes += [a + (b - a) * k / given.ELEMENTS for k in range(1, given.ELEMENTS + 1)]
    names = (SKIDS["starboard"], SADDLES["starboard"], SADDLES["port"], SKIDS["port"])
    model = beam_model(
        np.array(nodes) if is_planar else np.column_stack((nodes, np.zeros(len(nodes)))),
        [(i, i + 1) for i in range(len(nodes) - 1)],
        Section(A=given.AREA, I_y=given.SECOND_MOMENT, I_z=given.SECOND_MOMENT, J=2.0 * given.SECOND_MOMENT),
        ALUMINIUM,
        theory="euler-bernoulli",
        planar=is_planar,
        rotary_inertia=False,
        groups={name: i * given.ELEMENTS for i, name in enumerate(names)},
    )
    model = attach(model, [LumpedMass(name, given.SKID_MASS) for name in SKIDS.values()])
    if saddles == "fixed":
        held = Interface(fixed="all")
    else:
        held = Interface(fixed=("x", "y") if is_planar else ("x", "y", "z", "rx", "ry"))
    return flexible_body(
        model,
        dict.fromkeys(SADDLES.values(), held),
        damping=ModalDamping(given.DAMPING_RATIO) if damping is None else damping,
    )
