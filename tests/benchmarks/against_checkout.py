"""Accelerations of 1,000 random scenes of every kind by two checkouts of kanefe: ``python against_checkout.py OLD``.

Each checkout draws the scenes by its own `tests/shared`, in a process of its own. The first one makes the states, the
second one evaluates there too. An error counts relative to what cancels: to the largest of the rates of modes, or of
all others, and of how much these change with the state; what holds a loop is in every rate of it. Of scenes that are
sampled, or whose contacts are rigid, the ends of a short run are compared.

Options: ``--scenes N`` (a share of each kind), ``--kind NAME``.
"""

from __future__ import annotations

import argparse
import os
import pickle
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

LARGEST = 1e-13
"""Of a rate, relative to its size and its sensitivity to the state."""

LARGEST_OF_RUN = 1e-7
"""Of the end of a run, relative to its size: a hundred times the tolerance of the run."""

NUDGE = 1e-7
"""Relative change of the state by which a sensitivity is measured."""

WHOLE = 1000
KINDS = {
    "rigid trees": 240,
    "flexible trees": 180,
    "springs and bushings": 100,
    "planar": 80,
    "rigid loops": 140,
    "flexible loops": 60,
    "linkages, flexible": 30,
    "linkages, exact beams": 30,
    "compliant contacts": 80,
    "drawn: contacts, drives, controllers": 60,
}
"""How many scenes of each kind."""


class Found(NamedTuple):
    """What a checkout gives for a scene.

    Attributes
    ----------
    state, rates, sensitivity : ndarray
        Of an evaluation; of a run the state at its end is the rates.
    modal : ndarray of bool
        Which of them are of modes.
    """

    state: np.ndarray
    rates: np.ndarray
    sensitivity: np.ndarray
    modal: np.ndarray


def scene_of(kind: str, seed: int) -> Any:
    """Return a frozen scene and a state, or a scene to run."""
    # of the checkout in which this runs
    import kanefe as kf
    from contact_scenes import FRICTION
    from contact_scenes import random_state as state_of_contact
    from contact_scenes import scene_of as touching
    from random_loops import LoopScene, closed_state
    from random_scenes import Recipe, planar_model, random_model
    from random_starts import linkage
    from scenes import random_state

    if kind.startswith("drawn"):
        from drawn_scenes import drawn

        return drawn(seed).scene
    if kind == "compliant contacts":
        shapes = (kf.shapes.Plane("z"), kf.shapes.Sphere(0.4), kf.shapes.Box((0.8, 0.7, 0.5)))
        friction = FRICTION[sorted(FRICTION)[seed % len(FRICTION)]]
        model = touching(shapes[seed % 3], kf.shapes.Sphere(0.3), friction=friction).freeze()
        return model, state_of_contact(model, seed, (0.1, 0.05, 0.27 + 0.4 * (seed % 3 > 0)))[:-2]  # without energies
    if kind.startswith("linkages"):
        scene = linkage(seed, "exact" if "exact" in kind else "flexible")
        result = scene.simulate((0.0, 0.01), output_step=0.01)
        return scene.freeze(), end_of(result)
    if kind.endswith("loops"):
        recipe = Recipe(seed, bodies=3 + seed % 10, elastic=0.4 if kind.startswith("flexible") else 0.0, loads=3)
        model = LoopScene(recipe, 1 + seed % 3).frozen()
        found = closed_state(model, seed) if model is not None else None
        if model is None or found is None:
            return None
        q, u = found
    elif kind == "planar":
        model = planar_model(Recipe(seed, bodies=2 + seed % 20, loads=4))
        q, u = random_state(model, seed)
    else:
        recipe = Recipe(
            seed,
            bodies=2 + seed % 20,
            elastic=0.4 if kind.startswith("flexible") else 0.2 * (seed % 2) * kind.startswith("springs"),
            loads=seed % 6,
            between=4 if kind.startswith("springs") else 0,
            slopes=("rotation-vector", "tait-bryan")[seed % 2],
        )
        model = random_model(recipe)
        q, u = random_state(model, seed)
    state = model.initial_state.copy()
    state[: len(q)], state[len(q) : len(q) + len(u)] = q, u
    return model, state


def end_of(result: Any) -> np.ndarray:
    """Return the state at the end of a run."""
    there = result.at(float(result.times[-1]))
    return np.concatenate((there.q, there.u, there.z))


def found_at(kind: str, seed: int, state: np.ndarray | None) -> Found | None:
    """Return what this checkout gives for a scene, at a state that another one made."""
    made = scene_of(kind, seed)
    if made is None:
        return None
    if kind.startswith("drawn"):
        end = end_of(made.simulate((0.0, 0.05), rtol=1e-9, output_step=0.05))
        return Found(end, end, np.zeros(len(end)), np.zeros(len(end), bool))
    model, own = made
    y = own if state is None else state
    rates = model.rhs(0.37, y)
    rng = np.random.default_rng(seed)
    change = np.zeros(len(y))
    for _ in range(3):
        moved = y + NUDGE * rng.standard_normal(len(y)) * np.maximum(abs(y), 1e-3)
        change = np.maximum(change, abs(model.rhs(0.37, moved) - rates) / NUDGE)
    return Found(y, rates, change, np.array(["eta" in name for name in model.state_names[: len(rates)]]))


def answer(job: str) -> None:
    """Do what another process asks for: a file of kinds, seeds and states, written back with what is found."""
    with open(job, "rb") as file:
        asked = pickle.load(file)
    import kanefe as kf

    answers: dict[tuple[str, int], tuple[Any, ...] | str | None] = {}
    for (kind, seed), state in asked.items():
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                found = found_at(kind, seed, state)
                answers[kind, seed] = None if found is None else tuple(found)  # its class has two names here
        except (kf.KanefeError, ArithmeticError, ValueError) as error:  # a refusal must be the same in both
            answers[kind, seed] = f"{type(error).__name__}: {error}"
    with open(job, "wb") as file:
        pickle.dump(answers, file)


def ask(checkout: Path, asked: dict[tuple[str, int], Any], folder: str) -> dict[tuple[str, int], Any]:
    """Return what a checkout answers."""
    job = Path(folder) / "job"
    job.write_bytes(pickle.dumps(asked))
    rooms = (".", "fem", "tests/shared", "tests/benchmarks")
    paths = os.pathsep.join(str(checkout / room) for room in rooms)
    code = f"import runpy; runpy.run_path({str(Path(__file__))!r})['answer']({str(job)!r})"
    cache = {"KANEFE_CACHE_DIR": os.environ.get(f"KANEFE_CACHE_OF_{checkout.name.upper()}", "")}
    environment = {**os.environ, "PYTHONPATH": paths, **{k: v for k, v in cache.items() if v}}
    subprocess.run([sys.executable, "-c", code], env=environment, cwd=folder, check=True)
    answers: dict[tuple[str, int], Any] = pickle.loads(job.read_bytes())
    return {key: Found(*found) if isinstance(found, tuple) else found for key, found in answers.items()}


def error_of(kind: str, ours: Found, theirs: Found) -> float:
    """Return the largest error over its limit."""
    difference = abs(ours.rates - theirs.rates)
    if kind.startswith("drawn"):
        return float((difference / np.maximum(abs(theirs.rates), 1.0)).max(initial=0.0)) / LARGEST_OF_RUN
    what_cancels = abs(theirs.rates) + theirs.sensitivity
    sorts = [sort for sort in (theirs.modal, ~theirs.modal) if sort.any()]
    return max(float(difference[sort].max() / max(what_cancels[sort].max(), 1e-300)) for sort in sorts) / LARGEST


def compare(old: Path, new: Path, scenes: int, only: str) -> bool:
    """Print a table of all kinds; return whether all agree."""
    print("| kind | scenes | both refuse | largest difference over its limit | differ |")
    print("|---|---|---|---|---|")
    agree = True
    for kind in [kind for kind in KINDS if only in kind]:
        asked = {(kind, seed): None for seed in range(max(1, KINDS[kind] * scenes // WHOLE))}
        with tempfile.TemporaryDirectory() as folder:
            theirs = ask(old, asked, folder)
            states = {key: getattr(found, "state", None) for key, found in theirs.items()}
            ours = ask(new, states, folder)
        worst, refused, differing = 0.0, 0, []
        for key, there in theirs.items():
            here = ours[key]
            if isinstance(there, Found) and isinstance(here, Found):
                error = error_of(kind, here, there)
                worst = max(worst, error)
                if not error <= 1.0:
                    differing.append((key[1], error))
            elif here != there:
                differing.append((key[1], here if isinstance(here, str) else there))
            else:
                refused += 1
        print(f"| {kind} | {len(theirs)} | {refused} | {worst:.2g} | {differing[:8] or ''} |", flush=True)
        agree = agree and not differing
    return agree


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("old", type=Path)
    parser.add_argument("--scenes", type=int, default=WHOLE)
    parser.add_argument("--kind", default="")
    options = parser.parse_args()
    here = Path(__file__).resolve().parents[2]
    sys.exit(not compare(options.old.resolve(), here, options.scenes, options.kind))
