"""Pictures, pages and models: what a person looks at. Needs the `viz` extra."""

from graft.viz.sheet import save_sheet
from graft.viz.views import save_views

__all__ = ["save_sheet", "save_views"]
