"""``kanefe verify``: kanefe's own cases pass, a miss is a miss, and the results come out as promised."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kanefe.checks.verification import Case, Check, dumbbell, loops, rigid, rotations, runner, simeon
from kanefe.checks.verification.references import load_references
from kanefe.checks.verification.registry import registered_cases
from kanefe.checks.verification.report import Row
from kanefe.errors import FileError, MissingDependency, ModelError, SimulationError

OWN = (*rigid.CASES, *rotations.CASES, *dumbbell.CASES, *simeon.CASES)
KEYS = ["case", "quantity", "value", "reference", "error", "tolerance", "seconds", "passed"]
CHECK = Check("length [m] (abs)", 1.0, 1.0, 0.0, 1e-14)


def only(monkeypatch, *cases):
    monkeypatch.setattr(runner, "registered_cases", lambda: cases)


@pytest.mark.parametrize("case", [*OWN, *loops.CASES], ids=lambda case: case.id)
def test_case_passes(case):
    rows = list(runner.run_case(case))
    assert rows
    assert [row for row in rows if not row.passed] == []


def test_the_registry_has_the_cases_of_the_plugin_and_all_have_references():
    assert {case.id for case in registered_cases()} == set(load_references())


@pytest.mark.parametrize("case", [c for c in OWN if c.id in ("A01", "E03")], ids=lambda case: case.id)
def test_a_wrong_reference_is_a_miss(monkeypatch, tmp_path, capsys, case):
    """One number of the reference is moved by 1e-6, ten tolerances at least."""
    right = load_references()[case.id]
    text = json.dumps(right.values)
    moved = {
        "A01": ("0.9862917511318753", "0.9862927511318753"),
        "E03": ("0.7233174113647117", "0.7233184113647117"),
    }
    assert moved[case.id][0] in text
    wrong = replace(right, values=json.loads(text.replace(*moved[case.id])))
    monkeypatch.setattr(runner, "load_references", lambda: {case.id: wrong})
    path = tmp_path / "out.json"
    assert runner.verify([case.id], str(path)) == 1
    assert "MISSED" in capsys.readouterr().out
    passed = [row["passed"] for row in json.loads(path.read_text())]
    assert True in passed
    assert False in passed


def test_json_has_exactly_the_promised_keys(tmp_path, capsys):
    path = tmp_path / "out.json"
    assert runner.verify(["E03"], str(path)) == 0
    rows = json.loads(path.read_text())
    assert rows
    for row in rows:
        assert list(row) == KEYS
        assert row["case"] == "E03"
        assert row["passed"] is True
        assert all(isinstance(row[key], float) for key in KEYS[2:7])
        assert row["error"] <= row["tolerance"]
    assert [p.name for p in tmp_path.iterdir()] == ["out.json"]
    assert "value" in capsys.readouterr().out


def test_json_on_standard_output_is_json_alone(capsys):
    assert runner.verify(["E03"], "-") == 0
    output = capsys.readouterr()
    assert [list(row) for row in json.loads(output.out)] == [KEYS] * len(json.loads(output.out))
    assert "E03" in output.err


def test_ids_are_read_in_either_case(capsys):
    assert runner.verify(["e03"]) == 0
    assert "E03" in capsys.readouterr().out


def test_a_factor_without_sense_is_refused_before_anything_is_printed(capsys):
    with pytest.raises(ModelError, match="must"):
        runner.verify(["E03"], factor=0.0)
    assert capsys.readouterr() == ("", "")


def test_an_unknown_case_is_named_with_those_there_are():
    with pytest.raises(ModelError, match=r"'Z99'.*A01, A02, A03.*E03, E04"):
        runner.verify(["A01", "Z99"])


@pytest.mark.parametrize("place", ["missing/out.json", "."])
def test_a_place_that_cannot_be_written_is_refused_before_anything_runs(monkeypatch, tmp_path, place):
    def run(reference):
        pytest.fail("the case ran")

    only(monkeypatch, Case("E03", run))
    with pytest.raises(FileError, match="Remedy"):
        runner.verify([], str(tmp_path / place))


def test_an_old_file_survives_a_failure_to_write(monkeypatch, tmp_path):
    path = tmp_path / "out.json"
    path.write_text("old")
    only(monkeypatch, Case("E03", lambda reference: [CHECK]))

    def full(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("kanefe.storage.files.os.fsync", full)
    with pytest.raises(FileError, match="No space left"):
        runner.verify([], str(path))
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["out.json"]


@pytest.mark.parametrize(("asked", "code"), [([], 0), (["E03"], 1)])
def test_what_a_missing_package_means(monkeypatch, capsys, asked, code):
    def run(reference):
        yield CHECK
        raise MissingDependency("dolfinx", "solid_model", "make setup")

    only(monkeypatch, Case("E03", run))
    assert runner.verify(asked) == code
    assert "E03   not run: needs dolfinx" in capsys.readouterr().out


def test_a_run_that_cannot_be_finished_is_a_miss_and_the_others_go_on(monkeypatch, capsys):
    def run(reference):
        raise SimulationError("no step is small enough")

    only(monkeypatch, Case("E03", run), Case("E03", lambda reference: [CHECK]))
    assert runner.verify([], "-") == 1
    output = capsys.readouterr()
    failed, fine = json.loads(output.out)
    assert "no step is small enough" in failed["quantity"]
    assert (failed["passed"], failed["value"], failed["error"]) == (False, None, None)
    assert fine["passed"] is True


def test_too_few_modes_are_a_miss(monkeypatch, capsys):
    def run(reference):
        yield Check.relative("f 1-3 [Hz]", [1.0, 2.0], [1.0, 2.0, 3.0], 1e-14)

    only(monkeypatch, Case("E03", run))
    assert runner.verify() == 1
    assert "f 1-3 [Hz]" in capsys.readouterr().out


def test_a_value_that_is_no_number_does_not_pass():
    check = Check.absolute("x [m]", [1.0, np.nan], [1.0, 2.0], 1.0)
    assert not check.passed
    assert check.reference == 2.0


def test_the_worst_of_a_set_is_reported():
    check = Check.relative("x [m]", [1.0, 2.2, 3.0], [1.0, 2.0, 3.0], 0.2)
    assert (check.value, check.reference) == (2.2, 2.0)
    assert check.error == pytest.approx(0.1)
    assert check.quantity == "x [m] (rel, worst of 3)"


def test_sets_of_different_shape_are_refused():
    with pytest.raises(ValueError, match="shape"):
        Check.absolute("x [m]", [1.0, 2.0], [1.0], 1e-3)


def test_a_tolerance_that_the_reference_does_not_state_is_refused(monkeypatch):
    reference = load_references()["A01"]  # abs 1e-8 (rtol 1e-10 integrator)
    assert reference.allows(1e-8)
    assert reference.allows(1e-12)
    assert not reference.allows(1e-7)
    assert load_references()["B02a"].allows(0.01)  # written as 1%
    loose = Case("A01", lambda reference: [replace(CHECK, tolerance=1e-3)])
    with pytest.raises(ValueError, match="is not a tolerance"):
        list(runner.run_case(loose))


def test_rows_have_the_keys_of_the_json():
    assert list(Row.__dataclass_fields__) == KEYS
