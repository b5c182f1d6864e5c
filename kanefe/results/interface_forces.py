"""Coupling forces of a run: the force on a flexible body at an interface, in total and by source (Eq. 30)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.tree.neighbours import parts_of, sources_of

if TYPE_CHECKING:
    from kanefe.tree.model_data import ModelData
    from kanefe.tree.run_sweeps import RunForces


class RunStates(Protocol):
    """Requirements on a run in memory: `kanefe.results.channels.RunChannels`."""

    @property
    def model(self) -> ModelData: ...  # noqa: D102
    @property
    def times(self) -> Vector: ...  # noqa: D102
    @property
    def forces(self) -> RunForces: ...  # noqa: D102


def coupling_force(run: RunStates, body: str, interface: str, of: str) -> Matrix:
    """Return a part of the coupling force at an interface (Eq. 30), (T, 6); "" is the total.

    About the deformed position of the interface, in axes of G: see `kanefe.results.reader.Reader.coupling_force`.
    """
    number = run.model.index(body)
    names = sources_of(run.model)[number, interface].neighbours.parts(of, f"{interface!r} of {body!r}")
    wanted = [
        i
        for i, part in enumerate(parts_of(run.model))
        if (part.body, part.interface) == (number, interface) and part.name in names
    ]
    return sum((run.forces.part(i) for i in wanted), np.zeros((len(run.times), 6)))
