"""Names of classes in files: a class can move to another module, and saved bodies stay readable.

A name never changes; the module of its class is given only here.
"""

from __future__ import annotations

from dataclasses import is_dataclass
from importlib import import_module
from typing import Any

SAVED_CLASSES = {
    "beam inertia": "kanefe.bodies.exact.inertia:BeamInertia",
    "beam line": "kanefe.bodies.exact.beam_line:BeamLine",
    "cells": "kanefe.fe_model.model:Cells",
    "elasticity": "kanefe.fe_model.model:Elasticity",
    "exact beam": "kanefe.bodies.exact.beam:ExactBeam",
    "facet block": "kanefe.fe_model.loaded_face:FacetBlock",
    "finite element model": "kanefe.fe_model.model:FiniteElementModel",
    "flexible body": "kanefe.bodies.flexible:FlexibleBody",
    "inertia field": "kanefe.bodies.inertia_field:InertiaField",
    "interface frame": "kanefe.bodies.flexible:InterfaceFrame",
    "load pattern": "kanefe.fe_model.load_pattern:LoadPattern",
    "loaded face": "kanefe.fe_model.loaded_face:LoadedFace",
    "mass field": "kanefe.fe_model.model:MassField",
    "mass moments": "kanefe.bodies.mass_moments:MassMoments",
    "model record": "kanefe.fe_model.file:ModelRecord",
    "nodal moments": "kanefe.bodies.nodal_moments:NodalMoments",
    "nodal pattern": "kanefe.fe_model.load_pattern:NodalPattern",
    "node group": "kanefe.fe_model.model:NodeGroup",
    "node shares": "kanefe.fe_model.node_shares:NodeShares",
    "pressure change": "kanefe.fe_model.pressure_change:PressureChange",
    "ribs": "kanefe.fe_model.ribs:Ribs",
    "section frame": "kanefe.bodies.exact.beam:SectionFrame",
    "shell stack": "kanefe.fe_model.shell_stack:ShellStack",
    "relaxation": "kanefe.bodies.relaxation:Relaxation",
    "unreduced body": "kanefe.bodies.unreduced:UnreducedBody",
    "viscoelastic part": "kanefe.fe_model.model:ViscoelasticPart",
    "wet moments": "kanefe.bodies.wet_moments:WetMoments",
}
"""Classes that can be saved, as "module:Class" by name."""

_WORDS = {place: word for word, place in SAVED_CLASSES.items()}


def word_of(cls: type) -> str | None:
    """Return the name of a class in files, or None if it has none."""
    return _WORDS.get(f"{cls.__module__}:{cls.__qualname__}")


def class_of(word: str) -> Any:
    """Return the dataclass of a name in a file; a file cannot name anything else.

    Raises
    ------
    ValueError
        If there is no such name.
    """
    if word not in SAVED_CLASSES:
        raise ValueError(f"{word!r} is not a kind of object that this version knows")
    module, _, name = SAVED_CLASSES[word].partition(":")
    found: Any = getattr(import_module(module), name)
    if not is_dataclass(found):
        raise ValueError(f"{word!r} cannot be read from a file")
    return found
