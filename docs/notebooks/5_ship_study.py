# %% [markdown]
# # A crate on a ship: a study over seas
#
# How often does a crate slip on the wet deck of a ship, depending on wave height and heading? We start with one
# run.

# %%
import numpy as np

import kanefe as kf


def crate_on_deck(state, heading, seed):
    """A crate on the deck of a frigate, 45 m from its middle, in a sea state."""
    ship = kf.Ship(kf.example_rao(), kf.Sea.state(state, seed=seed), heading_deg=heading)
    scene = kf.System(gravity=(0, 0, -9.81))
    deck = scene.add_frame("deck", joint=kf.Free(motion=ship.at((-45, 0, 6))))
    plating = scene.add_surface("plating", deck, kf.shapes.Plane("z"))
    free = kf.Free(position=(0, 0, 0.5))
    crate = scene.add_rigid_body("crate", 200.0, 40.0, parent=deck, joint=free)
    box = scene.add_surface("box", crate, kf.shapes.Box((1.2, 1.2, 1.0)))
    law = kf.HuntCrossley(2e6, damping=1.0)
    scene.add_contact("on deck", box, plating, normal=law, friction=kf.Coulomb(0.12))
    return scene


scene = crate_on_deck(6, 60, seed=1)
scene

# %%
result = scene.simulate((0.0, 60.0))
result

# %%
result.view(title="a crate in sea state 6")

# %%
contact = result.contact("on deck")
print(f"it slips by {contact.slip[-1] - contact.slip[result.times > 1.0][0]:.3f} m in a minute")

# %% [markdown]
# For each run the study records the friction that was required, and how far the crate slipped. In a notebook use
# the serial executor; a script uses all cores.


# %%
def kept(result):
    late = result.times > 2.0
    contact = result.contact("on deck")
    share = contact.tangential / np.maximum(contact.normal, 1.0)
    return {
        "friction": float(np.max(share[late])),
        "slip": float(np.ptp(contact.slip[late])),
    }


seas = {"state": [5, 6], "heading": [30.0, 90.0, 150.0], "seed": range(2)}
study = kf.Study(crate_on_deck, kept, duration=40.0, **seas)
table = study.run(executor="serial")
print(table)

# %%
often = table.operability({"slip": 0.01})
for row in often.rows():
    low, high = row["probability low"], row["probability high"]
    passed = f"{row['exceeded']} of {row['runs']} runs, probability {low:.2f} to {high:.2f}"
    print(f"sea state {row['state']}, {row['heading']:.0f} degrees: {passed}")

# %% [markdown]
# Each case of the table can be run again and viewed:

# %%
worst = int(np.argmax(table.column("slip")))
table.case(worst).view(title="the worst case")
