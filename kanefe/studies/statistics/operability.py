"""Probabilities of exceeding limits, by counting and by Gumbel fits; as a table, a polar plot and a report."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.studies.statistics.cells import Cell, cell_of

if TYPE_CHECKING:
    from kanefe.documents.document import Report
    from kanefe.views.plots import Figure


@dataclass(frozen=True, eq=False)
class Operability:
    """Probabilities of exceeding limits, cell by cell.

    Attributes
    ----------
    limits : dict of str to float
        By output.
    cells : dict of str to tuple of Cell
        By output, in the order of the cases.
    band : float
        Probability of the confidence intervals.
    about : dict
        Header of the study.

    Examples
    --------
    >>> print(table.operability({"tension": 30e3}))                      # doctest: +SKIP
    >>> table.operability(30e3).plot("heading_deg", "sea_state", path="map.png")  # doctest: +SKIP
    """

    limits: dict[str, float]
    cells: dict[str, tuple[Cell, ...]]
    band: float
    about: dict[str, Any]

    def __str__(self) -> str:
        return str(self.report())

    def rows(self) -> list[dict[str, Any]]:
        """Return a dict for each cell of each output: its parameters and all numbers, NaN without a fit."""
        return [self._row(output, cell) for output, cells in self.cells.items() for cell in cells]

    def to_dataframe(self) -> Any:
        """Return the same as a ``pandas.DataFrame``; `MissingDependency` without pandas."""
        from kanefe.storage._pandas import frame_of

        rows = self.rows()
        return frame_of({"case": range(len(rows)), **{n: [row[n] for row in rows] for n in rows[0]}}, "case")

    def governing(self) -> list[tuple[dict[str, Any], str, float]]:
        """Return for each cell its parameters, the limit that is exceeded most often, and the probability."""
        found = []
        for cells in zip(*self.cells.values(), strict=True):
            worst = max(range(len(cells)), key=lambda j: cells[j].probability)
            found.append((cells[worst].parameters, list(self.cells)[worst], cells[worst].probability))
        return found

    @checked
    def plot(
        self,
        angle: str | None = None,
        radius: str | None = None,
        *,
        output: str | None = None,
        path: str | Path | None = None,
    ) -> Figure:
        """Draw the probability that a limit is exceeded in a polar plot, and return matplotlib's figure.

        Ahead is up, and angles increase to port (to the left), as `heading_deg` of a ship.

        Parameters
        ----------
        angle : str, optional
            Parameter in degrees; default: the first whose name ends in ``_deg``.
        radius : str, optional
            Parameter of the rings; default: the other one, if there is one.
        output : str, optional
            The output of a limit; default: a plot of each.
        path : path, optional
            File to write (.png, .pdf, .svg); its folder is created.

        Raises
        ------
        ModelError, FileError, MissingDependency
            If there is no such parameter or output, cells differ in more than the two, the file cannot be written, or
            matplotlib is not installed.
        """
        from kanefe.views.polar import PolarMap, polar_picture

        chosen = list(self.cells) if output is None else [self._known(output)]
        around, outward = self._axes(angle, radius)
        maps = []
        for name in chosen:
            cells = self.cells[name]
            angles = sorted({cell.parameters[around] for cell in cells})
            radii: list[Any] = list(dict.fromkeys(cell.parameters[outward] for cell in cells)) if outward else [""]
            values = np.full((len(radii), len(angles)), np.nan)
            for cell in cells:
                row = radii.index(cell.parameters[outward]) if outward else 0
                values[row, angles.index(cell.parameters[around])] = cell.probability
            title = f"P({name} > {self.limits[name]:g})"
            maps.append(PolarMap(title, np.array(angles, dtype=float), tuple(map(str, radii)), values, outward or ""))
        return polar_picture(maps, path)

    def report(self) -> Report:
        """Return a report of the runs, the failures, and each limit, with ``to_html`` and ``to_markdown``."""
        from kanefe.studies.statistics.page import report_of

        return report_of(self.limits, self.cells, self.band, self.about, self.governing(), self._pictures)

    @checked
    def to_html(self, path: str | Path) -> Path:
        """Write the report as one HTML page with its pictures embedded; errors as of `plot`."""
        return self.report().to_html(path)

    def _row(self, output: str, cell: Cell) -> dict[str, Any]:
        limit, fit = self.limits[output], cell.fit
        low, high = fit.exceedance_band(limit, self.band) if fit else (math.nan, math.nan)
        lower, upper = fit.quantile_band(0.9, self.band) if fit else (math.nan, math.nan)
        return {
            **cell.parameters,
            "output": output,
            "limit": limit,
            "runs": cell.runs,
            "failed": cell.failed,
            "exceeded": cell.exceeded,
            "probability": cell.probability,
            "probability low": cell.band[0],
            "probability high": cell.band[1],
            "mean maximum": cell.mean,
            "highest": cell.highest,
            "fit location": fit.location if fit else math.nan,
            "fit scale": fit.scale if fit else math.nan,
            "fit probability": fit.exceedance(limit) if fit else math.nan,
            "fit probability low": low,
            "fit probability high": high,
            "fit 90 %": fit.quantile(0.9) if fit else math.nan,
            "fit 90 % low": lower,
            "fit 90 % high": upper,
        }

    def _known(self, output: str) -> str:
        if output not in self.cells:
            raise ModelError(f"no limit was given for {output!r}. There are: {', '.join(self.cells)}")
        return output

    def _pictures(self) -> dict[str, bytes]:
        """Return a polar plot (.png) of each output; none if there is no angle, or too many parameters."""
        try:
            self._axes(None, None)
        except ModelError:
            return {}
        found = {}
        for output in self.cells:
            buffer = io.BytesIO()
            self.plot(output=output).savefig(buffer, format="png", dpi=110)
            found[output] = buffer.getvalue()
        return found

    def _axes(self, angle: str | None, radius: str | None) -> tuple[str, str | None]:
        first = next(iter(self.cells.values()))
        names = list(first[0].parameters)
        varying = [name for name in names if len({json.dumps(c.parameters[name]) for c in first}) > 1]
        around = angle or next((name for name in names if name.endswith("_deg")), None)
        if around is None or around not in names:
            raise ModelError(f"there is no angle {angle or '*_deg'!r}. Remedy: angle= one of {', '.join(names)}")
        rest = [name for name in varying if name != around]
        outward = radius or (rest[0] if rest else None)
        if outward is not None and outward not in names:
            raise ModelError(f"there is no parameter {outward!r}. Remedy: radius= one of {', '.join(names)}")
        others = [name for name in rest if name != outward]
        if others:
            raise ModelError(
                f"cells differ in {', '.join(others)} too, which a polar plot cannot show. Remedy: a study with one "
                "value of it, or operability(over=(..., that))"
            )
        return around, outward


def operability(
    columns: Mapping[str, list[Any]],
    parameters: tuple[str, ...],
    outputs: tuple[str, ...],
    about: dict[str, Any],
    limit: float | Mapping[str, float],
    over: str | tuple[str, ...],
    band: float,
) -> Operability:
    """Return the result of `StudyTable.operability` from the columns of a table."""
    limits = _limits(limit, outputs)
    apart = (over,) if isinstance(over, str) else tuple(over)
    unknown = [name for name in apart if name not in parameters]
    if unknown:
        raise ModelError(
            f"the study has no parameter {unknown[0]!r}. Remedy: over= one or several of {', '.join(parameters)}"
        )
    if not 0.0 < band < 1.0:
        raise ModelError(f"band must lie between 0 and 1, not {band!r}")
    kept = [name for name in parameters if name not in apart]
    groups: dict[str, list[int]] = {}
    for row in range(len(columns["case"])):
        groups.setdefault(json.dumps([columns[name][row] for name in kept]), []).append(row)
    cells = {
        output: tuple(
            cell_of({name: columns[name][rows[0]] for name in kept}, [columns[output][r] for r in rows], value, band)
            for rows in groups.values()
        )
        for output, value in limits.items()
    }
    return Operability(limits, cells, band, about)


def _limits(limit: float | Mapping[str, float], outputs: tuple[str, ...]) -> dict[str, float]:
    if not isinstance(limit, Mapping):
        if len(outputs) != 1:
            raise ModelError(f"limit must be a dict by output. There are: {', '.join(outputs) or 'none yet'}")
        limit = {outputs[0]: limit}
    for name, value in limit.items():
        if name not in outputs:
            raise ModelError(f"there is no output {name!r}. There are: {', '.join(outputs) or 'none yet'}")
        if numbers(value).shape != () or not math.isfinite(numbers(value)):
            raise ModelError(f"the limit of {name} must be a finite number, not {value!r}")
    if not limit:
        raise ModelError("no limit was given")
    return {name: float(value) for name, value in limit.items()}
