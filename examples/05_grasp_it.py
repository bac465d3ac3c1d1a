"""From a contact to grasps
========================

A contact is transferred to a kettle that nobody demonstrated, and a Panda's hand is placed there.
"""

# %%
# The library knows other categories; the contact comes with the part that it lies on.
import tempfile
from pathlib import Path

import graft
from graft import zoo

library = graft.Library()
for category in zoo.demonstrated():
    library.add(zoo.demonstration(category, seed=1))
kettle = zoo.make("kettle", seed=3)
contact = graft.agree([graft.transfer_contact(match) for match in library.retrieve(kettle, k=10)])[0].contact
print(f"contact on the {kettle.part_names[contact.part]}")

# %%
# Grasps come best first, in metres; an empty set says how many candidates fell for what.
grasps = graft.plan_grasps(kettle, contact, graft.PANDA_HAND, k=10)
for grasp in grasps[:3]:
    print(f"score {grasp.score:.3f}, {1000 * grasp.width:.0f} mm wide, {1000 * grasp.distance:.0f} mm from the contact")
print(f"{len(grasps)} grasps; rejected: {dict(grasps.rejected)}")

# %%
# They are saved with their gripper and seed, or in the formats of GraspNet (.npy) and GraspGen (.json).
folder = Path(tempfile.mkdtemp())
graft.save_grasps(folder / "grasps.npz", grasps)
print(f"{len(graft.load_grasps(folder / 'grasps.npz'))} grasps read back")

# %%
# The best five as pictures, the gripper closed on the kettle:
picture = folder / "grasps.png"
graft.save_grasp_sheet(picture, kettle, grasps, contact)
