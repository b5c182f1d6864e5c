"""The sparse solver: MUMPS for large matrices, SuperLU for small ones, and a refusal of what is not held."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from fem_meshes import STEEL, box, shown
from kanefe.errors import ModelError
from kanefe.fe_model.factorise import splu_factorise
from kanefe.fe_model.progress import stages
from kanefe_fem import _petsc
from kanefe_fem._petsc import SMALL, MumpsFactor, factorise
from kanefe_fem.machine import factor_plan
from kanefe_fem.machine.memory import MemoryWarning, free_memory
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.model import solid_model
from repository import ARM

pytestmark = [pytest.mark.fenicsx, pytest.mark.gmsh]


@pytest.fixture(scope="module")
def model():
    return solid_model(ARM, Material(E=70e9, nu=0.33, rho=2700.0))


@pytest.fixture(scope="module")
def held(model):
    fixed = (3 * model.groups["root"].nodes[:, None] + np.arange(3)).reshape(-1)
    free = np.setdiff1d(np.arange(model.size), fixed)
    return model.stiffness[free][:, free].tocsc()


class TestFactorise:
    def test_it_solves_for_one_and_for_many(self, held):
        assert held.shape[0] > SMALL
        factor = factorise(held)
        assert isinstance(factor, MumpsFactor)
        rhs = np.random.default_rng(0).standard_normal((held.shape[0], 5))
        kept = rhs.copy()
        many = factor.solve(rhs)
        one = factor.solve(rhs[:, 2])
        np.testing.assert_array_equal(rhs, kept)
        assert many.shape == rhs.shape
        assert one.shape == (held.shape[0],)
        # backward error of a direct solver
        assert np.abs(held @ many - rhs).max() < 1e-12 * abs(held).max() * np.abs(many).max()
        np.testing.assert_allclose(many[:, 2], one, rtol=0, atol=1e-10 * np.abs(one).max())
        np.testing.assert_allclose(factor.solve(np.asfortranarray(rhs)), many, rtol=0, atol=1e-10 * np.abs(many).max())

    def test_small_matrices_go_to_superlu_with_the_same_result(self, held):
        small = held[:600][:, :600].tocsc()
        factor = factorise(small)
        assert not isinstance(factor, MumpsFactor)
        rhs = np.ones((600, 2))
        ours, theirs = factor.solve(rhs), MumpsFactor(small).solve(rhs)
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * np.abs(theirs).max())

    def test_a_body_that_is_not_held_is_refused(self, model):
        with pytest.raises(ModelError) as error:
            factorise(model.stiffness.tocsc())
        shown(error, "insufficiently supported")

    @pytest.mark.parametrize("held_nodes", [1, 2])
    def test_a_body_that_can_still_turn_is_refused(self, model, held_nodes):
        nodes = model.groups["root"].nodes[:held_nodes]
        free = np.setdiff1d(np.arange(model.size), (3 * nodes[:, None] + np.arange(3)).reshape(-1))
        with pytest.raises(ModelError) as error:
            factorise(model.stiffness[free][:, free].tocsc())
        shown(error, "insufficiently supported")

    def test_an_indefinite_matrix_and_an_empty_row_are_refused(self, held):
        shifted = held - 1e-6 * held.diagonal().max() * sp.identity(held.shape[0])
        with pytest.raises(ModelError) as error:
            MumpsFactor(shifted)
        shown(error, "4 pivots are negative")
        mask = sp.diags(np.r_[0.0, np.ones(held.shape[0] - 1)])
        with pytest.raises(ModelError) as error:
            MumpsFactor(mask @ held @ mask)
        shown(error, "no stiffness at all")
        with pytest.raises(ModelError) as error:
            MumpsFactor(sp.kron(sp.identity(30), np.ones((2, 2)), format="csc"))
        shown(error, "insufficiently supported (pivot")

    def test_only_what_is_needed_is_factored_once(self, held, monkeypatch):
        monkeypatch.setattr(_petsc, "free_memory", lambda: 1e12)
        calls = []
        original = MumpsFactor._set_up
        monkeypatch.setattr(MumpsFactor, "_set_up", lambda self, **o: calls.append(o) or original(self, **o))
        factorise(held)
        assert calls == [{"folder": None}]  # neither an analysis before nor a piece


class TestIndefinite:
    @pytest.fixture
    def dynamic(self, held):
        return (held - 1e-6 * held.diagonal().max() * sp.identity(held.shape[0])).tocsc()  # with four negative pivots

    def test_it_solves_like_superlu(self, dynamic):
        rhs = np.random.default_rng(0).standard_normal((dynamic.shape[0], 3))
        factor = factorise(dynamic, definite=False)
        assert isinstance(factor, MumpsFactor)
        assert factor._factor.getMumpsInfog(12) == 4
        ours, theirs = factor.solve(rhs), splu_factorise(dynamic, definite=False).solve(rhs)
        # round-off times the condition of the matrix, 1e6 here at the least
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-7 * np.abs(theirs).max())
        assert np.abs(dynamic @ ours - rhs).max() < 1e-10 * abs(dynamic).max() * np.abs(ours).max()

    def test_pivots_of_two_rows_are_taken(self):
        swapped = sp.kron(sp.identity(50), [[0.0, 1.0], [1.0, 0.0]], format="csc")  # no pivot of one row at all
        rhs = np.arange(100.0)
        np.testing.assert_allclose(MumpsFactor(swapped, definite=False).solve(rhs), rhs.reshape(-1, 2)[:, ::-1].ravel())

    def test_a_singular_one_is_told(self):
        singular = sp.diags(np.r_[-1.0, 0.0, np.ones(10)]).tocsc()
        for make in (lambda: MumpsFactor(singular, definite=False), lambda: splu_factorise(singular, definite=False)):
            with pytest.raises(RuntimeError):
                make()

    def test_krylov_takes_it(self, monkeypatch):
        mesh = box("tetra", (8, 2, 2), (1.0, 0.1, 0.1))
        reduction = kf.Krylov(frequencies=(0.0, 700.0), order=2, loads=("gravity", "tip"))

        def body():
            return solid_body(mesh, STEEL, {"root": "clamped", "tip": "rigid"}, reduction=reduction, cache=False)

        made = []
        original = MumpsFactor.__init__
        monkeypatch.setattr(
            MumpsFactor,
            "__init__",
            lambda self, matrix, definite=True, accepts=None: made.append(definite) or original(self, matrix, definite),
        )
        by_superlu = body()
        assert made == []
        monkeypatch.setattr(_petsc, "SMALL", 100)
        by_mumps = body()
        assert made == [True, False]  # K once, K - w^2 M once
        # between the first two pairs of bending modes, so that the matrix is indefinite
        assert by_superlu.frequencies[0] < 700.0
        np.testing.assert_allclose(by_mumps.frequencies, by_superlu.frequencies, rtol=1e-6)


class TestMemory:
    @pytest.fixture
    def small_machine(self, monkeypatch, tmp_path):
        monkeypatch.setenv("KANEFE_CACHE_DIR", str(tmp_path))
        monkeypatch.setattr(_petsc, "free_memory", lambda: 20e6)
        return tmp_path / "factors"

    def test_factors_that_do_not_fit_go_to_the_disk_and_are_told_before(self, held, small_machine):
        left = small_machine / "999999999-killed"  # no process has such a number
        left.mkdir(parents=True)
        pattern = (
            r"factoring the stiffness of \d+ unknowns needs .* GB of memory, and 0.02 GB .* go to the disk .* Remedy"
        )
        with pytest.warns(MemoryWarning, match=pattern) as w, stages(1) as shown:
            factor = factorise(held)
        assert len(w) == 1
        # MUMPS's own estimate of what it takes: the factor of this body, of some 15 million numbers at most
        needed = float(str(w[0].message).partition("needs ")[2].split()[0])
        assert 0.02 < needed < 0.2
        (told,) = shown.told
        assert f"{held.shape[0]} unknowns" in told
        assert "GB on the disk, at most about" in told
        assert not left.exists()
        (own,) = small_machine.iterdir()
        assert sum(file.stat().st_size for file in own.iterdir()) > 1e6
        rhs = np.ones((held.shape[0], 2))
        np.testing.assert_allclose(factor.solve(rhs)[:, 0], factor.solve(rhs[:, 0]))
        assert np.abs(held @ factor.solve(rhs) - rhs).max() < 1e-6
        del factor
        assert not own.exists()

    def test_a_machine_that_is_too_small_is_told_before(self, held, small_machine, monkeypatch):
        monkeypatch.setattr(factor_plan, "_free_disk", lambda: 1e5)
        with pytest.warns(MemoryWarning, match=r"needs .* GB of memory, and 0.02 GB .* end the process. Remedy"):
            factor = factorise(held)
        assert not small_machine.exists()
        rhs = np.ones(held.shape[0])
        assert np.abs(held @ factor.solve(rhs) - rhs).max() < 1e-6

    def test_a_machine_that_is_large_enough_is_not_warned_of(self, held, monkeypatch):
        monkeypatch.setattr(_petsc, "free_memory", lambda: 1e9)  # MUMPS is asked, and its answer is less
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            factorise(held)

    def test_this_machine(self):
        free = free_memory()
        assert free is None or 1e7 < free < 1e14

    def test_the_limit_of_a_control_group_counts(self, monkeypatch):
        texts = {
            "/proc/meminfo": "MemTotal: 9 kB\nMemAvailable:   2000000 kB\n",
            "/sys/fs/cgroup/memory.max": "900000000\n",
            "/sys/fs/cgroup/memory.current": "400000000\n",
        }

        def read(path, *args):
            if str(path) not in texts:
                raise FileNotFoundError(path)
            return texts[str(path)]

        monkeypatch.setattr(Path, "read_text", read)
        assert free_memory() == 5e8
        texts["/sys/fs/cgroup/memory.max"] = "max\n"
        assert free_memory() == 2000000 * 1024
        del texts["/sys/fs/cgroup/memory.max"]
        assert free_memory() == 2000000 * 1024
        del texts["/proc/meminfo"]
        assert free_memory() is None

    @pytest.mark.parametrize(("of_metis", "of_pord", "taken"), [(2.0, 1.0, 4), (1.0, 2.0, 5), (None, 1.0, 7)])
    def test_the_cheaper_ordering_is_taken(self, of_metis, of_pord, taken, monkeypatch):
        class Analysed:
            def __init__(self, ordering):
                is_metis = ordering == 7 and of_metis is not None
                self.ordering, self.operations = (5, of_metis) if is_metis else (4, of_pord)
                self.is_there = True

            def getMumpsInfog(self, number):
                assert number == 7
                return self.ordering

            def getMumpsRinfog(self, number):
                assert number == 1
                return self.operations

            def destroy(self):
                self.is_there = False

        made = []

        def set_up(self, megabytes=0, folder=None, of=None):
            made.append(Analysed(self._ordering))
            return made[-1], made[-1]

        monkeypatch.setattr(_petsc.MumpsFactor, "_set_up", set_up)
        factor = object.__new__(_petsc.MumpsFactor)
        factor._ordering = _petsc.AUTOMATIC
        pc, found = factor._analysed()
        assert factor._ordering == taken
        assert found.operations == min(of_pord, of_metis or of_pord)
        assert [one for one in made if one.is_there] == [pc]

    def test_a_body_keeps_what_was_told(self, monkeypatch):
        monkeypatch.setattr(_petsc, "SMALL", 100)
        monkeypatch.setattr(_petsc, "TOLD", 100)
        mesh = box("tetra", (8, 2, 2), (1.0, 0.1, 0.1))
        ends, reduction = {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=4)
        body = solid_body(mesh, STEEL, ends, reduction=reduction, cache=False)
        (told,) = body.provenance["solver"]
        assert "unknowns: 0.00" in told
        assert "GB of memory, at most about" in told
        residuals = body.provenance["reduction"]["residuals"]
        assert residuals["constraint modes"] < 1e-11  # round-off
        assert 0.0 < residuals["normal modes"] < 1e-7  # the tolerance of the Lanczos method, in another norm
