"""Verify the plates of a page, natively and as WebAssembly."""

from typing import Any

import numpy as np
import pytest
from web_module import Module

from fem.explicit.columns import Measures
from tailslap.browser import plate
from tailslap.case.corner.corner_run import attempt
from tailslap.case.of_arguments import case_of_scene
from tailslap.errors import InputError


@pytest.mark.parametrize("name", [
    "paper-table-3", *(pytest.param(name, marks=pytest.mark.long) for name in (*plate.SCENES[1:], "mash-tl1-car"))
])  # fmt: skip
def test_a_plate_is_that_of_the_command_and_in_webassembly(name):
    """They agree to 1e-9 of each column."""
    case: Any = case_of_scene(name, None)
    calls: Any = plate.calls_of(case.plan())
    module = Module(calls)
    kernel, arguments = calls["plate"]
    (count, t), rows, strike = kernel(*arguments), arguments[-3], arguments[-1]
    assert not rows[count:].any()
    struck: Any = attempt(case).run.strike
    values = struck.values
    expected = [values["t"], *(values[column] for column in Measures._fields)]
    scale = np.array([t, *map(scale_of, Measures._fields, np.abs(rows).max(axis=0))])
    assert (np.abs(np.array([t, *strike]) - expected) <= 1e-9 * scale).all()
    assert t == pytest.approx(case.tail_slap["t"], rel=1e-3)
    assert module.call("plate", 2)[1] == pytest.approx(t, rel=1e-12)
    for there, here in ((module["plate.rows"], rows), (module["plate.strike"], strike)):
        assert (np.abs(there - here) <= 1e-9 * scale[1:]).all()


def scale_of(column: str, largest: float) -> float:
    """Return the size to which numbers of a column are rounded.

    The gap is a difference of places, and the reaction a spring's of it. Energies of strain and vibration, and the work
    of damping, are of differences of motion.
    """
    sizes = {
        "gap": 1e-3,
        "damping_work": 1.0,
        "reaction_normal": 1e3 * largest,
        "reaction_tangential": 1e3 * largest,
    }
    return sizes.get(column, max(largest, 1.0) if "energy" in column else largest)


def test_a_plate_that_never_strikes_has_no_tail_slap():
    """It turns away from the wall, and its rows are all used."""
    case: Any = case_of_scene("paper-table-3", None)
    calls: Any = plate.calls_of(case.plan())
    kernel, arguments = calls["plate"]
    arguments[0].velocities[:] = 0.0
    count, t = kernel(*arguments)
    assert count == len(arguments[-3])
    assert np.isnan(t)


@pytest.mark.parametrize(("changes", "words"), [
    ({"plate.elements": [200, 60]}, "at most 5000 elements; `tailslap run paper-table-3`"),
    ({"plate": None, "wall": None}, "`tailslap rigid paper-table-3`"),
])  # fmt: skip
def test_plates_beyond_a_page_are_refused_with_the_command(changes, words):
    with pytest.raises(InputError, match=words):
        plate.demand_plate(case_of_scene("paper-table-3", changes))
