"""Fixtures of tests of pages."""

import pytest
from browser.session import MISSING, chromium


@pytest.fixture(scope="module")
def browser():
    """Start Chromium, or skip tests where a part of it is missing."""
    if MISSING:
        pytest.skip(f"not installed: {', '.join(MISSING)}")
    with chromium() as started:
        yield started
