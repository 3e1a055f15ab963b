"""Verification: threads of the time loop sleep while they wait, and are not used where they would hurt."""

import threading
import time

import pytest

from fem.explicit.parallel import Meeting, _meet, new_meeting
from tailslap.case.corner.case import CornerCase
from tailslap.case.corner.decisions import ELEMENTS_A_THREAD, open_threads
from tailslap.scene.read import read_scene

LATE = 0.5


def test_who_waits_long_sleeps():
    """The processor time of a thread that waits half a second for another is a fraction of that."""
    _meet(new_meeting(), 1, 1)  # compiled
    meeting, spent = new_meeting(), []

    def wait() -> None:
        before = time.thread_time()
        _meet(meeting, 2, 1)
        spent.append(time.thread_time() - before)

    first = threading.Thread(target=wait)
    first.start()
    time.sleep(LATE)
    assert first.is_alive()
    _meet(meeting, 2, 1)
    first.join(10.0)
    assert spent
    assert spent[0] < 0.1 * LATE


def test_threads_meet_again_and_again():
    """Three threads and 2 000 meetings, on however few cores: none is missed, and all come to the end."""
    meeting, done = new_meeting(), []

    def attend(meeting: Meeting) -> None:
        for turn in range(1, 2001):
            _meet(meeting, 3, turn)
        done.append(True)

    threads = [threading.Thread(target=attend, args=(meeting,), daemon=True) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert len(done) == 3


@pytest.mark.parametrize(
    ("elements", "used"), [((20, 6), 1), ((200, 60), 1), ((200, 100), 2), ((320, 96), 3)]
)
def test_threads_are_as_many_as_the_mesh_has_work_for(elements, used):
    plan = CornerCase(*read_scene("paper-table-3", (f"plate.elements={list(elements)}", "time.threads=3")))
    assert plan.scene.plate
    decisions = open_threads(plan, plan.scene.plate)
    assert plan.decided(decisions).scene.time.threads == used
    assert [decision.value for decision in decisions] == ([] if used == 3 else [used])
    for decision in decisions:
        assert "3 were asked for" in decision.why
        assert str(ELEMENTS_A_THREAD) in decision.why


def test_run_and_check_say_that_one_thread_is_used():
    plan = CornerCase(*read_scene("paper-table-3", ("time.threads=2",)))
    fe_plan = plan.plan()
    assert fe_plan.case.scene.time.threads == 1
    assert [decision.key for decision in fe_plan.decisions] == ["time.threads"]
    assert fe_plan.decisions[0].shown.startswith("time.threads = 1: 2 were asked for; ")
