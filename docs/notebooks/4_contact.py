# %% [markdown]
# # Contact and friction
#
# On a ramp of 15 degrees a block slides, a wheel rolls without slipping, and a box is caught by a flexible
# stop.

# %%
import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

shapes = kf.shapes
slope = np.radians(15.0)
tilted = kf.rotation_about("y", slope)
scene = kf.System(gravity=(0, 0, -9.81))
ramp = scene.ground.frame(orientation=tilted)  # x leads down the slope, z away from it
deck = scene.add_surface("deck", ramp, shapes.Plane("z"))
law = kf.HuntCrossley(2e6, damping=2.0)


def on_ramp(x, y, z):
    return tuple(ramp.axes @ (x, y, z))


lies = kf.Free(position=on_ramp(0, 0, 0.1), orientation=tilted)
block = scene.add_rigid_body("block", 5.0, 0.05, joint=lies)
feet = scene.add_surface("feet", block, shapes.Box((0.3, 0.3, 0.2)))
scene.add_contact("block", feet, deck, normal=law, friction=kf.Coulomb(0.2))

stands = kf.Free(position=on_ramp(0, 1, 0.35))
wheel = scene.add_rigid_body("wheel", 8.0, (0.36, 0.72, 0.36), joint=stands)
tyre = scene.add_surface("tyre", wheel, shapes.Torus(0.3, 0.05, axis="y"))
scene.add_contact("tyre", tyre, deck, normal=law, friction=kf.Coulomb(0.6))

# %% [markdown]
# The stop is a beam that stands on the ramp. Nodes of flexible bodies can touch surfaces: its second node
# touches the box.

# %%
aluminium = Material(E=70e9, nu=0.3, rho=2700.0)
post = beam_body(
    straight_beam(0.4, Rectangle(0.03, 0.03), aluminium, elements=4),
    {"root": "clamped", "tip": "rigid"},
    reduction=kf.CraigBampton(modes=4),
    damping=kf.ModalDamping(0.05),
)
upright = kf.rotation_about("y", slope - np.pi / 2)  # along the normal of the ramp
stop = scene.add_flexible_body("stop", post, at=on_ramp(0.8, -1, 0), orientation=upright)
behind = kf.Free(position=on_ramp(0, -1, 0.1), orientation=tilted)
box = scene.add_rigid_body("box", 5.0, 0.05, joint=behind)
sole = scene.add_surface("sole", box, shapes.Box((0.2, 0.2, 0.2)))
scene.add_contact("box", sole, deck, normal=law)
front = scene.add_surface("front", box, shapes.Box((0.2, 0.2, 0.2)))
scene.add_contact("stop", stop.node(1), front, normal=kf.HuntCrossley(1e6, damping=1.0))
scene

# %%
result = scene.simulate((0.0, 1.5))
result

# %%
result.view(scale=20.0, title="three ways down a ramp")

# %%
print(result.contact_report())

# %%
result.plot("contacts", "stop")

# %% [markdown]
# The block follows the closed form of a sliding body, the wheel that of a rolling body:

# %%
down, g, end = ramp.axes[:, 0], 9.81, result.times[-1]
inertia = 0.72 / (8.0 * 0.35**2)  # of the wheel, over m r^2
for name, a in (
    ("block", g * (np.sin(slope) - 0.2 * np.cos(slope))),
    ("wheel", g * np.sin(slope) / (1 + inertia)),
):
    way = (result.position(name)[-1] - result.position(name)[0]) @ down
    print(f"the {name} goes {way:.4f} m; closed form {0.5 * a * end**2:.4f} m")
