"""Motions in waves from files: VERES, WAMIT, Capytaine, and tables of text."""

from __future__ import annotations

from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

from kanefe.arguments import checked
from kanefe.environment.rao.rao import MotionRao
from kanefe.environment.rao.rao_checks import check_long_waves
from kanefe.environment.rao.rao_table import read_table
from kanefe.environment.rao.veres import read_veres
from kanefe.environment.rao.wamit import read_wamit
from kanefe.errors import FileError, ModelError
from kanefe.frames import shaped_numbers

READERS = {
    ".re1": (read_veres, ()),
    ".4": (read_wamit, ("length", "depth", "reference")),
    ".csv": (read_table, ("convention",)),
    ".txt": (read_table, ("convention",)),
}
"""Reader, with its required and optional arguments, by suffix."""


@checked("symmetric")
def read_rao(
    path: Any, *, wave_at: tuple[float, float] = (0.0, 0.0), symmetric: bool | None = None, **options: Any
) -> MotionRao:
    """Return the motions of a ship in waves from a file, converted to the convention of kanefe and checked.

    The conventions of VERES (ShipX) ``.re1`` and Capytaine ``.nc`` are known. WAMIT's ``.4`` needs the length that made
    it dimensionless; a table of text (``.csv``, ``.txt``) declares its convention in its header or here. In its longest
    waves a ship must follow the surface: other motions are refused with their likely cause.

    Parameters
    ----------
    path : str or Path, or xarray.Dataset
        A data set is one of Capytaine that contains ``RAO``.
    wave_at : (float, float)
        Point at which the phase of the wave is given, m forward and to port of the reference point; for WAMIT and
        Capytaine it is the origin of the mesh.
    symmetric : bool, optional
        Whether the ship is symmetric, so that headings of one side serve for the other. None: judged by the motions in
        head and following seas.
    length : float
        ULEN of WAMIT, m.
    depth : float
        Depth of the water, m, if the file (WAMIT) does not contain it; default: infinite.
    reference : str
        For WAMIT: the origin of the body axes.
    convention : RaoConvention or dict, optional
        For a table of text.

    Returns
    -------
    MotionRao

    Raises
    ------
    FileError
        If the file does not exist, is truncated or of another format.
    ModelError
        If a convention is not declared, or the motions in long waves contradict it.
    MissingDependency
        If xarray is needed and not installed.

    Examples
    --------
    ``rao = kanefe.read_rao("s175.re1")``, ``kanefe.read_rao("tanker.4", length=1.0, wave_at=(-3.2, 0.0))``
    """
    forward, port = shaped_numbers(wave_at, (2,), "wave_at (m forward and to port)").tolist()
    if not isinstance(path, (str, Path)):
        from kanefe.environment.rao.capytaine import read_capytaine

        _refuse(options, (), "a data set of Capytaine")
        found = read_capytaine(path, symmetric)
    elif Path(path).suffix.lower() in (".nc", ".nc4", ".netcdf"):
        from kanefe.environment.rao.capytaine import read_netcdf

        _refuse(options, (), Path(path).name)
        found = read_netcdf(Path(path), symmetric)
    else:
        suffix = Path(path).suffix.lower()
        if suffix not in READERS:
            raise FileError(
                f"{path}: files of motions in waves end in .nc, {', '.join(READERS)}. Remedy: a table of text (.csv) "
                "with its convention declared"
            )
        reader, known = READERS[suffix]
        _refuse(options, known, Path(path).name)
        found = reader(Path(path), symmetric=symmetric, **options)
    if forward or port:
        found = found.with_wave_at(forward, port)
    check_long_waves(found)
    return found


def example_rao() -> MotionRao:
    """Return the motions in waves of a frigate-sized hull without speed, for examples.

    A modified Wigley hull of 110 x 15 x 4.5 m, computed with Capytaine; its roll is largest at 0.56 rad/s and damped by
    8 %. The header of the file, ``kanefe/environment/data/frigate.csv``, has the details; the file is also an example
    of a table that declares its convention.

    Examples
    --------
    >>> import kanefe as kf
    >>> ship = kf.Ship(kf.example_rao(), kf.Sea.state(5, seed=1), heading_deg=60)
    >>> round(ship.motions_std()["heave"], 2)
    0.59
    """
    with as_file(files("kanefe.environment").joinpath("data", "frigate.csv")) as path:
        return read_rao(path)


def _refuse(options: dict[str, Any], known: tuple[str, ...], what: str) -> None:
    unknown = [name for name in options if name not in known]
    if unknown:
        takes = f"takes {', '.join(known)}" if known else "states its convention itself"
        raise ModelError(f"{', '.join(unknown)} cannot be given for {what}, which {takes}. Remedy: leave it out")
