"""The margins of rigid contacts in states of a run: the calls of the kernel that evaluates and looks at them."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler.arrays import NOT_CALLED
from kanefe.kernels.compiler.entries import LATER, Bound, Call
from kanefe.kernels.constraints.contact_margins import LeastMargins, Looked, watch_contacts
from kanefe.kernels.evaluation.evaluation import AT_TIME
from kanefe.kernels.loads.telling import States
from kanefe.kernels.scene import work_in
from kanefe.kernels.steppers.step_commands import VECTOR
from kanefe.kernels.values.records import column
from kanefe.order_n.evaluated import Evaluated
from kanefe.tree.model_data import QUADRATURES

NAMES = {"never": "never", "touch": "gap", "lift": "normal", "slip": "slip_margin", "stick": "left_of_slip"}
COLUMNS = {kind: column(LeastMargins, name) for kind, name in (NAMES | {"largest": "largest"}).items()}
"""Columns of what happens to rigid contacts, and of the largest force."""


class ContactLook:
    """One evaluation of a scene with rigid contacts, whose memory is looked into: of one thread at a time.

    Parameters
    ----------
    route : Evaluated
    """

    def __init__(self, route: Evaluated) -> None:
        model = route.model
        size = model.coordinate_count + model.free_count + model.state_count + QUADRATURES
        self.drives, self.inputs = np.zeros((len(model.drives), 3)), np.zeros_like(route.inputs.constants)
        self.vectors = np.zeros((VECTOR.slope + 1, size))
        kernel = route.kernel_in_space
        self.call = kernel.prepared(self.drives, self.inputs, self.vectors, np.empty(kernel.memory_size))
        memory = self.call.arguments[-1]
        self.workspace = work_in(route.scene, memory)
        self.looked = Looked(
            evaluation=self.call.for_kernels(),
            time_at=AT_TIME,
            speeds=model.free_count + model.driven_count,
            first_state=model.coordinate_count + model.free_count,
            drives=self.drives,
            inputs=self.inputs,
            vectors=self.vectors,
            frames=self.workspace.frames.numbers,
            multipliers=self.workspace.multipliers,
            holding=self.workspace.holding,
        )


def watching_contacts(route: Evaluated) -> Bound:
    """Return the kernel that writes margins, of a scene."""
    return watch_contacts.bound(LATER, LATER, route.scene, LATER, LATER)


def watching_call(route: Evaluated, watching: Bound, loads: Call | None, states: States, found: np.ndarray) -> Call:
    """Return the call that writes the values of loads, by a call of their own, and then those of rigid contacts."""
    of_loads = NOT_CALLED if loads is None else loads.for_kernels()
    return watching.prepared(ContactLook(route).looked, of_loads, states, found)
