"""The door to wavespectra: spectra over directions from files of wave models and buoys."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import FileError, MissingDependency, ModelError
from kanefe.frames import Matrix, Vector
from kanefe.storage.files import regular_file

READERS = {".nc": "read_netcdf", ".spc": "read_swan", ".spec": "read_swan", ".swn": "read_swan"}
"""Functions of wavespectra that read files, by suffix."""


def frequencies_densities_directions(spectrum: Any) -> tuple[Vector, Matrix, Vector]:
    """Return frequencies (rad/s), densities (m2 s/(rad degree)) and compass directions of a data set or file."""
    if isinstance(spectrum, (str, Path)):
        spectrum = _read(Path(spectrum))
    table = getattr(spectrum, "efth", spectrum)
    dims = tuple(getattr(table, "dims", ()))
    more = {d: table.sizes[d] for d in dims if d not in ("freq", "dir") and table.sizes[d] > 1}
    if not {"freq", "dir"} <= set(dims) or more:
        raise ModelError(
            f"a spectrum of wavespectra has efth over freq and dir, for one place and time; this one has {dims}. "
            f"Remedy: choose {', '.join(more) or 'another'}, such as spectrum.isel(time=0)"
        )
    table = table.squeeze().transpose("freq", "dir")
    hertz = np.asarray(table["freq"], dtype=float)
    density = np.asarray(table, dtype=float) / (2.0 * np.pi)
    return 2.0 * np.pi * hertz, density, np.asarray(table["dir"], dtype=float)


def _read(path: Path) -> Any:
    path = regular_file(path, "for the spectrum of waves")
    if path.suffix not in READERS:
        raise FileError(
            f"{path}: files of spectra end in {', '.join(READERS)}. Remedy: pass the data set that wavespectra reads"
        )
    try:
        import wavespectra
    except ImportError as problem:
        raise MissingDependency(
            "wavespectra", "Sea.from_wavespectra of a file", "pip install 'kanefe[sea]'"
        ) from problem
    try:
        return getattr(wavespectra, READERS[path.suffix])(str(path))
    except (OSError, ValueError, KeyError, AttributeError, RuntimeError) as error:
        raise FileError(f"cannot read the spectrum of waves from {path}: {error}") from error
