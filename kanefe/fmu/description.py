"""modelDescription.xml: variables, units and abilities of a model, as FMI 2.0 and 3.0 want it."""

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


class Variable(NamedTuple):
    """A variable of a model.

    Attributes
    ----------
    name, unit : str
    start : float
        Of an input, or a state.
    """

    name: str
    unit: str
    start: float = 0.0


class UnitDescription(NamedTuple):
    """What a model is, for the programs that run it.

    Attributes
    ----------
    name, identifier, text, token : str
        The identifier is that of its files; the token is told by who makes an instance.
    inputs, outputs, states : tuple of Variable
        States are those of a model for exchange, which is what it is if there are any.
    is_linear : bool
        Whether it is a model for exchange, else for co-simulation.
    start, every : float
        Where it begins, and how far a step usually goes, s.
    keeps_states : bool
        Whether its states can be got, set and serialised.
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
        """Return itself; a ModelError says which name no variable of a unit can have."""
        names = [variable.name for variable, _, _ in self.variables()]
        for name in names:
            if not name.strip() or not name.isprintable():
                raise ModelError(f"a variable of a unit cannot be called {name!r}. Remedy: a name that can be read")
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
        """Yield all variables with what they are, and of a derivative the number of its state; -1: of none."""
        yield from ((variable, "input", -1) for variable in self.inputs)
        yield from ((variable, "output", -1) for variable in self.outputs)
        yield Variable(TIME, "s"), "independent", -1
        first = len(self.inputs) + len(self.outputs) + 1
        yield from ((variable, "state", -1) for variable in self.states)
        for i, variable in enumerate(self.states):
            yield Variable(f"der({variable.name})", _rate(variable.unit)), "derivative", first + i


def _rate(unit: str) -> str:
    if unit.endswith("/s"):
        return f"{unit}2"
    return f"{unit}/s" if unit else ""


def _root(of: UnitDescription, version: str, token: str, **more: str) -> Tree.Element:
    told = {"fmiVersion": version, "modelName": of.name, token: of.token, "description": of.text}
    told |= {"generationTool": f"kanefe {__version__}", "variableNamingConvention": "flat"}
    return Tree.Element("fmiModelDescription", told | more)


def _units(of: UnitDescription, root: Tree.Element) -> None:
    units = sorted({variable.unit for variable, _, _ in of.variables() if variable.unit})
    listed = Tree.SubElement(root, "UnitDefinitions")
    for unit in units:
        element = Tree.SubElement(listed, "Unit", name=unit)
        powers = base_powers(unit)
        if powers is not None:
            Tree.SubElement(element, "BaseUnit", {name: str(power) for name, power in powers.items() if power})


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


def _experiment(of: UnitDescription, root: Tree.Element) -> None:
    told = {"startTime": repr(of.start)}
    Tree.SubElement(root, "DefaultExperiment", told if of.is_linear else told | {"stepSize": repr(of.every)})


def _abilities(of: UnitDescription, *of_states: str) -> dict[str, str]:
    return {"modelIdentifier": of.identifier, **(dict.fromkeys(of_states, "true") if of.keeps_states else {})}


def _of_two(of: UnitDescription) -> Tree.Element:
    root = _root(of, "2.0", "guid", numberOfEventIndicators="0")
    able = _abilities(of, "canGetAndSetFMUstate", "canSerializeFMUstate")
    if of.is_linear:
        Tree.SubElement(root, "ModelExchange", able)
    else:
        Tree.SubElement(root, "CoSimulation", able | {"canHandleVariableCommunicationStepSize": "true"})
    _units(of, root)
    _experiment(of, root)
    listed = Tree.SubElement(root, "ModelVariables")
    numbers: dict[str, list[int]] = {"output": [], "state": [], "derivative": []}
    for reference, (variable, what, derived) in enumerate(of.variables()):
        told = {"name": variable.name, "valueReference": str(reference)}
        told |= {"causality": "local" if what in ("state", "derivative") else what, "variability": "continuous"}
        value = {"unit": variable.unit} if variable.unit else {}
        if what in ("output", "derivative"):
            told["initial"] = "calculated"
        elif what == "state":
            told["initial"] = "exact"
        if what in ("input", "state"):
            value["start"] = repr(variable.start)
        if derived >= 0:
            value["derivative"] = str(derived + 1)
        Tree.SubElement(Tree.SubElement(listed, "ScalarVariable", told), "Real", value)
        numbers.setdefault(what, []).append(reference + 1)
    structure = Tree.SubElement(root, "ModelStructure")
    for name, wanted in (
        ("Outputs", numbers["output"]),
        ("Derivatives", numbers["derivative"]),
        ("InitialUnknowns", sorted((*numbers["output"], *numbers["derivative"]))),
    ):
        if wanted:
            element = Tree.SubElement(structure, name)
            for number in wanted:
                Tree.SubElement(element, "Unknown", index=str(number))
    return root


def _of_three(of: UnitDescription) -> Tree.Element:
    root = _root(of, "3.0", "instantiationToken")
    able = _abilities(of, "canGetAndSetFMUState", "canSerializeFMUState")
    if of.is_linear:
        Tree.SubElement(root, "ModelExchange", able)
    else:
        Tree.SubElement(root, "CoSimulation", able | {"canHandleVariableCommunicationStepSize": "true"})
    _units(of, root)
    _experiment(of, root)
    listed = Tree.SubElement(root, "ModelVariables")
    unknown: list[tuple[str, int]] = []
    for reference, (variable, what, derived) in enumerate(of.variables()):
        told = {"name": variable.name, "valueReference": str(reference)}
        told |= {"causality": "local" if what in ("state", "derivative") else what, "variability": "continuous"}
        if variable.unit:
            told["unit"] = variable.unit
        if what in ("output", "derivative"):
            told["initial"] = "calculated"
            unknown.append((what, reference))
        elif what == "state":
            told["initial"] = "exact"
        if what in ("input", "state"):
            told["start"] = repr(variable.start)
        if derived >= 0:
            told["derivative"] = str(derived)
        Tree.SubElement(listed, "Float64", told)
    structure = Tree.SubElement(root, "ModelStructure")
    for name, wanted in (("Output", "output"), ("ContinuousStateDerivative", "derivative")):
        for what, reference in unknown:
            if what == wanted:
                Tree.SubElement(structure, name, valueReference=str(reference))
    for _, reference in unknown:
        Tree.SubElement(structure, "InitialUnknown", valueReference=str(reference))
    return root
