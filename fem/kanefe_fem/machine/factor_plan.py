"""How a large matrix is factored, with time and memory told before: its factors in memory, or on the disk."""

from __future__ import annotations

import os
import shutil
import tempfile
import warnings
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from kanefe.errors import FileError, outside
from kanefe.fe_model.progress import tell
from kanefe.storage.files import cache_folder, make_folder
from kanefe_fem.machine.memory import SHARE, MemoryWarning


class Analysis(NamedTuple):
    """What a solver says of a factorisation before it begins.

    Attributes
    ----------
    unknowns : int
    operations : float
        Of floating-point numbers.
    in_memory : float
        Memory that it takes, bytes.
    beside_disk : float
        Memory that it takes with the factors on the disk, bytes.
    factors : float
        Size of the factors, bytes.
    """

    unknowns: int
    operations: float
    in_memory: float
    beside_disk: float
    factors: float


class FactorPlan(NamedTuple):
    """The way that was chosen.

    Attributes
    ----------
    analysis : Analysis
    folder : Path or None
        Of the factors on the disk; None: in memory.
    seconds : float
        Time at the rate of a small piece of the matrix: larger ones are faster.
    """

    analysis: Analysis
    folder: Path | None
    seconds: float

    def __str__(self) -> str:
        known = self.analysis
        needed, where = known.in_memory, "of memory"
        if self.folder is not None:
            needed, where = known.beside_disk, f"of memory and {1e-9 * known.factors:.2g} GB on the disk"
        return f"{known.unknowns} unknowns: {1e-9 * needed:.2g} GB {where}, at most about {self.seconds:.2g} s"


def planned(analysis: Analysis, free: float | None, rate: float) -> FactorPlan:
    """Choose where the factors go, and tell it.

    Parameters
    ----------
    analysis : Analysis
    free : float or None
        Free memory in bytes, if it is known.
    rate : float
        Operations per second of a small piece.

    Warns
    -----
    MemoryWarning
        If the factors go to the disk, or if there is not enough room there either; then the memory is tried.
    """
    seconds = analysis.operations / rate
    if free is None or analysis.in_memory <= SHARE * free:
        plan = FactorPlan(analysis, None, seconds)
        tell(str(plan))
        return plan
    needed = (
        f"factoring the stiffness of {analysis.unknowns} unknowns needs {1e-9 * analysis.in_memory:.3g} GB of memory, "
        f"and {1e-9 * free:.3g} GB are free"
    )
    remedy = (
        "Remedy: a coarser mesh where stresses do not matter, order=1 there, a substructure for each part, or a larger "
        "machine"
    )
    disk = _free_disk()
    if analysis.beside_disk <= SHARE * free and analysis.factors <= SHARE * disk:
        plan = FactorPlan(analysis, factors_folder(), seconds)
        text = f"{needed}: its factors go to the disk ({plan}; {plan.folder}), and solutions take longer. {remedy}"
    else:
        plan = FactorPlan(analysis, None, seconds)
        text = (
            f"{needed}; with its factors on the disk {1e-9 * analysis.beside_disk:.3g} GB of memory and "
            f"{1e-9 * analysis.factors:.3g} GB of {1e-9 * disk:.3g} GB there: the machine may become very slow, or end "
            f"the process. {remedy}"
        )
    tell(str(plan))
    warnings.warn(text, MemoryWarning, stacklevel=outside())
    return plan


def _all_factors() -> Path:
    return cache_folder() / "factors"


def _free_disk() -> float:
    """Return the free space of the disk of the cache in bytes; 0 where nothing can be written."""
    try:
        make_folder(_all_factors(), is_own=True)
        return float(shutil.disk_usage(_all_factors()).free)
    except (OSError, FileError):
        return 0.0


def factors_folder() -> Path:
    """Return a new folder for factors of this process, and remove those of processes that were killed."""
    for left in _all_factors().iterdir():
        if not _is_alive(left.name.partition("-")[0]):
            shutil.rmtree(left, ignore_errors=True)
    return Path(tempfile.mkdtemp(prefix=f"{os.getpid()}-", dir=_all_factors()))


def _is_alive(process: str) -> bool:
    """Return whether a process with this number exists; True of what is no number."""
    with suppress(ValueError, PermissionError):
        try:
            os.kill(int(process), 0)
        except ProcessLookupError:
            return False
    return True
