"""A helicopter on compliant skids, or on wheels, on a ship's deck, after SRAMSS-2D of Schock & Langlois (section V).

The paper describes the structure without numbers. The parameters here are assumed; they are exact, so that the results
of different programs can be compared.
"""

from kanefe_fem.sramss.aircraft_loads import add_haul_down as add_haul_down
from kanefe_fem.sramss.aircraft_loads import add_rotors as add_rotors
from kanefe_fem.sramss.aircraft_loads import add_wind as add_wind
from kanefe_fem.sramss.chocks import add_chocks as add_chocks
from kanefe_fem.sramss.gear import gear_body as gear_body
from kanefe_fem.sramss.planar import Deck as Deck
from kanefe_fem.sramss.planar import from_level as from_level
from kanefe_fem.sramss.planar import lashing_length as lashing_length
from kanefe_fem.sramss.planar import level_rest as level_rest
from kanefe_fem.sramss.planar import planar_scene as planar_scene
from kanefe_fem.sramss.probe import add_probe as add_probe
from kanefe_fem.sramss.spatial import lashing_lengths as lashing_lengths
from kanefe_fem.sramss.spatial import resting_on as resting_on
from kanefe_fem.sramss.spatial import solid_gear as solid_gear
from kanefe_fem.sramss.spatial import spatial_gear as spatial_gear
from kanefe_fem.sramss.spatial import spatial_scene as spatial_scene
from kanefe_fem.sramss.wheeled import wheeled_scene as wheeled_scene
