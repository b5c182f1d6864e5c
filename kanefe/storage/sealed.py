"""Lines of JSON that end with their checksum."""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Mapping
from typing import Any

SEAL = "crc"
"""Last key of a sealed mapping."""

_SEALED = re.compile(rb'(\{.*), "crc": "([0-9a-f]{8})"\}', re.DOTALL)


def sealed(content: Mapping[str, Any]) -> str:
    """Return a mapping as JSON, with its checksum as last item.

    Examples
    --------
    >>> sealed({"a": 1.5})
    '{"a": 1.5, "crc": "7bb78250"}'
    >>> unsealed(b'{"a": 1.5, "crc": "7bb78250"}')
    {'a': 1.5}
    """
    text = json.dumps(content)[:-1]
    return f'{text}, "{SEAL}": "{zlib.crc32(text.encode()):08x}"}}'


def unsealed(text: bytes) -> dict[str, Any]:
    """Return the mapping of a text that `sealed` returned.

    Raises
    ------
    ValueError
        If the text is of another form, or was changed.
    """
    found = _SEALED.fullmatch(text.strip())
    if found is None:
        raise ValueError("it does not end with a checksum")
    if zlib.crc32(found[1]) != int(found[2], 16):
        raise ValueError("its checksum is wrong")
    content: dict[str, Any] = json.loads(text)
    del content[SEAL]
    return content
