"""Laws of normal force and of friction, one a file, and the table of them: their public names, and how they are called.

A law is added by its file, which says what `NormalLaw` or `FrictionLaw` asks, and two lines here.
"""

from __future__ import annotations

from typing import Any

from kanefe.kernels.algebra.vectors import Numbers
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.contact.laws.bump_stop import BUMP_STOP, with_hysteresis
from kanefe.kernels.contact.laws.bump_stop import BumpStop as BumpStop
from kanefe.kernels.contact.laws.compiled_law import BY_FUNCTION, by_function
from kanefe.kernels.contact.laws.compiled_law import CompiledLaw as CompiledLaw
from kanefe.kernels.contact.laws.coulomb import Coulomb as Coulomb
from kanefe.kernels.contact.laws.coulomb import coulomb
from kanefe.kernels.contact.laws.lugre import LUGRE, lugre
from kanefe.kernels.contact.laws.lugre import LuGre as LuGre
from kanefe.kernels.contact.laws.power_laws import KELVIN_VOIGT, by_power, spring_and_damper
from kanefe.kernels.contact.laws.power_laws import Hertz as Hertz
from kanefe.kernels.contact.laws.power_laws import HuntCrossley as HuntCrossley
from kanefe.kernels.contact.laws.power_laws import KelvinVoigt as KelvinVoigt
from kanefe.kernels.contact.laws.power_laws import Restitution as Restitution
from kanefe.kernels.contact.laws.stribeck import STRIBECK, stribeck
from kanefe.kernels.contact.laws.stribeck import Stribeck as Stribeck
from kanefe.kernels.contact.laws.table_law import TABLE, by_table
from kanefe.kernels.contact.laws.table_law import TableLaw as TableLaw


@inlined
def normal_force(
    kind: float, numbers: Any, at: int, share: float, depth: Any, rate: Any, more: Any, branch: Any
) -> Any:
    """Return normal force (N), its elastic part and the energy of that (J), and the rate of the branch (1/s).

    Parameters
    ----------
    kind : float
        Of the law, whose numbers are from `at` on.
    share : float
        Of the contact, that the point has.
    depth, rate : float
        m, above 0, and m/s.
    more : float
        What an impact added to the damping.
    branch : float
        Of a hysteresis, -1 to 1.
    """
    if kind == BY_FUNCTION:
        found = by_function(numbers, at, share, depth, rate, more, branch)
    elif kind == TABLE:
        found = by_table(numbers, at, share, depth, rate, more, branch)
    elif kind == BUMP_STOP:
        found = with_hysteresis(numbers, at, share, depth, rate, more, branch)
    elif kind == KELVIN_VOIGT:
        found = spring_and_damper(numbers, at, share, depth, rate, more, branch)
    else:
        found = by_power(numbers, at, share, depth, rate, more, branch)
    force, elastic, energy, branch_rate = found
    if force.real < 0.0:
        force = 0.0 * force
    return force, elastic, energy, branch_rate


@inlined
def rub(
    kind: float,
    numbers: Any,
    at: int,
    share: float,
    pressed: Any,
    normal: Numbers,
    A_s: Numbers,
    along: Numbers,
    w: Numbers,
    is_held: bool,
    waits: bool,
    rests: bool,
) -> Any:
    """Return what friction gives at a point that touches.

    Parameters
    ----------
    kind : float
        Of the law, whose numbers are from `at` on.
    share : float
        Of the contact, that the point has.
    pressed : float
        Normal force, N.
    normal, along, w : tuple of 3 floats
        Normal; velocity along the surface, m/s; stretch, m; in N.
    A_s : tuple of 9 floats
        From the axes of the surface to those of N.
    is_held : bool
        Whether it sticks as far as that is remembered.
    waits : bool
        Whether an event ends the sticking: see `kanefe.kernels.constraints.tolerances.HELD_BEYOND`.
    rests : bool
        Whether the stretch follows the motion from a state of rest.

    Returns
    -------
    tuple
        Friction (3 numbers, N, against the motion), rate of the stretch (3, m/s), stiffness whose energy is in the
        stretch (N/m), speed of the slip (m/s), and the pull beyond what friction holds, or what of it slips (N).
    """
    if kind == LUGRE:
        return lugre(numbers, at, pressed, normal, along, w, rests)
    if kind == STRIBECK:
        return stribeck(numbers, at, share, pressed, normal, along, w, is_held, waits)
    return coulomb(numbers, at, share, pressed, normal, A_s, along, w, is_held, waits)
