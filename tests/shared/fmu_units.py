"""Functional mock-up units run by the functions of their library, as any program runs them."""

from __future__ import annotations

import ctypes
import json
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Tree

import numpy as np

OK, ERROR = 0, 3

SIMULATE = """
import json, sys
import fmpy
path, options = json.loads(sys.argv[1])
found = fmpy.simulate_fmu(path, **options)
print(json.dumps({name: found[name].tolist() for name in found.dtype.names}))
"""


def simulated(path: Path, **options: Any) -> dict[str, np.ndarray]:
    """Return what FMPy finds, in a process of its own: it loads a SUNDIALS of its own, which must not meet another."""
    command = [sys.executable, "-c", SIMULATE, json.dumps((str(path), options))]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return {name: np.array(values) for name, values in json.loads(told.splitlines()[-1]).items()}


class Unit:
    """A unit for co-simulation of FMI 2.0 or 3.0, in a folder."""

    def __init__(self, path: Path) -> None:
        folder = path.with_suffix("")
        if not folder.exists():  # libraries that are loaded must stay as they are
            with zipfile.ZipFile(path) as archive:
                archive.extractall(folder)
        root = Tree.parse(folder / "modelDescription.xml").getroot()
        self.is_two = root.get("fmiVersion") == "2.0"
        self.token = root.get("guid" if self.is_two else "instantiationToken", "")
        listed = root.find("ModelVariables")
        assert listed is not None
        self.references = {str(v.get("name")): int(str(v.get("valueReference"))) for v in listed}
        self.library_path = next(folder.glob(f"binaries/*/{path.stem}.so"))
        self.library = ctypes.CDLL(str(self.library_path))
        self.messages: list[str] = []
        self.instance = ctypes.c_void_p(self._made(self.token))

    def _made(self, token: str) -> Any:
        """Return an instance; None if it is refused."""
        name, told = b"unit", token.encode()
        if self.is_two:
            kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, *(ctypes.c_char_p, ctypes.c_int, *(ctypes.c_char_p,) * 3))
            self._logger = kind(lambda e, n, s, c, m, *rest: self.messages.append(rest[0].decode()))
            self._callbacks = (ctypes.c_void_p * 5)(ctypes.cast(self._logger, ctypes.c_void_p).value)
            function = self.library.fmi2Instantiate
            function.restype = ctypes.c_void_p
            return function(name, 1, told, b"", self._callbacks, 0, 0)
        kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
        self._logger = kind(lambda e, s, c, m: self.messages.append(m.decode()))
        function = self.library.fmi3InstantiateCoSimulation
        function.restype = ctypes.c_void_p
        no = ctypes.c_bool(False)
        return function(name, told, b"", no, no, no, no, None, ctypes.c_size_t(0), None, self._logger, None)

    def begin(self, t: float) -> int:
        start, none = ctypes.c_double(t), ctypes.c_double(0.0)
        if self.is_two:
            return self.call("SetupExperiment", 0, none, start, 0, none)
        return self.call("EnterInitializationMode", ctypes.c_bool(False), none, start, ctypes.c_bool(False), none)

    def call(self, name: str, *arguments: Any) -> int:
        return int(self.library[f"fmi{2 if self.is_two else 3}{name}"](self.instance, *arguments))

    def set(self, name: str, value: float) -> int:
        references, values = (ctypes.c_uint32 * 1)(self.references[name]), (ctypes.c_double * 1)(value)
        more = () if self.is_two else (ctypes.c_size_t(1),)
        return self.call("SetReal" if self.is_two else "SetFloat64", references, ctypes.c_size_t(1), values, *more)

    def get(self, names: Sequence[str]) -> list[float]:
        count = len(names)
        references = (ctypes.c_uint32 * count)(*(self.references[name] for name in names))
        values = (ctypes.c_double * count)()
        more = () if self.is_two else (ctypes.c_size_t(count),)
        name = "GetReal" if self.is_two else "GetFloat64"
        assert self.call(name, references, ctypes.c_size_t(count), values, *more) == OK, self.messages
        return list(values)

    def step(self, dt: float, at: float | None = None) -> int:
        """Go on by dt from a communication point (s); None: from the unit's own time."""
        t, h = ctypes.c_double(self.get(["time"])[0] if at is None else at), ctypes.c_double(dt)
        if self.is_two:
            return self.call("DoStep", t, h, 1)
        told = [ctypes.byref(ctypes.c_bool()) for _ in range(3)]
        return self.call("DoStep", t, h, ctypes.c_bool(True), *told, ctypes.byref(ctypes.c_double()))

    def state(self) -> bytes:
        """Return the state as bytes."""
        kept, size = ctypes.c_void_p(), ctypes.c_size_t()
        word = "FMUstate" if self.is_two else "FMUState"
        assert self.call(f"Get{word}", ctypes.byref(kept)) == OK
        assert self.call(f"Serialized{word}Size", kept, ctypes.byref(size)) == OK
        made = ctypes.create_string_buffer(size.value)
        assert self.call(f"Serialize{word}", kept, made, size) == OK
        assert self.call(f"Free{word}", ctypes.byref(kept)) == OK
        return made.raw

    def go_back(self, state: bytes) -> None:
        kept, word = ctypes.c_void_p(), "FMUstate" if self.is_two else "FMUState"
        name = "DeSerialize" if self.is_two else "Deserialize"
        assert self.call(f"{name}{word}", state, ctypes.c_size_t(len(state)), ctypes.byref(kept)) == OK
        assert self.call(f"Set{word}", kept) == OK
        assert self.call(f"Free{word}", ctypes.byref(kept)) == OK

    def run(self, inputs: Sequence[dict[str, float]], dt: float, names: Sequence[str]) -> np.ndarray:
        """Return the outputs after steps with inputs."""
        found = []
        for values in inputs:
            assert [self.set(name, value) for name, value in values.items()] == [OK] * len(values)
            assert self.step(dt) == OK, self.messages
            found.append(self.get(names))
        return np.array(found)

    def free(self) -> None:
        self.library[f"fmi{2 if self.is_two else 3}FreeInstance"](self.instance)
