"""Laws of normal force and of friction, one a file, and the table of them: their public names, and how they are called.

A law is added by its file, which says what `NormalLaw` or `FrictionLaw` asks, and two lines here.
"""

from typing import Any

from kanefe.kernels.contact.laws.bump_stop import BUMP_STOP, with_hysteresis
from kanefe.kernels.contact.laws.bump_stop import BumpStop as BumpStop
from kanefe.kernels.contact.laws.compiled_law import BY_FUNCTION, by_function
from kanefe.kernels.contact.laws.compiled_law import CompiledLaw as CompiledLaw
from kanefe.kernels.contact.laws.coulomb import Coulomb as Coulomb
from kanefe.kernels.contact.laws.coulomb import coulomb
from kanefe.kernels.contact.laws.friction_law import Rubbed, Sliding
from kanefe.kernels.contact.laws.lugre import LUGRE, lugre
from kanefe.kernels.contact.laws.lugre import LuGre as LuGre
from kanefe.kernels.contact.laws.normal_law import NormalForce, Pressing
from kanefe.kernels.contact.laws.power_laws import KELVIN_VOIGT, by_power, spring_and_damper
from kanefe.kernels.contact.laws.power_laws import Hertz as Hertz
from kanefe.kernels.contact.laws.power_laws import HuntCrossley as HuntCrossley
from kanefe.kernels.contact.laws.power_laws import KelvinVoigt as KelvinVoigt
from kanefe.kernels.contact.laws.power_laws import Restitution as Restitution
from kanefe.kernels.contact.laws.stribeck import STRIBECK, stribeck
from kanefe.kernels.contact.laws.stribeck import Stribeck as Stribeck
from kanefe.kernels.contact.laws.table_law import TABLE, by_table
from kanefe.kernels.contact.laws.table_law import TableLaw as TableLaw
from kanefe.kernels.language import inlined


@inlined
def normal_force(kind: float, numbers: Any, at: int, point: Pressing) -> NormalForce:
    """Return what a law gives by its kind, of numbers from a place on."""
    if kind == BY_FUNCTION:
        found = by_function(numbers, at, point)
    elif kind == TABLE:
        found = by_table(numbers, at, point)
    elif kind == BUMP_STOP:
        found = with_hysteresis(numbers, at, point)
    elif kind == KELVIN_VOIGT:
        found = spring_and_damper(numbers, at, point)
    else:
        found = by_power(numbers, at, point)
    if found.force.real < 0.0:
        found = NormalForce(0.0 * found.force, found.elastic, found.energy, found.branch_rate)
    return found


@inlined
def rub(kind: float, numbers: Any, at: int, point: Sliding) -> Rubbed:
    """Return what friction gives at a point, likewise."""
    if kind == LUGRE:
        return lugre(numbers, at, point)
    if kind == STRIBECK:
        return stribeck(numbers, at, point)
    return coulomb(numbers, at, point)
