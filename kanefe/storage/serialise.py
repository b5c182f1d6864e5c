"""Conversion of frozen dataclasses to a text and arrays for files, and back.

A class is written field by field, so that a new field needs no change here. The fields in a file must be those of the
class: a file of another version is refused, never misread.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from kanefe.storage.saved_classes import class_of, word_of
from kanefe.storage.scipy_later import sp

NOT_SAVED = {"saved": False}
"""Metadata of a field that a file leaves out, ``field(metadata=NOT_SAVED)``; the field must have a default."""

SHARED = 1 << 16
"""Size above which equal arrays are written only once, bytes."""

_TAG = "is"


class OtherVersion(ValueError):
    """The fields in the file are not those of the class."""


def encoded(value: Any) -> tuple[str, dict[str, np.ndarray]]:
    """Return the text and the arrays of a value.

    Parameters
    ----------
    value : object
        Made of dataclasses that have a name in `kanefe.storage.saved_classes`, arrays, sparse matrices, tuples, lists,
        mappings with names, texts and numbers.

    Raises
    ------
    TypeError
        If a part is none of these; the message names it.

    Examples
    --------
    >>> decoded(*encoded({"a": (1, 2.5), "b": [None, "text"]}))
    {'a': (1, 2.5), 'b': [None, 'text']}
    """
    arrays: dict[str, np.ndarray] = {}
    return json.dumps(_encode(value, "", arrays)), arrays


def decoded(text: str, arrays: Mapping[str, np.ndarray]) -> Any:
    """Return the value of a text and arrays that `encoded` returned.

    Raises
    ------
    OtherVersion
        If a class has other fields now.
    ValueError, KeyError, TypeError, AttributeError, ImportError
        If the text is damaged.
    """
    return _decode(json.loads(text), arrays)


def _encode(value: Any, path: str, arrays: dict[str, np.ndarray]) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, np.ndarray):
        return {_TAG: "array", "name": _stored(value, path, arrays)}
    if sp.issparse(value):
        csr = sp.csr_matrix(value)
        parts = {name: _stored(getattr(csr, name), f"{path}.{name}", arrays) for name in ("data", "indices", "indptr")}
        return {_TAG: "csr", "shape": list(csr.shape), **parts}
    if isinstance(value, (tuple, list)):
        items = [_encode(item, f"{path}[{i}]", arrays) for i, item in enumerate(value)]
        return {_TAG: "tuple", "items": items} if isinstance(value, tuple) else items
    if isinstance(value, Mapping):
        strange = [key for key in value if not isinstance(key, str)]
        if strange:
            raise TypeError(f"{path or 'the value'} has the key {strange[0]!r}, which is not a name")
        return {_TAG: "dict", "items": {k: _encode(v, f"{path}.{k}", arrays) for k, v in value.items()}}
    if is_dataclass(value) and not isinstance(value, type):
        kind = type(value)
        word = word_of(kind)
        if word is None:
            where = path.lstrip(".") or "the value"
            raise TypeError(f"{where} is a {kind.__name__}, which has no word in kanefe.storage.saved_classes")
        parts = {name: _encode(getattr(value, name), f"{path}.{name}".lstrip("."), arrays) for name in _saved(kind)}
        return {_TAG: "object", "class": word, "fields": parts}
    raise TypeError(f"{path or 'the value'} is a {type(value).__name__}, which cannot be saved")


def _decode(item: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    if isinstance(item, list):
        return [_decode(part, arrays) for part in item]
    if not isinstance(item, dict):
        return item
    kind = item[_TAG]
    if kind == "array":
        return arrays[item["name"]]
    if kind == "csr":
        return sp.csr_matrix((arrays[item["data"]], arrays[item["indices"]], arrays[item["indptr"]]), item["shape"])
    if kind == "tuple":
        return tuple(_decode(part, arrays) for part in item["items"])
    if kind == "dict":
        return {name: _decode(part, arrays) for name, part in item["items"].items()}
    cls = class_of(item["class"])
    if set(item["fields"]) != set(_saved(cls)):
        raise OtherVersion(f"{cls.__name__} has other fields in this version")
    return cls(**{name: _decode(part, arrays) for name, part in item["fields"].items()})


def _saved(cls: Any) -> list[str]:
    """Return the names of the fields that are written."""
    return [f.name for f in fields(cls) if f.init and f.metadata.get("saved", True)]


def _stored(array: np.ndarray, path: str, arrays: dict[str, np.ndarray]) -> str:
    """Add an array to those to be written, unless an equal one is among them; return its name."""
    if array.nbytes >= SHARED:
        for name, other in arrays.items():
            if _is_same(array, other):
                return name
    arrays[path or "value"] = array
    return path or "value"


def _is_same(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether two arrays are equal bit for bit, with the same order in memory."""
    if a.shape != b.shape or a.dtype != b.dtype or a.strides != b.strides:
        return False
    if a.__array_interface__["data"] == b.__array_interface__["data"]:
        return True
    if not (a.flags.forc and b.flags.forc):
        return False
    return bool(np.array_equal(a.ravel(order="K").view(np.uint8), b.ravel(order="K").view(np.uint8)))
