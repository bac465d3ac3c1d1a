"""One demonstration, an object never seen
=======================================

A library of demonstrated objects, a target of another category, and the contact that graft proposes for it.
"""

# %%
# The zoo has demonstrated and unseen categories; each seed is another variant.
import tempfile
from pathlib import Path

import graft
from graft import zoo

library = graft.Library()
for category in zoo.demonstrated():
    library.add(zoo.demonstration(category, seed=1))
kettle = zoo.make("kettle", seed=3)

# %%
# Matches come best first; each has the transport plan between the parts.
matches = library.retrieve(kettle, k=3)
for match in matches:
    print(f"{match.demonstration.name}: cost {match.cost:.4f}")

# %%
# The contact lies on the kettle's surface, with its normal and the transform that carries a gripper pose along.
result = graft.transfer_contact(matches[0])
part = kettle.part_names[result.target_part]
print(f"contact on the {part} at {result.contact.point.round(3)}, confidence {result.confidence:.2f}")
print(result.transform.round(3))

# %%
# A page with both objects, parts coloured by the match, needs no network. The same as a picture:
folder = Path(tempfile.mkdtemp())
page, picture = folder / "kettle.html", folder / "kettle.png"
graft.save_sheet(picture, result)
graft.save_scene(page, result)
print(f"{page.name}: {page.stat().st_size / 1e6:.1f} MB")
