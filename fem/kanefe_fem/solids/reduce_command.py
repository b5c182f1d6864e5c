"""The command ``kanefe reduce``: a flexible body from a mesh, made by one process or by many."""

from __future__ import annotations

import time
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

import kanefe as kf
from kanefe.errors import FileError, ModelError, did_you_mean
from kanefe_fem import _fenicsx
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.materials.orthotropic import Anisotropic, Orthotropic
from kanefe_fem.processes.team import led
from kanefe_fem.solids.body import solid_body

CLASSES = {"Material": Material, "Orthotropic": Orthotropic, "Anisotropic": Anisotropic}
"""Materials by the word under "class" in a table, by default the first."""

WITH = ("order", "plane", "thickness", "surfaces", "cells", "densities", "stiffening", "solver", "cache", "progress")
"""Keywords of `solid_body` that --with takes."""

WITH_HELP = f"Keywords of solid_body, such as \"order=1, cells='arm'\": {', '.join(WITH)}."


@dataclass(frozen=True)
class _GivenOptions:
    """The arguments of `solid_body` from those of the command."""

    materials: Any
    interfaces: dict[str, str]
    reduction: kf.CraigBampton
    damping: kf.ModalDamping | None
    more: dict[str, Any]


def reduce(
    mesh: Annotated[str, typer.Argument(help="The mesh, such as part.msh.")],
    materials: Annotated[
        str,
        typer.Option(
            help='"E=210e9, nu=0.3, rho=7850" for a body of one material, or a .toml file with such a table for each '
            'group of cells; class="Orthotropic" or "Anisotropic" with the names of those classes.'
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="The file of the body, .npz; see FlexibleBody.load.")],
    interface: Annotated[
        list[str] | None, typer.Option(help="GROUP=KIND, as often as needed: clamped, rigid, hinged, average, node.")
    ] = None,
    modes: Annotated[int | None, typer.Option(help="Number of normal modes.")] = None,
    up_to: Annotated[float | None, typer.Option(help="Instead of --modes: all up to this frequency, Hz.")] = None,
    load: Annotated[
        list[str] | None, typer.Option(help="A load whose static shapes are kept too, such as gravity or an interface.")
    ] = None,
    damping: Annotated[float | None, typer.Option(help="Damping ratio of all modes, such as 0.01.")] = None,
    more: Annotated[str, typer.Option("--with", help=WITH_HELP)] = "",
) -> None:
    """Make a flexible body from a mesh (Craig-Bampton), and write its file; under mpirun all processes make it.

    mpirun -n 4 kanefe reduce part.msh --materials "E=210e9, nu=0.3, rho=7850" --interface root=clamped --interface
    tip=rigid --modes 20 -o part.npz
    """
    comm = _fenicsx.world()

    def read(_: object) -> _GivenOptions:
        if out.suffix != ".npz":
            raise ModelError(f"--out {out} must end with .npz, the format of bodies. Remedy: {out.with_suffix('.npz')}")
        reduction = kf.CraigBampton(modes, up_to, loads=tuple(load or ()))
        ratio = None if damping is None else kf.ModalDamping(damping)
        return _GivenOptions(_materials(materials), _interfaces(interface or []), reduction, ratio, _keywords(more))

    began = time.perf_counter()
    given: _GivenOptions = comm.bcast(led(comm, read))  # read once, so that there is one message
    body = solid_body(mesh, given.materials, given.interfaces, given.reduction, given.damping, comm=comm, **given.more)
    if body is not None:
        body.save(out)
        _tell(body, out, time.perf_counter() - began)


def _materials(text: str) -> Any:
    """Return one material, or those of groups, from a file or a table of one line."""
    if not text.endswith(".toml"):
        return _material("--materials", _table("--materials", text))
    try:
        found = tomllib.loads(Path(text).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as problem:
        raise FileError(f"the materials {text} cannot be read: {problem}. Remedy: tables of TOML") from problem
    if not found:
        raise FileError(f"{text} has no table. Remedy: [GROUP], and below it E, nu and rho")
    if not all(isinstance(one, Mapping) for one in found.values()):
        return _material(text, found)
    return {group: _material(f"{text}, [{group}]", table) for group, table in found.items()}


def _material(where: str, table: Mapping[str, Any]) -> Any:
    entries = dict(table)
    name = entries.pop("class", "Material")
    if name not in CLASSES:
        raise ModelError(f"{where}: class={name!r} is no material. Remedy: one of {', '.join(CLASSES)}")
    cls: Any = CLASSES[name]
    known = [one for one in cls.__dataclass_fields__ if one not in ("damping", "strengths")]
    for entry in entries:
        if entry not in known:
            raise ModelError(
                f"{where}: {name} has no {entry!r}. {did_you_mean(entry, known)}Remedy: among {', '.join(known)}"
            )
    try:
        return cls(**entries)
    except TypeError as problem:
        raise ModelError(f"{where}: {name} is incomplete: {problem}") from problem


def _interfaces(pairs: list[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for pair in pairs:
        group, sign, kind = pair.rpartition("=")
        if not (group and sign and kind) or group in found:
            raise ModelError(f"--interface {pair}. Remedy: GROUP=KIND, each group once, such as root=clamped")
        found[group] = kind
    return found


def _keywords(text: str) -> dict[str, Any]:
    found = _table("--with", text)
    for name in found:
        if name not in WITH:
            raise ModelError(f"--with has no {name!r}. {did_you_mean(name, WITH)}Remedy: among {', '.join(WITH)}")
    return found


def _table(option: str, text: str) -> dict[str, Any]:
    """Return the entries of one line of TOML, ``name=value, name=value``."""
    try:
        table: dict[str, Any] = tomllib.loads(f"table = {{ {text} }}")["table"]
    except tomllib.TOMLDecodeError as problem:
        raise ModelError(f'{option} "{text}" cannot be read: {problem}. Remedy: "name=value, name=value"') from problem
    return table


def _tell(body: kf.FlexibleBody, out: Path, seconds: float) -> None:
    about, hertz = body.provenance, body.frequencies
    how = about.get("processes")
    print(f"{about['source']}: {about['nodes']} nodes, {about['cells']} cells, {about['dofs']} degrees of freedom")
    print(f"body: {body.free_count} coordinates, {hertz[0]:.6g} to {hertz[-1]:.6g} Hz" if len(hertz) else "body: rigid")
    if about.get("cache", {}).get("found"):
        print("from the cache")
    elif how is not None:
        left = how["residuals"]
        print(
            f"processes: {how['count']}, factor of {' + '.join(map(str, how['factor_megabytes']))} MB; residuals of "
            f"statics {left['statics']:.1e}, of modes {left['modes']:.1e}"
        )
    print(f"{out}, {1e-6 * out.stat().st_size:.3g} MB, after {seconds:.1f} s")
