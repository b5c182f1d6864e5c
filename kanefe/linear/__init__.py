"""Linear analysis: equilibrium, linearisation about a state, modes, Campbell diagram, frequency response, stability."""

from kanefe.linear.equilibrium.equilibria import Equilibrium as Equilibrium
from kanefe.linear.equilibrium.equilibria import equilibrium as equilibrium
from kanefe.linear.frequency_response import FrequencyResponse as FrequencyResponse
from kanefe.linear.linearisation import Linearisation as Linearisation
from kanefe.linear.linearisation import linearise as linearise
from kanefe.linear.modes.floquet_modes import FloquetModes as FloquetModes
from kanefe.linear.modes.floquet_modes import floquet as floquet
from kanefe.linear.modes.modes import Modes as Modes
from kanefe.linear.over_speed.campbell_diagram import Campbell as Campbell
from kanefe.linear.over_speed.campbell_diagram import campbell as campbell
from kanefe.linear.over_speed.stability_maps import stability_map as stability_map
from kanefe.linear.over_speed.stability_over_speed import StabilityMap as StabilityMap
from kanefe.linear.sampled.sampled_loop import SampledLoop as SampledLoop
from kanefe.linear.sampled.sampled_loop import sampled_loop as sampled_loop
from kanefe.linear.stability.buckling_modes import Buckling as Buckling
from kanefe.linear.stability.buckling_modes import buckling as buckling
from kanefe.linear.stability.stability_limit import StabilityLimit as StabilityLimit
from kanefe.linear.stability.stability_limit import stability_limit as stability_limit
