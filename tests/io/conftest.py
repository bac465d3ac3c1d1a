from __future__ import annotations

import pytest
from solids import Box


@pytest.fixture
def body():
    return Box(size=(0.08, 0.08, 0.1))


@pytest.fixture
def handle():
    return Box(low=(0.08, 0.03, 0.02), size=(0.03, 0.02, 0.06))
