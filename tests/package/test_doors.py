"""The doors: each heavy package is imported by one file only, and importing kanefe loads none of them."""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator

import pytest

from repository import ROOT

# module -> the files that may import it
DOORS = {
    "dolfinx": {"fem/kanefe_fem/_fenicsx.py"},
    # the newest dolfinx brings its own MPI, which must be loaded before MPI's or PETSc's Python side
    "dolfinx_solver": {"fem/kanefe_fem/_fenicsx.py", "fem/kanefe_fem/_petsc.py"},
    "ufl": {"fem/kanefe_fem/_fenicsx.py"},
    "basix": {"fem/kanefe_fem/_fenicsx.py"},
    "mpi4py": {"fem/kanefe_fem/_fenicsx.py"},
    "petsc4py": {
        "fem/kanefe_fem/_fenicsx.py",
        "fem/kanefe_fem/_petsc.py",
        "fem/kanefe_fem/multigrid/_petsc.py",
        "fem/kanefe_fem/processes/_petsc.py",
    },
    "slepc4py": {"fem/kanefe_fem/processes/_petsc.py"},
    "gmsh": {"fem/kanefe_fem/_gmsh.py"},
    "OCP": {"fem/kanefe_fem/cad/_ocp.py"},
    "meshio": {"fem/kanefe_fem/_meshio.py"},
    "matplotlib": {"kanefe/views/plots.py"},
    "evtk": {"kanefe/views/vtk.py"},
    "pyevtk": {"kanefe/views/vtk.py"},
    "h5py": {"kanefe/storage/hdf5.py"},
    "pyvista": {"kanefe/views/_pyvista.py"},
    "numba": {
        "kanefe/kernels/compiler/_numba.py",
        "kanefe/kernels/compiler/_numba_alone.py",
        "kanefe/kernels/compiler/_numba_arrays.py",
        "kanefe/kernels/compiler/_numba_calls.py",
        "kanefe/kernels/compiler/_numba_lanes.py",
        "kanefe/kernels/compiler/_numba_loops.py",
        "kanefe/kernels/compiler/_numba_passes.py",
        "kanefe/kernels/compiler/_numba_pointers.py",
        "kanefe/kernels/compiler/_numba_records.py",
        "kanefe/kernels/compiler/_numba_rows.py",
        "kanefe/kernels/compiler/_numba_in_place.py",
        "kanefe/kernels/compiler/_numba_tensors.py",
        "kanefe/kernels/compiler/_numba_values.py",
        "kanefe/kernels/compiler/_numba_objects.py",
        "kanefe/kernels/compiler/_numba_functions.py",
        "kanefe/kernels/compiler/local_numbers.py",
    },
    "pyyeti": {"kanefe/imports/_pyyeti.py"},
    "mapdl_archive": {"kanefe/imports/_mapdl.py"},
    "control": {"kanefe/linear/_control.py"},
    "xarray": {"kanefe/storage/_xarray.py"},
    "h5netcdf": {"kanefe/storage/_xarray.py"},
    "wavespectra": {"kanefe/environment/_wavespectra.py"},
    "netCDF4": set(),
    "capytaine": set(),
    "sksundae": {"kanefe/integrate/methods/_sundials.py"},
    "coal": set(),
    "hppfcl": set(),
    "yourdfpy": {"kanefe/robots/_yourdfpy.py"},
    "mujoco": {"kanefe/robots/_mujoco.py"},
    "distributed": {"kanefe/studies/workers/_dask.py"},
    "rainflow": {"kanefe/fatigue/_rainflow.py"},
    "pandas": {"kanefe/storage/_pandas.py"},
    "cloudpickle": {"kanefe/storage/functions_by_value.py"},
}
SOURCES = sorted([*ROOT.glob("kanefe/**/*.py"), *ROOT.glob("fem/kanefe_fem/**/*.py")])


def is_for_type_checkers(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) in {"TYPE_CHECKING", "typing.TYPE_CHECKING"}


def imported_modules(tree: ast.AST) -> Iterator[tuple[int, str, bool]]:
    """Line, top-level name and "at run time" of every import, lazy ones and importlib's with a literal name too."""
    blocks = [block for node in ast.walk(tree) if is_for_type_checkers(node) for block in node.body]
    names_only = {id(node) for block in blocks for node in ast.walk(block)}
    for node in ast.walk(tree):
        modules = []
        if isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            modules = [node.module]
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
            modules = [a.value for a in node.args[:1] if isinstance(a, ast.Constant) and isinstance(a.value, str)]
        for module in modules:
            yield node.lineno, module.partition(".")[0], id(node) not in names_only


def trespasses(path: str, source: str) -> list[str]:
    """Imports in the file `path` (relative to the repository) that only a door, or only kanefe_fem, may make."""
    found: list[str] = []
    if not any(name in source for name in (*DOORS, "kanefe_fem")):
        return found
    for line, module, at_run_time in imported_modules(ast.parse(source)):
        if at_run_time and module in DOORS and path not in DOORS[module]:
            found.append(f"{path}:{line} imports {module}, which only {sorted(DOORS[module]) or 'nobody'} may")
        if module == "kanefe_fem" and path.startswith("kanefe/"):
            found.append(f"{path}:{line} imports kanefe_fem, which kanefe never does")
    return found


def test_there_are_sources_of_both_packages():
    folders = {path.relative_to(ROOT).parts[0] for path in SOURCES}
    assert folders == {"kanefe", "fem"}


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_heavy_packages_come_in_by_their_doors_only(path):
    assert trespasses(path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("path", "source"),
    [
        ("kanefe/system.py", "import h5py"),
        ("kanefe/system.py", "def f():\n    from matplotlib import pyplot"),
        ("kanefe/views/plots.py", "import h5py as store"),
        ("kanefe/cli.py", "import importlib\nimportlib.import_module('gmsh.model')"),
        ("kanefe/cli.py", "from kanefe_fem.demo import demo"),
        ("kanefe/cli.py", "if TYPE_CHECKING:\n    from kanefe_fem.demo import demo"),
        ("kanefe/cli.py", "if TYPE_CHECKING:\n    import h5py\nelse:\n    import h5py"),
        ("fem/kanefe_fem/solids/body.py", "import dolfinx.fem"),
        ("fem/kanefe_fem/_gmsh.py", "import petsc4py"),
    ],
)
def test_a_trespass_is_seen(path, source):
    assert len(trespasses(path, source)) == 1


def test_ruff_bans_the_same_names():
    import tomllib

    config = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["ruff"]["lint"]
    tidy = config["flake8-tidy-imports"]
    assert set(tidy["banned-api"]) == set(DOORS)
    assert tidy["banned-module-level-imports"] == ["kanefe_fem"]
    opened = {path for path, rules in config["per-file-ignores"].items() if "TID251" in rules and path.endswith(".py")}
    assert opened == set().union(*DOORS.values())


def test_the_page_for_contributors_lists_every_door():
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rows = [(packages.split(", "), path) for packages, path in re.findall(r"\| ([\w, ]+) \| `(\S+\.py)` \|", page)]
    assert {path for _, path in rows} == set().union(*DOORS.values())
    for packages, path in rows:
        for package in packages:
            assert path in DOORS[package]


@pytest.mark.parametrize("package", ["kanefe", "kanefe_fem"])
def test_importing_loads_nothing_heavy(package):
    heavy = sorted({*DOORS, "typer", "tqdm"} | ({"kanefe_fem"} if package == "kanefe" else set()))
    code = f"import sys, {package}; print(sorted(set(sys.modules) & set({heavy!r})))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"
