"""Linear analysis: equilibrium, linearisation about a state, modes, Campbell diagram, frequency response, stability."""

from kanefe.linear.buckling_modes import Buckling as Buckling
from kanefe.linear.buckling_modes import buckling as buckling
from kanefe.linear.campbell_diagram import Campbell as Campbell
from kanefe.linear.campbell_diagram import campbell as campbell
from kanefe.linear.equilibria import Equilibrium as Equilibrium
from kanefe.linear.equilibria import equilibrium as equilibrium
from kanefe.linear.floquet_modes import FloquetModes as FloquetModes
from kanefe.linear.floquet_modes import floquet as floquet
from kanefe.linear.frequency_response import FrequencyResponse as FrequencyResponse
from kanefe.linear.linearisation import Linearisation as Linearisation
from kanefe.linear.linearisation import linearise as linearise
from kanefe.linear.modes import Modes as Modes
from kanefe.linear.sampled_loop import SampledLoop as SampledLoop
from kanefe.linear.sampled_loop import sampled_loop as sampled_loop
from kanefe.linear.stability import StabilityLimit as StabilityLimit
from kanefe.linear.stability import stability_limit as stability_limit
from kanefe.linear.stability_maps import stability_map as stability_map
from kanefe.linear.stability_over_speed import StabilityMap as StabilityMap
