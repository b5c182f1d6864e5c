"""Machine code of kernels for processes without Python."""

from __future__ import annotations

import struct

from kanefe.errors import ModelError

HEADER, SECTION, SYMBOL = struct.Struct("<16sHHIQQQIHHHHHH"), struct.Struct("<IIQQQQIIQQ"), struct.Struct("<IBBHQQ")
DYNAMIC_SYMBOLS = 11
WEAK = 2


def without_python(library: bytes, name: str) -> bytes:
    """Return a library (ELF, 64 bit) that can be loaded without Python's functions.

    Kernels refer to functions of Python only for the report of unexpected errors; these references are made weak, so
    that the functions may be missing. Errors of kernels themselves are returned as numbers.

    Raises
    ------
    ModelError
        If the file is not such a library.
    """
    made = bytearray(library)
    try:
        if made[:6] != b"\x7fELF\x02\x01":
            raise ValueError
        fields = HEADER.unpack_from(made)
        first, size, count = fields[6], fields[11], fields[12]
        sections = [SECTION.unpack_from(made, first + i * size) for i in range(count)]
        symbols = next(section for section in sections if section[1] == DYNAMIC_SYMBOLS)
        names = sections[symbols[6]][4]
        for at in range(symbols[4], symbols[4] + symbols[5], SYMBOL.size):
            title, info, other, section, value, length = SYMBOL.unpack_from(made, at)
            start = names + title
            if section == 0 and made[start : start + 2] == b"Py":
                SYMBOL.pack_into(made, at, title, WEAK << 4 | info & 15, other, section, value, length)
    except (ValueError, StopIteration, struct.error, IndexError) as error:
        raise ModelError(f"the kernel {name} is not a 64-bit ELF library. Remedy: kanefe prepare") from error
    return bytes(made)
