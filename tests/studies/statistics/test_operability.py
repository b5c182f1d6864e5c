"""Statistics of maxima: Gumbel's law and its bands, maps of exceedance, pictures, pages, samples of distributions."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

import kanefe as kf
from kanefe.studies import GumbelFit
from kanefe.studies.sampling import SAMPLINGS, sampled_rows
from kanefe.studies.statistics.cells import cell_of, share_band
from study_scenes import lowest, pendulum

RUNS = 12


def still(heading_deg: float, sea_state: int, seed: int) -> kf.System:
    """Return a scene whose start holds the maximum of a run: Gumbel's law, higher in beam seas."""
    if sea_state == 4 and heading_deg == 90 and seed == 3:
        raise ValueError("lost")
    generator = np.random.default_rng((sea_state, seed))
    place = (0.5 + 0.5 * math.sin(math.radians(heading_deg))) * sea_state
    scene = kf.System()
    joint = kf.Prismatic("x", position=generator.gumbel(place, 0.5), speed=float(seed > 2))
    scene.add_rigid_body("mass", 1.0, joint=joint)
    return scene


def maxima(result: kf.Result) -> dict[str, Any]:
    return {"tension": result.joint_coordinates("mass")[0, 0], "slip": result.joint_speeds("mass")[0, 0]}


@pytest.fixture(scope="module")
def table() -> kf.StudyTable:
    study = kf.Study(
        still,
        maxima,
        duration=0.1,
        simulate={"output_step": 0.1},
        heading_deg=range(0, 360, 90),
        sea_state=(3, 4),
        seed=range(RUNS),
    )
    return study.run("serial")


@pytest.mark.parametrize("count", [5, 40, 1000])
def test_a_fit_is_the_most_probable_one(count: int) -> None:
    x = np.random.default_rng(count).gumbel(1e3, 2.0, count)
    fit = GumbelFit.of(x)
    location, scale = stats.gumbel_r.fit(x)
    assert fit.location == pytest.approx(location, rel=1e-9)
    assert fit.scale == pytest.approx(scale, rel=1e-6)  # scipy solves to 1e-8
    law = stats.gumbel_r(fit.location, fit.scale)
    best = law.logpdf(x).sum()
    for change in (1.001, 0.999):
        assert stats.gumbel_r(fit.location, change * fit.scale).logpdf(x).sum() < best
        assert stats.gumbel_r(fit.location + (change - 1.0) * fit.scale, fit.scale).logpdf(x).sum() < best
    assert fit.quantile(0.9) == pytest.approx(law.ppf(0.9), rel=1e-12)
    assert fit.exceedance(1005.0) == pytest.approx(law.sf(1005.0), rel=1e-9)
    assert fit.mean == pytest.approx(law.mean(), rel=1e-12)


@pytest.mark.parametrize("count", [4, 10, 60])
def test_bands_hold_the_truth_as_often_as_they_say(count: int) -> None:
    generator = np.random.default_rng(7)
    limit, samples = 2.5, 1000
    truth, quantile = stats.gumbel_r.sf(limit), stats.gumbel_r.ppf(0.9)
    hits = np.zeros(2)
    for _ in range(samples):
        fit = GumbelFit.of(generator.gumbel(size=count))
        for j, (true, (low, high)) in enumerate(
            ((truth, fit.exceedance_band(limit)), (quantile, fit.quantile_band(0.9)))
        ):
            hits[j] += low < true < high
    # three standard deviations of a share of a thousand, and the 1 % of the sampled pivots
    assert np.abs(hits / samples - 0.9).max() < 3.0 * math.sqrt(0.09 / samples) + 0.01


@pytest.mark.parametrize("values", [[1.0, 2.0], [1.0, 1.0, 1.0, 1.0], [1.0, 2.0, np.nan]])
def test_what_has_no_law_is_refused(values: Any) -> None:
    with pytest.raises(kf.ModelError, match="Gumbel's law needs 3 finite maxima"):
        GumbelFit.of(values)


def test_bands_of_shares_are_exact() -> None:
    low, high = share_band(2, 10, 0.9)
    assert stats.binom.sf(1, 10, low) == pytest.approx(0.05, rel=1e-9)
    assert stats.binom.cdf(2, 10, high) == pytest.approx(0.05, rel=1e-9)
    assert share_band(0, 10, 0.9)[0] == 0.0
    assert share_band(10, 10, 0.9)[1] == 1.0
    assert share_band(0, 0, 0.9) == (0.0, 1.0)


def test_cells_count_what_is_above(table: kf.StudyTable) -> None:
    found = table.operability({"tension": 3.0, "slip": 0.5})
    assert [cell.parameters for cell in found.cells["tension"]] == [
        {"heading_deg": h, "sea_state": s} for h in (0, 90, 180, 270) for s in (3, 4)
    ]
    columns = {name: table.column(name) for name in ("heading_deg", "sea_state", "tension")}
    for cell in found.cells["tension"]:
        own = (columns["heading_deg"] == cell.parameters["heading_deg"]) & (
            columns["sea_state"] == cell.parameters["sea_state"]
        )
        values = columns["tension"][own]
        values = values[np.isfinite(values)]
        assert cell.runs + cell.failed == RUNS
        assert cell.exceeded == (values > 3.0).sum()
        assert cell.probability == cell.exceeded / len(values)
        assert cell.fit == GumbelFit.of(values)
    assert found.cells["tension"][3].failed == 1
    slips = found.cells["slip"][0]
    assert slips.probability == (RUNS - 3) / RUNS
    assert slips.fit is None  # two values: there is no law of extremes
    capped = cell_of({}, [0.15 * (1.0 + 1e-15 * seed) for seed in range(10)], 0.1, 0.9)
    assert (capped.exceeded, capped.fit) == (10, None)  # friction's cap, to round-off
    rows = found.rows()
    assert len(rows) == 16
    assert rows[0]["fit probability low"] < rows[0]["fit probability"] < rows[0]["fit probability high"]
    assert math.isnan(rows[-1]["fit probability"])
    assert {name for _, name, _ in found.governing()} <= {"tension", "slip"}


def test_cells_over_other_parameters(table: kf.StudyTable) -> None:
    found = table.operability({"tension": 3.0}, over=("seed", "heading_deg"))
    assert [cell.parameters for cell in found.cells["tension"]] == [{"sea_state": 3}, {"sea_state": 4}]


def test_a_polar_picture_is_drawn(table: kf.StudyTable, tmp_path: Path) -> None:
    found = table.operability({"tension": 3.0, "slip": 0.5})
    figure = found.plot(path=tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 10_000
    panels = [axes for axes in figure.axes if axes.name == "polar"]
    assert [axes.get_title() for axes in panels] == ["P(tension > 3)", "P(slip > 0.5)"]
    sectors = [mesh.get_array().reshape(2, -1)[:, 0].tolist() for mesh in panels[0].collections]
    shares = [cell.probability for cell in found.cells["tension"]]
    assert sectors == [shares[j : j + 2] for j in range(0, 8, 2)]
    assert panels[0].get_theta_offset() == pytest.approx(math.pi / 2)  # ahead is up
    assert panels[0].get_theta_direction() == 1  # and port to the left
    assert len(found.plot(output="slip").axes) == 2


def test_a_page_tells_what_was_run(table: kf.StudyTable, tmp_path: Path) -> None:
    found = table.operability({"tension": 3.0, "slip": 0.5})
    path = found.to_html(tmp_path / "page.html")
    page = path.read_text(encoding="utf-8")
    for text in (
        "1 runs failed",
        "tension above 3",
        "What governs",
        "data:image/png",
        "default_rng",
        "heading deg",
        "still",
    ):
        assert text in page, text
    assert "tension above 3" in str(found)


BAD: dict[str, tuple[Any, str]] = {
    "which output": (lambda t: t.operability(3.0), "limit must be a dict by output. There are: tension, slip"),
    "no output": (lambda t: t.operability({"force": 1.0}), "there is no output 'force'. There are: tension, slip"),
    "no limit": (lambda t: t.operability({}), "no limit was given"),
    "no number": (lambda t: t.operability({"tension": math.inf}), "the limit of tension must be a finite number"),
    "no parameter": (lambda t: t.operability({"tension": 1.0}, over="wave"), "the study has no parameter 'wave'"),
    "no band": (lambda t: t.operability({"tension": 1.0}, band=1.0), "band must lie between 0 and 1"),
    "no picture": (lambda t: t.operability({"slip": 1.0}).plot(output="tension"), "no limit was given for 'tension'"),
    "no angle": (lambda t: t.operability({"slip": 1.0}).plot("wind"), "there is no angle 'wind'"),
    "no radius": (lambda t: t.operability({"slip": 1.0}).plot(radius="wind"), "there is no parameter 'wind'"),
    "too many": (lambda t: t.operability({"slip": 1.0}, over=()).plot(), "cells differ in seed too"),
}


@pytest.mark.parametrize(("use", "message"), BAD.values(), ids=BAD)
def test_bad_input_is_refused(table: kf.StudyTable, use: Any, message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        use(table)


def test_a_latin_hypercube_meets_each_stratum_once() -> None:
    laws = {"mass": stats.norm(10.0, 0.5), "friction": stats.uniform(0.1, 0.5)}
    rows, record = sampled_rows(laws, 40, "latin hypercube", 3)
    for name, law in laws.items():
        strata = np.floor(40 * law.cdf([row[name] for row in rows]))
        assert sorted(strata) == list(range(40))
    assert sampled_rows(laws, 40, "latin hypercube", 3)[0] == rows
    assert sampled_rows(laws, 40, "latin hypercube", 4)[0] != rows
    assert record["seed"] == 3
    assert record["distributions"] == {"mass": "norm(10.0, 0.5)", "friction": "uniform(0.1, 0.5)"}


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_samples_are_those_of_the_distribution(sampling: str) -> None:
    rows, _ = sampled_rows({"a": stats.norm(2.0, 3.0)}, 256, sampling, 0)
    values = np.array([row["a"] for row in rows])
    assert np.isfinite(values).all()
    assert stats.kstest(values, stats.norm(2.0, 3.0).cdf).pvalue > 0.01


def test_a_study_is_sampled() -> None:
    study = kf.Study.sampled(
        pendulum, lowest, 5, length=stats.uniform(0.5, 1.0), angle=stats.norm(0.0, 0.1), seed=range(2), duration=0.1
    )
    table = study.run("serial")
    assert len(table) == 10
    lengths = table.column("length")
    assert ((lengths >= 0.5) & (lengths <= 1.5)).all()
    assert lengths[0] == lengths[1] != lengths[2]
    assert table.header["sampling"]["sampling"] == "latin hypercube"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"samples": 0}, "samples must be a whole number above zero"),
        ({"sampling": "dice"}, "there is no sampling 'dice'. Remedy: latin hypercube, sobol"),
        ({"sampling_seed": -1}, "sampling_seed must be a whole number"),
        ({"length": 1.0}, "none of the parameters .length., .angle. is a distribution to sample"),
    ],
)
def test_bad_samplings_are_refused(options: Any, message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        kf.Study.sampled(
            pendulum,
            lowest,
            **{"samples": 3, "length": stats.uniform(0.5, 1.0), "angle": 0.0, "duration": 1.0, **options},
        )
