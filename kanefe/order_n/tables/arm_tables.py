"""Arms of viscoelastic bodies that linearly implicit sweeps eliminate: `kanefe.kernels.bodies.Arm`."""

from __future__ import annotations

import numpy as np

from kanefe.order_n.tables.modal_constants import are_modes_of_unit_mass
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import kept_of_scene


@kept_of_scene
def swept_arms(model: ModelData) -> dict[int, np.ndarray]:
    """Return the mode, the state, the pull and the rate of each such arm, (arms, 4), by the number of their load.

    They pull on one mode each, of a body whose coordinates are modes of unit mass: as where all of it is of one
    material.
    """
    found = {}
    for number, load in enumerate(model.loads):
        if load.kind != "relaxation":
            continue
        from kanefe.bodies.mass_moments import MassMoments
        from kanefe.loads.body_relaxation import BodyRelaxation

        terms = model.bodies[load.ends[0].body].flexible
        if not isinstance(load, BodyRelaxation) or load.is_relaxed or terms is None:
            continue
        factors, moments, k = load.of.factors, terms.free_moments, terms.body.free_count
        alone = np.all(np.count_nonzero(factors, axis=0) == 1) and isinstance(moments, MassMoments)
        if alone and are_modes_of_unit_mass(moments.elastic_mass, terms.body.stiffness[:k, :k]):
            states = model.load_states[number].start + np.arange(factors.shape[1])
            modes = np.argmax(factors != 0.0, axis=0)
            found[number] = np.column_stack((modes, states, factors[modes, np.arange(len(modes))], 1.0 / load.of.times))
    return found
