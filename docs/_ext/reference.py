"""Pages of the reference: every public name of kanefe and kanefe_fem, room by room."""

from __future__ import annotations

import inspect
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

import kanefe
import kanefe_fem
from kanefe._public import homes

# Rooms in the order of a user's way, with the titles of their pages.
ROOMS = {
    "system": "Scenes",
    "scene": "Frames of a scene",
    "joints": "Joints and motions",
    "loads": "Loads between frames",
    "contact": "Contact and friction",
    "environment": "Seas and ships",
    "bodies": "Flexible bodies",
    "fe_model": "Finite-element models and their interfaces",
    "reduction": "Reduction",
    "imports": "Matrices of other programs",
    "robots": "Robots of URDF and MJCF files",
    "equations": "Equations",
    "integrate": "Methods and events",
    "records": "Records",
    "result": "Results",
    "instants": "A scene at one time",
    "stepping": "A scene that is stepped from outside",
    "tree": "What functions of the user see",
    "linear": "Equilibria and small motions",
    "screening": "Screened runs",
    "batches": "Many runs at once",
    "certified": "Answers with a bound",
    "results": "How wrong an answer may be",
    "studies": "Studies",
    "fatigue": "Fatigue",
    "frames": "Rotations",
    "errors": "Errors and warnings",
}
FEM_ROOMS = {
    "shells": "Bodies from meshes of surfaces",
    "solids": "Bodies from meshes",
    "beams": "Beams",
    "materials": "Materials",
    "mesh": "Meshes",
    "mesh_files": "Mesh files",
    "assemblies": "Assemblies from CAD",
    "lumped": "Lumped masses and springs",
    "segments": "Bodies that are cut",
    "recovery": "Stresses and strains",
}
# Public modules, whose names are used through them.
MODULES = {"contact": ("shapes",), "studies": ("studies",), "fatigue": ("fatigue",)}


def rooms_of(package, titles: dict[str, str]) -> dict[str, list[str]]:
    """Return the public names of a package by room; each room must have a title."""
    found: dict[str, list[str]] = {}
    for name, module in homes(package.__file__).items():
        found.setdefault(module.split(".")[1], []).append(name)
    for room, modules in MODULES.items():
        found[room] = [name for name in found.get(room, []) if name not in modules] if room in found else []
    extra = sorted(set(found) - set(titles)) if package is kanefe else sorted(set(found) - set(titles) - set(MODULES))
    if extra:
        raise ExtensionError(f"docs/_ext/reference.py has no title for: {', '.join(extra)}")
    return {room: found.get(room, []) for room in titles}


def _entry(package: str, name: str, thing: object) -> str:
    if inspect.isclass(thing):
        is_error = issubclass(thing, BaseException)
        kind = "autoexception" if is_error else "autoclass"
        options = "" if is_error else "   :members:\n   :inherited-members: object, tuple, str, int\n"
        return f".. {kind}:: {package}.{name}\n{options}"
    return f".. auto{'function' if callable(thing) else 'data'}:: {package}.{name}\n"


def _names_of(module) -> list[str]:
    """Return what a public module says is in it, or what its room defines."""
    room = module.__name__.rpartition(".")[0]
    defined = [n for n, x in vars(module).items() if n[0] != "_" and getattr(x, "__module__", "").startswith(room)]
    return list(getattr(module, "__all__", defined))


def _page(package, room: str, title: str, names: list[str]) -> str:
    stem = package.__name__
    parts = [title, "=" * len(title), ""]
    for name in names:
        parts += [name, "-" * len(name), "", _entry(stem, name, getattr(package, name)), ""]
    for module in MODULES.get(room, ()) if package is kanefe else ():
        members = getattr(package, module)
        parts += [f"{stem}.{module}", "-" * len(f"{stem}.{module}"), "", f".. py:module:: {stem}.{module}", ""]
        for name in _names_of(members):
            if name not in names:
                parts += [_entry(f"{stem}.{module}", name, getattr(members, name)), ""]
    return "\n".join(parts)


def _write(app: Sphinx) -> None:
    folder = Path(app.srcdir) / "reference" / "generated"
    folder.mkdir(parents=True, exist_ok=True)
    wanted = {}
    for package, titles in ((kanefe, ROOMS), (kanefe_fem, FEM_ROOMS)):
        for room, names in rooms_of(package, titles).items():
            wanted[f"{package.__name__}-{room}.rst"] = _page(package, room, titles[room], names)
    for path in folder.glob("*.rst"):
        if path.name not in wanted:
            path.unlink()
    for name, text in wanted.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def _order(app: Sphinx, name: str, source: list[str]) -> None:
    """Put the rooms in their order into the lists of contents."""
    if name != "reference/index":
        return
    for package, titles in ((kanefe, ROOMS), (kanefe_fem, FEM_ROOMS)):
        rooms = [f"generated/{package.__name__}-{room}" for room in titles]
        source[0] = source[0].replace(f"generated/{package.__name__}-*", "\n".join(rooms))


def _keep_formulas(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Show what a docstring indents in its text as it stands: formulas, with their bars and stars."""
    section, found = "", []
    for i, line in enumerate(lines):
        if i + 1 < len(lines) and set(lines[i + 1].strip()) == {"-"}:
            section = line.strip()
        begins = line.startswith("    ") and i > 1 and not lines[i - 1].strip() and not lines[i - 2].startswith(" ")
        before = next((text for text in reversed(found) if text.strip()), "")
        if begins and section in ("", "Notes") and not before.endswith("::") and not before.startswith(("-", "1.")):
            found += ["::", ""]
        found.append(line)
    lines[:] = found


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages before sources are looked for."""
    app.connect("builder-inited", _write, priority=100)
    app.connect("source-read", _order)
    app.connect("autodoc-process-docstring", _keep_formulas, priority=100)
    return {"parallel_read_safe": True}
