"""Read an object and look at its parts
====================================

Every named geometry of a scene is a part. Here the file is made on the fly; any GLB, OBJ, PLY, STL, OFF, MJCF or URDF
of your own is read by the same call.
"""

# %%
# A hammer of two named meshes, written as GLB.
import tempfile
from pathlib import Path

import trimesh

import graft

folder = Path(tempfile.mkdtemp())
scene = trimesh.Scene()
handle = trimesh.creation.cylinder(radius=0.015, height=0.30)
head = trimesh.creation.box(extents=(0.10, 0.03, 0.03))
head.apply_translation((0.0, 0.0, 0.165))
scene.add_geometry(handle, geom_name="handle")
scene.add_geometry(head, geom_name="head")
scene.export(folder / "hammer.glb")

# %%
# Reading it gives a :class:`graft.PartObject`; its part graph has boxes, samples and relations.
hammer = graft.load_object(folder / "hammer.glb")
graph = graft.build_graph(hammer)
for name, extents in zip(hammer.part_names, 2 * graph.half_extents, strict=True):
    print(f"{name}: {' x '.join(f'{100 * e:.1f}' for e in extents)} cm")
print("touching:", graph.adjacency.tolist())

# %%
# A picture needs no OpenGL.
picture = folder / "hammer.png"
graft.save_views(picture, hammer)
print("wrote", sorted(path.name for path in folder.iterdir()))
