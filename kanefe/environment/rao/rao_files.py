"""Motions in waves from files: VERES, WAMIT, Capytaine, and tables of text."""

from __future__ import annotations

from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.environment.rao.rao import MotionRao
from kanefe.environment.rao.rao_checks import check_long_waves
from kanefe.environment.rao.rao_table import read_table
from kanefe.environment.rao.veres import read_veres
from kanefe.environment.rao.wamit import read_wamit
from kanefe.errors import FileError, ModelError
from kanefe.frames import numbers

READERS = {
    ".re1": (read_veres, ()),
    ".4": (read_wamit, ("length", "depth", "reference")),
    ".csv": (read_table, ("convention",)),
    ".txt": (read_table, ("convention",)),
}
"""Reader, with its required and optional arguments, by suffix."""


@checked("symmetric")
def read_rao(
    path: Any, *, wave_at: tuple[float, float] = (0.0, 0.0), symmetric: bool | None = None, **said: Any
) -> MotionRao:
    """Return the motions of a ship in waves of a file, in the convention of the house, checked.

    VERES (ShipX) ``.re1`` and Capytaine ``.nc`` say what they mean. Of WAMIT's ``.4`` the length that made it free of
    dimensions is asked for; a table of text (``.csv``, ``.txt``) declares its convention in its head or here. In its
    longest waves a ship must follow their surface: what does not is refused, with the cause that fits.

    Parameters
    ----------
    path : str or Path, or xarray.Dataset
        The data set is of Capytaine, with ``RAO`` in it.
    wave_at : (float, float)
        Where the phase of the wave is told, m forward and to port of the reference point: WAMIT and Capytaine tell it
        at the origin of the mesh.
    symmetric : bool, optional
        Whether the ship is its own mirror image, so that headings of one side serve the other. None: as the file's head
        and following seas tell.
    length : float
        ULEN of WAMIT, m.
    depth : float
        Of the water, m, where the file (WAMIT) does not say it. Infinite if left out.
    reference : str
        Of WAMIT: which point the axes of the body are in.
    convention : RaoConvention or dict, optional
        Of a table of text.

    Returns
    -------
    MotionRao

    Raises
    ------
    FileError
        If the file is not there, truncated or of another format.
    ModelError
        If a convention is not declared, or the motions in long waves contradict it.
    MissingDependency
        If xarray is needed and not installed.

    Examples
    --------
    ``rao = kanefe.read_rao("s175.re1")``, ``kanefe.read_rao("tanker.4", length=1.0, wave_at=(-3.2, 0.0))``
    """
    forward, port = _two(wave_at)
    if not isinstance(path, (str, Path)):
        from kanefe.environment.rao.capytaine import read_capytaine

        _refuse(said, (), "a data set of Capytaine")
        found = read_capytaine(path, symmetric)
    elif Path(path).suffix.lower() in (".nc", ".nc4", ".netcdf"):
        from kanefe.environment.rao.capytaine import read_netcdf

        _refuse(said, (), Path(path).name)
        found = read_netcdf(Path(path), symmetric)
    else:
        suffix = Path(path).suffix.lower()
        if suffix not in READERS:
            raise FileError(
                f"{path}: files of motions in waves end in .nc, {', '.join(READERS)}. Remedy: a table of text (.csv) "
                "with its convention declared"
            )
        reader, options = READERS[suffix]
        _refuse(said, options, Path(path).name)
        found = reader(Path(path), symmetric=symmetric, **said)
    if forward or port:
        found = found.with_wave_at(forward, port)
    check_long_waves(found)
    return found


def example_rao() -> MotionRao:
    """Return the motions in waves of a frigate-sized hull at rest, to try things with.

    A modified Wigley hull of 110 x 15 x 4.5 m, computed with Capytaine; its roll is largest at 0.56 rad/s and damped by
    8 %. The file says the rest: ``kanefe/environment/data/frigate.csv``, which is also an example of a table that
    declares its convention.

    Examples
    --------
    >>> import kanefe as kf
    >>> ship = kf.Ship(kf.example_rao(), kf.Sea.state(5, seed=1), heading_deg=60)
    >>> round(ship.motions_std()["heave"], 2)
    0.59
    """
    with as_file(files("kanefe.environment").joinpath("data", "frigate.csv")) as path:
        return read_rao(path)


def _refuse(said: dict[str, Any], known: tuple[str, ...], what: str) -> None:
    unknown = [name for name in said if name not in known]
    if unknown:
        takes = f"takes {', '.join(known)}" if known else "states its convention itself"
        raise ModelError(f"{', '.join(unknown)} cannot be given for {what}, which {takes}. Remedy: leave it out")


def _two(point: tuple[float, float]) -> tuple[float, float]:
    given = numbers(point)
    if given.shape != (2,) or not np.all(np.isfinite(given)):
        raise ModelError(f"wave_at must be two numbers, m forward and to port, not {point!r}")
    return float(given[0]), float(given[1])
