"""The door to xarray: arrays with names, and netCDF files, read by h5netcdf on the same HDF5 as everything else."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from kanefe.errors import FileError, MissingDependency, ModelError
from kanefe.storage.files import regular_file


def data_set_of(arrays: Mapping[str, Any], coordinates: Mapping[str, Any], about: Mapping[str, str]) -> Any:
    """Return a data set of arrays, each as xarray takes them: dimensions, values and, if any, attributes.

    Names that netCDF or zarr do not take are changed; the name itself is then the attribute "long_name".

    Raises
    ------
    ModelError
        If two names are written alike.
    MissingDependency
        If xarray is not installed.
    """
    try:
        import xarray
    except ImportError as problem:
        raise MissingDependency("xarray", "arrays with names", "pip install 'kanefe[sea]'") from problem
    found = xarray.Dataset(dict(arrays), dict(coordinates), dict(about))
    written: dict[str, str] = {}
    for name in map(str, found.variables):
        if (other := written.setdefault(_portable(name), name)) != name:
            raise ModelError(
                f"{other!r} and {name!r} have the same name in netCDF, {_portable(name)!r}. Remedy: other names"
            )
    changed = {name: new for new, name in written.items() if new != name}
    for name in changed:
        found[name].attrs["long_name"] = name
    return found.rename(changed)


def _portable(name: str) -> str:
    """Return a name as netCDF and zarr take it: a "/" would be a folder there, and signs may not begin it."""
    found = re.sub(r"[\x00-\x1f\x7f]", "_", name.replace("/", ".")).rstrip()
    return found if re.match(r"(?!__)[\w]", found) else f"v{found}"


def open_dataset(path: Path) -> Any:
    """Return the data set of a netCDF-4 file, loaded into memory.

    Raises
    ------
    FileError
        If the file does not exist, or is not netCDF-4.
    MissingDependency
        If xarray or h5netcdf is not installed.
    """
    path = regular_file(path, "of motions in waves")
    try:
        import h5netcdf  # noqa: F401
        import xarray
    except ImportError as problem:
        raise MissingDependency("xarray with h5netcdf", "reading netCDF", "pip install 'kanefe[sea]'") from problem
    try:
        with xarray.open_dataset(path, engine="h5netcdf") as found:
            return found.load()
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        raise FileError(f"{path} is truncated or not a netCDF-4 file ({error}). Remedy: export it again") from error
