"""Rates that compiled code and plain Python must agree on: of scenes of every kind."""

import numpy as np

from kanefe.equations.model import Model
from kanefe.order_n.route import OrderN
from loop_scenes import four_bar
from random_scenes import Recipe, planar_model, random_model
from scenes import random_state

T = 0.37


def order_n(model: Model) -> OrderN:
    assert isinstance(model.route, OrderN)
    return model.route


def rates_of_recipes() -> list[np.ndarray]:
    """Return dy/dt of some scenes: rigid, flexible, with springs, with loops."""
    made = [
        (random_model(Recipe(3, bodies=12, loads=5)), 3),
        (random_model(Recipe(4, bodies=8, elastic=0.5, loads=5, slopes="tait-bryan")), 4),
        (random_model(Recipe(5, bodies=8, elastic=0.4, loads=3, between=4)), 5),
        (planar_model(Recipe(6, bodies=8, loads=3)), 6),
    ]
    found = []
    for model, seed in made:
        q, u = random_state(model, seed)
        found.append(order_n(model).held_rates(T, np.concatenate((q, u, np.zeros(2))))[0])
    model = four_bar().freeze()
    found.append(order_n(model).held_rates(T, np.concatenate((model.initial_state, np.zeros(2))))[0])
    return found
