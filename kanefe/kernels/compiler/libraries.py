"""Libraries of machine code: which functions each has, and what names its file.

A kernel that several functions of a library call is compiled once. The engine has all functions of real numbers that
runs and analyses of any scene call, and a library of its own those of complex numbers, which give exact derivatives. A
method of integration, and a law of a load or a joint, is a small library by itself. A file is named by a stamp of what
it was made from: the files of kernels that the functions' own import, directly or not, so that an edit makes again what
depends on it and nothing else.
"""

import hashlib
import os
from functools import cache
from pathlib import Path
from typing import NamedTuple

PACKAGE = Path(__file__).parents[1]

_ENGINE = """
    compiler.filling constraints.closing constraints.contact_margins evaluation.evaluation evaluation.derivatives
    evaluation.forces evaluation.masses evaluation.momenta evaluation.replay evaluation.stiff_directions events.lookout
    events.steps_with_events impacts.cones impacts.contact_changes impacts.moments loads.telling loads.watching
    planar.evaluation steppers.integration steppers.lanes steppers.sampling steppers.settled_outputs
    steppers.step_commands sweeps.outward
"""

ENGINE = "engine"
"""Name of the library of what runs and analyses of any scene call."""

SHARED = {
    ENGINE: _ENGINE,
    "explicit": "steppers.explicit_steps",
    "extrapolation": "steppers.extrapolation steppers.extrapolation_dense",
    "radau": "steppers.radau steppers.radau_polynomial",
    "generalised_alpha": "steppers.generalised_alpha steppers.generalised_alpha_state",
    "energy_momentum": "steppers.energy_momentum",
}
"""Libraries with functions of other modules than the one that they are named for, and these modules."""

SECONDS = {
    "engine": 42.0,
    "engine-complex": 22.0,
    "contact_forces": 19.0,
    "linearised_tree-complex": 10.0,
    "contact_outputs": 6.0,
    "granular_contacts": 2.3,
    "time_stepping": 2.3,
}
"""CPU time of building a library, s, where it is more than `LEAST_SECONDS`; see `kanefe.kernels.compiler.progress`."""

LEAST_SECONDS = 0.8
"""CPU time of building a library that is not listed, s."""

IMPORT = b"\nfrom kanefe.kernels"

ALWAYS = tuple(
    f"{name}.py"
    for name in (
        "compiler/_numba",
        "compiler/_numba_alone",
        "compiler/_numba_arrays",
        "compiler/_numba_calls",
        "compiler/_numba_change",
        "compiler/_numba_in_place",
        "compiler/_numba_lanes",
        "compiler/_numba_loops",
        "compiler/_numba_module",
        "compiler/_numba_objects",
        "compiler/_numba_passes",
        "compiler/_numba_pointers",
        "compiler/_numba_records",
        "compiler/_numba_rows",
        "compiler/_numba_symbols",
        "compiler/_numba_tensors",
        "compiler/_numba_values",
        "compiler/arrays",
        "compiler/signatures",
        "values/numbers",
        "values/parts",
        "values/records",
        "values/tensors",
    )
)
"""Files of kernels on which every library depends."""

NEVER = (
    *(
        f"compiler/{name}.py"
        for name in ("entries", "compiled_functions", "libraries", "processors", "side_by_side", "_numba_functions")
    ),
    "values/filled.py",
)
"""Files that call machine code, compile functions of users in each process, or fill memory where a scene is frozen, and
are no part of a library."""


def _modules(names: str) -> tuple[str, ...]:
    return tuple(f"kanefe.kernels.{name}" for name in names.split())


_LIBRARY_OF = {module: name for name, names in SHARED.items() for module in _modules(names)}


class Library(NamedTuple):
    """A library of machine code.

    Attributes
    ----------
    name : str
    modules : tuple of str
        Those whose functions it has.
    """

    name: str
    modules: tuple[str, ...]

    @property
    def file_name(self) -> str:
        """First part of the name of its file, which identifies what it was made from."""
        return f"{self.name}-{stamp(self.modules)}"

    @property
    def seconds(self) -> float:
        """CPU time of building it, s."""
        return SECONDS.get(self.name, LEAST_SECONDS)


@cache
def library_of(module: str, is_complex: bool) -> Library:
    """Return the library that has the functions of a module of kernels, of real or of complex numbers."""
    name = _LIBRARY_OF.get(module)
    modules = (module,) if name is None else _modules(SHARED[name])
    kind = "-complex" if is_complex else ""
    return Library(f"{name or module.rpartition('.')[2]}{kind}", modules)


@cache
def stamp(modules: tuple[str, ...]) -> str:
    """Return what names the files of kernels that modules of kernels are made from."""
    found, wanted = set(ALWAYS), [*modules]
    while wanted:
        path = _path_in_package(wanted.pop())
        if path not in found and path not in NEVER:
            found.add(path)
            wanted += _source(path).imports
    lines = [f"{path} {_source(path).digest}\n" for path in sorted(found)]
    return hashlib.sha256("".join(lines).encode()).hexdigest()[:16]


@cache
def _path_in_package(module: str) -> str:
    name = module.removeprefix("kanefe.kernels").lstrip(".").replace(".", "/")
    return f"{name}.py" if os.path.isfile(f"{PACKAGE}/{name}.py") else f"{name}/__init__.py".lstrip("/")


class _Source(NamedTuple):
    """A file of kernels: a digest of it, and the modules of kernels that it imports."""

    digest: str
    imports: tuple[str, ...]


@cache
def _source(path: str) -> _Source:
    with open(f"{PACKAGE}/{path}", "rb") as file:
        text = file.read()
    return _Source(hashlib.sha256(text).hexdigest(), imports_of(text))


def imports_of(text: bytes) -> tuple[str, ...]:
    """Return the modules of kernels that a file imports, each once; a regular expression takes 4 ms for all files.

    They are imported by name from their package, or names are from them.
    """
    found: dict[str, None] = {}
    for rest in text.split(IMPORT)[1:]:
        module, _, names = rest.partition(b" import ")
        name = f"kanefe.kernels{module.decode()}"
        found[name] = None
        folder, is_package, _ = _path_in_package(name).partition("__init__.py")
        if is_package:
            end = b")" if names.startswith(b"(") else b"\n"
            files = (file.strip() for file in names.partition(end)[0].decode().strip("(").split(","))
            found |= {f"{name}.{file}": None for file in files if os.path.isfile(f"{PACKAGE}/{folder}{file}.py")}
    return tuple(found)
