# %% [markdown]
# # A rotating blade and its Campbell diagram
#
# A spinning blade becomes stiffer because the centrifugal force straightens it. `stiffening="full"` includes
# this effect in the body.

# %%
import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

glass = Material(E=35e9, nu=0.3, rho=1900.0)
blade = beam_body(
    straight_beam(6.0, Rectangle(0.5, 0.08), glass, elements=16),
    {"root": "clamped"},
    reduction=kf.CraigBampton(modes=8, loads=("centrifugal",)),
    stiffening="full",
)
blade


# %%
def spinning(speed):
    scene = kf.System()
    spin = kf.Revolute("z", motion=kf.Motion.steady(speed))
    scene.add_flexible_body("blade", blade, joint=spin)
    return scene


for speed in (0.0, 20.0, 40.0):
    modes = kf.equilibrium(spinning(speed)).linearise().modes()
    lowest = ", ".join(f"{f:.2f}" for f in modes.frequencies[:4])
    print(f"{speed:4.0f} rad/s: {lowest} Hz")

# %% [markdown]
# The diagram over all speeds has the lines of integer multiples of the speed: where one crosses a frequency, that
# mode can be excited.

# %%
diagram = kf.campbell(spinning, np.linspace(0.0, 50.0, 26))
diagram.plot()

# %%
kf.equilibrium(spinning(40.0)).linearise().modes()

# %% [markdown]
# In this run the blade is accelerated to 30 rad/s within a second, and lags behind the hub meanwhile.

# %%
t = np.linspace(0.0, 2.0, 401)
s = np.clip(t, 0.0, 1.0)
angle = 30.0 * (s**3 - 0.5 * s**4) + 30.0 * np.clip(t - 1.0, 0.0, None)  # a smooth start
scene = kf.System()
driven = kf.Revolute("z", motion=kf.Motion.table(t, angle))
scene.add_flexible_body("blade", blade, joint=driven)
result = scene.simulate((0.0, 2.0))
result.view(scale=5.0, title="a blade is brought to speed")
