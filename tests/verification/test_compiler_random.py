"""Verify compiled functions on random programs, against Python.

Exact: no number of `random_kernels` is rounded.
"""

from collections import Counter

import pytest
from random_kernels import check, check_outside

pytestmark = pytest.mark.usefixtures("keeping")


@pytest.mark.parametrize("first", [100_000, 200_000])
def test_random_programs_have_the_results_of_python(first):
    outcomes = Counter(map(check, range(first, first + 36)))
    assert outcomes["same"] > 27


def test_random_programs_with_a_statement_outside_of_the_language_are_refused():
    assert all(map(check_outside, range(100_000, 100_040)))


@pytest.mark.long
def test_many_random_programs_have_the_results_of_python():
    """The programs are others than those of the short test."""
    assert Counter(map(check, range(300_000, 303_000)))["same"] > 2_400
