"""StudyTable: the results of a study, one row per case."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.studies.cases import Cases, key_of, plain
from kanefe.studies.store import Store

if TYPE_CHECKING:
    from kanefe.result import Result
    from kanefe.studies.statistics.operability import Operability

ENDS = ("finished", "stopped", "failed")
"""Status of a case. A stopped case was ended by a terminal event or a limit, and has outputs up to that time."""

MEASURED = ("wall", "cpu", "worker")
"""Columns that depend on the machine; all others are identical to the bit wherever the study runs."""


class RunsCases(Protocol):
    """What a table requires of its `kanefe.Study`."""

    def result(self, parameters: Mapping[str, Any]) -> Result:
        """Run the case of some parameters, and return its full result."""
        ...


@checked("store")
class StudyTable:
    """Results of a study: one row per case, in the order of the cases, read from its store on request.

    Columns are the parameters, the outputs, and: status ("finished", "stopped" or "failed"), reason, simulated
    (end time of the results, s), warnings, wall and cpu (of the case, s), worker, key. A failed case has no
    outputs.

    Parameters
    ----------
    store : path
        Folder of the study; it may still be running.
    study : Study, optional
        Needed to run a case again; a table from ``study.table(store)`` has it.

    Raises
    ------
    FileError
        If the folder contains no study.

    Examples
    --------
    >>> table = kf.StudyTable("study/")                                 # doctest: +SKIP
    >>> print(table)                                                    # doctest: +SKIP
    350 cases, 348 finished, 2 failed; parameters: heading_deg, sea_state, seed; outputs: tension, slip
    """

    def __init__(self, store: str | Path, *, study: RunsCases | None = None, owns: Any = None) -> None:
        self._store = Store(store)
        self._study = study
        self._owns = owns  # keeps a temporary folder as long as the table
        header = self._store.header()
        self.cases: Cases = Cases.from_record(header["cases"])
        self._identity: str = header["identity"]
        self._numbers = {key_of(self._identity, case): number for number, case in enumerate(self.cases)}

    def __len__(self) -> int:
        """Return the number of cases, run or not."""
        return len(self.cases)

    def __str__(self) -> str:
        counts = [f"{len(self)} cases", *(f"{count} {name}" for name, count in self.counts.items() if count)]
        parts = [f"parameters: {', '.join(self.parameters)}", f"outputs: {', '.join(self.outputs) or 'none yet'}"]
        return f"{', '.join(counts)}; {'; '.join(parts)}"

    @property
    def store(self) -> Path:
        """The folder of the study."""
        return self._store.folder

    @property
    def header(self) -> dict[str, Any]:
        """Header of the study: versions, parameters, options and the source of its functions."""
        return self._store.header()

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return self.cases.names

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs of all cases that are done."""
        return tuple(dict.fromkeys(name for row in self._rows() for name in row["outputs"]))

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of cases that are finished, stopped, failed, and not run."""
        found = [status for _, status in self.statuses()]
        return {end: found.count(end) for end in ENDS} | {"not run": len(self) - len(found)}

    def statuses(self) -> Iterator[tuple[str, str]]:
        """Yield (key, status) of each case that is done."""
        last = {row["key"]: row["status"] for row in self._store.rows()}
        return ((key, status) for key, status in last.items() if key in self._numbers)

    @checked
    def column(self, name: str) -> np.ndarray:
        """Return a column of the cases that are done; NaN where a case has no value.

        Raises
        ------
        ModelError
            If there is no such column; the message lists them.
        """
        columns = self.lists()
        if name not in columns:
            raise ModelError(f"the table has no column {name!r}. It has: {', '.join(columns)}")
        return array_of(columns[name])

    def to_dataframe(self) -> Any:
        """Return the cases that are done as a ``pandas.DataFrame`` with their numbers as index.

        Raises
        ------
        MissingDependency
            If pandas is not installed.
        """
        from kanefe.storage._pandas import frame_of

        return frame_of(self.lists(), "case")

    def to_xarray(self) -> Any:
        """Return the cases that are done as an ``xarray.Dataset`` over the parameters: numbers and status.

        Cases that failed or were not run are NaN. If the cases are not a grid, such as samples, it is over the cases.
        Names are such that netCDF and zarr take them: "/" is ".", and the attribute "long_name" is what was changed.

        Raises
        ------
        MissingDependency
            If xarray is not installed.

        Examples
        --------
        ``table.to_xarray()["tension"].sel(sea_state=5).mean("seed").plot()``
        """
        from kanefe.studies.grid import over_parameters

        kept = {"kanefe": str(self.header["kanefe"]), "built by": str(self.header["build"]["name"])}
        return over_parameters(self.lists(), self.parameters, kept)

    def lists(self) -> dict[str, list[Any]]:
        """Return all columns as lists, None where a case has no value."""
        rows = self._rows()
        outputs = dict.fromkeys(name for row in rows for name in row["outputs"])
        columns: dict[str, list[Any]] = {"case": [self._numbers[row["key"]] for row in rows]}
        columns |= {name: [row["parameters"].get(name) for row in rows] for name in self.parameters}
        columns |= {name: [row["outputs"].get(name) for row in rows] for name in outputs}
        columns |= {name: [row[name] for row in rows] for name in ("status", "reason", "simulated")}
        columns["warnings"] = ["; ".join(row["warnings"]) for row in rows]
        return columns | {name: [row[name] for row in rows] for name in (*MEASURED, "key")}

    def case(self, key: int | str | Mapping[str, Any]) -> Result:
        """Run a case again in this process, and return its full `Result`.

        Parameters
        ----------
        key : int, str or mapping
            Its number, its key, or its parameters.

        Raises
        ------
        ModelError
            If there is no such case, or the table has no study.
        """
        number = self._number(key)
        if self._study is None:
            raise ModelError(
                f"{self._store.folder} contains the source of build, not build itself. Remedy: construct the study "
                "again, and use study.table(store).case(...)"
            )
        return self._study.result(self.cases[number])

    @checked
    def save(self, path: str | Path) -> Path:
        """Write the table to one file: .csv, .h5 (HDF5), or .parquet (which needs pandas and pyarrow).

        In HDF5 each column is one array of the file; "/" in a name is "%2F" there, "%" is "%25", and truth values are 0
        and 1.

        Raises
        ------
        ModelError, FileError, MissingDependency
            If the suffix is none of these, the file cannot be written, or a package is not installed.
        """
        from kanefe.studies.export import save_table

        return save_table(self.lists(), self.header, path)

    @checked("over", "band")
    def operability(
        self, limit: float | Mapping[str, float], *, over: str | tuple[str, ...] = "seed", band: float = 0.9
    ) -> Operability:
        """Return the probability of exceeding limits, by counting the runs of a cell and by a Gumbel fit to them.

        Parameters
        ----------
        limit : float or mapping
            Limits by name of outputs, which are maxima of each run; one number if there is one output.
        over : str or tuple of str
            Parameters by which the runs of a cell differ, such as seeds.
        band : float
            Probability of the confidence intervals.

        Raises
        ------
        ModelError
            If there is no such output or parameter.

        Examples
        --------
        ``table.operability({"tension": 30e3, "slip": 0.05}).to_html("map.html")``
        """
        from kanefe.studies.statistics.operability import operability

        about = self.header | {"counts": self.counts}
        return operability(self.lists(), self.parameters, self.outputs, about, limit, over, band)

    def _rows(self) -> list[dict[str, Any]]:
        last = {row["key"]: row for row in self._store.rows() if row["key"] in self._numbers}
        return sorted(last.values(), key=lambda row: self._numbers[row["key"]])

    def _number(self, key: int | str | Mapping[str, Any]) -> int:
        if isinstance(key, Mapping):
            wanted = {name: plain(value, name) for name, value in key.items()}
            key = next((number for number, case in enumerate(self.cases) if case == wanted), str(key))
        if isinstance(key, str) and key in self._numbers:
            return self._numbers[key]
        if isinstance(key, (int, np.integer)) and 0 <= key < len(self):
            return int(key)
        raise ModelError(
            f"there is no case {key!r}. Remedy: a number from 0 to {len(self) - 1}, a key, or a dict of "
            f"{', '.join(self.parameters)}"
        )


def array_of(values: list[Any]) -> np.ndarray:
    """Return numbers as an array, with NaN for gaps; anything else as objects."""
    if all(value is None or (isinstance(value, (int, float)) and not isinstance(value, bool)) for value in values):
        if any(value is None or isinstance(value, float) for value in values):
            return np.array([np.nan if value is None else value for value in values], dtype=float)
        return np.array(values, dtype=int if values else float)
    if all(isinstance(value, bool) for value in values):
        return np.array(values)
    found = np.empty(len(values), dtype=object)
    found[:] = values
    return found
