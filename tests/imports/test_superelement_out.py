"""Bodies as superelements of OpenFAST, Nastran and Abaqus, against dense Craig-Bampton matrices, and read back."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.imports.nodal_inertia import NodalFormWarning
from kanefe.imports.superelement import superelement
from kanefe_fem.beams.body import beam_body
from steel_beams import craig_bampton, steel_beam

FULL = steel_beam(20)
KINDS = {"root": "clamped", "tip": "rigid"}
MODES = 6


@pytest.fixture(scope="module")
def body() -> kf.FlexibleBody:
    return beam_body(FULL, KINDS, kf.CraigBampton(modes=MODES), kf.RayleighDamping(0.3, 1e-4))


def dense(boundary: list[int]) -> tuple[np.ndarray, np.ndarray]:
    T = craig_bampton(FULL, boundary, MODES)
    return T.T @ FULL.mass @ T, T.T @ FULL.stiffness @ T


def same(found: np.ndarray, wanted: np.ndarray, nodal: int) -> None:
    """Compare matrices whose modes may have either sign."""
    sign = np.ones(len(found))
    sign[nodal:] = np.sign(np.einsum("ij,ij->j", found[:nodal, nodal:], wanted[:nodal, nodal:]))
    sign[sign == 0.0] = 1.0
    scale = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
    np.testing.assert_allclose(sign[:, None] * found * sign / scale, wanted / scale, atol=1e-7)


def test_the_matrices_are_those_of_craig_and_bampton(body):
    frames = [body.interface("root"), body.interface("tip")]
    found = superelement(body, frames)
    M, K = dense([0, 20])
    assert found.modes == MODES
    same(found.stiffness, K, 12)
    np.testing.assert_allclose(found.mass[:12, :12], M[:12, :12], rtol=0, atol=1e-7 * abs(M[:12, :12]).max())
    rigid = np.linalg.eigh(found.stiffness[:12, :12])[1][:, :6]
    # dampers inside a body do nothing in a rigid motion
    assert abs(found.damping[:12, :12] @ rigid).max() < 1e-7 * abs(found.damping).max()
    held = superelement(body, frames[1:])
    squares = scipy.linalg.eigh(held.stiffness, held.mass, eigvals_only=True)
    assert np.sqrt(squares) / (2.0 * np.pi) == pytest.approx(body.frequencies, rel=1e-8)
    damped = scipy.linalg.eigh(held.damping, held.mass, eigvals_only=True)
    assert damped == pytest.approx(0.3 + 1e-4 * squares, rel=1e-6)


def test_nastran_is_read_back(body, tmp_path):
    path = tmp_path / "beam.bdf"
    assert kf.write_superelement(body, path, "nastran") == {"root": 1, "tip": 2} | {
        f"mode {i}": 1000 + i for i in range(1, MODES + 1)
    }
    with pytest.warns(NodalFormWarning):
        model = kf.read_nastran(path, path)
    assert (len(model.nodes), model.generalised) == (2, MODES)
    found = superelement(body, body.interfaces)
    # numbers of sixteen letters have ten digits
    np.testing.assert_allclose(model.stiffness.toarray(), found.stiffness, atol=1e-9 * abs(found.stiffness).max())
    np.testing.assert_allclose(model.mass.toarray(), found.mass, atol=1e-9 * abs(found.mass).max())
    np.testing.assert_allclose(model.damping.toarray(), found.damping, atol=1e-9 * abs(found.damping).max())


def test_abaqus_is_read_back(body, tmp_path):
    path = tmp_path / "beam.inp"
    kf.write_superelement(body, path, "abaqus", modes=0)
    model = kf.read_abaqus(path, substructure=path)
    found = superelement(body, body.interfaces, 0)
    np.testing.assert_allclose(model.stiffness.toarray(), found.stiffness, rtol=1e-14)
    np.testing.assert_allclose(model.mass.toarray(), found.mass, rtol=1e-14)
    assert set(model.groups) >= {"ROOT", "TIP"}
    kf.write_superelement(body, path, "abaqus")
    text = path.read_text()
    assert f"NODES={2 + MODES}, LINEAR" in text
    assert re.search(r"^3, 1$", text, re.MULTILINE)  # from the third node on, a mode each


def read_openfast(path: Path) -> dict[str, np.ndarray]:
    """Read the file as its documentation says: after each head of a matrix one comment, then as many rows as it has."""
    lines = path.read_text().splitlines()
    assert "flex 5 format" in lines[1].lower()
    n = int(next(line for line in lines if line.lower().startswith("!dimension:")).split(":")[1])
    found = {}
    for name in ("Mass", "Stiffness", "Damping", "Loading"):
        at = next(i for i, line in enumerate(lines) if line.startswith(f"!{name}"))
        found[name] = np.array([[float(x) for x in line.split()] for line in lines[at + 2 : at + 2 + n] if line])
    return found


def test_openfast_has_the_matrices_of_one_interface(body, tmp_path):
    path = tmp_path / "tower_SE.dat"
    numbers = kf.write_superelement(body, path, "openfast", modes=4)
    assert list(numbers) == ["tip", "mode 1", "mode 2", "mode 3", "mode 4"]
    found, wanted = read_openfast(path), superelement(body, [body.interface("tip")], 4)
    assert found["Stiffness"] == pytest.approx(wanted.stiffness, rel=1e-14)
    assert found["Mass"] == pytest.approx(wanted.mass, rel=1e-14)
    assert found["Damping"] == pytest.approx(wanted.damping, rel=1e-14)
    assert found["Loading"].shape == (2, 11)
    assert not found["Loading"][:, 1:].any()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"form": "openfast", "boundary": ["root", "tip"]}, "has one interface, of six motions"),
        ({"form": "nastran", "boundary": []}, "needs an interface"),
        ({"form": "nastran", "boundary": ["hub"]}, "no interface called 'hub'"),
        ({"form": "ansys"}, "form"),
    ],
)
def test_refusals(body, tmp_path, options: dict[str, Any], message):
    with pytest.raises(ModelError, match=message):
        kf.write_superelement(body, tmp_path / "x", **options)
    assert not (tmp_path / "x").exists()


def test_bodies_without_static_shapes_are_refused(tmp_path):
    modal = beam_body(FULL, {"root": "clamped", "tip": "rigid"}, kf.FreeInterface(modes=3, attachment=False))
    with pytest.raises(ModelError, match="do not move by themselves"):
        kf.write_superelement(modal, tmp_path / "x", "openfast")
