"""Physics needs the extra."""

from __future__ import annotations

import pytest

pytest.importorskip("mujoco")
