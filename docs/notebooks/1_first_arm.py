# %% [markdown]
# # A first flexible arm
#
# A hub with a motor carries a flexible arm, and the arm carries a mass at its tip. The arm is made of beam
# elements, so that this notebook runs without a mesh; the [second one](2_own_mesh.md) makes a body from a mesh.

# %%
import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

aluminium = Material(E=70e9, nu=0.33, rho=2700.0)
# 1 m along x, 40 x 10 mm
beam = straight_beam(1.0, Rectangle(0.04, 0.01), aluminium, elements=12)
body = beam_body(
    beam,
    {"root": "clamped", "tip": "rigid"},
    reduction=kf.CraigBampton(modes=6),
    damping=kf.ModalDamping(0.01),
)
body

# %% [markdown]
# A body at the end of a cell is displayed with its picture, mass and frequencies. The root is *clamped*: the
# frame of the arm is fixed there, and its mode shapes are those of a cantilever. The *rigid* tip can carry
# another body.

# %%
scene = kf.System(gravity=(0, 0, -9.81))
hub = scene.add_rigid_body("hub", mass=2.0, inertia=0.01, joint=kf.Revolute("z"))
arm = scene.add_flexible_body("arm", body, parent=hub, at=(0.05, 0, 0))
tip = scene.add_rigid_body("tip", mass=0.3, inertia=2e-4, parent=arm.interface("tip"))
still = scene.copy()  # without the motor: for the modes below


def motor(t):
    return 6.0 * np.sin(2 * np.pi * t / 0.8) if t < 0.8 else 0.0


scene.add_torque(hub, motor)
scene

# %%
result = scene.simulate((0.0, 1.6))
result

# %% [markdown]
# The run as an animation: rotate it with the mouse, play it, and scale its displacements.
# `result.to_html("run.html")` writes the same view to a file that opens in any browser.

# %%
result.view(title="a first arm")

# %%
result.plot("deflection", "arm", "tip")

# %% [markdown]
# Force and moment at the root of the arm are computed from the equations of the components that are fixed there.

# %%
force = result.coupling_force("arm", "root")
most = np.abs(force).max(axis=0)
print(f"at most {most[:3].max():.1f} N and {most[3:].max():.2f} N m")
print(f"energy balance to {np.abs(result.energy.balance_error).max():.1e} J")

# %% [markdown]
# The modes of the whole scene about its equilibrium under gravity, with a hub that is free to rotate:

# %%
rest = kf.equilibrium(still.copy())
kf.linearise(still, start=rest).modes()
