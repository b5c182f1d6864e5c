"""Figures of the engine alone: growth with the scene, independence of the mesh, and what is skipped."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable
from functools import partial
from itertools import pairwise

import numpy as np

from benchmarks import engine_scenes as ours
from benchmarks.clocks import FEW_ROUNDS, Race, check_agreement, microseconds, repeated, seconds
from benchmarks.goals import Figure, Goal, median
from benchmarks.work_precision.rigid_chain import GRAVITY, chain_links, chain_scene
from benchmarks.work_precision.steel_bar import FREE_MODES, bar_model
from exact_accelerations import exact_accelerations, is_extended
from kanefe.equations.model import Model
from kanefe.joints import Free, JointFriction, PoseMotion, Revolute
from kanefe.kernels.bodies import ModalBodies
from kanefe.kernels.sweeps.elastic import transposed_product
from kanefe.scene.scene import Frame
from kanefe.system import System

# Cells of quadratic hexahedra, and the nodes they make.
SMALL_BAR, LARGE_BAR = (21, 4, 3), (54, 12, 6)
MODES = (8, 16, 32)

GROWTH = Goal("rigid chain: t(N=1000) / t(N=100)", 10.5)
IMPLICIT_GROWTH = Goal("rigid chain, step of generalised-alpha: t(N=1000) / t(N=100)", 13.0)
COUPLED_GROWTH = Goal("chain with springs between neighbours, step of radau5: t(N=1000) / t(N=100)", 12.0)
POSED_GROWTH = Goal("rigid chain on a pose by Python functions, right-hand side: t(N=1000) / t(N=100)", 12.0)
ACCURACY = Goal("rigid chain, N=1000: largest error of du / largest du", 1e-9)
PRODUCTS = Goal(f"S4, {FREE_MODES} modes: right-hand side / its own k x k products", 4.0)
MESHES = {modes: Goal(f"S3, {modes} modes: right-hand side on 35k nodes / on 2.7k nodes", 1.05) for modes in MODES}
MANY_MODES = Goal("S3: right-hand side with 32 modes / with 8 modes", 5.0)
FLEXIBLE = Goal("chain of flexible bodies, 12 modes each: t(50) / t(10)", 5.1)
PLANAR = {count: Goal(f"planar chain, N={count}: time / as a scene in space", 0.5) for count in (5, 20)}
RUBBING = Goal("friction in 20 joints from their loads: step / without friction", 2.5)
FREEZE = Goal("freeze of 100 bodies, tables included [ms]", 20.0)

BEARINGS = JointFriction(mu=0.1, radius=0.01)

# So many times the products are taken between two looks at the clock.
TAKEN = 2000


def growth(rounds: int) -> list[Figure]:
    """Compare steps of the chain of 1000 links with those of 100."""
    race = _steps_of(chain_scene(1000).freeze(), chain_scene(100).freeze(), (50, 500), rounds)
    remark = f"{microseconds(race.ours)} and {microseconds(race.theirs)} a step"
    return [GROWTH.figure(race.ratio, remark)]


def implicit_growth(rounds: int) -> list[Figure]:
    """Compare the same of generalised-alpha, which assembles no matrix; memory that no cache holds is part of it."""
    race = _steps_of(
        chain_scene(1000).freeze(), chain_scene(100).freeze(), (50, 500), rounds, method="generalised-alpha"
    )
    remark = f"{microseconds(race.ours)} and {microseconds(race.theirs)} a step"
    return [IMPLICIT_GROWTH.figure(race.ratio, remark)]


def coupled_growth(rounds: int) -> list[Figure]:
    """Compare first steps of chains whose links have springs to the next: each two make matrices once."""

    def sprung(count: int) -> Model:
        scene = chain_scene(count)
        links = [scene.body(f"link {i}") for i in range(count)]
        for i, (one, other) in enumerate(pairwise(links)):
            ends = one.frame(at=(0.1, 0.05, 0.0)), other.frame(at=(0.4, 0.05, 0.0))
            scene.add_spring(f"spring {i}", *ends, stiffness=1e4, damping=10.0)
        return scene.freeze()

    race = _steps_of(sprung(1000), sprung(100), (2, 2), min(rounds, FEW_ROUNDS), method="radau5")
    return [COUPLED_GROWTH.figure(race.ratio, f"{microseconds(race.ours)} and {microseconds(race.theirs)} a step")]


def posed_growth(rounds: int) -> list[Figure]:
    """Compare evaluations of chains that hang from a body whose pose functions in Python give."""

    def posed(count: int) -> Callable[[], object]:
        scene = System(gravity=GRAVITY)
        heave = PoseMotion(*(lambda t, f=f: (0.0, 0.0, f(t)) for f in (np.sin, np.cos, lambda t: -np.sin(t))))
        last: Frame = scene.add_frame("deck", joint=Free(motion=heave))
        for i, link in enumerate(chain_links(count)):
            numbers = {"mass": link["mass"], "inertia": link["inertia"], "com": link["com"], "at": link["at"]}
            last = scene.add_rigid_body(f"link {i}", joint=Revolute(link["axis"]), parent=last, **numbers)
        model = scene.freeze()
        return partial(model.rhs, 0.3, model.initial_state)

    one, other = posed(1000), posed(100)
    race = Race(lambda: repeated(one, 100), lambda: repeated(other, 200), rounds)
    return [POSED_GROWTH.figure(race.ratio, f"{microseconds(race.ours)} and {microseconds(race.theirs)}")]


def long_chain_accuracy(rounds: int) -> list[Figure]:
    """Compare accelerations of 1000 links in random motion with an independent computation in extended precision."""
    if not is_extended():
        return [ACCURACY.skipped("numpy's longdouble is no better than double here")]
    count = 1000
    rng = np.random.default_rng(1000)
    q, u = rng.standard_normal((2, count))
    exact, bound = exact_accelerations(chain_links(count), GRAVITY, q, u)
    found = chain_scene(count).freeze().rhs(0.0, np.concatenate((q, u)))[count:]
    error = float(abs(found - exact).max() / abs(exact).max())
    return [ACCURACY.figure(error + bound, f"the judge's own error is {bound:.2g}, and counted")]


def own_products(rounds: int) -> list[Figure]:
    """Compare a step of S4 with the products of matrices and vectors that its four evaluations cannot do without."""
    model = ours.free_bar(bar_model((10, 2, 1)))
    steps = 4000
    products = _products(model)
    products(1)
    race = Race(
        lambda: seconds(lambda: ours.run(model, steps, 5e-5)) / steps / 4,
        lambda: seconds(lambda: products(TAKEN)) / TAKEN,
        rounds,
    )
    remark = f"{microseconds(race.ours)} an evaluation, {microseconds(race.theirs)} the 12 products"
    return [PRODUCTS.figure(race.ratio, remark)]


def mesh_independence(rounds: int) -> list[Figure]:
    """Compare evaluations of S3 on a coarse and a fine mesh, and with many and few modes."""
    coarse, fine = bar_model(SMALL_BAR), bar_model(LARGE_BAR)
    small = {modes: ours.hinged_bar(coarse, modes) for modes in MODES}
    figures = []
    for modes, goal in MESHES.items():
        if rounds <= FEW_ROUNDS and modes > MODES[0]:
            print(f"left out of a quick run: {goal.what} (20 s to reduce the fine mesh)", file=sys.stderr, flush=True)
            continue  # what a quick run does not ask for cannot fail it
        race = _steps_of(ours.hinged_bar(fine, modes), small[modes], (2000, 2000), 2 * rounds, h=1e-6)
        remark = f"{microseconds(race.ours / 4)} an evaluation; {len(fine.nodes)} and {len(coarse.nodes)} nodes"
        figures.append(goal.figure(race.ratio, remark))
    race = _steps_of(small[MODES[-1]], small[MODES[0]], (1000, 2000), rounds, h=1e-6)
    remark = f"{microseconds(race.ours / 4)} and {microseconds(race.theirs / 4)} an evaluation"
    return [*figures, MANY_MODES.figure(race.ratio, remark)]


def flexible_growth(rounds: int) -> list[Figure]:
    """Compare steps of chains of 50 and 10 flexible bodies."""
    race = _steps_of(ours.flexible_chain(50, 12), ours.flexible_chain(10, 12), (100, 500), rounds, h=1e-5)
    remark = f"{microseconds(race.ours / 200)} and {microseconds(race.theirs / 40)} a body and evaluation"
    return [FLEXIBLE.figure(race.ratio, remark)]


def planar_chains(rounds: int) -> list[Figure]:
    """Compare steps of a planar chain with those of the same chain with a hinge a millionth out of the plane."""
    figures = []
    for count, goal in PLANAR.items():
        steps = 40000 // count
        flat, spatial = ours.planar_chain(count), ours.planar_chain(count, tilt=1e-6)
        # the tilt moves links by its own size
        check_agreement(f"planar chain {count}", ours.run(flat, 50), ours.run(spatial, 50), tolerance=1e-5)
        race = _steps_of(flat, spatial, (steps, steps), rounds)
        remark = f"{microseconds(race.ours)} a step against {microseconds(race.theirs)}"
        figures.append(goal.figure(race.ratio, remark))
    return figures


def joint_friction(rounds: int) -> list[Figure]:
    """Compare steps of 20 links whose bearings rub as they are loaded with those of links that do not rub.

    Half a second after the start, in 40 ms, with the few events that there are.
    """
    rubbing, plain = (chain_scene(20, friction=friction) for friction in (BEARINGS, None))
    whole = [seconds(partial(scene.simulate, (0.0, 1.0), progress=False)) for scene in (rubbing, plain) for _ in "12"]
    models = [scene.freeze(0.5, start=scene.simulate((0.0, 0.5), progress=False).at(0.5)) for scene in (rubbing, plain)]
    race = _steps_of(models[0], models[1], (4000, 4000), rounds, h=1e-5)
    remark = (
        f"{microseconds(race.ours)} a step against {microseconds(race.theirs)}; the first second, by auto: "
        f"{whole[1]:.2g} s against {whole[3]:.2g} s"
    )
    return [RUBBING.figure(race.ratio, remark)]


def freezing(rounds: int) -> list[Figure]:
    """Time `freeze` and the tables of the kernels for 100 bodies."""
    times = []
    for _ in range(2 * rounds + 1):
        scene = chain_scene(100)
        gc.collect()

        def freeze(scene: System = scene) -> object:
            return scene.freeze().route

        times.append(seconds(freeze))
    return [FREEZE.figure(1e3 * median(times[1:]))]


def _steps_of(
    one: Model, other: Model, steps: tuple[int, int], rounds: int, h: float = ours.STEP, method: str = "rk4"
) -> Race:
    """Return the race of two models, both stepped by the same method."""
    return Race(
        lambda: seconds(lambda: ours.run(one, steps[0], h, method)) / steps[0],
        lambda: seconds(lambda: ours.run(other, steps[1], h, method)) / steps[1],
        rounds,
    )


def _products(model: Model) -> Callable[[int], None]:
    """Return a compiled loop of the nine products with eta and three with deta, on the arrays of the first body."""
    import numba

    from kanefe.kernels.compiler._numba import dispatcher

    product = dispatcher(transposed_product)
    flexible = model.route.flexible
    body = ModalBodies(flexible.bodies, flexible.pool, np.zeros(0))[0]
    k, matrices = body.k, body.products
    eta, deta = np.random.default_rng(0).standard_normal((2, k))
    of_eta, of_deta = np.empty(9 * k), np.empty(3 * k)

    @numba.njit(error_model="numpy")
    def loop(matrices, eta, deta, of_eta, of_deta, count):  # type: ignore[no-untyped-def]
        for _ in range(count):
            product(matrices, 0, eta, of_eta)
            product(matrices, 6 * len(eta), deta, of_deta)
            # what depends on the last round cannot be taken out of the loop
            eta[0] += 1e-300 * of_deta[0]
            deta[0] += 1e-300 * of_eta[0]

    return lambda count: loop(matrices, eta, deta, of_eta, of_deta, count)


GROUPS = {
    growth: [GROWTH],
    implicit_growth: [IMPLICIT_GROWTH],
    coupled_growth: [COUPLED_GROWTH],
    posed_growth: [POSED_GROWTH],
    long_chain_accuracy: [ACCURACY],
    own_products: [PRODUCTS],
    mesh_independence: [*MESHES.values(), MANY_MODES],
    flexible_growth: [FLEXIBLE],
    planar_chains: list(PLANAR.values()),
    joint_friction: [RUBBING],
    freezing: [FREEZE],
}
