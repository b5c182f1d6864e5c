"""Built kernels: what they are made from, where they are kept, and what is said when they are made."""

from __future__ import annotations

import ast
import contextlib
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import kanefe.kernels
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler.build import all_compiled_functions, all_libraries, build
from kanefe.kernels.compiler.filling import fill_nothing
from kanefe.kernels.compiler.libraries import ALWAYS, ENGINE, NEVER, imports_of, stamp
from kanefe.kernels.compiler.processors import generations_here, own_folder
from kanefe.kernels.steppers.step_commands import Run, interpolated

KERNELS = Path(kanefe.kernels.__file__).parent

# the smallest kernel there is: a load that Python gives
CALL = """
import ctypes, sys
import numpy as np
from kanefe.kernels.compiler.addresses import NUMBER, NUMBERS, call_in_python, house_address
from kanefe.kernels.force_elements.given import given
out = np.zeros(2)
address = house_address(given, NUMBER, *[NUMBERS] * 5)
call_in_python(address, (0.0, np.array((2.0,)), np.array((3.0, 4.0)), np.zeros(0), np.zeros(0), out))
print(out.tolist(), "numba" in sys.modules)
"""


class Copy:
    """A copy of the package, with a cache of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.cache = folder, folder / "cache"
        ignored = shutil.ignore_patterns("__pycache__", "built")
        shutil.copytree(KERNELS.parent, folder / "kanefe", ignore=ignored)
        self.kernels = folder / "kanefe" / "kernels"

    def run(self, code: str = CALL, **environment: str) -> tuple[str, str]:
        """Return what a new process prints, and its errors."""
        variables = {"KANEFE_CACHE_DIR": str(self.cache), "KANEFE_JIT": "1", "PYTHONPATH": str(self.folder)}
        command, surroundings = [sys.executable, "-c", code], os.environ | variables | environment
        run = subprocess.run(command, env=surroundings, cwd=self.folder, capture_output=True, text=True, check=True)
        return run.stdout.strip(), run.stderr

    def stamp(self, module: str) -> str:
        return self.run(f"from kanefe.kernels.compiler.libraries import stamp; print(stamp(({module!r},)))")[0]


@pytest.fixture
def copy(tmp_path: Path) -> Copy:
    return Copy(tmp_path)


def test_it_is_built_once_told_and_then_loaded_without_numba(copy: Copy) -> None:
    printed, said = copy.run()
    assert printed == "[3.0, 4.0] False"  # it was built in a process of its own
    assert "kanefe: preparing the solver, once: about" in said
    assert "(given)" in said
    assert "kanefe: the solver is prepared, in" in said
    assert copy.run() == ("[3.0, 4.0] False", "")
    (file,) = copy.cache.rglob("*.so")
    assert file.name.startswith("given-")


def test_an_edit_never_runs_old_code(copy: Copy) -> None:
    copy.run()
    path = copy.kernels / "force_elements" / "given.py"
    whole = path.read_text()
    path.write_text(whole.replace("out[i] = inputs[i]", "out[i] = 2.0 * inputs[i]"))
    assert copy.run()[0] == "[6.0, 8.0] False"
    path.write_text(whole)
    assert copy.run() == ("[3.0, 4.0] False", "")  # what was built first is still there


def test_an_edit_concerns_what_imports_it_alone(copy: Copy) -> None:
    modules = (
        "kanefe.kernels.evaluation.evaluation",
        "kanefe.kernels.planar.evaluation",
        "kanefe.kernels.force_elements.given",
    )
    before = {module: copy.stamp(module) for module in modules}
    with (copy.kernels / "sweeps" / "elastic.py").open("a") as file:
        file.write("# changed\n")
    after = {module: copy.stamp(module) for module in modules}
    assert [before[module] != after[module] for module in modules] == [True, True, False]
    for name in ALWAYS:
        with (copy.kernels / name).open("a") as file:
            file.write("# changed\n")
        last, after = after, {module: copy.stamp(module) for module in modules}
        assert all(last[module] != after[module] for module in modules)


@pytest.mark.parametrize("trouble", ["no linker", "no folder"])
def test_where_nothing_can_be_kept_it_is_built_for_the_process(copy: Copy, trouble: str) -> None:
    environment = {"CC": "no-such-compiler"} if trouble == "no linker" else {}
    if trouble == "no folder":
        copy.cache.write_text("a file where the folder should be")
    for _ in range(2):
        printed, said = copy.run(**environment)
        assert printed == "[3.0, 4.0] True"
        assert "preparing the solver" in said


ALONE = """
from llvmlite import binding
from numba.core import codegen
from kanefe.kernels.compiler import _numba
from kanefe.kernels.compiler import _numba_alone as alone
from kanefe.kernels.compiler import _numba_module as alone_module
from kanefe.kernels.force_elements.bushing import bushing
from kanefe.kernels.compiler.addresses import compiled_functions_of

whole, of_machine = [], []
optimise = codegen.CPUCodeLibrary._optimize_final_module
codegen.CPUCodeLibrary._optimize_final_module = lambda library: (whole.append(library.name), optimise(library))
codegen.JITCodeLibrary._finalize_specific = lambda library: of_machine.append(library.name)
run, modules = binding.ModulePassManager.run, []
binding.ModulePassManager.run = lambda passes, *given: (modules.append(1), run(passes, *given))
OTHER
is_done = alone.build_alone()
made = [(unit.symbol, unit.compile()) for unit in compiled_functions_of(bushing, bushing.kinds)]
codes = alone_module.object_codes(made)
ours = len(modules) if is_done else 0
kinds = [kind for made in _numba._dispatchers.values() for given in made.overloads for kind in given]
for_constants = any("Literal" in str(kind) for kind in kinds)
print(is_done, len(codes), min(map(len, codes)) > 1000, ours, len(whole) > 1, len(of_machine) > 1, for_constants)
"""


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_a_process_that_only_builds_optimises_once_and_makes_no_machine_code_for_itself(copy: Copy) -> None:
    assert copy.run(ALONE.replace("OTHER", "")) == ("True 1 True 1 False False False", "")


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_a_numba_with_another_inside_builds_as_it_does(copy: Copy) -> None:
    other = "link = codegen.CPUCodeLibrary.add_linking_library\n"
    other += "codegen.CPUCodeLibrary.add_linking_library = lambda self, library: link(self, library)"
    assert copy.run(ALONE.replace("OTHER", other)) == ("False 2 True 0 True True True", "")


PROBE = '''"""A kernel that hands on arrays of all kinds, and variables set in one place and in several."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import IntegerRows, RealBlocks, RealRows, ValueRows, Values
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.compiler.signatures import COMPLEX, REAL


class Parts(NamedTuple):
    rows: IntegerRows
    blocks: RealBlocks
    table: RealRows


@kernel
def sizes(array: np.ndarray) -> int:
    if array.size == 0:
        return 0
    return array.size + 10 * array.nbytes + 1000 * array.strides[0] + 100000 * array.shape[0] + 7 * array.itemsize


@kernel
def weighed(parts: Parts, vector: np.ndarray, strided: np.ndarray, i: int) -> complex:
    rows, blocks, table = parts
    total, last = 0.0 * vector[0], -1
    if i > 0:
        set_once = 2.0 + i
    for row in range(rows.shape[0]):
        if rows[row, 0] > 0:
            last = row
            factor = table[row, i]
        else:
            factor = strided[row]
            if last >= 0:
                factor += last
        of_row = factor * vector[row] * blocks[i, row, 1]
        total += of_row
    if i > 0:
        total += set_once + of_row
    count = sizes(blocks) + sizes(blocks[i]) + sizes(blocks[i, 0]) + sizes(rows) + sizes(strided) + sizes(vector[1:])
    while count > 100.0:
        count //= 3
    return total + count + last + blocks.reshape(-1, 2)[i, 0]


@entry(REAL, COMPLEX)
def probe(parts: Parts, vectors: ValueRows, out: Values) -> int:
    for i in range(len(out)):
        out[i] = weighed(parts, vectors[i], parts.table[:, i], i)
        out[i] += sizes(parts.blocks) + sizes(parts.blocks[1:]) + sizes(vectors) + sizes(vectors[:0])
    return len(out)
'''

CALL_PROBE = """
import numpy as np
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.force_elements.probe import Parts, probe
number, out = np.random.default_rng(1), []
parts = Parts(number.integers(-1, 2, (5, 3)), number.random((2, 5, 4)), number.random((5, 2)))
for kind in (float, complex):
    vectors = (number.random((2, 5)) + (0.5j if kind is complex else 0.0)).astype(kind)
    found = np.zeros(2, kind)
    probe.bound(parts, vectors, found, is_complex=kind is complex)()
    out += found.tolist()
print([round(value, 6) if isinstance(value, float) else (round(value.real, 6), round(value.imag, 6)) for value in out])
"""


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_what_is_built_alone_computes_what_python_does(copy: Copy) -> None:
    (copy.kernels / "force_elements" / "probe.py").write_text(PROBE)
    compiled, said = copy.run(CALL_PROBE)
    assert "(probe)" in said
    assert "(probe-complex)" in said
    assert (compiled, "") == copy.run(CALL_PROBE, KANEFE_JIT="0")


def test_plain_python_builds_nothing(copy: Copy) -> None:
    assert copy.run(KANEFE_JIT="0") == ("[3.0, 4.0] False", "")
    assert not copy.cache.exists()


def imported_by(source: str) -> Iterator[str]:
    """Yield the modules of kernels that the statements at the top of a file import, by themselves or names of."""
    for node in ast.parse(source).body:
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("kanefe.kernels"):
            yield str(node.module)
            folder = KERNELS.parent.parent / str(node.module).replace(".", "/")
            yield from (f"{node.module}.{one.name}" for one in node.names if (folder / f"{one.name}.py").is_file())


def test_stamps_see_modules_that_are_imported_by_name() -> None:
    seen = imports_of((KERNELS / "joints" / "by_kind.py").read_bytes())
    assert {"kanefe.kernels.joints.ball", "kanefe.kernels.joints.axis"} <= {*seen}


def test_kernels_import_each_other_in_the_one_way_that_stamps_see() -> None:
    for path in KERNELS.rglob("*.py"):
        source = path.read_text(encoding="utf-8")
        seen = imports_of(path.read_bytes())
        assert seen == tuple(dict.fromkeys(imported_by(source))), path
        if path.name not in ("build.py", "side_by_side.py", "libraries.py"):  # which no kernel imports
            assert source.count("import kanefe.kernels") == 0, path
        for module in seen:
            place = KERNELS.parent.parent / module.replace(".", "/")
            assert place.with_suffix(".py").is_file() or (place / "__init__.py").is_file(), (path, module)


def test_stamps_differ_with_what_is_imported() -> None:
    assert stamp(("kanefe.kernels.steppers.step_commands",)) != stamp(("kanefe.kernels.evaluation.evaluation",))


def test_every_unit_has_a_name_of_its_own() -> None:
    names = [unit.name for unit in all_compiled_functions()]
    assert len(names) == len(set(names))
    assert {"integrate", "evaluate_planar", "spring-complex", "advance_radau"} <= set(names)


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_what_is_there_is_not_built_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = {library: units for library, units in all_libraries().items() if library.name in ("given", "spring")}
    monkeypatch.setattr("kanefe.kernels.compiler.build.all_libraries", lambda: few)
    said: list[str] = []
    assert sorted(build(tmp_path, 2, said.append)) == ["given", "spring"]
    assert "the solver is prepared" in said[-1]
    assert build(tmp_path, 2, said.append) == []
    assert len(list(tmp_path.glob("*.so"))) == 2


def test_each_library_has_what_the_table_of_libraries_says() -> None:
    """The engine has what calls evaluations; a law or a method is by itself, and complex numbers are apart."""
    names = {library.name: {unit.name for unit in units} for library, units in all_libraries().items()}
    assert len(names) == len(all_libraries())
    assert {"evaluate", "close_state", "forces_of_states", "integrate", "watch_states"} <= names[ENGINE]
    assert names[f"{ENGINE}-complex"] == {"evaluate-complex", "derivatives-complex"}
    assert names["radau"] == {"advance_radau", "interpolate_radau"}
    assert names["spring"] == {"spring-real", "spring-complex"}
    assert not any(name.endswith("-complex") for name in names[ENGINE])


def test_every_file_of_the_compiler_is_a_part_of_stamps_or_known_to_be_none() -> None:
    """A file that changes what is compiled, and no stamp, would leave old code in use."""
    files = {f"{room}/{path.name}" for room in ("compiler", "values") for path in (KERNELS / room).glob("*.py")}
    never_imported = {"build", "progress", "watched", "__init__", "foreign"}
    by_import = {"addresses", "calls", "filling", "local_numbers", "python_calls"}
    rest = {f"compiler/{name}.py" for name in never_imported | by_import} | {"values/__init__.py"}
    assert files == {*ALWAYS, *NEVER, *rest}


TWICE = """
import subprocess, sys
command = [sys.executable, "-c", CALL]
both = [subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) for _ in range(2)]
for one in both:
    printed, said = one.communicate()
    print(printed.strip(), "about" in said, "another process" in said)
"""


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_two_processes_at_once_build_once(copy: Copy) -> None:
    printed, _ = copy.run(TWICE.replace("CALL", repr(CALL)))
    lines = printed.splitlines()
    assert [line.split("] ")[0] for line in lines] == ["[3.0, 4.0", "[3.0, 4.0"]
    builders = [line for line in lines if line.endswith("True False")]
    assert len(builders) == 1  # the other waited, or came when it was there
    assert len(list(copy.cache.rglob("*.so"))) == 1


KILLED = """
import os, signal, subprocess, sys, threading, time
from kanefe.kernels.compiler import side_by_side
from kanefe.kernels.compiler.build import all_libraries
from kanefe.kernels.compiler.processors import generations_here, own_folder
own_folder().mkdir(parents=True)
few = [library for library in all_libraries() if library.name in ("given", "contact_forces")]
def told(name, line):
    print(name, line, flush=True)
    if name == "given" and line == "done":
        os.kill(os.getpid(), signal.SIGKILL)
side_by_side.BuildProgress.note = lambda self, name, line: told(name, line)
side_by_side.build_libraries(few, own_folder(), 2, lambda text: None)
"""


@pytest.mark.skipif(not IS_COMPILED or sys.platform != "linux", reason="builders end with their parent on Linux")
def test_after_a_kill_builders_end_and_what_is_whole_is_kept(copy: Copy) -> None:
    with pytest.raises(subprocess.CalledProcessError):
        copy.run(KILLED)
    assert [path.name.split("-")[0] for path in copy.cache.rglob("*.so")] == ["given"]

    def builders() -> list[str]:
        found = []
        for folder in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                found.append((folder / "cmdline").read_bytes().decode())
        return [line for line in found if str(copy.cache) in line]

    deadline = time.monotonic() + 20.0
    while builders() and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not builders()
    assert copy.run() == ("[3.0, 4.0] False", "")  # the lock is free, and nothing is built again


def test_a_processor_that_lacks_a_feature_has_a_folder_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    ours = own_folder()
    monkeypatch.setattr("kanefe.kernels.compiler.processors._features", lambda: "sse2")
    own_folder.cache_clear()
    try:
        assert own_folder() != ours
        assert generations_here() == ["x86-64"]
    finally:
        own_folder.cache_clear()


def test_without_a_compiler_nothing_is_begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(kanefe.MissingDependency, match=r"'no-such-compiler'.*apt-get install gcc"):
        build(tmp_path, 1, lambda line: pytest.fail(line))
    assert not list(tmp_path.iterdir())


def test_arguments_of_another_kind_are_refused_before_they_are_read() -> None:
    if IS_COMPILED:
        memory = np.zeros(2), np.zeros(1), np.zeros((1, 1)), np.zeros((1, 1))
        run = Run(fill_nothing, fill_nothing, *memory, np.zeros(0), np.zeros((0, 1)), 0, np.zeros(1, dtype=np.int64))
        with pytest.raises(TypeError, match=r"contiguous int64 array of 1 axes, not float64 \(2,\)"):
            interpolated(run, 0.0, np.zeros(1))
