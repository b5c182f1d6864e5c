"""Built kernels: what they are made from, where they are kept, and what is said when they are made."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kanefe.kernels
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler.build import all_compiled_functions, build
from kanefe.kernels.compiler.compiled_functions import ALWAYS, imports_of, stamp
from kanefe.kernels.compiler.filling import fill_nothing
from kanefe.kernels.compiler.signatures import signature_of, wrapper_source
from kanefe.kernels.evaluation.evaluation import evaluate
from kanefe.kernels.steppers.step_commands import interpolated

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
        return self.run(f"from kanefe.kernels.compiler.compiled_functions import stamp; print(stamp({module!r}))")[0]


@pytest.fixture
def copy(tmp_path: Path) -> Copy:
    return Copy(tmp_path)


def test_it_is_built_once_told_and_then_loaded_without_numba(copy: Copy) -> None:
    printed, said = copy.run()
    assert printed == "[3.0, 4.0] False"  # it was built in a process of its own
    assert "kanefe: preparing the solver: 1 of 1 parts" in said
    assert said.count("kanefe: preparing the solver") == said.count("\n")
    assert copy.run() == ("[3.0, 4.0] False", "")
    (file,) = copy.cache.rglob("*.so")
    assert file.name.startswith("given-real-")


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
from numba.core import analysis, codegen
from kanefe.kernels.compiler import _numba_alone as alone
from kanefe.kernels.force_elements.bushing import bushing
from kanefe.kernels.compiler.addresses import compiled_functions_of

of_numba, of_house, seen = analysis.compute_live_map, alone.live_variables, []

def both(*given):
    ours, theirs = of_house(*given), of_numba(*given)
    assert ours == theirs and list(ours) == list(theirs)
    seen.append(len(ours))
    return ours

alone.live_variables = both
whole, of_machine = [], []
optimise = codegen.CPUCodeLibrary._optimize_final_module
codegen.CPUCodeLibrary._optimize_final_module = lambda library: (whole.append(library.name), optimise(library))
codegen.JITCodeLibrary._finalize_specific = lambda library: of_machine.append(library.name)
OTHER
is_done = alone.build_alone()
unit, *_ = compiled_functions_of(bushing, bushing.kinds)
is_code = len(unit.compile().code) > 1000
print(is_done, is_code, len(whole) > 1, len(of_machine) > 1, max(seen, default=0) > 10)
"""


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_a_process_that_only_builds_optimises_once_and_makes_no_machine_code_for_itself(copy: Copy) -> None:
    assert copy.run(ALONE.replace("OTHER", "")) == ("True True False False True", "")


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_a_numba_with_another_inside_builds_as_it_does(copy: Copy) -> None:
    other = "link = codegen.CPUCodeLibrary.add_linking_library\n"
    other += "codegen.CPUCodeLibrary.add_linking_library = lambda self, library: link(self, library)"
    assert copy.run(ALONE.replace("OTHER", other)) == ("False True True True False", "")


PROBE = '''"""A kernel that hands on arrays of all kinds, and variables set in one place and in several."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import IntegerRows, RealBlocks, RealRows, ValueRows, Values
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.compiler.signatures import Variant


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


@entry(Variant(), Variant(is_complex=True))
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
    assert said.count("(probe") == 2
    assert (compiled, "") == copy.run(CALL_PROBE, KANEFE_JIT="0")


def test_plain_python_builds_nothing(copy: Copy) -> None:
    assert copy.run(KANEFE_JIT="0") == ("[3.0, 4.0] False", "")
    assert not copy.cache.exists()


def test_kernels_import_each_other_in_the_one_way_that_stamps_see() -> None:
    for path in KERNELS.rglob("*.py"):
        source = path.read_text(encoding="utf-8")
        seen = imports_of(path.read_bytes())
        lines = re.findall(r"^from (kanefe\.kernels[\w.]*) import", source, re.MULTILINE)
        assert seen == tuple(dict.fromkeys(lines)), path
        if path.name not in ("build.py", "side_by_side.py"):  # which no kernel imports
            assert source.count("kanefe.kernels") - source.count("`kanefe.kernels") >= len(seen)
            assert source.count("import kanefe.kernels") == 0, path
        for module in seen:
            place = KERNELS.parent.parent / module.replace(".", "/")
            assert place.with_suffix(".py").is_file() or (place / "__init__.py").is_file(), (path, module)


def test_stamps_differ_with_what_is_imported() -> None:
    assert stamp("kanefe.kernels.steppers.step_commands") != stamp("kanefe.kernels.evaluation.evaluation")


def test_every_unit_has_a_name_of_its_own() -> None:
    names = [unit.name for unit in all_compiled_functions()]
    assert len(names) == len(set(names))
    assert {"integrate", "evaluate_planar", "spring-complex", "advance_radau"} <= set(names)


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_what_is_there_is_not_built_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = [unit for unit in all_compiled_functions() if unit.name in ("given-real", "fill_nothing")]
    monkeypatch.setattr("kanefe.kernels.compiler.build.all_compiled_functions", lambda: few)
    said: list[str] = []
    assert build(tmp_path, 2, said.append) == 2
    assert "preparing the solver: 2 of 2 parts" in said[-1]
    assert build(tmp_path, 2, said.append) == 0
    assert len(list(tmp_path.glob("*.so"))) == 2


def test_without_a_compiler_nothing_is_begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(kanefe.MissingDependency, match=r"'no-such-compiler'.*apt-get install gcc"):
        build(tmp_path, 1, lambda line: pytest.fail(line))
    assert not list(tmp_path.iterdir())


def test_arguments_of_another_kind_are_refused_before_they_are_read() -> None:
    if IS_COMPILED:
        with pytest.raises(TypeError, match=r"contiguous int64 array of 1 axes, not float64 \(2,\)"):
            interpolated(fill_nothing, np.zeros(2), np.zeros(1), np.zeros((1, 1)), np.zeros((1, 1)), 0.0, np.zeros(1))


def test_what_unpacks_arguments_asks_once_whether_it_raised() -> None:
    """Asking after each expression took a third of the time of building."""
    source, _ = wrapper_source(signature_of(evaluate.function, evaluate.variants[-1]))
    wrapper = ast.parse(source).body[-1]
    (attempt,) = (node for node in ast.walk(wrapper) if isinstance(node, ast.Try))
    assert [ast.unparse(line) for line in attempt.body] == ["call(places, numbers)"]
