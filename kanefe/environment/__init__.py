"""The environment of a scene: seas, and ships that move in them."""

from kanefe.environment.rao.rao import MotionRao as MotionRao
from kanefe.environment.rao.rao_convention import RaoConvention as RaoConvention
from kanefe.environment.rao.rao_files import example_rao as example_rao
from kanefe.environment.rao.rao_files import read_rao as read_rao
from kanefe.environment.rao.roll_damping import RollDamping as RollDamping
from kanefe.environment.sea import Sea as Sea
from kanefe.environment.ship import Ship as Ship
