"""Mark a contact on your own object
=================================

A demonstration is an object and a contact. Mark it on a part, save it, and any later session can transfer it.
"""

# %%
# Arrays will do: vertices, faces and one label per face.
import tempfile
from pathlib import Path

import numpy as np
import trimesh

import graft

body = trimesh.creation.cylinder(radius=0.04, height=0.10)
handle = trimesh.creation.torus(major_radius=0.025, minor_radius=0.006)
handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0)))
handle.apply_translation((0.06, 0.0, 0.0))
mesh = trimesh.util.concatenate([body, handle])
labels = np.repeat([0, 1], [len(body.faces), len(handle.faces)])
mug = graft.as_object((mesh.vertices, mesh.faces, labels))
print(mug.part_names)

# %%
# Without a point the contact goes to the middle of the part; a point is snapped to the surface.
demonstration = graft.mark_contact(mug, mug.part_names[1], point=(0.085, 0.0, 0.0))
print(demonstration.contact.point, demonstration.contact.normal)

# %%
# A demonstration is a folder with a GLB and a JSON file; a library is a folder of those.
folder = Path(tempfile.mkdtemp())
graft.save_demonstration(folder / "my_mug", demonstration)
library = graft.Library.open(folder)

# %%
# A larger, turned mug gets the same contact.
turn = trimesh.transformations.rotation_matrix(0.7, (0, 0, 1)) @ np.diag([2.0, 2.0, 2.0, 1.0])
found = graft.transfer_contact(library.retrieve(mug.transformed(turn))[0])
expected = (turn @ [*demonstration.contact.point, 1])[:3]
print("distance to where it should be:", np.linalg.norm(found.contact.point - expected).round(4))
