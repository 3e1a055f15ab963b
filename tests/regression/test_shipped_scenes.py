"""Record numbers of this program, so that changes are detected.

They were printed by the program; nothing here confirms them.
"""

from collections.abc import Callable
from typing import Any

import pytest


@pytest.mark.long
def test_work_is_bounded(outcome: Callable[..., Any]) -> None:
    """More steps of the shipped scenes have no reason."""
    assert outcome("paper-table-3").run.steps == pytest.approx(5676, abs=3)
    assert outcome("paper-abaqus").run.steps == pytest.approx(5663, abs=3)


def test_differences_of_the_shipped_scene(outcome: Callable[..., Any]) -> None:
    expected = {"t": -2.139e-7, "v_gx": -3.748e-7, "v_gy": 2.2375e-6, "omega": 3.046e-7, "slide": -2.993e-7}
    assert outcome("paper-table-3").difference == pytest.approx(expected, abs=2e-9)
