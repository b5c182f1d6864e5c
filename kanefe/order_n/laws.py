"""The functions of the loads and joints of a scene, which the kernels call by address."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from kanefe.kernels.compiler.addresses import compiled_functions_of
from kanefe.kernels.compiler.compiled_functions import CompiledFunction
from kanefe.kernels.force_elements import places as of_loads
from kanefe.kernels.force_elements.given import given
from kanefe.kernels.links import places as of_links
from kanefe.tree.model_data import ModelData


def functions_of_laws(model: ModelData) -> Iterator[CompiledFunction]:
    """Yield what is built for the loads and joints of a scene; nothing for functions that have an address."""
    for number, load in enumerate(model.loads):
        kernel = load.kernel
        if number in model.rigid_contacts:
            continue
        if kernel is None:
            yield from compiled_functions_of(given, of_loads.SIGNATURE)
            continue
        yield from _built(of_loads.SIGNATURE, kernel.real, kernel.complex_)
        yield from _built(of_loads.WATCH_SIGNATURE, kernel.watch, kernel.change)
    for body in model.bodies:
        for link in body.joint.links() or ():
            if link.kernel is not None:
                yield from _built(of_links.SIGNATURE, link.kernel.real, link.kernel.complex_)


def _built(signature: tuple[str, ...], *functions: Callable[..., None] | int | None) -> Iterator[CompiledFunction]:
    for function in functions:
        if callable(function):
            yield from compiled_functions_of(function, signature)
