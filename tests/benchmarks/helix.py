"""The whole helix: CPU time of a rest that coils a straight cantilever by ten turns (Ibrahimbegovic 1997).

The same beams are at rest under a twentieth and a tenth of the loads first, where their tip must be as well.

    python tests/benchmarks/helix.py [--json FILE] [--only TEXT] [--quick]

A dead couple of 200 pi N m and a dead force of 50 N about and along z at the tip of a beam of 10 m along x; EA = GA =
1e4 N, EI = GJ = 100 N m2. Newton's method does not find the rest from the straight beam; the loads are raised by
themselves. The reference is by shooting of the beam's differential equations, at a relative tolerance of 1e-11,
followed along the load from zero.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.clocks import Disagreement, seconds
from benchmarks.command_line import parser, run
from benchmarks.goals import Figure, Goal

if TYPE_CHECKING:
    import kanefe as kf

TIP = (0.00480324966, 0.0000724968464, -0.0764417417)
"""Place of the tip, m."""

PARTS = {
    0.05: (0.7114810288724, 6.285664430812771, 2.750736205012037),
    0.1: (0.410203352617302, 0.053770903120071, -1.091729019348189),
}
"""Place of the tip under shares of the loads, m: case G07 of `kanefe verify`."""

LENGTH = 10.0


class Coil(NamedTuple):
    """How the beam is cut, its functions of twist and curvatures and of stretch and shears, and the error it reaches.

    `error` is of the place of the tip over the length.
    """

    beams: int
    bending: int
    stretch: int
    error: float
    slow: bool = False

    @property
    def goal(self) -> Goal:
        """The goal of the figure."""
        what = f"helix of ten turns, {self.beams} beams of {self.bending} functions, to {self.error:g} of the length"
        return Goal(f"{what}: CPU time [s]", 60.0)


COILS = (Coil(2, 14, 6, 1e-4), Coil(8, 6, 5, 1e-5), Coil(2, 20, 20, 1e-6, slow=True))


def arguments() -> argparse.Namespace:
    """Return the options of the command line."""
    return parser(__doc__, quick="only the fewest functions").parse_args()


def measured(options: argparse.Namespace) -> list[Figure]:
    """Return all figures."""
    chosen = (coil for coil in COILS if options.only in coil.goal.what and not (options.quick and coil.slow))
    return [coiled(coil) for coil in chosen]


def coiled(coil: Coil) -> Figure:
    """Return the time of a rest, which must be as good as the coil says."""
    import numpy as np

    import kanefe as kf
    from kanefe_fem import Section, exact_beam

    section = Section.from_stiffness(EA=1e4, GA_y=1e4, GA_z=1e4, GJ=100.0, EI_y=100.0, EI_z=100.0, rho_A=1.0)
    basis = dict.fromkeys(("twist", "curvature_y", "curvature_z"), coil.bending)
    basis |= dict.fromkeys(("stretch", "shear_y", "shear_z"), coil.stretch)
    length = LENGTH / coil.beams
    places = {"middle": 0.5 * length, "tip": length}
    beam = exact_beam(length, section, theory="shear-deformable", basis=basis, interfaces=places)

    def loaded(share: float) -> kf.System:
        scene, tip = kf.System(), None
        for i in range(coil.beams):
            tip = scene.add_flexible_body(f"beam {i}", beam, **({"parent": tip} if tip else {})).interface("tip")
        scene.add_force(tip, (0.0, 0.0, 50.0 * share))
        scene.add_torque(tip, (0.0, 0.0, 200.0 * math.pi * share))
        return scene

    def missed(rest: kf.Equilibrium, place: tuple[float, ...]) -> float:
        error = float(np.linalg.norm(rest.position(f"beam {coil.beams - 1}", "tip") - place)) / LENGTH
        if error > coil.error:
            raise Disagreement(f"{coil.goal.what}: error {error:.2g}")
        return error

    parts = [missed(kf.equilibrium(loaded(share)), place) for share, place in PARTS.items()]
    model, found = loaded(1.0).freeze(), []
    taken = seconds(lambda: found.append(kf.equilibrium(model)))
    errors = ", ".join(f"{error:.2g}" for error in (missed(found[0], TIP), *parts))
    told = f"{model.free_count} coordinates, errors {errors} under all, a twentieth and a tenth of the loads"
    return coil.goal.figure(taken, told)


if __name__ == "__main__":
    sys.exit(run(arguments(), measured))
