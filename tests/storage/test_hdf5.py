"""Small files are written as they are; arrays of large ones are compressed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kanefe.storage import hdf5
from kanefe.storage.hdf5 import SMALL_FILE, SMALLEST_COMPRESSED, WHOLE_CHUNK, decode, encode


@pytest.mark.parametrize("is_large", [False, True])
def test_arrays_are_compressed_where_the_file_is_large(tmp_path: Path, is_large: bool) -> None:
    h5py = pytest.importorskip("h5py")
    columns = 3 * (SMALL_FILE // (8 * 3) + 1) if is_large else 3 * SMALLEST_COMPRESSED
    arrays = {"long": np.zeros((columns // 3, 3)), "short": np.arange(12.0), "one": np.array(2.0), "none": np.zeros(0)}
    path = tmp_path / "arrays.h5"
    path.write_bytes(encode({"format": "test"}, {name: (array, "m") for name, array in arrays.items()}))
    with h5py.File(path, "r") as file:
        assert file["long"].compression == ("gzip" if is_large else None)
        assert file["short"].compression is None
        assert file["short"].chunks == (12,)
        assert (file["long"].chunks == arrays["long"].shape) == (arrays["long"].nbytes <= WHOLE_CHUNK)
        assert all(file[name].fletcher32 for name in ("long", "short"))
    header, found = decode(path)
    assert header["format"] == "test"
    for name, array in arrays.items():
        np.testing.assert_array_equal(found[name], array)


def test_a_bar_of_what_is_read_knows_the_number_of_arrays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("h5py")
    path, told = tmp_path / "arrays.h5", []
    arrays = {name: (np.arange(3.0), "m") for name in ("one", "bodies/arm/nodes", "bodies/arm/basis")}
    path.write_bytes(encode({"format": "test"}, arrays))

    def bar(what: str, parts: Iterable[Any], count: int | None) -> Iterable[Any]:
        told.append(count)
        return parts

    monkeypatch.setattr(hdf5, "is_watched", lambda: True)
    monkeypatch.setattr(hdf5, "long_work", bar)
    _, found = decode(path)
    assert told == [len(found)] == [len(arrays)]
