"""A pole on a cart learns to stand: a Gymnasium-like environment on a scene that is stepped, and a search over it.

``reset`` restores a saved state, which takes microseconds, and starts the pole slightly off the vertical; ``step``
holds a force for 20 ms. The cross-entropy method then searches the gains of a linear law for the longest time that the
pole stays up: it draws laws from a normal distribution, and fits the distribution to the best of them.
"""

import math

import numpy as np

import kanefe as kf

DT, LENGTH, FALLEN, OFF_TRACK = 0.02, 0.5, 0.3, 2.4  # s, m, rad, m
MOST_STEPS, MOST_FORCE = 200, 10.0  # N


class CartPole:
    """The environment: observations are place, angle and their rates."""

    def __init__(self) -> None:
        scene = kf.System(gravity=(0, -9.81, 0))
        cart = scene.add_rigid_body("cart", 1.0, joint=kf.Prismatic("x"))
        up = kf.Revolute("z", forces=kf.CoordinateForce(damping=1e-3))
        scene.add_rigid_body("pole", 0.1, 0.1 * LENGTH**2 / 3, com=(0, LENGTH, 0), parent=cart, joint=up)
        names = [f"joint_{what} {body}" for what in ("coordinates", "speeds") for body in ("cart", "pole")]
        self.sim = scene.start(inputs="motor cart", outputs=names, every=DT)
        self.start = self.sim.save()
        self.steps = 0

    def reset(self, seed: int) -> tuple[np.ndarray, dict]:
        """Begin anew: a random push, as long as one step."""
        self.sim.restore(self.start)
        self.steps = 0
        self.sim.step(DT, {"motor cart": float(np.random.default_rng(seed).uniform(-2.0, 2.0))})
        return self._seen(), {}

    def step(self, action: float) -> tuple[np.ndarray, float, bool, bool, dict]:
        """Push the cart; return what is seen, the reward, whether the pole fell, and whether the time is over."""
        self.sim.step(DT, {"motor cart": float(np.clip(action, -MOST_FORCE, MOST_FORCE))})
        self.steps += 1
        seen = self._seen()
        has_fallen = bool(abs(seen[1]) > FALLEN or abs(seen[0]) > OFF_TRACK)
        return seen, 1.0, has_fallen, self.steps >= MOST_STEPS, {}

    def _seen(self) -> np.ndarray:
        return np.array(list(self.sim.outputs.values()))


def stands(environment: CartPole, law: np.ndarray, seed: int) -> float:
    """Return for how many steps a law keeps the pole up."""
    seen, _ = environment.reset(seed)
    total, is_over = 0.0, False
    while not is_over:
        seen, reward, has_fallen, is_late, _ = environment.step(law @ seen)
        total, is_over = total + reward, has_fallen or is_late
    return total


environment, generator = CartPole(), np.random.default_rng(1)
mean, spread, history = np.zeros(4), 5.0 * np.ones(4), []
for generation in range(6):
    laws = generator.normal(mean, spread, size=(16, 4))
    scores = np.array([stands(environment, law, seed=generation) for law in laws])
    best = laws[np.argsort(scores)[-4:]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 0.5
    history.append(DT * scores)
    print(f"generation {generation}: {DT * scores.mean():.2f} s up on average, {DT * scores.max():.2f} s at best")

# a push that was not part of the search
checked = (stands(environment, mean, seed=1000), float(MOST_STEPS), 0.0)
print(f"the law {mean.round(2)} keeps the pole up for {DT * checked[0]:.2f} s of {DT * MOST_STEPS:.2f} s")
rate = math.sqrt(9.81 / (4.0 / 3.0 * LENGTH))
print(f"left alone it falls by a factor e in {1.0 / rate:.2f} s")
