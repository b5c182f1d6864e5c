"""A state of rest or of steady motion, with all outputs of a run for one time."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.instants.instant import Instant
from kanefe.linear.imbalance import Imbalance
from kanefe.linear.small_motions import SmallMotions
from kanefe.scene.targets import Named
from kanefe.tree.bending import Bending, worst_bending
from kanefe.tree.resolution import Resolution, worst_resolution

if TYPE_CHECKING:
    from kanefe.linear.equilibrium.other_rest import OtherRest
    from kanefe.linear.linearisation import Linearisation

MOST_NAMED = 6
"""Largest number of modal coordinates of a body that are listed individually."""


class Equilibrium(Instant):
    """A state of rest or of steady motion, found by `equilibrium`; it has all outputs of a `Result` for one time.

    Stresses at rest or in steady rotation: ``kanefe_fem.recover(found, "blade").von_mises``. A run that starts from it:
    ``scene.simulate((0.0, 1.0), start=found)``.

    Attributes
    ----------
    model : Model
    time : float
        s.
    state : ndarray
        y = (q, u, z) of the model, named by `Model.state_names`.
    imbalance : Imbalance
        The largest remaining imbalance.
    iterations : int
    """

    def __init__(
        self,
        model: Model,
        time: float,
        state: Vector,
        imbalance: Imbalance,
        iterations: int,
        begun: Model,
        small: SmallMotions,
    ) -> None:
        super().__init__(model, time, state)
        self.imbalance, self.iterations, self._begun, self._small = imbalance, iterations, begun, small

    def __str__(self) -> str:
        left = "nothing is left free to move"
        if self.imbalance.name:
            left = f"largest imbalance: {self.imbalance}, {self.imbalance.ratio:.1e} of the forces there"
        lines = [f"equilibrium at t = {self.time:g} s after {self.iterations} iterations; {left}"]
        coordinates = [f"  {name}: {value:.6g}" for name, value in self.coordinates.items()]
        for body in reversed(self.model.bodies):
            if body.flexible is not None and body.flexible.body.free_count > MOST_NAMED:
                eta = self.q[body.flexible.eta]
                at = int(np.argmax(np.abs(eta)))
                coordinates[body.flexible.eta] = [
                    f"  {body.name}: {len(eta)} modal coordinates, the largest eta {at}: {eta[at]:.6g}"
                ]
        bending = self.bending
        coordinates += [f"  bending inside bodies: {bending}"] if bending is not None else []
        resolution = self.resolution
        coordinates += [f"  strains {resolution}"] if resolution is not None else []
        other = [f"  {self.other_rest}"] if self.other_rest is not None else []
        return "\n".join([*lines, *coordinates, *self._contacts_in_words(), *other])

    @property
    def bending(self) -> Bending | None:
        """The largest rotation within a flexible body: of the one closest to its limit, or farthest beyond it."""
        return worst_bending(self.model, np.array([self.time]), self.q[None])

    @property
    def resolution(self) -> Resolution | None:
        """How far last functions and quadratures move a beam that bends far: that with the most over its length.

        By itself: what forces that change with the shape add to it is not estimated, which may be several times as much
        in a soft scene.
        """
        return worst_resolution(self.model, np.array([self.time]), self.q[None])

    @cached_property
    def other_rest(self) -> OtherRest | None:
        """Another rest on contacts near this one, if it is close to tipping or some contacts have lifted."""
        if not self.contacts:
            return None
        from kanefe.linear.equilibrium.other_rest import other_rest

        return other_rest(self.model, self.time, self.q, self.u, self._begun)

    @property
    def carrying(self) -> dict[str, float]:
        """Normal forces of the loaded contacts by name, N; all outputs of a contact: ``contact(name)``."""
        forces = {name: float(self.contact(name).normal) for name in self.contacts}
        return {name: force for name, force in forces.items() if force > 0.0}

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Rigid contacts whose normal forces are not unique for rigid bodies; those of least norm are returned."""
        if not self.model.rigid_contacts:
            return ()
        from kanefe.linear.equilibrium.rigid_rest import undetermined

        return undetermined(self.model.literal.at(self.time, self.q, self.u, self.z))

    def _contacts_in_words(self) -> list[str]:
        """Return a line for each contact."""
        lines, carrying, shared = [], self.carrying, self.undetermined
        for name in self.contacts:
            one = self.contact(name)
            if name not in carrying:
                lines.append(f"  contact {name}: carries nothing, gap {-float(one.penetration):.4g} m")
                continue
            rubs = f", friction {float(one.tangential):.6g} N" if float(one.tangential) > 0.0 else ""
            how = " (not unique for rigid bodies: of least norm)" if name in shared else ""
            lines.append(f"  contact {name}: carries {carrying[name]:.6g} N{how}{rubs}")
        return lines

    def linearise(self, *, inputs: Named | None = None, outputs: Named | None = None) -> Linearisation:
        """Linearise about this state: see `kanefe.linearise`."""
        from kanefe.linear.linearisation import linearised

        return linearised(self.model, self.time, self.state, inputs, outputs, self._small)
