"""Functional mock-up units: a scene, or a linear system, compiled and packed."""

from __future__ import annotations

import hashlib
import platform
import re
import subprocess
import sys
import tempfile
import uuid
import warnings
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from kanefe._version import __version__
from kanefe.errors import FileError, ModelError, SimulationWarning, outside
from kanefe.fmu import c_text as c
from kanefe.fmu.description import UnitDescription, Variable
from kanefe.fmu.image import NeedsPython
from kanefe.fmu.portable import without_python
from kanefe.fmu.scene_source import scene_source
from kanefe.fmu.serve import packed
from kanefe.kernels.compiler.compiled_functions import content_of, linker
from kanefe.linear.input_to_output import tell_of_losses
from kanefe.linear.linearisation import Linearisation
from kanefe.linear.unsettled import imbalance_in_words
from kanefe.stepping.simulation import Simulation
from kanefe.storage.files import write_whole

SOURCES = Path(__file__).parent / "source"
VERSIONS = "2.0", "3.0"
FOLDERS = {
    "x86_64": {"2.0": "linux64", "3.0": "x86_64-linux"},
    "aarch64": {"2.0": "aarch64-linux", "3.0": "aarch64-linux"},
}
"""Folders of the binaries, by processor and version of the standard."""

FLAGS = ("-std=gnu11", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-Wl,-s")
EPOCH = (1980, 1, 1, 0, 0, 0)
"""Date of all files in an archive, which makes the archive reproducible."""


def write_scene(sim: Simulation, path: str | Path, version: str, every: float) -> Path:
    """Write a simulation at its start as a unit for co-simulation; return its path.

    A unit of a scene with Python functions needs Python and kanefe where it runs; a warning says so.

    Raises
    ------
    ModelError
        If there is no such version or no C compiler, or functions cannot be sent to another process.
    FileError
        If the file cannot be written.
    """
    folder = _checked(version)
    try:
        source = scene_source(sim)
    except NeedsPython as reason:
        found = _served(sim, path, version, every, str(reason))
        warnings.warn(
            f"the unit {Path(path).name} needs kanefe {__version__} where it runs, by KANEFE_PYTHON or as python3, "
            f"and cannot save states: {reason}",
            SimulationWarning,
            stacklevel=outside(),
        )
        return found
    token = _token(source.header.encode(), source.image, *(content_of(file) for file in source.files))
    text = (
        "A multibody scene with the compiled kernels of kanefe; it needs no Python. For processors with the "
        f"instructions of the one that it was exported on ({platform.machine()})."
    )
    description = _description(sim, path, every, text, token)
    made = _compiled(version, "scene.c", _header(description) + source.header, source.image)
    files = {f"binaries/{folder}/{description.identifier}.so": made}
    kernels = {file.name: without_python(content_of(file), file.name) for file in source.files}
    files |= {f"binaries/{folder}/{name}": code for name, code in kernels.items()}
    return _packed(path, {"modelDescription.xml": description.xml(version), **files})


def _served(sim: Simulation, path: str | Path, version: str, every: float, reason: str) -> Path:
    """Write a unit whose scene is stepped by a Python process."""
    scene = packed(sim.scene, sim.asked)
    text = f"A multibody scene of kanefe {__version__}, which this unit needs, in Python: {reason}"
    description = _description(sim, path, every, text, _token(scene), keeps_states=False)
    lines = [
        c.define("INPUT_COUNT", len(sim.input_names)),
        c.define("OUTPUT_COUNT", len(sim.output_names)),
        c.define("VERSION", __version__),
        c.define("PYTHON", sys.executable or "python3"),
        f"#define START {c.number(sim.time)}",
    ]
    made = _compiled(version, "served.c", _header(description) + "\n".join(lines) + "\n", b"")
    files = {f"binaries/{_checked(version)}/{description.identifier}.so": made, "resources/scene.pickle": scene}
    return _packed(path, {"modelDescription.xml": description.xml(version), **files})


def _description(
    sim: Simulation, path: str | Path, every: float, text: str, token: str, keeps_states: bool = True
) -> UnitDescription:
    name = Path(path).stem
    inputs = tuple(Variable(name, sim.units[name], value) for name, value in sim.inputs.items())
    on = tuple(range(len(inputs)))
    outputs = tuple(
        Variable(output.name, output.unit, inputs=on if output.follows_inputs else ()) for output in sim.output_list
    )
    return UnitDescription(
        name, _identifier(name), text, token, inputs, outputs, (), False, sim.time, every, keeps_states
    ).checked()


def write_linear(small: Linearisation, path: str | Path, version: str) -> Path:
    """Write a linearised scene as a unit for model exchange; return its path.

    Raises
    ------
    ModelError
        If there is no such version, or no C compiler.
    FileError
        If the file cannot be written.
    """
    folder = _checked(version)
    tell_of_losses(small, "a unit")
    name = Path(path).stem
    matrices = [np.asarray(matrix, dtype=float) for matrix in (small.A, small.B, small.C, small.D)]
    lines = [c.numbers(f"MATRIX_{letter}", matrix) for letter, matrix in zip("ABCD", matrices, strict=True)]
    body = "\n".join((*lines, c.numbers("OFFSETS", small.output_values))) + "\n"
    named = (small.input_names, small.output_names, small.state_names)
    inputs, outputs, states = (tuple(map(_variable, names)) for names in named)
    outputs = tuple(
        one._replace(inputs=_on(D), states=_on(C)) for one, C, D in zip(outputs, *matrices[2:], strict=True)
    )
    states = tuple(one._replace(inputs=_on(B), states=_on(A)) for one, A, B in zip(states, *matrices[:2], strict=True))
    description = UnitDescription(
        name,
        _identifier(name),
        "; ".join(
            (
                "A scene of kanefe, linearised: inputs and states are deviations from the state of linearisation",
                *(line.strip() for line in imbalance_in_words(small.imbalance)),
            )
        ),
        _token(body.encode(), repr([inputs, outputs, states]).encode()),
        inputs,
        outputs,
        states,
        True,
        small.time,
        0.0,
    ).checked()
    made = _compiled(version, "linear.c", _header(description) + body, b"")
    files = {f"binaries/{folder}/{description.identifier}.so": made}
    return _packed(path, {"modelDescription.xml": description.xml(version), **files})


def _checked(version: str) -> str:
    """Return the folder of binaries; raise a ModelError for an unknown version or platform."""
    if version not in VERSIONS:
        raise ModelError(f"fmi must be '2.0' or '3.0', not {version!r}")
    if sys.platform != "linux" or platform.machine() not in FOLDERS:
        raise ModelError(f"units are written on Linux on x86-64 and arm64, not on {sys.platform} {platform.machine()}")
    return FOLDERS[platform.machine()][version]


def _token(*parts: bytes) -> str:
    digest = hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts))
    return f"{{{uuid.UUID(digest.hexdigest()[:32])}}}"


def _identifier(name: str) -> str:
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return plain if plain and not plain[0].isdigit() else f"m_{plain}"


def _on(row: np.ndarray) -> tuple[int, ...]:
    """Return the numbers of what has a weight in a sum."""
    return tuple(np.flatnonzero(row).tolist())


def _variable(label: str) -> Variable:
    name, _, unit = label.partition(" [")
    return Variable(name, unit.removesuffix("]"))


def _header(of: UnitDescription) -> str:
    counts = [
        c.define("TOKEN", of.token),
        c.define("IS_LINEAR", int(of.is_linear)),
        c.define("KEEPS_STATES", int(of.keeps_states)),
        c.define("STATE_COUNT", len(of.states)),
        c.define("FIRST_STATE", len(of.inputs) + len(of.outputs) + 1),
    ]
    if of.is_linear:
        counts += [c.define("INPUT_COUNT", len(of.inputs)), c.define("OUTPUT_COUNT", len(of.outputs))]
    return "\n".join(("#include <stdint.h>", *counts)) + "\n"


def _compiled(version: str, engine: str, header: str, image: bytes) -> bytes:
    """Return the shared library of a unit."""
    sources: Sequence[Path] = (SOURCES / f"fmi{version[0]}.c", SOURCES / engine)
    with tempfile.TemporaryDirectory(prefix="kanefe-") as name:
        folder = Path(name)
        (folder / "model.h").write_text(header, encoding="utf-8")
        (folder / "image.bin").write_bytes(image)
        command = [linker(), *FLAGS, f"-I{folder}", f"-I{SOURCES}", *map(str, sources), "-o", "model.so"]
        try:
            subprocess.run(
                [*command, "-lm", "-ldl", "-lpthread"], cwd=folder, check=True, capture_output=True, text=True
            )
        except FileNotFoundError as error:
            raise ModelError(
                f"to_fmu needs a C compiler, and {linker()!r} is not available. Remedy: apt-get install gcc, or CC=..."
            ) from error
        except subprocess.CalledProcessError as error:
            raise ModelError(f"the C compiler {linker()!r} refuses the unit: {error.stderr.strip()[:500]}") from error
        return (folder / "model.so").read_bytes()


def _packed(path: str | Path, files: dict[str, bytes]) -> Path:
    made = Path(path)
    if made.suffix != ".fmu":
        raise FileError(f"the file of a unit ends in .fmu, not {made.name!r}. Remedy: another name")

    def write(file: object) -> None:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:  # type: ignore[call-overload]
            for name, content in files.items():
                archive.writestr(zipfile.ZipInfo(name, EPOCH), content, zipfile.ZIP_DEFLATED)

    write_whole(made, write)
    return made
