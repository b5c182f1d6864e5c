"""Bodies by multigrid: the shapes and modes are those by factors, residuals are told, and the choice is too."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

import kanefe as kf
from fem_meshes import STEEL, box, shown
from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import MIDS, shape
from kanefe.storage import unfinished
from kanefe_fem.multigrid import choice, lobpcg
from kanefe_fem.multigrid.corners import corner_interpolation
from kanefe_fem.multigrid.factor import Discretisation, MultigridFactor
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.model import solid_model

BAR = (1.0, 0.2, 0.2)
ENDS = {"root": "clamped", "tip": "rigid"}


@pytest.mark.parametrize("kind", [kind for kind in MIDS if shape(kind).order == 2])
def test_corners_of_a_cell_carry_the_positions_of_its_nodes(kind: str) -> None:
    element = shape(kind)
    nodes = np.random.default_rng(0).permutation(len(element.nodes) + 1)[: len(element.nodes)]
    count = int(nodes.max()) + 1
    positions = np.zeros((count, element.dimension))
    positions[nodes] = element.nodes
    values, corners = corner_interpolation([Cells(kind, nodes[None]), Cells(kind, nodes[None])], count)
    assert corners.tolist() == sorted(nodes[: element.corners])
    np.testing.assert_allclose(values @ positions[corners], positions, atol=1e-15)


class TestLobpcg:
    def test_random_pairs_against_lapack(self) -> None:
        rng = np.random.default_rng(0)
        for size, count in ((60, 3), (200, 12)):
            A, B = (rng.standard_normal((size, size)) for _ in range(2))
            K, M = A @ A.T + 0.1 * np.eye(size), B @ B.T / size + np.eye(size)
            rough = np.linalg.inv(np.diag(np.diag(K)) + 0.9 * (K - np.diag(np.diag(K))))
            start = rng.standard_normal((size, count + 3))
            squares, shapes = lobpcg.lowest_modes(K.__matmul__, M.__matmul__, rough.__matmul__, start, count)
            np.testing.assert_allclose(squares, scipy.linalg.eigvalsh(K, M)[:count], rtol=1e-10)
            np.testing.assert_allclose(shapes.T @ M @ shapes, np.eye(count), atol=1e-10)
            left = K @ shapes - M @ shapes * squares
            assert (np.linalg.norm(left, axis=0) <= lobpcg.TOLERANCE * np.linalg.norm(K @ shapes, axis=0) * 1.01).all()

    def test_equal_frequencies_are_all_found(self) -> None:
        d = np.repeat(np.arange(1.0, 41.0), 3)[:, None]
        start = np.random.default_rng(0).standard_normal((120, 9))
        squares, _ = lobpcg.lowest_modes(lambda x: d * x, np.copy, lambda x: x / (d + 0.3), start, 6)
        np.testing.assert_allclose(squares, np.repeat([1.0, 2.0], 3), rtol=1e-10)

    def test_what_does_not_converge_is_refused(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(lobpcg, "STEPS", 2)
        d = np.arange(1.0, 1001.0)[:, None]
        start = np.random.default_rng(0).standard_normal((1000, 4))
        with pytest.raises(ModelError) as error:
            lobpcg.lowest_modes(lambda x: d * x, np.copy, np.copy, start, 2)
        shown(error, "not found in 2 steps")


BODIES = {
    "clamped and rigid, tetrahedra": (("tetra", (6, 2, 2), BAR), ENDS, 2),
    "hexahedra": (("hexahedron", (6, 2, 2), BAR), ENDS, 2),
    "order 1, by aggregation": (("hexahedron", (12, 5, 5), BAR), ENDS, 1),
    "floating, an average": (("tetra", (6, 2, 2), BAR), {"root": "average", "tip": "rigid"}, 2),
    "without interfaces": (("tetra", (6, 2, 2), BAR), {}, 2),
    "hinged": (("tetra", (6, 2, 2), BAR), {"root": "clamped", "tip": "hinged"}, 2),
}


@pytest.mark.fenicsx
@pytest.mark.gmsh
class TestBodies:
    @pytest.mark.parametrize("what", BODIES)
    def test_the_body_is_that_by_factors(self, what: str) -> None:
        mesh, ends, order = BODIES[what]
        reduction = kf.FreeInterface(modes=5) if not ends else kf.CraigBampton(modes=5, loads=("gravity",))

        def body(solver: choice.Solver) -> kf.FlexibleBody:
            return solid_body(box(*mesh), STEEL, ends, reduction, order=order, solver=solver, cache=False)

        ours, theirs = body("multigrid"), body("direct")
        records = [[mode["frequency"] for mode in one.provenance["reduction"]["modes"]] for one in (ours, theirs)]
        np.testing.assert_allclose(*records, rtol=1e-10)  # residuals of 5e-7, whose square is the error of frequencies
        np.testing.assert_allclose(ours.frequencies, theirs.frequencies, rtol=1e-6)  # of the span: of first order
        residuals = ours.provenance["reduction"]["residuals"]
        assert 0.0 < residuals["normal modes"] <= 1e-6
        assert residuals.get("constraint modes", 0.0) <= 1e-11
        assert "by multigrid" in ours.provenance["solver"][0]
        assert theirs.provenance["solver"] == []

    def test_neither_size_nor_slenderness_costs_iterations(self) -> None:
        counts = []
        for cells, size in (((4, 2, 2), (0.2, 0.1, 0.1)), ((40, 2, 2), (2.0, 0.1, 0.1)), ((8, 4, 4), (0.2, 0.1, 0.1))):
            model = solid_model(box("tetra", cells, size), STEEL)
            held = np.isin(np.arange(len(model.nodes)), model.groups["root"].nodes)
            motion = sp.identity(model.size, format="csc")[:, np.repeat(~held, 3)].tocsr()
            K = (motion.T @ model.stiffness @ motion).tocsc()
            factor = MultigridFactor(K, Discretisation(model.nodes, model.components, model.cells), motion)
            load = np.random.default_rng(0).standard_normal(K.shape[0])
            # round-off of K u, which is large beside a load on single nodes that bend a slender bar
            assert np.linalg.norm(K @ factor.solve(load) - load) <= 1e-9 * np.linalg.norm(load)
            counts.append(factor.hierarchy.iterations)
        assert max(counts) <= 25
        assert max(counts) <= 1.3 * min(counts)

    def test_a_body_that_is_not_held_is_refused(self) -> None:
        model = solid_model(box("tetra", (4, 2, 2), (0.2, 0.1, 0.1)), STEEL)
        motion = sp.identity(model.size, format="csr")
        mesh = Discretisation(model.nodes, model.components, model.cells)
        with pytest.raises(ModelError) as error:
            MultigridFactor(model.stiffness, mesh, motion)
        shown(error, "insufficiently supported")

    def test_iterations_without_end_are_refused(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("kanefe_fem.multigrid._petsc.ITERATIONS", 3)
        with pytest.raises(ModelError) as error:
            solid_body(
                box("tetra", (4, 2, 2), BAR), STEEL, ENDS, kf.CraigBampton(modes=2), solver="multigrid", cache=False
            )
        shown(error, "3 iterations leave", 'solver="direct"')

    def test_auto_takes_it_where_factors_do_not_fit(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("kanefe_fem._petsc.SMALL", 100)
        for name in ("kanefe_fem._petsc.free_memory", "kanefe_fem.multigrid.choice.free_memory"):
            monkeypatch.setattr(name, lambda: 4e6)
        body = solid_body(box("tetra", (8, 4, 4), BAR), STEEL, ENDS, kf.CraigBampton(modes=2), cache=False)
        assert "by multigrid" in body.provenance["solver"][0]

    def test_modes_of_a_run_that_was_ended_are_taken_up(self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        monkeypatch.setattr(unfinished, "SECONDS", 0.0)
        made: list[str] = []
        ended = [5]

        def keep(name: str, **arrays: np.ndarray) -> None:
            unfinished.keep(name, **arrays)
            made.append(name)
            if len(made) == ended[0]:
                raise KeyboardInterrupt

        monkeypatch.setattr("kanefe_fem.multigrid.factor.keep", keep)

        def body() -> kf.FlexibleBody:
            with unfinished.resumable(tmp_path / "own"):
                return solid_body(
                    box("tetra", (6, 2, 2), BAR), STEEL, ENDS, kf.CraigBampton(modes=4), solver="multigrid", cache=False
                )

        with pytest.raises(KeyboardInterrupt):
            body()
        ended[0] = -1
        first = len(made)
        body()
        again = len(made) - first
        body()
        assert again < len(made) - first - again  # fewer steps than of a run from the start

    def test_what_it_cannot_do_is_refused(self) -> None:
        for solver, reduction, said in (
            ("iterative", kf.CraigBampton(modes=2), "'auto', 'direct', 'multigrid'"),
            ("multigrid", None, "reduction=None"),
        ):
            with pytest.raises(ModelError) as error:
                solid_body("none.msh", STEEL, ENDS, reduction, solver=solver)
            shown(error, said)
