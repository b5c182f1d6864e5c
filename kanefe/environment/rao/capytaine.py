"""Motions of Capytaine: data sets with ``RAO``, and their netCDF files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.environment.rao.rao import NAMES, MotionRao
from kanefe.environment.rao.rao_convention import RaoConvention
from kanefe.environment.rao.rao_grid import Rows, warn_left_out
from kanefe.errors import FileError, ModelError

MOTIONS = "radiating_dof"


def read_netcdf(path: Path, symmetric: bool | None = None) -> MotionRao:
    """Return the RAO of a file; see `read_capytaine`."""
    from kanefe.storage._xarray import open_dataset

    return read_capytaine(open_dataset(path), symmetric, path)


def read_capytaine(
    dataset: Any, symmetric: bool | None = None, path: Path = Path("data set of Capytaine")
) -> MotionRao:
    """Return the RAO of a data set to which ``dataset["RAO"] = capytaine.post_pro.rao(dataset)`` was added.

    Motions are the real parts of ``exp(-i omega t)``; wave directions in rad are those to which waves propagate, from
    x, which points forward, to port; rotations in rad/m about the body's centre of rotation. In files, the real and
    imaginary parts are an axis ``complex``.

    Raises
    ------
    FileError
        If there is no RAO, or its motions are not six of one body.
    ModelError
        If there is more than one depth of water.
    """
    table = _table(dataset, path)
    omega = np.atleast_1d(table["omega"].values).astype(float)
    speeds, headings = (np.atleast_1d(table[d].values).astype(float) for d in ("forward_speed", "wave_direction"))
    finite = np.isfinite(omega) & (omega > 0.0)
    grid = np.meshgrid(speeds, np.degrees(headings), omega[finite], indexing="ij")
    values = np.asarray(table.values, dtype=complex)[:, :, finite].reshape(-1, 6)
    depth = float(np.max(dataset["water_depth"].values)) if "water_depth" in dataset.variables else math.inf
    centre = "body's centre of rotation in Capytaine"
    convention = RaoConvention("exp(-iwt)", "following", "starboard", "forward", "port", "up", "rad/m", centre)
    rows = Rows(grid[0].ravel(), grid[1].ravel(), grid[2].ravel(), values)
    return rows.rao(path, convention, depth=depth, symmetric=symmetric)


def _table(dataset: Any, path: Path) -> Any:
    """Return the RAO over forward speed, wave direction, frequency and the six motions in their order."""
    if "RAO" not in getattr(dataset, "variables", {}):
        raise FileError(
            f'{path} has no RAO. Remedy: dataset["RAO"] = capytaine.post_pro.rao(dataset), before it is exported'
        )
    table = dataset["RAO"]
    if "complex" in table.dims:
        table = table.sel(complex="re") + 1j * table.sel(complex="im")
    dofs = {str(name).split("__")[-1].lower(): name for name in np.atleast_1d(table[MOTIONS].values)}
    missing = [name for name in NAMES if name not in dofs]
    if missing or len(dofs) != table[MOTIONS].size:
        raise FileError(
            f"{path}: motions {', '.join(missing) or 'of one body'} are missing. Remedy: one body with "
            "add_all_rigid_body_dofs()"
        )
    if more := [name for name in dofs if name not in NAMES]:
        warn_left_out(path, f"motions {', '.join(more)}, generalised modes")
    along = next(iter(table["omega"].dims), "omega")
    known = (along, "wave_direction", MOTIONS, "forward_speed")
    many = [d for d in table.dims if d not in known and table.sizes[d] > 1]
    if many:
        raise ModelError(
            f"{path} has several {', '.join(many)}. Remedy: choose one, such as by dataset.isel({many[0]}=0)"
        )
    table = table.squeeze([d for d in table.dims if d not in known])
    for name in ("wave_direction", "forward_speed", along):
        if name not in table.dims and name in table.coords:
            table = table.expand_dims(name)
        elif name not in table.dims:
            table = table.expand_dims({name: [0.0]})
    order = [dofs[name] for name in NAMES]
    return table.transpose("forward_speed", "wave_direction", along, MOTIONS).sel({MOTIONS: order})
