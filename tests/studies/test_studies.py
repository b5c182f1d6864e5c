"""A study: cases, rows, bad input; executors, stores and statistics have files of their own."""

from __future__ import annotations

import importlib
import itertools
import json
import signal
import sys
import time
import urllib.parse
import warnings
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.studies.cases import cases_of
from kanefe.studies.workers.case_warnings import CaseWarnings
from kanefe.studies.workers.time_limit import within
from kanefe.studies.workers.work import run_block, stamp
from repository import ROOT
from study_scenes import GRID, bits, hinged, lowest, pendulum, told, troubled


@pytest.fixture(scope="module")
def study() -> kf.Study:
    return kf.Study(pendulum, lowest, duration=0.2, **GRID)


@pytest.fixture(scope="module")
def table(study: kf.Study) -> kf.StudyTable:
    return study.run("serial")


def test_the_grid_runs_through_all_combinations() -> None:
    cases = cases_of([{"a": 1, "b": "x"}, {"a": 2, "b": "y"}], {"c": (1.5, 2.5), "d": range(3)})
    assert len(cases) == 12
    assert cases[0] == {"a": 1, "b": "x", "c": 1.5, "d": 0}
    assert list(cases) == [
        {"a": a, "b": b, "c": c, "d": d} for a, b in ((1, "x"), (2, "y")) for c in (1.5, 2.5) for d in range(3)
    ]
    with pytest.raises(IndexError):
        cases[12]


def test_values_of_numpy_are_those_of_python() -> None:
    one = cases_of(None, {"a": np.linspace(0.0, 1.0, 3), "b": np.arange(2)})
    other = cases_of(None, {"a": [0.0, 0.5, 1.0], "b": [0, 1]})
    assert json.dumps(one.record()) == json.dumps(other.record())


def test_a_row_tells_parameters_outputs_and_costs(table: kf.StudyTable) -> None:
    columns = table.lists()
    assert list(columns) == [
        *("case", "length", "angle", "seed", "lowest", "status", "reason", "simulated", "warnings"),
        *("wall", "cpu", "worker", "key"),
    ]
    assert columns["case"] == list(range(12))
    assert set(columns["status"]) == {"finished"}
    assert min(columns["wall"]) > 0.0
    assert min(columns["cpu"]) > 0.0
    assert table.counts == {"finished": 12, "stopped": 0, "failed": 0, "not run": 0}
    assert "12 cases, 12 finished" in str(table)


def test_outputs_are_those_of_the_run_to_the_bit(table: kf.StudyTable) -> None:
    for number, case in ((0, GRID), (11, {"length": 1.0, "angle": 0.3, "seed": 2})):
        parameters = table.cases[number] if number == 0 else case
        run = pendulum(**parameters).simulate((0.0, 0.2))
        assert table.column("lowest")[number] == lowest(run)["lowest"]


def test_a_case_runs_again_in_full(table: kf.StudyTable) -> None:
    parameters = {"length": 1.0, "angle": 0.0, "seed": 1}
    number = list(table.cases).index(parameters)
    key = table.lists()["key"][number]
    for name in (number, key, parameters, {**parameters, "length": 1}):
        result = table.case(name)
        assert lowest(result)["lowest"] == table.column("lowest")[number]
        assert len(result.times) == 501
    with pytest.raises(kf.ModelError, match=r"there is no case 12\. Remedy: a number from 0 to 11"):
        table.case(12)
    with pytest.raises(kf.ModelError, match="contains the source of build, not build itself"):
        kf.StudyTable(table.store).case(0)


def test_trouble_of_a_case_is_its_own() -> None:
    table = kf.Study(troubled, told, duration=0.2, seed=range(6)).run("serial")
    columns = table.lists()
    assert columns["status"] == ["finished", "failed", "finished", "failed", "failed", "failed"]
    lines = (ROOT / "tests" / "shared" / "study_scenes.py").read_text(encoding="utf-8").splitlines()
    line = 1 + next(number for number, text in enumerate(lines) if "too much wind" in text)
    assert columns["reason"][1] == f"build raised ValueError: too much wind (study_scenes.py, line {line})"
    assert "the run failed at t = 0" in columns["reason"][3]
    assert columns["reason"][4].startswith("simulate: ")
    assert "outputs raised RuntimeError: no number" in columns["reason"][5]
    assert "it is windy" in columns["warnings"][2]
    assert "SimulationWarning" in columns["warnings"][3]
    assert columns["lowest"][1] is None
    assert np.isnan(table.column("lowest")[[1, 3, 4, 5]]).all()


def test_options_of_runs_come_from_the_study_and_from_build() -> None:
    def early(angle: float) -> tuple[kf.System, dict[str, Any]]:
        down = kf.Event("down", lambda t, state: state.joint_coordinates("rod")[0] + 0.1, terminal=True)
        return pendulum(1.0, angle), {"events": down}

    def kept(result: kf.Result) -> dict[str, Any]:
        return {"stored": len(result.times), "method": result.statistics["method"]}

    table = kf.Study(early, kept, duration=1.0, simulate={"output_step": 0.01, "method": "vern9"}, angle=0.0).run(
        "serial"
    )
    (row,) = (dict(zip(table.lists(), values, strict=True)) for values in zip(*table.lists().values(), strict=True))
    assert row["status"] == "stopped"
    assert row["method"] == "vern9"
    assert row["simulated"] < 0.3
    assert "event" in row["reason"]


def test_a_table_of_parameters_is_taken_row_by_row() -> None:
    rows = [{"length": 0.5, "angle": 0.1}, {"angle": 0.2, "length": 0.7}]
    table = kf.Study(pendulum, lowest, table=rows, duration=0.1, seed=(0, 1)).run("serial")
    assert table.column("length").tolist() == [0.5, 0.5, 0.7, 0.7]
    assert table.column("seed").tolist() == [0, 1, 0, 1]


@pytest.mark.dask
def test_a_frame_and_a_frame_of_parameters() -> None:
    import pandas

    rows = pandas.DataFrame({"length": [0.5, 0.7], "angle": [0.1, 0.2]})
    table = kf.Study(pendulum, lowest, table=rows, duration=0.1).run("serial")
    frame = table.to_dataframe()
    assert frame.index.name == "case"
    assert frame["lowest"].to_numpy().tobytes() == table.column("lowest").tobytes()
    assert frame.loc[1, "status"] == "finished"


def test_arrays_and_texts_are_kept() -> None:
    def kinds(result: kf.Result) -> dict[str, Any]:
        return {"text": "yes", "flag": np.True_, "count": np.int64(3), "curve": np.arange(3.0), "gap": None}

    table = kf.Study(pendulum, kinds, duration=0.1, length=1.0, angle=[0.0, 0.1]).run("serial")
    columns = table.lists()
    assert [columns[name][0] for name in ("text", "flag", "count", "curve", "gap")] == [
        *("yes", True, 3, [0.0, 1.0, 2.0], None)
    ]
    assert table.column("count").dtype == int


def with_option(duration: float) -> kf.System:
    return pendulum(1.0, duration)


def exits(length: float, seed: int = 0) -> kf.System:
    if length == 2.0:
        sys.exit(7)
    return pendulum(length, 0.0)


def hangs(length: float) -> kf.System:
    deadline = time.monotonic() + 5.0  # a thread that is left behind ends with the test
    while length == 2.0 and time.monotonic() < deadline:
        time.sleep(0.01)
    return pendulum(length, 0.0)


def test_a_case_that_exits_is_a_row() -> None:
    table = kf.Study(exits, lowest, duration=0.1, length=[1.0, 2.0, 3.0]).run("serial")
    assert table.lists()["status"] == ["finished", "failed", "finished"]
    assert table.lists()["reason"][1] == "build called sys.exit(7)"
    with pytest.raises(kf.ModelError, match=r"build\(length=2.0\) called sys.exit\(7\). Nothing was run. Remedy"):
        kf.Study(exits, lowest, duration=0.1, length=2.0).run("serial")


@pytest.mark.parametrize("executor", ["serial", "threads"])
def test_a_case_that_hangs_ends(executor: str) -> None:
    study = kf.Study(hangs, lowest, duration=0.1, length=[1.0, 2.0, 3.0])
    study.result({"length": 1.0})  # what is read once, such as kernels, is read
    with ThreadPoolExecutor(1) as threads:
        table = study.run(threads if executor == "threads" else "serial", most_seconds=0.5)
    assert table.lists()["status"] == ["finished", "failed", "finished"]
    assert table.lists()["reason"][1] == "build was not done after 0.5 s (most_seconds=)"
    assert bits(table)  # the limit is no part of the study


def test_a_first_build_that_hangs_is_told() -> None:
    with pytest.raises(kf.ModelError, match=r"build\(length=2.0\) took longer than most_seconds=0.1. Nothing was run"):
        kf.Study(hangs, lowest, duration=0.1, length=[2.0, 3.0]).run("serial", most_seconds=0.1)


@pytest.mark.parametrize("given", [0.0, -1.0, np.nan, np.inf, "1", True, 1e300])
def test_a_limit_that_is_none_is_refused(given: Any, study: kf.Study, tmp_path: Any) -> None:
    with pytest.raises(kf.ModelError, match=r"most_seconds must be above zero, in s, not .*Remedy: None"):
        study.run("serial", store=tmp_path / "store", most_seconds=given)
    assert not (tmp_path / "store").exists()


def test_an_alarm_of_the_user_stays() -> None:
    rung = []
    before = signal.signal(signal.SIGALRM, lambda *_: rung.append(1))
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        assert within(60.0, lambda: "done") == "done"
        assert within(30.0, lambda: time.sleep(0.01)) is None
        deadline = time.monotonic() + 10.0
        while not rung and time.monotonic() < deadline:
            time.sleep(0.01)
        assert rung == [1]
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


class Builder:
    """Builds a scene when it is called."""

    def __init__(self, angle: float) -> None:
        self.angle = angle

    def __call__(self, length: float) -> kf.System:
        return pendulum(length, self.angle)


TYPED_IN = """
import kanefe as kf
def build(length):
    scene = kf.System(gravity=(0.0, -G, 0.0))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(length, 0, 0), joint=kf.Revolute("z"))
    return scene
"""


def typed_in(gravity: float) -> Any:
    space: dict[str, Any] = {"__name__": "__main__", "G": gravity}
    exec(compile(TYPED_IN, "<stdin>", "exec"), space)
    return space["build"]


def other_builder() -> Any:
    """Return an object of a class of the same name, that does something else."""

    class Builder:
        def __init__(self) -> None:
            self.angle = 0.1

        def __call__(self, length: float) -> kf.System:
            return pendulum(2.0 * length, self.angle)

    Builder.__qualname__ = "Builder"
    return Builder()


MADE: dict[str, tuple[Any, Any]] = {
    "partial": (lambda: partial(pendulum, angle=0.1), lambda: partial(pendulum, angle=0.2)),
    "object": (lambda: Builder(0.1), lambda: Builder(0.2)),
    "method": (lambda: Builder(0.1).__call__, lambda: Builder(0.2).__call__),
    "class": (lambda: Builder(0.1), other_builder),
    "typed in": (lambda: typed_in(9.81), lambda: typed_in(1.6)),
}


@pytest.mark.parametrize(("make", "other"), MADE.values(), ids=MADE)
def test_a_study_is_known_by_its_content(make: Any, other: Any, tmp_path: Any) -> None:
    def study(build: Any) -> kf.Study:
        options = {"events": kf.Event("down", lambda t, state: t - 0.05)}
        return kf.Study(build, lambda result: {"a": 1.0}, duration=0.1, simulate=options, length=[1.0, 2.0])

    study(make()).run("serial", store=tmp_path)
    again = study(make())
    assert again.run("serial", store=tmp_path).counts["finished"] == 2
    assert len(list((tmp_path / "rows").iterdir())) == 1
    assert " at 0x" not in (tmp_path / "study.json").read_text()
    with pytest.raises(kf.FileError, match="contains another study: it differs in"):
        study(other()).run("serial", store=tmp_path)


def test_what_a_module_of_the_user_does_counts(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    found = []
    for factor in ("1.0", "2.0"):
        (tmp_path / "my_parts.py").write_text(f"def long(length):\n    return {factor} * length\n")
        sys.modules.pop("my_parts", None)
        importlib.invalidate_caches()
        monkeypatch.setattr(sys, "dont_write_bytecode", True)
        space = {"my_parts": importlib.import_module("my_parts"), "pendulum": pendulum}
        exec("def build(length): return pendulum(my_parts.long(length), 0.0)", space)
        found.append(kf.Study(space["build"], lowest, duration=0.1, length=1.0)._identity)
    sys.modules.pop("my_parts")
    assert found[0] != found[1]


ROW = {"length": 1.0, "angle": 0.0}

BAD: dict[str, tuple[dict[str, Any], str]] = {
    "no function": ({"build": 3}, "build must be a function"),
    "no outputs": ({"outputs": None, **ROW}, "outputs must be a function"),
    "no parameter": ({"build": lambda: None}, "a study needs a parameter"),
    "unknown parameter": ({**ROW, "mass": 1.0}, "unexpected keyword argument 'mass'"),
    "parameter missing": ({"length": 1.0}, "missing a required argument: 'angle'"),
    "name of an option": ({"build": with_option, "duration": 1.0, "a": 1}, "duration is an option of Study"),
    "name of a column": ({"build": lambda status: None, "status": 1}, "status is a column"),
    "no values": ({**ROW, "length": []}, "length has no values"),
    "not a number": ({**ROW, "length": np.nan}, "length is nan"),
    "a value twice": ({**ROW, "length": [1.0, 1.0]}, "length has the value 1.0 twice"),
    "an object": ({**ROW, "length": [kf.System()]}, "length is a System"),
    "a mapping": ({**ROW, "length": {1: 2}}, "length are a mapping"),
    "no rows": ({"table": []}, "the table has no rows"),
    "no table": ({"table": {"length": [1.0]}}, "table must be a sequence of mappings"),
    "no row": ({"table": [3]}, "row 0 of the table is not a mapping"),
    "other rows": ({"table": [ROW, {"length": 1.0}]}, "row 1 of the table has length, row 0 has angle, length"),
    "a row twice": ({"table": [ROW, ROW]}, "the table has the row"),
    "in both": ({"table": [{"length": 1.0}], **ROW}, "length is in the table"),
    "option of screened runs": ({**ROW, "simulate": {"spacing": 0.1}}, "simulate takes no spacing"),
    "unknown option": ({**ROW, "simulate": {"speed": 3}}, "simulate takes no speed"),
    "no end": ({**ROW, "length": itertools.count(1)}, "the values of length are more than 1000: count may be infinite"),
    "a range without an end": ({**ROW, "length": range(10**12)}, "the values of length are more than 1000: range"),
    "rows without an end": (
        {"table": ({"length": i} for i in itertools.count())},
        "the rows of the table are more than",
    ),
    "option twice": ({**ROW, "duration": 1.0, "simulate": {"t_span": (0, 2)}}, "duration is given twice"),
}


@pytest.mark.parametrize(("given", "message"), BAD.values(), ids=BAD)
def test_bad_input_is_refused(given: dict[str, Any], message: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("kanefe.studies.cases.MOST_VALUES", 1000)
    with pytest.raises(kf.ModelError, match=message):
        kf.Study(**{"build": pendulum, "outputs": lowest, **given})


def raises(length: float) -> kf.System:
    raise ZeroDivisionError(f"length {length}")


def returns_a_number(length: float) -> float:
    return length


def checkpoints(length: float) -> tuple[kf.System, dict[str, Any]]:
    return pendulum(length, 0.0), {"checkpoint": "run.npz"}


generator = np.random.default_rng()


def draws(length: float) -> kf.System:
    return pendulum(length, generator.random())


BEFORE = {
    "build raises": (
        raises,
        {"duration": 1.0},
        r"build\(length=1.0\) raised ZeroDivisionError: length 1.0. Nothing was",
    ),
    "no scene": (returns_a_number, {"duration": 1.0}, "build returned float, not a scene"),
    "no span": (lambda length: pendulum(length, 0.0), {}, "the runs have no time span. Remedy: Study"),
    "own checkpoint": (checkpoints, {"duration": 1.0}, "checkpoint cannot be given to the runs of a study"),
    "bad option": (
        lambda length: pendulum(length, 0.0),
        {"duration": 1.0, "rtol": 2.0},
        "rtol must lie between 0 and 1",
    ),
    "bad span": (lambda length: pendulum(length, 0.0), {"duration": -1.0}, "t_span|span"),
}


@pytest.mark.parametrize(("build", "options", "message"), BEFORE.values(), ids=BEFORE)
def test_what_is_wrong_with_all_is_told_before_the_first_run(build: Any, options: Any, message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        kf.Study(build, lowest, length=[1.0, 2.0], **options).run("serial")


def test_what_draws_by_chance_is_no_study() -> None:
    with pytest.raises(kf.ModelError, match=r"cannot be distinguished from other studies: .*generator"):
        kf.Study(draws, lowest, length=1.0)


def test_bad_outputs_are_told_in_the_row() -> None:
    for outputs, message in (
        (lambda result: 3.0, "it returned float, not a dict"),
        (lambda result: {"length": 1.0}, "'length' is a parameter or another column"),
        (lambda result: {"status": 1.0}, "'status' is a parameter or another column"),
        (lambda result: {"one": 1j}, "'one' is a complex"),
        ([lowest, lowest], "two outputs are called lowest"),
    ):
        table = kf.Study(pendulum, outputs, duration=0.1, length=1.0, angle=0.0).run("serial")
        assert message in table.lists()["reason"][0]


def test_a_worker_with_another_kanefe_runs_nothing(study: kf.Study) -> None:
    with pytest.raises(
        kf.SimulationError, match=r"has kanefe .*, the study has 9.9. Remedy: the same version everywhere"
    ):
        run_block(study._work, "9.9", [])
    assert run_block(study._work, stamp(), []).cases == 0


def test_warnings_of_threads_are_kept_apart() -> None:
    import threading

    found: dict[str, list[str]] = {}
    together = threading.Barrier(2)

    def warned(name: str) -> None:
        with CaseWarnings() as told:
            together.wait()
            for _ in range(2):
                warnings.warn(f"of {name}", UserWarning, stacklevel=1)
            together.wait()
        found[name] = told.texts

    threads = [threading.Thread(target=warned, args=(name,)) for name in "ab"]
    shown = warnings.showwarning
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {name: [f"UserWarning: of {name}"] for name in "ab"}
    assert warnings.showwarning is shown


def test_ctrl_c_leaves_what_is_done(tmp_path: Any) -> None:
    calls = []

    class Interrupted:
        def __call__(self, result: kf.Result) -> dict[str, Any]:
            calls.append(result)
            if len(calls) == 2:
                raise KeyboardInterrupt
            return lowest(result)

        def __reduce__(self) -> str:
            return "Interrupted"

    study = kf.Study(pendulum, Interrupted(), duration=0.1, length=1.0, angle=[0.0, 0.1, 0.2])
    with pytest.warns(kf.SimulationWarning, match="stopped by Ctrl-C"):
        table = study.run("serial", store=tmp_path / "store")
    assert table.counts == {"finished": 1, "stopped": 0, "failed": 0, "not run": 2}
    assert study.run("serial", store=tmp_path / "store").counts["finished"] == 3
    assert len(calls) == 4


def test_ctrl_c_within_a_run_is_no_end_of_it() -> None:
    def interrupts(t: float) -> float:
        if t > 0.05:
            raise KeyboardInterrupt
        return 0.0

    def build(angle: float) -> kf.System:
        scene, rod = hinged(1.0, angle)
        scene.add_torque(rod, interrupts)
        return scene

    with pytest.warns(kf.SimulationWarning, match="stopped by Ctrl-C"):
        table = kf.Study(build, lowest, duration=0.1, angle=[0.0, 0.1]).run("serial")
    assert table.counts["not run"] == 2


def test_a_table_is_a_data_set_over_its_parameters() -> None:
    pytest.importorskip("xarray")
    table = kf.Study(pendulum, lowest, duration=0.1, **GRID).run("serial")
    found = table.to_xarray()
    assert found["lowest"].dims == ("length", "angle", "seed")
    one = found.sel(length=1.0, angle=0.3, seed=2)
    assert float(one["lowest"]) == table.column("lowest")[-1]
    assert str(one["status"].values) == "finished"
    rows = kf.Study(
        pendulum, lowest, table=[{"length": 0.5 + 0.1 * i, "angle": 0.1 * i} for i in range(5)], duration=0.1
    )
    samples = rows.run("serial")
    assert samples.to_xarray()["lowest"].dims == ("case",)
    assert samples.to_xarray()["length"].values.tolist() == samples.column("length").tolist()


def test_every_column_is_one_array_of_its_file_whatever_its_name(tmp_path: Path) -> None:
    """A "/" made groups, and the columns a and a/b together an error of h5py."""
    h5py = pytest.importorskip("h5py")

    def named(result: kf.Result) -> dict[str, float | bool]:
        return {
            "peak": 1.0,
            "peak/limit": 2.0,
            "peak [m/s]": 3.0,
            "in %": 4.0,
            ".": 5.0,
            "is good": result.times[-1] > 0,
        }

    table = kf.Study(pendulum, named, duration=0.1, length=[0.5, 1.0], angle=0.1).run("serial")
    with h5py.File(table.save(tmp_path / "table.h5")) as file:
        assert {urllib.parse.unquote(name) for name in file} == set(table.lists())
        assert file["peak [m%2Fs]"][:].tolist() == [3.0, 3.0]
        assert file["is good"].dtype == np.int8
        assert file["is good"][:].tolist() == [1, 1]


def test_a_data_set_of_any_names_is_saved_by_xarray(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")

    def named(result: kf.Result) -> dict[str, float | bool]:
        return {"peak [m/s]": 1.0, "is good": True}

    found = kf.Study(pendulum, named, duration=0.1, length=[0.5, 1.0], angle=0.1).run("serial").to_xarray()
    assert found["peak [m.s]"].attrs == {"long_name": "peak [m/s]"}
    found.to_netcdf(tmp_path / "table.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "table.nc", engine="h5netcdf") as read:
        assert read["peak [m.s]"].values.tolist() == [[1.0], [1.0]]


def test_files_that_others_left_open_are_no_warning_of_a_case() -> None:
    """They are told when the garbage collector comes by, so that rows would depend on what was run before."""
    with pytest.warns(ResourceWarning, match="left open"), CaseWarnings() as told:
        warnings.warn("left open", ResourceWarning, stacklevel=1)
    assert told.texts == []
