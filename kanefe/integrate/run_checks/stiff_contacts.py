"""Contacts that are stiffer than numbers can follow, or than a run can wait for."""

from __future__ import annotations

import math
import warnings
from typing import NamedTuple

import numpy as np

from kanefe.errors import SimulationWarning, outside
from kanefe.loads.base import has_contacts
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import kept_of_scene, scene_length

EPSILON = float(np.finfo(float).eps)

SOFT_ENOUGH = 1e6
"""Smallest deflection of a contact under its weight, in multiples of the round-off of positions, for a force of six
digits."""

STEPS_OF_PERIOD = 10.0
"""Steps in a period of a contact's vibration that resolve it."""


class StiffContact(NamedTuple):
    """A contact whose law is a straight line.

    Attributes
    ----------
    name : str
    stiffness, mass : float
        N/m, and of both bodies in series, kg.
    """

    name: str
    stiffness: float
    mass: float

    @property
    def period(self) -> float:
        """Period of vibrations on the contact, s."""
        return 2.0 * math.pi * math.sqrt(self.mass / self.stiffness)

    def __str__(self) -> str:
        return f"contact {self.name!r} of {self.stiffness:.3g} N/m"


@kept_of_scene
def stiffest_contact(model: ModelData) -> StiffContact | None:
    """Return the contact with the shortest period; None without one whose law is a straight line."""
    if not has_contacts(model.loads):
        return None
    from kanefe.contact.contact import compliant_contacts

    found = [
        StiffContact(contact.name, contact.straight, contact.mass)
        for _, contact in compliant_contacts(model.loads)
        if contact.straight is not None
    ]
    return min(found, key=lambda one: one.period, default=None)


def with_contact(model: ModelData, step: float, reason: str, remedy: str) -> tuple[str, str]:
    """Return a reason and a remedy that name the contact for which a step (s) is too long, if there is one."""
    contact = stiffest_contact(model)
    if contact is None or step * STEPS_OF_PERIOD <= contact.period:
        return reason, remedy
    reason += (
        f", too long for {contact}, on which {contact.mass:.3g} kg vibrates with a period of {contact.period:.2g} s"
    )
    return reason, f"{remedy} ({contact.period / STEPS_OF_PERIOD:.1g} s would resolve it)"


def warn_of_stiff_contacts(model: ModelData) -> None:
    """Warn of a contact that yields less under the weight on it than places are rounded by."""
    if text := _too_stiff(model):
        warnings.warn(text, SimulationWarning, stacklevel=outside())


@kept_of_scene
def _too_stiff(model: ModelData) -> str:
    """Return the text of that warning; empty if there is none."""
    contact, g = stiffest_contact(model), float(np.linalg.norm(model.gravity))
    if contact is None or g == 0.0:
        return ""
    weight, rounding = contact.mass * g, EPSILON * scene_length(model)
    depth = weight / contact.stiffness
    if not depth < rounding:
        return ""
    return (
        f"{contact} deflects by {depth:.2g} m under the weight on it, less than the round-off of positions in this "
        f"scene, {rounding:.2g} m: its force is noise, and the run may take very long. Remedy: a stiffness of at "
        f"most {weight / (SOFT_ENOUGH * rounding):.1g} N/m, or kanefe.Rigid()"
    )
