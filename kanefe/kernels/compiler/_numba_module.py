"""One module of all functions of a library: each kernel is in it once, whoever calls it, and is optimised once.

Only kernels of long sums, and of many alike, use vector instructions (`vector_kernel`, `in_vectors` of `_numba`): they
are optimised by themselves, with the vectorisers, before they are laid into those that call them. The rest, which is
algebra of three components and short loops, is optimised without vectorisers and without unrolling of loops: that takes
half the time, gives two thirds of the code, and runs as fast or faster.
"""

import os
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from llvmlite import binding

from kanefe.kernels.compiler._numba import vector_dispatchers
from kanefe.kernels.compiler._numba_alone import is_alone
from kanefe.kernels.compiler.watched import end_with_parent


class Translated(NamedTuple):
    """A C function that numba has translated.

    Attributes
    ----------
    library : CPUCodeLibrary
        Of numba, with those that it calls.
    symbol : str
    """

    library: Any
    symbol: str

    def address(self) -> int:
        """Return where it is in this process, which makes its machine code."""
        return int(self.library.get_pointer_to_function(self.symbol))


def object_codes(functions: Sequence[tuple[str, Translated]], parts: int = 1) -> list[bytes]:
    """Return the machine code of functions, each with the name that it is to have, for the linker.

    Parameters
    ----------
    functions : sequence of (str, Translated)
    parts : int
        On how many cores it is optimised.
    """
    # other forms of the indices of loops take as long to find as registers, and are more code, no faster
    binding.set_option("kanefe", "-disable-lsr")
    if not is_alone():  # each has a copy of what it calls, and is optimised
        return [_apart(name, function) for name, function in functions]
    wanted = {function.symbol: name for name, function in functions}
    kernels = [_Kernel(one) for one in _reached(function.library for _, function in functions)]
    groups = _groups(kernels, parts)
    works = [_Work(kernels, group, wanted) for group in groups]
    return [works[0].code()] if len(works) == 1 else _side_by_side([work.code for work in works])


def _apart(name: str, function: Translated) -> bytes:
    module = binding.parse_bitcode(function.library._final_module.as_bitcode())
    for one in module.functions:
        if not one.is_declaration and one.name != function.symbol:
            one.linkage = "internal"
    module.get_function(function.symbol).name = name
    return bytes(_machine(function.library._codegen).emit_object(module))


def _reached(libraries: Iterable[Any]) -> list[Any]:
    """Return libraries with all that they call, each once: what is called by one alone stands beside it."""
    found: dict[int, Any] = {}
    waiting = [*libraries][::-1]
    while waiting:
        one = waiting.pop()
        if id(one) not in found:
            found[id(one)] = one
            waiting += one._linking_libraries[::-1]
    return list(found.values())


class _Kernel:
    """A library of numba, which has one kernel and the functions around it.

    Attributes
    ----------
    library : CPUCodeLibrary
    defined, called : set of str
        Names of functions that it has, and of those that it takes from others.
    is_inlined : bool
        Whether it is laid into each kernel that calls it.
    """

    def __init__(self, library: Any) -> None:
        self.library, functions = library, list(library._final_module.functions)
        own = [one for one in functions if not one.is_declaration]
        self.defined = {one.name for one in own}
        self.called = {one.name for one in functions if one.is_declaration}
        self.is_inlined = bool(own) and all(b"alwaysinline" in b" ".join(one.attributes) for one in own)


def _groups(kernels: Sequence[_Kernel], parts: int) -> list[set[int]]:
    """Return which kernels each part has, about as much code in each; those that call each other stay together."""
    sizes = [len(kernel.library._final_module.as_bitcode()) for kernel in kernels]
    found: list[set[int]] = [set() for _ in range(parts)]
    before, whole = 0, sum(sizes)
    for i, size in enumerate(sizes):
        found[parts * before // whole].add(i)
        before += size
    return [group for group in found if group]


class _Work:
    """A part of a library that is to be optimised.

    Parameters
    ----------
    kernels : sequence of _Kernel
        All of the library.
    group : set of int
        Those of this part.
    wanted : dict
        Names of the functions that are called from outside, by their symbols.
    """

    def __init__(self, kernels: Sequence[_Kernel], group: set[int], wanted: dict[str, str]) -> None:
        self._own = [kernels[i] for i in sorted(group)]
        self._inlined = [kernel for i, kernel in enumerate(kernels) if kernel.is_inlined and i not in group]
        self._wanted = wanted
        self._of_library = {name for kernel in kernels for name in kernel.defined}
        self._seen = set[str]()  # by other parts, which have a copy of what is inlined
        if len(group) < len(kernels):
            others = [kernel for i, kernel in enumerate(kernels) if kernel.is_inlined or i not in group]
            called = {name for kernel in others for name in kernel.called}
            for kernel in self._own:
                for name in kernel.defined & called:  # else some of numba's are left out where their part calls none
                    kernel.library._final_module.get_function(name).linkage = "external"
                    self._seen.add(name)
        self._uses_vectors = {id(one.library) for kernel in vector_dispatchers() for one in kernel.overloads.values()}

    def code(self) -> bytes:
        """Return its machine code."""
        codegen = self._own[0].library._codegen
        module = binding.parse_assembly(str(codegen._create_empty_module("kanefe")))
        for kernel in (*self._own, *self._inlined):
            if id(kernel.library) in self._uses_vectors:
                module.link_in(_with_vectors(kernel.library))
            else:
                module.link_in(kernel.library._final_module, preserve=True)
        for function in module.functions:
            if function.name in self._wanted:
                function.name = self._wanted[function.name]
            elif function.name in self._of_library and (function.is_declaration or function.name in self._seen):
                function.visibility = "hidden"
            elif not function.is_declaration:
                function.linkage = "internal"
        _optimise(codegen, module)
        module.verify()
        return bytes(_machine(codegen).emit_object(module))


def _with_vectors(library: Any) -> Any:
    """Return the module of such a kernel, optimised with vector instructions."""
    own, *called = _reached([library])
    module = binding.parse_bitcode(own._final_module.as_bitcode())
    names = {one.name for one in module.functions if not one.is_declaration}
    for other in called:
        module.link_in(other._final_module, preserve=True)
    for one in module.functions:
        if not one.is_declaration and one.name not in names:
            one.linkage = "internal"
    _optimise(library._codegen, module, has_vectors=True)
    return module


def _optimise(codegen: Any, module: Any, has_vectors: bool = False) -> None:
    options = binding.create_pipeline_tuning_options(speed_level=3 if has_vectors else 2)
    options.loop_vectorization = options.slp_vectorization = has_vectors
    options.loop_unrolling = options.loop_interleaving = has_vectors
    builder = binding.create_pass_builder(_machine(codegen), options)
    builder.getModulePassManager().run(module, builder)


def _machine(codegen: Any) -> Any:
    """Return the compiler for code that may lie anywhere: numba's own is for its process alone."""
    target = binding.Target.from_triple(binding.get_process_triple())
    return target.create_target_machine(
        cpu=codegen._get_host_cpu_name(), features=codegen._tm_features, opt=3, reloc="pic", codemodel="default"
    )


def _side_by_side(works: Sequence[Callable[[], bytes]]) -> list[bytes]:
    """Return what functions give, each but the first in a copy of this process.

    Raises
    ------
    OSError
        If a copy cannot be made, or one has failed.
    """
    with tempfile.TemporaryDirectory(prefix="kanefe-") as folder:
        copies = {}
        for i, work in enumerate(works[1:]):
            place = Path(folder) / str(i)
            copy = os.fork()
            if copy == 0:
                _work_to_file(work, place)
            copies[copy] = place
        codes = [works[0]()]
        for copy, place in copies.items():
            _, status = os.waitpid(copy, 0)
            if status:
                raise OSError(f"a part of the solver could not be compiled (status {status})")
            codes.append(place.read_bytes())
        return codes


def _work_to_file(work: Callable[[], bytes], place: Path) -> None:
    """Write what a function gives to a file, and end this process, a copy of another."""
    status = 1
    try:
        end_with_parent()
        place.write_bytes(work())
        status = 0
    finally:
        os._exit(status)
