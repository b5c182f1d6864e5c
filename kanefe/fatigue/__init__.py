"""Fatigue: cycles of stress histories and their damage.

A stress history, such as that of a strain gauge times Young's modulus, is counted by rainflow (ASTM E1049-85), and
Miner's rule adds up the damage of its cycles by an S-N curve: ``kf.fatigue.damage(stress, curve)``. The damage all over
a body is ``kanefe_fem.recover(result, "arm").damage(curve)``.
"""

from kanefe.fatigue.curve import SNCurve as SNCurve
from kanefe.fatigue.mean_stress import Gerber as Gerber
from kanefe.fatigue.mean_stress import Goodman as Goodman
from kanefe.fatigue.mean_stress import MeanStress as MeanStress
from kanefe.fatigue.mean_stress import Walker as Walker
from kanefe.fatigue.miner import Cycles as Cycles
from kanefe.fatigue.miner import Damage as Damage
from kanefe.fatigue.miner import count_cycles as count_cycles
from kanefe.fatigue.miner import damage as damage

__all__ = ["Cycles", "Damage", "Gerber", "Goodman", "MeanStress", "SNCurve", "Walker", "count_cycles", "damage"]
