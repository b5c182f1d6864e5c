"""The command ``kanefe reduce`` in one process: its arguments, and the body of `solid_body`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

import kanefe as kf
from kanefe.errors import KanefeError
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.materials.oriented import Oriented
from kanefe_fem.materials.orthotropic import Orthotropic
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids import reduce_command
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.reduce_command import _interfaces, _keywords, _materials

STEEL = "E=210e9, nu=0.3, rho=7850.0"


def test_materials_from_one_line() -> None:
    assert _materials(STEEL) == Material(E=210e9, nu=0.3, rho=7850.0)


def test_materials_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "parts.toml"
    path.write_text(
        f'[arm]\n{STEEL.replace(", ", chr(10))}\n[skin]\nclass = "Orthotropic"\nrho = 1600.0\n'
        + "\n".join(f"{name} = {value}" for name, value in ORTHOTROPIC.items())
    )
    assert _materials(str(path)) == {
        "arm": Material(E=210e9, nu=0.3, rho=7850.0),
        "skin": Orthotropic(rho=1600.0, **ORTHOTROPIC),
    }
    path.write_text(STEEL.replace(", ", "\n"))
    assert _materials(str(path)) == Material(E=210e9, nu=0.3, rho=7850.0)


ORTHOTROPIC = {
    **dict.fromkeys(("E1", "E2", "E3"), 10e9),
    **dict.fromkeys(("nu12", "nu13", "nu23"), 0.3),
    **dict.fromkeys(("G12", "G13", "G23"), 4e9),
}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("E=210e9, nu=0.3", "is incomplete"),
        ("E=210e9, nu=0.3, roh=7850", "Did you mean 'rho'"),
        ("210e9", "cannot be read"),
        ('class="Steel", E=1.0', "class='Steel' is no material"),
        ("none.toml", "none.toml cannot be read"),
    ],
)
def test_bad_materials_are_named(text: str, said: str) -> None:
    with pytest.raises(KanefeError, match=said):
        _materials(text)


def test_interfaces_and_keywords() -> None:
    assert _interfaces(["root=clamped", "a=b=rigid"]) == {"root": "clamped", "a=b": "rigid"}
    assert _keywords("order=1, densities={arm=2700.0}") == {"order": 1, "densities": {"arm": 2700.0}}
    for pairs in (["root"], ["=rigid"], ["root=rigid", "root=clamped"]):
        with pytest.raises(KanefeError, match="GROUP=KIND"):
            _interfaces(pairs)
    with pytest.raises(KanefeError, match="Did you mean 'order'"):
        _keywords("ordr=1")


@pytest.mark.fenicsx
@pytest.mark.gmsh
def test_the_body_is_that_of_solid_body(tmp_path: Path) -> None:
    mesh = Path(__file__).parents[3] / "meshes" / "arm.msh"
    app = typer.Typer()
    app.command()(reduce_command.reduce)
    out = tmp_path / "arm.npz"
    options = ["--materials", STEEL, "--interface", "root=clamped", "--interface", "tip=rigid", "--modes", "3"]
    more = ["--damping", "0.02", "--with", "order=1, cache=false", "-o", str(out)]
    done = CliRunner().invoke(app, [str(mesh), *options, *more], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    assert "coordinates" in done.stdout
    body = kf.FlexibleBody.load(out)
    expected = solid_body(
        mesh,
        Material(E=210e9, nu=0.3, rho=7850.0),
        {"root": "clamped", "tip": "rigid"},
        kf.CraigBampton(modes=3),
        kf.ModalDamping(0.02),
        order=1,
        cache=False,
    )
    assert np.array_equal(body.stiffness, expected.stiffness)
    assert np.array_equal(body.damping, expected.damping)
    refused = CliRunner().invoke(app, [str(mesh), *options, "-o", "arm.h5"])
    assert "must end with .npz" in str(refused.exception)


def test_what_one_process_does_alone_is_named() -> None:
    from kanefe_fem.solids.on_processes import refuse_one_process

    model = {"materials": Material(E=1e9, nu=0.3, rho=1e3), "preload": None, "forms": None, "lumped": ()}
    body = {"reduction": kf.CraigBampton(modes=2)}
    refuse_one_process(model, body)
    for wrong, said in (
        ({"preload": 1}, "preload"),
        ({"lumped": [1]}, "lumped"),
        ({"forms": 1}, "forms"),
    ):
        with pytest.raises(kf.ModelError, match=said):
            refuse_one_process({**model, **wrong}, body)
    with pytest.raises(kf.ModelError, match="reduction=None"):
        refuse_one_process(model, {"reduction": None})


@pytest.mark.parametrize(
    "loss", [{"damping": kf.RayleighDamping(stiffness=1e-5)}, {"loss_factor": 0.1}, {"prony": [(0.1, 1.0)]}], ids=str
)
def test_damping_of_materials_is_not_lost(loss: dict[str, Any]) -> None:
    """The second material has axes of its own, and its damping inside."""
    from kanefe_fem.materials.of_groups import cell_materials
    from kanefe_fem.solids.on_processes import refuse_assembly

    mesh, lossy = box_mesh((1.0, 0.1, 0.1), (2, 1, 1)), Material(E=1e9, nu=0.3, rho=1e3, **loss)
    refuse_assembly(mesh, cell_materials(mesh, {"body": Material(E=1e9, nu=0.3, rho=1e3)}, None, 1.0).losses)
    for one in (lossy, Oriented(lossy, np.eye(3))):
        with pytest.raises(kf.ModelError, match="damping of materials"):
            refuse_assembly(mesh, cell_materials(mesh, {"body": one}, None, 1.0).losses)


def test_groups_that_no_process_has_are_named() -> None:
    from kanefe_fem.solids.on_processes import check_owned

    nodes, groups = np.zeros((4, 3)), {"root": np.array([0, 1]), "tip": np.array([3])}
    check_owned([np.array([2, 0]), np.array([1, 3])], nodes, groups)
    with pytest.raises(kf.KanefeError, match=r"1 nodes .* node 3 at .* nodes of 'tip'"):
        check_owned([np.array([2, 0]), np.array([1])], nodes, groups)
    with pytest.raises(kf.KanefeError, match=r"node 0 at .* nodes of 'root'"):
        check_owned([np.array([2, 0]), np.array([0, 1, 3])], nodes, groups)


def test_a_number_is_no_communicator() -> None:
    with pytest.raises(kf.ModelError, match="not a communicator"):
        solid_body(box_mesh((1.0, 0.1, 0.1), (2, 1, 1)), Material(E=1e9, nu=0.3, rho=1e3), {}, comm=2)
