import warnings

import pytest


@pytest.fixture(scope="session")
def ot():
    """POT; it warns on import about backends that are not installed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pytest.importorskip("ot")
