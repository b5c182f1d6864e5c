"""Loads, one concept per file. The names imported here are public, also for loads written by users."""

from typing import TYPE_CHECKING

from kanefe._public import lazy

if TYPE_CHECKING:
    from kanefe.loads.action import Action as Action
    from kanefe.loads.action import End as End
    from kanefe.loads.action import LoadKernel as LoadKernel
    from kanefe.loads.action import Tangent as Tangent
    from kanefe.loads.aerodynamics import Aerodynamics as Aerodynamics
    from kanefe.loads.base import Load as Load
    from kanefe.loads.base import LoadEvent as LoadEvent
    from kanefe.loads.bearing import Bearing as Bearing
    from kanefe.loads.guide import Guide as Guide
    from kanefe.loads.offered_function import compiled as compiled
    from kanefe.loads.oleo import Oleo as Oleo
    from kanefe.loads.periodic_load import PeriodicLoad as PeriodicLoad
    from kanefe.loads.rope import Rope as Rope
    from kanefe.loads.screened import ScreenedLoad as ScreenedLoad
    from kanefe.loads.winch import Winch as Winch
    from kanefe.loads.wind import Gust as Gust
    from kanefe.loads.wind import Turbulence as Turbulence
    from kanefe.loads.wind import Wind as Wind

_names, __getattr__, __dir__ = lazy(__file__, globals())
