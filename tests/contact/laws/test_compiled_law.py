"""Normal forces by functions of the user in machine code: the same as laws of the house where they compute the same."""

from __future__ import annotations

import ctypes
import pickle
import re
import shutil
import subprocess

import numpy as np
import pytest
from numba import cfunc, types

import kanefe as kf
from contact_scenes import FRICTION, assert_routes_agree, random_state, scene_of
from kanefe import shapes
from touched_shapes import TOUCHED

POINTER = types.CPointer(types.float64)
LAW = types.void(types.float64, types.float64, POINTER, POINTER)

IN_C = """
void kelvin(double d, double rate, const double *c, double *out)
{
    out[0] = c[0] * d + c[1] * rate;
    out[1] = c[0] * d;
    out[2] = 0.5 * c[0] * d * d;
    out[3] = c[0];
    out[4] = c[1];
}
"""


@cfunc(LAW)
def hunt_crossley(d, rate, c, out):
    brake = 1.0 + c[1] * rate
    out[0] = c[0] * d * brake
    out[1] = c[0] * d
    out[2] = 0.5 * c[0] * d * d
    out[3] = c[0] * brake
    out[4] = c[0] * d * c[1]


@cfunc(LAW)
def untold(d, rate, c, out):
    out[0] = c[0] * d * (1.0 + c[1] * rate)


@pytest.fixture(scope="module")
def kelvin(tmp_path_factory):
    """Return the function of a library that a compiler made."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler here")
    folder = tmp_path_factory.mktemp("law")
    (folder / "law.c").write_text(IN_C)
    subprocess.run([compiler, "-O2", "-shared", "-fPIC", "-o", "law.so", "law.c"], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "law.so")).kelvin


@pytest.mark.parametrize("friction", [None, FRICTION["turning"]], ids=("smooth", "rough"))
@pytest.mark.parametrize("slopes", [True, False])
def test_a_function_is_the_law_of_the_house_on_both_routes(slopes, friction):
    """To the last digits: the same products in the same order, but for how machine code contracts them."""
    ours, theirs = kf.HuntCrossley(2e4, damping=0.4), kf.CompiledLaw(hunt_crossley, 0.01, (2e4, 0.4), slopes)
    scenes = [scene_of(TOUCHED["plane"], shapes.Sphere(0.3), law, friction) for law in (ours, theirs)]
    assert_routes_agree(scenes[1], range(12), (0.1, 0.2))
    first, second = (scene.freeze() for scene in scenes)
    for seed in range(6):
        y = random_state(first, seed, (0, 0, 0.15))
        along = np.random.default_rng(1).standard_normal((2, len(y)))
        along[:, -2:] = 0.0
        for one, other in ((first.literal, second.literal), (first.route, second.route)):
            wanted = one.evaluate(0.0, y).rates
            np.testing.assert_allclose(other.evaluate(0.0, y).rates, wanted, rtol=1e-12, atol=1e-12)
            assert other.energy(0.0, y).total == pytest.approx(one.energy(0.0, y).total, rel=1e-13)
        # all but the books of energy, of which nothing is a function
        wanted, found = (model.route.derivatives(0.0, y, along)[:, :-2] for model in (first, second))
        np.testing.assert_allclose(found, wanted, atol=(1e-12 if slopes else 1e-8) * np.abs(wanted).max())


def test_a_function_of_a_c_library_is_the_law_of_the_house(kelvin):
    ours, theirs = kf.KelvinVoigt(3e4, damping=200.0), kf.CompiledLaw(kelvin, 0.01, (3e4, 200.0), slopes=True)
    for law in (ours, theirs):
        scene = scene_of(TOUCHED["plane"], shapes.Sphere(0.3), law, FRICTION["one"])
        model = scene.freeze()
        y = random_state(model, 3, (0, 0, 0.15))
        rates = model.route.evaluate(0.0, y).rates
        if law is ours:
            wanted = rates
    np.testing.assert_allclose(rates, wanted, rtol=1e-12, atol=1e-12)


def bouncing(law):
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    ball = scene.add_point("ball", 2.0, joint=kf.Prismatic("z", position=0.02))
    scene.add_contact("c", ball, floor, normal=law)
    return scene


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_energy_is_balanced_also_of_a_force_that_tells_none(method):
    """What is not told as kept counts as taken: the force's work to the same digits."""
    for law in (kf.CompiledLaw(hunt_crossley, 1e-3, (1e5, 0.3), True), kf.CompiledLaw(untold, 1e-3, (1e5, 0.3))):
        result = bouncing(law).simulate((0.0, 0.5), rtol=1e-10, method=method)
        assert result.statistics["route"] == "order n"
        assert result.contact("c").normal.max() > 10 * 2.0 * 9.81
        assert abs(result.energy.balance_error).max() < 1e-7 * 2.0 * 9.81 * 0.02


def test_it_has_equilibria_and_small_motions():
    for slopes in (True, False):
        scene = bouncing(kf.CompiledLaw(hunt_crossley, 1e-3, (1e5, 0.0), slopes))
        rest = kf.equilibrium(scene)
        assert rest.load("c")[3] == pytest.approx(2.0 * 9.81, rel=1e-9)
        modes = rest.linearise().modes()
        assert modes.frequencies[0] == pytest.approx(np.sqrt(1e5 / 2.0) / (2 * np.pi), rel=1e-8)


@cfunc(LAW)
def pulls(d, rate, c, out):
    out[0] = -d


@cfunc(LAW)
def wrong_energy(d, rate, c, out):
    out[0] = out[1] = 2e4 * d
    out[2] = 2e4 * d * d


@cfunc(LAW)
def energy_from_nothing(d, rate, c, out):
    out[0] = out[1] = 2e4 * d
    out[2] = 1e4 * d * d + 1.0


@cfunc(LAW)
def wrong_slope(d, rate, c, out):
    out[0] = 2e4 * d
    out[3] = 1e4


@cfunc(LAW)
def wrong_rate(d, rate, c, out):
    out[0] = 2e4 * d * (1.0 + rate)
    out[3] = 2e4 * (1.0 + rate)


@cfunc(LAW)
def no_number(d, rate, c, out):
    out[0] = np.log(-d)


@pytest.mark.parametrize(
    ("function", "given", "message"),
    [
        (lambda d: d, {}, "must be a compiled function"),
        (10**9, {}, "must be a compiled function"),
        (10**400, {}, "must be a compiled function"),
        (pulls, {}, r"does not repel: -0.01 N at the depth of 0.01 m"),
        (wrong_energy, {}, r"elastic part, out\[1\], is not the derivative of its energy"),
        (energy_from_nothing, {}, r"not 0 at zero depth"),
        (wrong_slope, {"slopes": True}, r"slope, out\[3\], is not that of its force by depth"),
        (wrong_rate, {"slopes": True}, r"slope, out\[4\], is not that of its force by rate"),
        (no_number, {}, r"gives .* at a depth of 1e-05 m"),
        (hunt_crossley, {"constants": (np.nan,)}, "constants of CompiledLaw must be finite"),
        (hunt_crossley, {"depth": -1.0}, "depth of CompiledLaw must be one number, finite and > 0"),
    ],
)
def test_what_contradicts_itself_is_refused(function, given, message):
    with pytest.raises(kf.ModelError, match=message):
        kf.CompiledLaw(function, **{"depth": 0.01} | given)


def test_it_stays_in_its_process():
    with pytest.raises(kf.ModelError, match="in the process that runs it"):
        pickle.dumps(kf.CompiledLaw(hunt_crossley, 0.01, (2e4, 0.4)))


def test_a_friction_with_it_needs_an_anchor():
    with pytest.raises(kf.ModelError, match=re.escape("Remedy: stiffness= of Coulomb")):
        scene_of(TOUCHED["plane"], shapes.Sphere(0.3), kf.CompiledLaw(untold, 0.01, (2e4, 0.4)), kf.Coulomb(0.3))


def test_a_checkpoint_tells_one_function_from_another(tmp_path):
    """By what they give, since an address is another in each process."""
    first, other = (kf.CompiledLaw(hunt_crossley, 1e-3, (1e5, c)) for c in (0.3, 0.4))
    path = tmp_path / "c.h5"
    bouncing(first).simulate((0.0, 0.1), checkpoint=path, most_steps=5)
    bouncing(first).simulate((0.0, 0.1), checkpoint=path, resume=path, most_steps=5)
    with pytest.raises(kf.FileError, match="another scene"):
        bouncing(other).simulate((0.0, 0.1), checkpoint=path, resume=path)
