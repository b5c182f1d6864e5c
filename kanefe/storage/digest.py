"""Digests of data and functions: equal parts give equal digests, in every process and on every machine."""

from __future__ import annotations

import dataclasses
import dis
import hashlib
import sys
from collections.abc import Mapping
from functools import cache, cached_property, partial
from pathlib import Path
from sysconfig import get_path
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

from kanefe.storage.saved_classes import word_of
from kanefe.storage.scipy_later import sp

PIECE = 1 << 20

MADE = {f"__{name}__" for name in ("init", "repr", "eq", "lt", "le", "gt", "ge", "hash", "setattr", "delattr")}
"""Names of functions that dataclasses generate."""

OWN = ("kanefe", "kanefe_fem")
"""Packages whose classes are identified by their names, whatever file they are in."""


class Unhashable(TypeError):
    """A part whose content cannot be identified; the message names it."""


def digest(**parts: Any) -> str:
    """Return 32 hexadecimal digits that stand for the parts.

    Parameters
    ----------
    **parts
        Numbers, texts, arrays, sparse matrices, paths (their content), dataclasses, and sequences and mappings of
        them. A function is identified by its code, its defaults and the outer values that it uses, also those of
        modules that are not installed; a class of the user by its name, its methods and its plain attributes.

    Raises
    ------
    Unhashable
        If a part is something else, such as an open file or an object of a library.

    Examples
    --------
    >>> digest(E=210e9, nu=0.3) == digest(E=2.1e11, nu=0.3)
    True
    >>> digest(E=210e9, nu=0.3) == digest(E=210e9, nu=0.31)
    False
    """
    hasher = _Hasher()
    hasher.feed(parts, "")
    return hasher.hexdigest()


def digest_of_scene(**parts: Any) -> str:
    """As `digest`, also for objects of any class, by class and attributes, and for compiled functions, by code.

    Data that such an object keeps elsewhere, as in a file, are not included.

    Raises
    ------
    Unhashable
        If an object has no attributes.
    """
    hasher = _Hasher(takes_objects=True)
    hasher.feed(parts, "")
    return hasher.hexdigest()


def digest_of_functions(**parts: Any) -> str:
    """As `digest_of_scene`, with functions of installed packages by their names alone.

    Where the versions of these packages matter, they are to be given as well.

    Raises
    ------
    Unhashable
        If a function uses an outer value whose content cannot be identified, such as a generator of numbers.
    """
    hasher = _Hasher(takes_objects=True, looks_into_packages=False)
    hasher.feed(parts, "")
    return hasher.hexdigest()


def code_stamp(*folders: Path) -> str:
    """Return the digest of all Python files in some folders, which identifies the version of the code."""
    stamp = hashlib.sha256()
    for folder in folders:
        for path in sorted(folder.rglob("*.py")):
            stamp.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    return stamp.hexdigest()[:32]


def installed_versions(*names: str) -> dict[str, str]:
    """Return the versions of the distributions that are installed, without importing them."""
    from importlib import metadata

    found = {}
    for name in names:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


class _Hasher:
    def __init__(self, takes_objects: bool = False, looks_into_packages: bool = True) -> None:
        self._hash = hashlib.sha256()
        self._functions: list[FunctionType] = []
        self._takes_objects = takes_objects
        self._looks_into_packages = looks_into_packages
        self._objects: list[Any] = []
        self._classes: list[type] = []

    def hexdigest(self) -> str:
        return self._hash.hexdigest()[:32]

    def feed(self, value: Any, where: str) -> None:
        """Add a value, preceded by its type and length, so that different values never give the same bytes."""
        if isinstance(value, np.generic):
            self.feed(value.item(), where)
        elif value is None or isinstance(value, (bool, int, float, complex, str)):
            self._text(f"{type(value).__name__} {value!r}")
        elif isinstance(value, bytes):
            self._text(f"bytes {len(value)}")
            self._hash.update(value)
        elif isinstance(value, np.ndarray):
            self._array(value, where)
        elif sp.issparse(value):
            csr = sp.csr_matrix(value, copy=True)
            csr.sum_duplicates()
            self._text(f"sparse {csr.shape}")
            for part in (csr.data, csr.indices, csr.indptr):
                self._array(part, where)
        elif isinstance(value, Path):
            self._file(value)
        elif isinstance(value, Mapping):
            self._text(f"mapping {len(value)}")
            for key, item in value.items():
                self.feed(key, where)
                self.feed(item, f"{where}.{key}".lstrip("."))
        elif isinstance(value, (list, tuple, range)):
            self._text(f"sequence {len(value)}")
            for i, item in enumerate(value):
                self.feed(item, f"{where}[{i}]")
        elif isinstance(value, slice):
            self._text(f"slice {value.start} {value.stop} {value.step}")
        elif isinstance(value, (set, frozenset)):
            self.feed(sorted(digest(item=item) for item in value), where)
        elif dataclasses.is_dataclass(value) and not isinstance(value, type):
            self._class(type(value), where)
            for f in dataclasses.fields(value):
                if not f.compare:  # derived from the others, or provenance
                    continue
                self.feed(f.name, where)
                self.feed(getattr(value, f.name), f"{where}.{f.name}".lstrip("."))
        else:
            self._callable(value, where)

    def _text(self, text: str) -> None:
        self._hash.update(text.encode() + b"\0")

    def _array(self, array: np.ndarray, where: str) -> None:
        if array.dtype.hasobject:
            raise Unhashable(f"{where} is an array of objects")
        self._text(f"array {array.dtype.str} {array.shape}")
        self._hash.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data)

    def _file(self, path: Path) -> None:
        self._text(f"file {path.stat().st_size}")
        with path.open("rb") as file:
            while piece := file.read(PIECE):
                self._hash.update(piece)

    def _callable(self, value: Any, where: str) -> None:
        if isinstance(value, type):
            self._class(value, where)
        elif isinstance(value, np.ufunc):
            self._text(f"named {_name(value)}")
        elif isinstance(value, BuiltinFunctionType):
            self._text(f"named {value.__name__}")
            self.feed(value.__self__, where)  # its module, or the object of a method
        elif isinstance(value, ModuleType):
            self._text(f"module {value.__name__}")
        elif isinstance(value, partial):
            self.feed((value.func, value.args, dict(sorted(value.keywords.items()))), where)
        elif isinstance(value, MethodType):
            self.feed((value.__func__, value.__self__), where)
        elif isinstance(value, FunctionType):
            self._function(value, where)
        elif self._takes_objects and isinstance(getattr(value, "py_func", None), FunctionType):
            self._function(value.py_func, where)
        elif self._takes_objects and (attributes := _attributes(value)) is not None:
            self._object(value, attributes, where)
        else:
            raise Unhashable(f"{where} is an object of {_place(type(value))}, whose content cannot be identified")

    def _function(self, function: FunctionType, where: str) -> None:
        if function in self._functions:
            self._text(f"function {self._functions.index(function)} again")
            return
        self._functions.append(function)
        if not self._looks_into_packages and _is_installed(function):
            self._text(f"installed {_place(function)}")
            return
        where = f"{where} (the function {function.__name__})"
        self._code(function.__code__, where)
        self.feed(function.__defaults__, where)
        self.feed(function.__kwdefaults__, where)
        for cell in function.__closure__ or ():
            self.feed(cell.cell_contents, where)
        for name in sorted(_global_names(function.__code__)):
            if name in function.__globals__:
                self.feed(name, where)
                self._global(function.__globals__[name], _attribute_names(function.__code__), f"{where}: {name}")

    def _global(self, value: Any, asked: set[str], where: str) -> None:
        """Add a global value of a function; of a module of the user, also the attributes that the function may use."""
        self.feed(value, where)
        if isinstance(value, ModuleType) and not _is_of_a_package(value.__name__, getattr(value, "__file__", None)):
            for name in sorted(asked & set(vars(value))):
                self.feed(name, where)
                self._global(vars(value)[name], asked - {name}, f"{where}.{name}")

    def _class(self, cls: type, where: str) -> None:
        """Add a class by its name; one of the user also by its members."""
        self._text(f"class {_name(cls)}")
        if cls in self._classes or _is_of_a_package(cls.__module__, _file_of(cls.__module__)):
            return
        self._classes.append(cls)
        for name, member in sorted(vars(cls).items()):
            for part in _written(cls, name, member):
                self.feed(name, where)
                self.feed(part, f"{where}: {cls.__name__}.{name}")
        for base in cls.__bases__:
            self._class(base, where)

    def _object(self, value: Any, attributes: dict[str, Any], where: str) -> None:
        known = next((i for i, other in enumerate(self._objects) if other is value), None)
        self._text("object" if known is None else f"object {known} again")
        if known is None:
            self._objects.append(value)
            self._class(type(value), where)
            self.feed(attributes, where)

    def _code(self, code: CodeType, where: str) -> None:
        self._text(f"code {code.co_name}")
        self.feed(code.co_code, where)
        self.feed((code.co_names, code.co_varnames, code.co_freevars), where)
        for constant in code.co_consts:
            if isinstance(constant, CodeType):
                self._code(constant, where)
            else:
                self.feed(None if constant is Ellipsis else constant, where)


def _is_installed(function: FunctionType) -> bool:
    """Return whether a function is of a package that was installed, of Python itself, or of this one."""
    return _is_of_a_package(function.__module__ or "", function.__code__.co_filename)


@cache
def _is_of_a_package(module: str, file: str | None) -> bool:
    """Return whether a module is of a package that was installed, of Python itself, or of this one."""
    if module.partition(".")[0] in OWN:
        return True
    if file is None:  # built in, or of an interactive session
        return module in sys.builtin_module_names
    path = Path(file)
    return bool({"site-packages", "dist-packages"} & set(path.parts)) or path.is_relative_to(get_path("stdlib"))


def _file_of(module: str) -> str | None:
    return getattr(sys.modules.get(module), "__file__", None)


def _written(cls: type, name: str, member: Any) -> list[Any]:
    """Return functions and plain values of a member of a class, without those that Python generates."""
    if isinstance(member, (staticmethod, classmethod)):
        member = member.__func__
    if isinstance(member, property):
        return [part for part in (member.fget, member.fset, member.fdel) if part is not None]
    if isinstance(member, cached_property):
        member = member.func
    if isinstance(member, FunctionType):
        is_from_fields = name in MADE and member.__code__.co_filename == "<string>"
        is_made = dataclasses.is_dataclass(cls) and (is_from_fields or member.__module__ == dataclasses.__name__)
        return [] if is_made else [member]
    is_plain = isinstance(member, (bool, int, float, complex, bytes, str, tuple, np.ndarray)) and name[:2] != "__"
    return [member] if is_plain else []


def _global_names(code: CodeType) -> set[str]:
    """Return the names of the globals that a function and its inner functions use."""
    names = {step.argval for step in dis.get_instructions(code) if step.opname in ("LOAD_GLOBAL", "LOAD_NAME")}
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names |= _global_names(constant)
    return names


def _attribute_names(code: CodeType) -> set[str]:
    """Return the names of the attributes that a function and its inner functions use."""
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names |= _attribute_names(constant)
    return names


def _attributes(value: Any) -> dict[str, Any] | None:
    """Return the attributes of an object; None if its content is elsewhere."""
    listed = (getattr(kind, "__slots__", ()) for kind in type(value).__mro__)
    slots = [name for names in listed for name in ((names,) if isinstance(names, str) else names)]
    found = {name: getattr(value, name) for name in slots if name[:2] != "__" and hasattr(value, name)}
    found |= getattr(value, "__dict__", {})
    return found or ({} if type(value).__module__ != "builtins" and hasattr(value, "__dict__") else None)


def _name(thing: Any) -> str:
    """Return the name of a class in a digest; a class of this package keeps it when it moves to another file."""
    package = (getattr(thing, "__module__", None) or "").partition(".")[0]
    if package not in OWN or not isinstance(thing, type):
        return _place(thing)
    return f"{package}: {word_of(thing) or thing.__qualname__}"


def _place(thing: Any) -> str:
    return f"{getattr(thing, '__module__', None)}.{getattr(thing, '__qualname__', thing.__name__)}"
