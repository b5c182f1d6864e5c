"""Static states of full-order models that are clamped at some nodes."""

from __future__ import annotations

import numpy as np
import scipy.sparse.linalg as spla


def held(model, root):
    """Return the degrees of freedom that are left when some nodes are clamped."""
    width = len(model.components)
    fixed = (np.asarray(root)[:, None] * width + np.arange(width)).ravel()
    return np.setdiff1d(np.arange(model.size), fixed)


def static(model, free, f):
    """Return the displacement under the nodal load f of a model held but for some degrees of freedom."""
    u = np.zeros(model.size)
    u[free] = spla.spsolve(model.stiffness[free][:, free].tocsc(), f[free])
    return u


def tip_load(model, component, size=1.0):
    """Return the load of one component at the last node."""
    f = np.zeros(model.size)
    f[(len(model.nodes) - 1) * len(model.components) + model.components.index(component)] = size
    return f
