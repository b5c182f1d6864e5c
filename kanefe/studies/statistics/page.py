"""The report of a study: its runs, its failures, and the probability of exceeding each limit."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from kanefe.documents.blocks import Block, Heading, Listing, Paragraph, Picture, Table
from kanefe.documents.document import Report
from kanefe.documents.record_tables import record_tables
from kanefe.studies.statistics.cells import Cell

LEAST_SHARE = 1e-6
"""Probability below which no digits are shown: no distribution fitted to tens of runs can resolve them."""

Map = Mapping[str, tuple[Cell, ...]]


def report_of(
    limits: Mapping[str, float],
    cells: Map,
    band: float,
    about: Mapping[str, Any],
    governing: Sequence[tuple[dict[str, Any], str, float]],
    draw: Callable[[], dict[str, bytes]],
) -> Report:
    """Return the report that `Operability.report` describes.

    Parameters
    ----------
    limits, cells, band, about, governing
        Data of the operability.
    draw : function
        Returns a picture (.png) of each output.
    """
    blocks: list[Block] = [
        Heading("What was run"),
        *record_tables(
            {
                "cases": {name: count for name, count in about["counts"].items() if count},
                "parameters": {name: _values(values) for name, values in about["cases"]["grid"].items()},
                **({"sampled": about["sampling"]} if about["sampling"] else {}),
                "options of the runs": about["options"],
                "kanefe": about["kanefe"],
                "python": about["python"],
                "packages": about["packages"],
                "built by": about["build"]["name"],
                "outputs by": about["outputs"]["name"],
            }
        ),
    ]
    lost = sum(cell.failed for cell in next(iter(cells.values())))
    if lost:
        blocks.append(Paragraph(f"{lost} runs failed and are left out of the statistics.", warning=True))
    if about["counts"]["not run"]:
        blocks.append(Paragraph(f"{about['counts']['not run']} cases were not run yet.", warning=True))
    for output, own in cells.items():
        blocks += _section(output, limits[output], own, band)
    if len(cells) > 1:
        rows = [
            [*map(_number, parameters.values()), *((name, _share(share)) if share else ("none", "0"))]
            for parameters, name, share in governing
        ]
        blocks += [Heading("What governs"), Table([*governing[0][0], "limit that is exceeded most often", "P"], rows)]
    blocks += [Heading("How it was built"), Listing(about["build"]["source"].rstrip())]
    return Report("Operability", tuple(blocks), lambda: _pictures(limits, draw()))


def _section(output: str, limit: float, cells: tuple[Cell, ...], share: float) -> list[Block]:
    band = f"{share:.0%} band"
    header = [
        *cells[0].parameters,
        "runs",
        "above",
        "P",
        band,
        "mean",
        "highest",
        "P by fit",
        band,
        "90 % by fit",
        band,
    ]
    rows = [[*map(_number, cell.parameters.values()), *_cell_texts(cell, limit, share)] for cell in cells]
    return [
        Heading(_title(output, limit)),
        Paragraph(
            "P: share of the runs whose maximum is above the limit, with its exact confidence interval. By fit: from "
            "the Gumbel distribution of the maxima of a cell, if enough of them differ; 90 %: the value that the "
            "maximum of nine out of ten runs does not exceed."
        ),
        Table(header, rows),
    ]


def _cell_texts(cell: Cell, limit: float, band: float) -> list[str]:
    fit = cell.fit
    texts = [
        str(cell.runs),
        str(cell.exceeded),
        _share(cell.probability),
        _range(_short, cell.band),
        _number(cell.mean),
        _number(cell.highest),
    ]
    if fit is None:
        return [*texts, "-", "-", "-", "-"]
    return [
        *texts,
        _short(fit.exceedance(limit)),
        _range(_short, fit.exceedance_band(limit, band)),
        _number(fit.quantile(0.9)),
        _range(_three, fit.quantile_band(0.9, band)),
    ]


def _pictures(limits: Mapping[str, float], drawn: Mapping[str, bytes]) -> dict[str, list[Picture]]:
    return {
        _title(output, limits[output]): [Picture(f"Probability that {output} is exceeded", png)]
        for output, png in drawn.items()
    }


def _title(output: str, limit: float) -> str:
    return f"{output} above {limit:g}"


def _values(values: Any) -> str:
    shown = [_number(value) for value in values]
    return ", ".join(shown if len(shown) <= 13 else [*shown[:6], "...", *shown[-3:]])


def _number(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _share(value: float) -> str:
    return f"{value:.3g}" if value == 0.0 or value >= LEAST_SHARE else f"< {LEAST_SHARE:g}"


def _three(value: float) -> str:
    return f"{value:.3g}"


def _short(value: float) -> str:
    """Return two digits, the accuracy that tens of runs allow."""
    return _share(float(f"{value:.2g}")) if value >= LEAST_SHARE or value == 0.0 else _share(value)


def _range(shown: Any, ends: tuple[float, float]) -> str:
    return f"{shown(ends[0])} to {shown(ends[1])}"
