"""The parameters of the aircraft, its gear and the deck: all of them assumed."""

from __future__ import annotations

import math

import numpy as np

GRAVITY = 9.81

AIRFRAME_MASS, AIRFRAME_INERTIA = 1500.0, 700.0
"""Mass of the airframe, kg, and inertia about its centre of mass and the ship's longitudinal axis, kg m2."""

CG_HEIGHT = 1.40
"""Height of the airframe's centre of mass above the bottoms of the undeformed skids, m."""

CORNERS = np.array(((-1.10, -1.40), (-0.45, -0.80), (0.45, -0.80), (1.10, -1.40)))
"""Positions y and z of skid, saddle, saddle, skid, from starboard to port, from the centre of mass in axes of the
airframe, m."""

ELEMENTS = 4
"""Number of elements of each of the three straight segments between the corners."""

YOUNG, DENSITY = 71.7e9, 2810.0
"""Young's modulus (Pa) and density (kg/m3) of aluminium."""

DIAMETER, WALL = 0.0762, 0.00635
"""Outer diameter and wall thickness of each of the two tubes, which are combined into one beam, m."""

INNER = DIAMETER - 2.0 * WALL
AREA = 2.0 * math.pi / 4.0 * (DIAMETER**2 - INNER**2)
SECOND_MOMENT = 2.0 * math.pi / 64.0 * (DIAMETER**4 - INNER**4)

SKID_MASS = 12.0
"""Mass at each end of the gear, kg."""

DAMPING_RATIO = 0.02
"""Damping ratio of every mode of the gear with held saddles and free skids."""

DECK_HEIGHT = 6.0
"""Height of the deck above its roll axis, m."""

NORMAL_STIFFNESS, NORMAL_DAMPING = 1e7, 0.3
"""Stiffness k (N/m) and damping lambda (s/m) of a skid on the deck in N = k d max(0, 1 + lambda d')."""

TANGENTIAL_STIFFNESS, TANGENTIAL_DAMPING = 1e7, 1e4
"""Lateral stiffness (N/m) and damping (N s/m) of the friction anchor of a skid."""

LASHING_STIFFNESS, LASHING_PRELOAD, LASHING_POINT = 5e5, 2000.0, 1.05
"""Lashing: stiffness, N/m; preload on the level deck, N; distance of its fastening from the middle of the deck, m."""
