"""Bodies made from a mesh, through the cache: a second run makes nothing, and nothing stale is ever taken."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import textwrap
import threading
import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from fem_meshes import STEEL, box
from kanefe.bodies import cache
from kanefe_fem import body_cache
from kanefe_fem.body_cache import cached_body, is_whole
from kanefe_fem.lumped.parts import LumpedMass
from kanefe_fem.materials.isotropic import AccuracyWarning, Material
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.preload import Preload
from repository import ARM
from whole_signatures import whole_signature

ENDS = {"root": "clamped", "tip": "rigid"}
MESH = box("hexahedron", (4, 1, 1), (1.0, 0.1, 0.1))


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("KANEFE_CACHE", "1")
    monkeypatch.setenv("KANEFE_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache" / "bodies"


def of_bar(**change: Any) -> kf.FlexibleBody:
    given = {"mesh": MESH, "materials": STEEL, "interfaces": ENDS, "reduction": kf.CraigBampton(modes=3), "order": 2}
    return solid_body(**{**given, **change})


def was_found(body: kf.FlexibleBody) -> bool:
    return bool(body.provenance["cache"]["found"])


@pytest.mark.fenicsx
class TestSolidBody:
    def test_the_second_body_is_the_first_one(self, folder: Path) -> None:
        first, second = of_bar(), of_bar()
        assert not was_found(first)
        assert was_found(second)
        for name in ("nodes", "basis", "stiffness", "damping", "inertia_basis"):
            np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
        assert second.provenance["materials"] == first.provenance["materials"]
        assert sorted(entry.kind or "" for entry in cache.entries()) == ["body", "model"]

    def test_it_can_be_turned_off(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        of_bar(cache=False)
        monkeypatch.setenv("KANEFE_CACHE", "0")
        of_bar()
        assert not folder.exists()

    @pytest.mark.parametrize(
        "change",
        [
            {"materials": Material(E=210e9, nu=0.3, rho=7850.1, name="steel")},
            {"mesh": box("hexahedron", (4, 1, 1), (1.0, 0.1, 0.1000001))},
            {"interfaces": {"tip": "rigid", "root": "clamped"}},
            {"interfaces": {"root": "clamped", "tip": "hinged"}},
            {"reduction": kf.CraigBampton(modes=4)},
            {"damping": kf.ModalDamping(0.01)},
            {"order": 1},
            {"surfaces": ["tip"]},
        ],
        ids=lambda change: next(iter(change)),
    )
    def test_every_change_makes_a_new_body(self, change: dict[str, Any]) -> None:
        of_bar()
        assert not was_found(of_bar(**change))

    def test_a_change_of_code_makes_a_new_body(self, monkeypatch: pytest.MonkeyPatch) -> None:
        of_bar()
        monkeypatch.setattr(body_cache, "code_stamp", lambda *folders: "another version")
        assert not was_found(of_bar())

    def test_a_damaged_file_is_made_again(self, folder: Path) -> None:
        of_bar()
        for path in folder.iterdir():
            path.write_bytes(path.read_bytes()[:5000])
        with pytest.warns(cache.CacheWarning, match="made again") as warned:
            assert not was_found(of_bar())
        assert len(warned) == 2
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # that the files were damaged is nothing of the body
            assert was_found(of_bar())

    def test_warnings_come_again(self) -> None:
        rubber = Material(E=2.1e11, nu=0.499, rho=7850.0)
        with pytest.warns(AccuracyWarning) as first:
            of_bar(materials=rubber, order=1)
        with pytest.warns(AccuracyWarning) as second:
            assert was_found(of_bar(materials=rubber, order=1))
        assert [str(w.message) for w in second] == [str(w.message) for w in first]

    def test_a_warning_is_kept_by_its_word(self) -> None:
        with pytest.warns(AccuracyWarning):
            body = of_bar(materials=Material(E=2.1e11, nu=0.499, rho=7850.0), order=1)
        assert {word for word, _ in body.provenance["warnings"]} == {"accuracy"}

    def test_every_option_is_in_the_key(self, monkeypatch: pytest.MonkeyPatch) -> None:
        taken: dict[str, Any] = {}

        def take(mesh: Any, options: dict[str, Any], make: Any) -> SimpleNamespace:
            taken.update(options)
            return SimpleNamespace()

        monkeypatch.setattr(body_cache, "cached_body", take)
        of_bar()
        others = {"mesh", "cache", "progress", "comm"}  # a body is the same for any number of processes
        assert {*taken, *others} == {*whole_signature(solid_body).parameters}

    def test_an_unreduced_body_is_not_kept(self) -> None:
        body = of_bar(mesh=box("hexahedron", (12, 2, 2), (1.0, 0.1, 0.1)), reduction=None)
        assert body.provenance["cache"]["skipped"] == "the body is not reduced"


def model_was_found(body: kf.FlexibleBody) -> bool:
    return bool(body.provenance["cache"]["model"]["found"])


@pytest.mark.fenicsx
class TestModel:
    """Bodies of the same mesh, materials and order have one assembled model."""

    @pytest.mark.parametrize(
        "change",
        [
            {"reduction": kf.CraigBampton(modes=4)},
            {"reduction": None},
            {"interfaces": {"tip": "clamped", "root": "average"}},
            {"damping": kf.ModalDamping(0.01)},
        ],
        ids=lambda change: next(iter(change)),
    )
    @pytest.mark.parametrize("lumped", [(), (LumpedMass("tip", mass=2.0),)], ids=["bare", "lumped"])
    def test_what_is_done_with_the_matrices_does_not_matter(self, change: dict[str, Any], lumped: Any) -> None:
        of_bar(lumped=lumped)
        body = of_bar(lumped=lumped, **change)
        assert not was_found(body)
        assert model_was_found(body)
        fresh = of_bar(lumped=lumped, cache=False, **change)
        assert type(body) is type(fresh)
        for name in ("nodes", "basis", "stiffness", "damping", "inertia_points", "inertia_basis"):
            np.testing.assert_array_equal(getattr(body, name), getattr(fresh, name))
        assert (body.inertia_mass != fresh.inertia_mass).nnz == 0

    def test_an_unreduced_body_is_made_of_it(self) -> None:
        mesh = box("hexahedron", (12, 2, 2), (1.0, 0.1, 0.1))
        of_bar(mesh=mesh)
        body, fresh = of_bar(mesh=mesh, reduction=None), of_bar(mesh=mesh, reduction=None, cache=False)
        assert model_was_found(body)
        assert (body.stiffness != fresh.stiffness).nnz == 0

    @pytest.mark.parametrize(
        "change",
        [
            {"materials": Material(E=211e9, nu=0.3, rho=7850.0, name="steel")},
            {"mesh": box("hexahedron", (4, 1, 1), (1.0, 0.1, 0.1000001))},
            {"order": 1},
            {"surfaces": ["tip"]},
            {"densities": {"bar": 7000.0}},
            {"lumped": (LumpedMass("tip", mass=2.0),)},
        ],
        ids=lambda change: next(iter(change)),
    )
    def test_what_is_assembled_makes_a_new_one(self, change: dict[str, Any]) -> None:
        of_bar()
        assert not model_was_found(of_bar(**change))

    @pytest.mark.parametrize(
        "change",
        [{"stiffening": "inertial"}, {"preload": Preload({"root": "xyz"}, acceleration=(0.0, 0.0, -9.81))}],
        ids=lambda change: next(iter(change)),
    )
    def test_stiffening_and_a_preload_are_assembled(self, change: dict[str, Any]) -> None:
        of_bar()
        count = len(cache.entries())
        body = of_bar(**change)
        assert "model" not in body.provenance["cache"]
        assert len(cache.entries()) == count + 1  # the body

    def test_warnings_come_again(self) -> None:
        rubber = Material(E=2.1e11, nu=0.499, rho=7850.0)
        with pytest.warns(AccuracyWarning) as first:
            of_bar(materials=rubber, order=1)
        with pytest.warns(AccuracyWarning) as second:
            body = of_bar(materials=rubber, order=1, reduction=kf.CraigBampton(modes=4))
        assert model_was_found(body)
        assert [str(w.message) for w in second] == [str(w.message) for w in first]
        with pytest.warns(AccuracyWarning) as third:  # of the body that was made of a model from the cache
            assert was_found(of_bar(materials=rubber, order=1, reduction=kf.CraigBampton(modes=4)))
        assert [str(w.message) for w in third] == [str(w.message) for w in first]

    @pytest.mark.parametrize("interfaces", [{"rot": "clamped"}, {"bar": "rigid"}, {"root": "welded"}, "root"], ids=str)
    def test_interfaces_are_refused_in_the_same_words(self, interfaces: Any) -> None:
        with pytest.raises(kf.ModelError) as fresh:
            of_bar(interfaces=interfaces, cache=False)
        of_bar()
        with pytest.raises(kf.ModelError) as found:
            of_bar(interfaces=interfaces)
        assert str(found.value) == str(fresh.value)


SCENE = """
import sys
import kanefe as kf
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.solids.body import solid_body

arm = solid_body(sys.argv[1], Material(E=70e9, nu=0.33, rho=2700.0), {"root": "clamped", "tip": "rigid"},
                 reduction=kf.CraigBampton(modes=int(sys.argv[2])))
scene = kf.System(gravity=(0, 0, -9.81))
scene.add_flexible_body("arm", arm, joint=kf.Revolute("y"))
state = scene.freeze().initial_state
heavy = ("dolfinx", "petsc4py", "mpi4py", "gmsh", "meshio", "ufl", "basix")
print(arm.provenance["cache"]["found"], [name for name in heavy if name in sys.modules], arm.frequencies.tolist())
"""


@pytest.mark.fenicsx
@pytest.mark.gmsh
def test_a_second_run_neither_reads_the_mesh_nor_assembles(tmp_path: Path) -> None:
    def run(modes: int = 4) -> str:
        return subprocess.run(
            [sys.executable, "-c", textwrap.dedent(SCENE), str(ARM), str(modes)],
            capture_output=True,
            text=True,
            env={**os.environ, "KANEFE_JIT": "0"},
            check=True,
        ).stdout

    first, second = run(), run()
    assert first.startswith("False ['dolfinx'")
    assert second.startswith("True [] ")
    assert first[first.rindex("[") :] == second[second.rindex("[") :]  # the same frequencies, digit by digit
    other = run(modes=5)  # of the model of the first: its factorisation is all that is done again
    assert "dolfinx" not in other
    assert "gmsh" not in other
    frequencies = (json.loads(text[text.rindex("[") :]) for text in (first, other))
    # the highest of those with the tip held may mix with the next one
    assert next(frequencies)[:6] == pytest.approx(next(frequencies)[:6], rel=1e-2)


class TestMeshFiles:
    """What the bytes of a file say about the mesh; `make` stands for the making of a body."""

    @pytest.fixture
    def made(self) -> list[Any]:
        return []

    def body(self, mesh: Any, made: list[Any], **options: Any) -> kf.FlexibleBody:
        from scenes import lattice_body

        def make(given: Any) -> kf.FlexibleBody:
            made.append(given)
            return lattice_body(0)

        return cached_body(mesh, options, make)

    def test_the_folder_of_a_file_does_not_matter(self, tmp_path: Path, made: list[Any]) -> None:
        for name in ("a", "b"):
            (tmp_path / name).mkdir()
            (tmp_path / name / "arm.msh").write_text("$MeshFormat")
            self.body(str(tmp_path / name / "arm.msh"), made)
        assert len(made) == 1
        (tmp_path / "b" / "arm.msh").write_text("$MeshFormat ")
        self.body(tmp_path / "b" / "arm.msh", made)
        assert len(made) == 2

    def test_a_missing_file_is_left_to_the_reader(self, tmp_path: Path) -> None:
        with pytest.raises(kf.FileError, match="there is no mesh file"):
            solid_body(tmp_path / "no.msh", STEEL, ENDS, reduction=kf.CraigBampton(modes=2))

    def test_a_source_that_reads_other_files_is_known_by_its_mesh(
        self, tmp_path: Path, made: list[Any], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        length, source = tmp_path / "length.txt", tmp_path / "bar.py"

        def read(path: Path, **options: Any) -> Mesh:
            return box("hexahedron", (4, 1, 1), (float(length.read_text()), 0.1, 0.1))

        monkeypatch.setattr("kanefe_fem.mesh_files.read_mesh", read)
        source.write_text("length = 1.0")
        self.body(source, made)
        assert made == [source]  # whoever makes the body reads it
        source.write_text("length = float(open('length.txt').read())")
        for text, count in (("1.0", 2), ("1.0", 2), ("1.5", 3)):
            length.write_text(text)
            self.body(source, made)
            assert isinstance(made[-1], Mesh)
            assert len(made) == count

    @pytest.mark.parametrize(
        ("name", "text", "whole"),
        [
            ("a.msh", "Include", True),
            ("a.xdmf", "", False),  # its numbers are in another file
            ("a.geo", "Point(1) = {0, 0, 0};", True),
            ("a.geo", 'Include "points.geo";', False),
            ("a.geo", 'Merge "part.step";', False),
            ("a.py", "import math\ndef build(gmsh):\n    gmsh.model.add(str(math.pi))\n", True),
            ("a.py", "import numpy as np\nfrom math import pi\n", True),
            ("a.py", "from sizes import h\n", False),
            ("a.py", "from . import sizes\n", False),
            ("a.py", "import os\n", False),
            ("a.py", "h = float(open('h.txt').read())\n", False),
            ("a.py", "import numpy as np\nx = np.loadtxt('x.txt')\n", False),
            ("a.py", "def build(gmsh):\n    gmsh.merge('part.step')\n", False),
            ("a.py", "def build(:\n", False),
        ],
    )
    def test_which_files_say_all(self, name: str, text: str, whole: bool, tmp_path: Path) -> None:
        (tmp_path / name).write_text(text)
        assert is_whole(tmp_path / name) is whole

    def test_an_option_whose_content_cannot_be_told_is_said(self, folder: Path, made: list[Any]) -> None:
        for _ in range(2):
            body = self.body(MESH, made, energy=threading.Lock().acquire)
            assert "energy is an object of" in body.provenance["cache"]["skipped"]
        assert len(made) == 2
        assert not folder.exists()

    def test_a_function_is_known_by_its_code(self, made: list[Any]) -> None:
        for power in (2, 2, 3):
            self.body(MESH, made, energy=lambda strain, power=power: strain**power)
        assert len(made) == 2
