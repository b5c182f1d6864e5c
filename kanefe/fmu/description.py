"""modelDescription.xml: variables, units and capabilities of a model, for FMI 2.0 and 3.0."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple
from xml.etree import ElementTree as Tree

from kanefe._version import __version__
from kanefe.errors import ModelError

TIME = "time"
"""Name of the independent variable."""

BASE = {
    "m": {"m": 1},
    "s": {"s": 1},
    "kg": {"kg": 1},
    "rad": {"rad": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
}
"""Powers of the base units of each unit."""

INITIAL = {"output": "calculated", "derivative": "calculated", "state": "exact"}
"""Attribute "initial" of variables, by role."""


class Variable(NamedTuple):
    """A variable of a model.

    Attributes
    ----------
    name, unit : str
    start : float
        Initial value of an input or a state.
    inputs, states : tuple of int
        Those by number that an output, or the rate of a state, depends on at once.
    """

    name: str
    unit: str
    start: float = 0.0
    inputs: tuple[int, ...] = ()
    states: tuple[int, ...] = ()


class UnitDescription(NamedTuple):
    """Description of a model for the programs that run it.

    Attributes
    ----------
    name, identifier, text, token : str
        The identifier names its files; the importing program passes the token to each instance.
    inputs, outputs, states : tuple of Variable
        Only a model for exchange has states.
    is_linear : bool
        Whether it is a model for exchange, else for co-simulation.
    start, every : float
        Start time and usual communication step, s.
    keeps_states : bool
        Whether its states can be read, set and serialised.
    """

    name: str
    identifier: str
    text: str
    token: str
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    states: tuple[Variable, ...]
    is_linear: bool
    start: float
    every: float
    keeps_states: bool = True

    def checked(self) -> UnitDescription:
        """Return the description; raise a ModelError if a name is not valid for a variable."""
        names = [variable.name for variable, _, _ in self.variables()]
        for name in names:
            if not name.strip() or not name.isprintable():
                raise ModelError(f"a variable of a unit cannot be called {name!r}. Remedy: a printable name")
            if names.count(name) > 1:
                also = ", as the time is" if name == TIME else ""
                raise ModelError(f"two variables of a unit cannot be called {name!r}{also}. Remedy: another name")
        return self

    def xml(self, version: str) -> bytes:
        """Return the file, for version "2.0" or "3.0"."""
        root = _of_two(self) if version == "2.0" else _of_three(self)
        Tree.indent(root)
        return b'<?xml version="1.0" encoding="UTF-8"?>\n' + Tree.tostring(root, encoding="utf-8") + b"\n"

    def variables(self) -> Iterator[tuple[Variable, str, int]]:
        """Yield all variables with their role and, for a derivative, the number of its state, else -1."""
        yield from ((variable, "input", -1) for variable in self.inputs)
        yield from ((variable, "output", -1) for variable in self.outputs)
        yield Variable(TIME, "s"), "independent", -1
        first = len(self.inputs) + len(self.outputs) + 1
        yield from ((variable, "state", -1) for variable in self.states)
        for i, variable in enumerate(self.states):
            yield variable._replace(name=f"der({variable.name})", unit=_rate(variable.unit)), "derivative", first + i


def _rate(unit: str) -> str:
    if unit.endswith("/s"):
        return f"{unit}2"
    return f"{unit}/s" if unit else ""


def _root(of: UnitDescription, version: str, token: str, *of_states: str, **more: str) -> Tree.Element:
    """Return the document up to its variables; `token` and `of_states` are the names of these attributes."""
    attributes = {"fmiVersion": version, "modelName": of.name, token: of.token, "description": of.text}
    attributes |= {"generationTool": f"kanefe {__version__}", "variableNamingConvention": "flat"}
    root = Tree.Element("fmiModelDescription", attributes | more)
    able = {"modelIdentifier": of.identifier, **(dict.fromkeys(of_states, "true") if of.keeps_states else {})}
    if of.is_linear:
        Tree.SubElement(root, "ModelExchange", able)
    else:
        Tree.SubElement(root, "CoSimulation", able | {"canHandleVariableCommunicationStepSize": "true"})
    listed = Tree.SubElement(root, "UnitDefinitions")
    for unit in sorted({variable.unit for variable, _, _ in of.variables() if variable.unit}):
        element = Tree.SubElement(listed, "Unit", name=unit)
        powers = base_powers(unit)
        if powers is not None:
            Tree.SubElement(element, "BaseUnit", {name: str(power) for name, power in powers.items() if power})
    times = {"startTime": repr(of.start)} | ({} if of.is_linear else {"stepSize": repr(of.every)})
    Tree.SubElement(root, "DefaultExperiment", times)
    return root


def base_powers(unit: str) -> dict[str, int] | None:
    """Return the powers of kg, m, s and rad of a unit such as "N m" or "rad/s2"; None if it has others."""
    powers: dict[str, int] = {}
    for i, part in enumerate(unit.split("/")):
        for token in part.split():
            found = re.fullmatch(r"([A-Za-z]+)(\d*)", token)
            if token == "1":
                continue
            if found is None or found[1] not in BASE:
                return None
            for name, power in BASE[found[1]].items():
                powers[name] = powers.get(name, 0) + (-1 if i else 1) * power * int(found[2] or 1)
    return powers


def _attributes(variable: Variable, what: str, reference: int) -> dict[str, str]:
    """Return the attributes of a variable that both versions have."""
    return {
        "name": variable.name,
        "valueReference": str(reference),
        "causality": "local" if what in ("state", "derivative") else what,
        "variability": "continuous",
        **({"initial": INITIAL[what]} if what in INITIAL else {}),
    }


def _value(variable: Variable, what: str, derived: int) -> dict[str, str]:
    """Return unit and initial value of a variable, and for a derivative the number of its state."""
    return {
        **({"unit": variable.unit} if variable.unit else {}),
        **({"start": repr(variable.start)} if what in ("input", "state") else {}),
        **({"derivative": str(derived)} if derived >= 0 else {}),
    }


def _of_two(of: UnitDescription) -> Tree.Element:
    root = _root(of, "2.0", "guid", "canGetAndSetFMUstate", "canSerializeFMUstate", numberOfEventIndicators="0")
    listed = Tree.SubElement(root, "ModelVariables")
    for reference, (variable, what, derived) in enumerate(of.variables()):
        scalar = Tree.SubElement(listed, "ScalarVariable", _attributes(variable, what, reference))
        Tree.SubElement(scalar, "Real", _value(variable, what, derived + 1 if derived >= 0 else -1))
    structure, known_by = Tree.SubElement(root, "ModelStructure"), _knowns(of)
    for name, references in zip(("Outputs", "Derivatives", "InitialUnknowns"), _unknowns(of), strict=True):
        if references:
            element = Tree.SubElement(structure, name)
            for reference in references:
                on = " ".join(str(known + 1) for known in known_by[reference])
                Tree.SubElement(element, "Unknown", index=str(reference + 1), dependencies=on)
    return root


def _of_three(of: UnitDescription) -> Tree.Element:
    root = _root(of, "3.0", "instantiationToken", "canGetAndSetFMUState", "canSerializeFMUState")
    listed = Tree.SubElement(root, "ModelVariables")
    for reference, (variable, what, derived) in enumerate(of.variables()):
        Tree.SubElement(listed, "Float64", _attributes(variable, what, reference) | _value(variable, what, derived))
    structure, known_by = Tree.SubElement(root, "ModelStructure"), _knowns(of)
    names = "Output", "ContinuousStateDerivative", "InitialUnknown"
    for name, references in zip(names, _unknowns(of), strict=True):
        for reference in references:
            on = " ".join(map(str, known_by[reference]))
            Tree.SubElement(structure, name, valueReference=str(reference), dependencies=on)
    return root


def _knowns(of: UnitDescription) -> list[list[int]]:
    """Return the references of the inputs and states that each variable depends on at once: none is told as none."""
    first = len(of.inputs) + len(of.outputs) + 1
    return [[*variable.inputs, *(first + i for i in variable.states)] for variable, _, _ in of.variables()]


def _unknowns(of: UnitDescription) -> tuple[list[int], list[int], list[int]]:
    """Return the references of outputs, of derivatives, and of both, which are also the unknowns at the start."""
    outputs, derivatives = (
        [reference for reference, (_, what, _) in enumerate(of.variables()) if what == wanted]
        for wanted in ("output", "derivative")
    )
    return outputs, derivatives, outputs + derivatives
