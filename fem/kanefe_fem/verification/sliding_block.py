"""K03: a block from a mesh that slides down a slope, at three sizes."""

from __future__ import annotations

import math
from collections.abc import Iterator

from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.scenes import whole_run
from kanefe.contact import Coulomb, KelvinVoigt
from kanefe.contact.shapes import Plane
from kanefe.equations.model import Model
from kanefe.fe_model.damping import ModalDamping
from kanefe.fe_model.places import OnPlane
from kanefe.joints import Free
from kanefe.reduction import CraigBampton
from kanefe.result import Result
from kanefe.system import System
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids.body import solid_body

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
GRAVITY, SLOPE, FRICTION = 9.81, math.radians(30.0), 0.3
FLAT = 0.5
"""Height of the block relative to its other edges."""

SOFT = 1e-3
"""Contact stiffness relative to that of a steel block of this size: the relative penetration is the same for all sizes.
"""

SETTLED = 400.0
"""Duration of a run relative to the time in which the contact vibrates by one radian; the first half is ignored."""


def block_on_slope(size: float, cells: tuple[int, int, int] = (4, 4, 2), modes: int = 6) -> tuple[Model, float]:
    """Return a block at rest with the static penetration into a slope, and the frequency of the contact, rad/s."""
    mesh = box_mesh((size, size, FLAT * size), cells, "hexahedron", start=(-0.5 * size, -0.5 * size, 0.0))
    body = solid_body(mesh, STEEL, {}, reduction=CraigBampton(modes=modes), damping=ModalDamping(0.05), progress=False)
    mass, stiffness = body.mass, SOFT * STEEL.E * size
    scene = System(gravity=(GRAVITY * math.sin(SLOPE), 0.0, -GRAVITY * math.cos(SLOPE)))
    depth = mass * GRAVITY * math.cos(SLOPE) / stiffness
    block = scene.add_flexible_body("block", body, joint=Free(position=(0.0, 0.0, -depth)))
    slope = scene.add_surface("slope", scene.ground, Plane("z"))
    law = KelvinVoigt(stiffness, damping=0.6 * math.sqrt(stiffness * mass))
    scene.add_contact("foot", block.patch(OnPlane((0, 0, 0), (0, 0, 1))), slope, normal=law, friction=Coulomb(FRICTION))
    return scene.freeze(), math.sqrt(stiffness / mass)


def sliding(reference: Reference) -> Iterator[Check]:
    """K03: the acceleration of the block after it has settled."""
    for size in (1.0, 0.1, 0.01):
        model, frequency = block_on_slope(size)
        end = SETTLED / frequency
        run = whole_run(model, (0.0, end), 1e-7, output_times=[0.0, 0.5 * end, end])
        speed = Result(model, run).velocity("block")[:, 0]
        found = float(speed[2] - speed[1]) / (0.5 * end)
        yield Check.relative(f"acceleration of a block of {size:g} m [m/s2]", found, reference.values["a"], 1e-6)


CASES = (Case("K03", sliding),)
