"""The parameters of the aircraft, its gear and the deck: all of them assumed."""

from __future__ import annotations

import math

import numpy as np

GRAVITY = 9.81

AIRFRAME_MASS, AIRFRAME_INERTIA = 1500.0, 700.0
"""kg, and kg m2 about its centre of mass and the ship's longitudinal axis."""

CG_HEIGHT = 1.40
"""Of the airframe's centre of mass over the bottoms of the undeformed skids, m."""

CORNERS = np.array(((-1.10, -1.40), (-0.45, -0.80), (0.45, -0.80), (1.10, -1.40)))
"""Skid, saddle, saddle, skid, from starboard to port: y and z from the centre of mass in axes of the airframe, m."""

ELEMENTS = 4
"""Of each of the three straight segments between the corners."""

YOUNG, DENSITY = 71.7e9, 2810.0
"""Of aluminium, Pa and kg/m3."""

DIAMETER, WALL = 0.0762, 0.00635
"""Of each of the two tubes that act as one, m."""

INNER = DIAMETER - 2.0 * WALL
AREA = 2.0 * math.pi / 4.0 * (DIAMETER**2 - INNER**2)
SECOND_MOMENT = 2.0 * math.pi / 64.0 * (DIAMETER**4 - INNER**4)

SKID_MASS = 12.0
"""At each end of the gear, kg."""

DAMPING_RATIO = 0.02
"""Of every mode of the gear with its saddles held and its skids free."""

DECK_HEIGHT = 6.0
"""Of the deck over its roll axis, m."""

NORMAL_STIFFNESS, NORMAL_DAMPING = 1e7, 0.3
"""k (N/m) and lambda (s/m) of a skid on the deck, N = k d max(0, 1 + lambda d')."""

TANGENTIAL_STIFFNESS, TANGENTIAL_DAMPING = 1e7, 1e4
"""Of what holds a skid across, N/m and N s/m."""

LASHING_STIFFNESS, LASHING_PRELOAD, LASHING_POINT = 5e5, 2000.0, 1.05
"""N/m; N, at the level rest; and how far from the middle of the deck it is fastened, m."""
