"""Lines of json that end with a checksum of themselves."""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Mapping
from typing import Any

SEAL = "crc"
"""Last name of a sealed mapping."""

_SEALED = re.compile(rb'(\{.*), "crc": "([0-9a-f]{8})"\}', re.DOTALL)


def sealed(content: Mapping[str, Any]) -> str:
    """Return a mapping as json, with a checksum as its last item.

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
    """Return the mapping that `sealed` gave this text for.

    Raises
    ------
    ValueError
        If the text is another one, or has changed since.
    """
    found = _SEALED.fullmatch(text.strip())
    if found is None:
        raise ValueError("it does not end with a checksum")
    if zlib.crc32(found[1]) != int(found[2], 16):
        raise ValueError("its checksum is wrong")
    content: dict[str, Any] = json.loads(text)
    del content[SEAL]
    return content
