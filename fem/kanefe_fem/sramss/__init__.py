"""A helicopter on compliant skids on a ship's deck, after SRAMSS-2D of Schock & Langlois (section V of the paper).

The paper tells the structure and no numbers: the parameters here are assumed, and exact, so that programs can agree.
"""

from kanefe_fem.sramss.gear import gear_body as gear_body
from kanefe_fem.sramss.planar import Deck as Deck
from kanefe_fem.sramss.planar import from_level as from_level
from kanefe_fem.sramss.planar import lashing_length as lashing_length
from kanefe_fem.sramss.planar import level_rest as level_rest
from kanefe_fem.sramss.planar import planar_scene as planar_scene
from kanefe_fem.sramss.planar import state_at as state_at
from kanefe_fem.sramss.spatial import lashing_lengths as lashing_lengths
from kanefe_fem.sramss.spatial import spatial_gear as spatial_gear
from kanefe_fem.sramss.spatial import spatial_scene as spatial_scene
