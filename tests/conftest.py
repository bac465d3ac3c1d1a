"""Before anything imports mujoco: what it draws with is chosen once."""

from __future__ import annotations

from graft.sim.engine import choose_gl

choose_gl()
