"""Damage over the surface of a body: against counting at each node, and the bound of nodes that are not counted."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.fe_model.skin import skin
from kanefe_fem.recovery.damage_map import SIGNED
from kanefe_fem.recovery.scalars import von_mises
from recovered_boxes import fields_of, mesh_of, recovered

CURVE = kf.fatigue.SNCurve(amplitude=50e6, cycles=1e6, slope=5, slope_below=9)
FLOOR = 0.9
"""A share that the bound of half of the bending stress is below: it is several times its damage."""


def shaken(amplitudes: tuple[float, ...] = (4e-4, 4e-3, 2e-3), count: int = 300):
    """A box in three modes of stretch and bending, with noise in each; stresses of some 100 MPa."""
    mesh = mesh_of("hexahedron", 1)
    x, y, z = mesh.nodes.T
    zero = np.zeros_like(x)
    modes = np.stack(
        [
            np.stack([x, zero, zero], axis=1),
            np.stack([x * y, -0.5 * x**2, zero], axis=1),
            np.stack([x * z + 0.1 * x * x, zero, -0.5 * x**2], axis=1),
        ],
        axis=2,
    )
    fields = fields_of(mesh, modes)
    rng = np.random.default_rng(5)
    eta = rng.normal(size=(count, 3)) * np.array(amplitudes)
    return fields, recovered(fields, eta)


def signed(stress: np.ndarray) -> np.ndarray:
    return np.where(stress[..., :3].sum(axis=-1) >= 0.0, 1.0, -1.0) * von_mises(stress)


@pytest.mark.parametrize("mean_stress", [None, kf.fatigue.Goodman(900e6), kf.fatigue.Walker()])
@pytest.mark.parametrize("quantity", [SIGNED, "xx", "xy"])
def test_each_node_has_the_damage_of_its_history(quantity, mean_stress):
    fields, recovery = shaken()
    found = recovery.damage(CURVE, mean_stress=mean_stress, quantity=quantity, floor=0.0)
    stress = recovery.stress_at_nodes()
    histories = signed(stress) if quantity == SIGNED else stress[..., {"xx": 0, "xy": 5}[quantity]]
    outside = np.unique(np.concatenate([block.nodes.ravel() for block in skin(fields.cells)]))
    assert 0 < len(outside) < len(fields.nodes)
    for node in outside:
        wanted = kf.fatigue.damage(histories[:, node], CURVE, mean_stress=mean_stress).total
        assert found.values[node] == pytest.approx(wanted, rel=1e-9)
    assert np.isnan(np.delete(found.values, outside)).all()
    assert not found.is_bound.any()
    assert found.peak == np.nanmax(found.values)
    np.testing.assert_array_equal(found.peak_position, fields.nodes[found.where])
    assert f"damage {found.peak:.3g}" in str(found)


@pytest.mark.parametrize("curve", [CURVE, kf.fatigue.SNCurve(50e6, 1e6, 3), kf.fatigue.SNCurve(200e6, 1e6, 4, 7)])
@pytest.mark.parametrize("mean_stress", [None, kf.fatigue.Gerber(900e6), kf.fatigue.Walker(0.3)])
def test_what_is_not_counted_is_below_its_bound_and_the_floor(curve, mean_stress, monkeypatch):
    from kanefe_fem.recovery import damage_map

    _, recovery = shaken((1e-6, 4e-3, 1e-6))  # bending, with three layers of nodes
    whole = recovery.damage(curve, mean_stress=mean_stress, floor=0.0)
    monkeypatch.setattr(damage_map, "PIECE", 1)  # a node at a time
    found = recovery.damage(curve, mean_stress=mean_stress, floor=FLOOR)
    rows = found.is_bound
    assert rows.any()
    assert (found.values[rows] >= whole.values[rows]).all()
    assert (found.values[rows] <= FLOOR * found.peak).all()
    counted = np.isfinite(whole.values) & ~rows
    np.testing.assert_allclose(found.values[counted], whole.values[counted], rtol=1e-12)
    assert found.peak == pytest.approx(whole.peak, rel=1e-12)


def test_nothing_is_damaged_below_the_endurance_limit(tmp_path):
    _, recovery = shaken()
    found = recovery.damage(kf.fatigue.SNCurve(5e9, 1e6, 5))
    assert found.peak == 0.0
    assert found.repeats == np.inf
    with pytest.raises(ModelError, match="below the endurance limit"):
        found.picture(tmp_path / "none.png")


def test_a_picture_of_the_damage(tmp_path):
    pytest.importorskip("pyvista")
    _, recovery = shaken()
    path = recovery.damage(CURVE).picture(tmp_path / "damage.png")
    assert path.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"quantity": "tresca"}, "no damage of 'tresca'. There are: signed_von_mises, xx"),
        ({"floor": 1.0}, "from 0 to below 1"),
        ({"mean_stress": kf.fatigue.Goodman(1e6)}, "breaks the material at once"),
    ],
)
def test_what_cannot_be_is_named(options, message):
    _, recovery = shaken()
    with pytest.raises(ModelError, match=message):
        recovery.damage(CURVE, **options)
    fields, _ = shaken()
    with pytest.raises(ModelError, match="two output times"):
        recovered(fields, np.ones((1, 3))).damage(CURVE)
