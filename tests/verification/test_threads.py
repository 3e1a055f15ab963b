"""Verify barriers of threads, and the number that a run uses."""

import threading
import time

import pytest

from fem.explicit.parallel import _wait_for_all, new_barrier
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.decisions import ELEMENTS_A_THREAD, open_threads
from tailslap.scene.read import read_scene

LATE = 0.5


def test_who_waits_long_sleeps():
    """A thread that waits half a second takes a fraction of that."""
    _wait_for_all(new_barrier(), 1, 1)  # compiled
    barrier, spent = new_barrier(), []

    def wait():
        before = time.thread_time()
        _wait_for_all(barrier, 2, 1)
        spent.append(time.thread_time() - before)

    first = threading.Thread(target=wait)
    first.start()
    time.sleep(LATE)
    assert first.is_alive()
    _wait_for_all(barrier, 2, 1)
    first.join(10.0)
    assert spent[0] < 0.1 * LATE


def test_threads_meet_again_and_again():
    """Three threads pass 2 000 barriers on any number of cores."""
    barrier, ended = new_barrier(), []

    def attend(barrier):
        for turn in range(1, 2001):
            _wait_for_all(barrier, 3, turn)
        ended.append(True)

    threads = [threading.Thread(target=attend, args=(barrier,), daemon=True) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert len(ended) == 3


@pytest.mark.parametrize(
    ("elements", "used"), [((20, 6), 1), ((200, 60), 1), ((200, 100), 2), ((320, 96), 3)]
)
def test_threads_are_as_many_as_the_mesh_has_work_for(elements, used):
    plan = CornerCase(*read_scene("paper-table-3", (f"plate.elements={list(elements)}", "time.threads=3")))
    decisions = open_threads(plan, plan.scene.needed_plate)
    assert plan.decided(decisions).scene.time.threads == used
    assert [decision.value for decision in decisions] == ([] if used == 3 else [used])
    for decision in decisions:
        assert "3 were requested" in decision.why
        assert str(ELEMENTS_A_THREAD) in decision.why


def test_run_and_check_say_that_one_thread_is_used():
    plan = CornerCase(*read_scene("paper-table-3", ("time.threads=2",)))
    fe_plan = plan.plan()
    assert fe_plan.case.scene.time.threads == 1
    assert [decision.key for decision in fe_plan.decisions] == ["time.threads"]
    assert fe_plan.decisions[0].text.startswith("time.threads = 1: 2 were requested; ")
