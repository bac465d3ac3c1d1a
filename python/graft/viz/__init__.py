"""Pictures, pages and models: what a person looks at. Needs the `viz` extra."""

from graft.viz.grasp_sheet import save_grasp_sheet
from graft.viz.model import save_glb, save_grasp_glb
from graft.viz.page import save_grasp_scene, save_object_scene, save_scene
from graft.viz.sheet import save_sheet
from graft.viz.views import save_views

__all__ = [
    "save_glb",
    "save_grasp_glb",
    "save_grasp_scene",
    "save_grasp_sheet",
    "save_object_scene",
    "save_scene",
    "save_sheet",
    "save_views",
]
