"""Hands parts to workers in batches, and puts their records on disk as they come.

A batch is as large as half a second's work, so that what a call costs is shared by many parts; each worker has one
batch to do and one in waiting. The parts of batches under which a worker died are suspects: each is made alone at the
end, with nothing else under way, so that one that kills its worker is known for certain.
"""

import contextlib
import math
import queue
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from itertools import accumulate
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from tailslap import progress
from tailslap.campaign import pools
from tailslap.campaign.records import Journal, Key, Records, program
from tailslap.case import cost

BATCH_S = 0.5
MAX_IN_BATCH = 1000
BATCHES_A_WORKER = 2


Group = tuple[Callable[..., Any], Mapping[str, tuple[Any, ...]], str]
"""A function, its arguments by key, and a label."""


class Parts(NamedTuple):
    """A function to call with the arguments of each key; died: the record of a key under which its worker dies."""

    function: Callable[..., Any]
    keys: list[Key]
    arguments: Callable[[Key], tuple[Any, ...]]
    died: Callable[[Key], Any]


@dataclass(frozen=True)
class CampaignEffort:
    """Effort of making parts: how many, on how many threads, wall time [s] and the sum of the parts' own times [s]."""

    runs: int = 0
    threads: int = 0
    wall_s: float = 0.0
    runs_s: float = 0.0

    @property
    def rate(self) -> float:
        """Parts a second."""
        return self.runs / self.wall_s if self.runs else 0.0

    @property
    def overhead_s(self) -> float:
        """Cost of a part to a thread beyond its own time [s]."""
        return (self.wall_s * self.threads - self.runs_s) / self.runs if self.runs else 0.0


def perform(parts: Parts, records: Records, pool: pools.Pool, look: Callable[[int], None]) -> CampaignEffort:
    """Make all parts and record them, until all is done or an error is raised in one.

    look: called with the number of workers, each second and whenever something came. Interrupted, it takes what is
    finished already.
    """
    return _Engine(parts, records, pool).run(look)


def run_parts(
    function: Callable[..., Any],
    parts: Mapping[str, tuple[Any, ...]],
    journal: Journal,
    label: str,
    workers: int | None = None,
    expected: Mapping[str, float] = MappingProxyType({}),
) -> None:
    """Call function(*arguments) for every part that the journal lacks; the results are records of the journal.

    workers: processes, None for one a core; a single one is this process itself. expected: processor time of each part
    [s], where it is known; the longest come first, and the sum is announced. An error in a part is raised here.
    """
    records = journal.records
    costs = {key: expected.get(key, 1.0) for key in parts if key not in records}
    left: list[Key] = [*sorted(costs, key=costs.__getitem__, reverse=True)]
    if not left:
        return
    count = cost.worker_count(workers, len(left))
    work = (0.0, *accumulate(costs[str(key)] for key in reversed(left)))
    if expected:
        cores = f"{count} cores" if count > 1 else "one core"
        wall = max(work[-1] / count, costs[str(left[0])])
        progress.estimated(f"{label}: expected time {progress.clock(wall)} on {cores}")
    with contextlib.ExitStack() as stack:
        pool = stack.enter_context(pools.local(count if count > 1 else 0))
        total, before = len(parts), len(parts) - len(left)
        rest = partial(_work_left, work, total)
        show = stack.enter_context(progress.counted(label, total, before, work_left=rest))
        todo = Parts(function, left, lambda key: parts[str(key)], _died)
        perform(todo, records, pool, lambda threads: show(len(records)))


def _work_left(work: Sequence[float], total: int, done: float) -> float:
    return work[round(total - done)]


@contextlib.contextmanager
def study(
    place: Path,
    definition: Mapping[str, Any],
    workers: int | None = None,
    expected: Mapping[str, float] = MappingProxyType({}),
) -> Iterator[Callable[[Group], dict[str, Any]]]:
    """Yield a function from a group of parts to its results; an interrupted study goes on from its journal."""
    name = definition["scene"]["name"]
    with Journal(place, definition) as journal:

        def results(group: Group) -> dict[str, Any]:
            function, parts, label = group
            run_parts(function, parts, journal, f"{name}: {label}", workers, expected)
            return {key: journal.records[key] for key in parts}

        yield results


def run_study(
    place: Path,
    definition: Mapping[str, Any],
    groups: Sequence[Group],
    workers: int | None = None,
    expected: Mapping[str, float] = MappingProxyType({}),
) -> list[dict[str, Any]]:
    """Results by key of each group of parts, see `study`."""
    with study(place, definition, workers, expected) as results:
        return [results(group) for group in groups]


def _died(key: Key) -> Any:
    raise OSError(f"{key}: its process died in every attempt; insufficient memory is a possible cause")


class _Engine:
    """The parts that are still to do, those under way, and how long a part takes."""

    def __init__(self, parts: Parts, records: Records, pool: pools.Pool) -> None:
        self._parts, self._records, self._pool = parts, records, pool
        self._waiting: deque[Key] = deque(parts.keys)
        self._suspects: deque[Key] = deque()
        self._under_way: dict[Future[Any], list[Key]] = {}
        self._alone: Future[Any] | None = None  # under way with nothing beside it from its start to its end
        self._done: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
        self._seconds = BATCH_S  # of a part: until one is known, a batch is one part
        self._own_s, self._threads = 0.0, 0

    def run(self, look: Callable[[int], None]) -> CampaignEffort:
        began, most = time.perf_counter(), 0
        try:
            while self._waiting or self._suspects or self._under_way:
                self._threads = self._pool.threads()
                most = max(most, self._threads)
                look(self._threads)
                self._fill()
                self._collect(pools.LOOK_S)
        except KeyboardInterrupt:
            self._collect(0.0)
            raise
        return CampaignEffort(len(self._parts.keys), most, time.perf_counter() - began, self._own_s)

    def _fill(self) -> None:
        most = BATCHES_A_WORKER * max(1, self._threads)
        while self._waiting and len(self._under_way) < most:
            # Half a second, but at the end few enough that all workers end together.
            fair = math.ceil(len(self._waiting) / most / 2.0)
            size = max(1, min(int(BATCH_S / self._seconds), MAX_IN_BATCH, fair))
            self._submit([self._waiting.popleft() for _ in range(size)])
        if self._suspects and not self._under_way:
            self._alone = self._submit([self._suspects.popleft()])

    def _submit(self, keys: list[Key]) -> Future[Any]:
        batch = [(key, self._parts.arguments(key)) for key in keys]
        future = self._pool.submit(pools.run_batch, program(), self._parts.function, batch)
        self._under_way[future] = keys
        future.add_done_callback(self._done.put)
        return future

    def _collect(self, timeout: float) -> None:
        """Wait for a batch, and take it with all others that are there: they go to disk in one piece."""
        records: dict[Key, Any] = {}
        seconds: dict[Key, float] = {}
        try:
            self._take(self._done.get(timeout=timeout), records, seconds)
            while True:
                self._take(self._done.get_nowait(), records, seconds)
        except queue.Empty:
            pass
        finally:
            if records:
                self._records.add(records, seconds)
                self._own_s += math.fsum(seconds.values())

    def _take(self, future: Future[Any], records: dict[Key, Any], seconds: dict[Key, float]) -> None:
        """Add the records of a batch that has come back, or take up its parts again."""
        keys = self._under_way.pop(future)
        try:
            done: pools.BatchResult = future.result()
        except self._pool.died:
            if future is self._alone:
                records[keys[0]] = self._parts.died(keys[0])
            else:
                self._suspects.extend(keys)
            return
        except self._pool.again:
            self._pool.threads()  # raises an error if all is lost
            self._waiting.extendleft(reversed(keys))
            return
        except Exception as error:
            raise self._pool.fault(error) from None
        records |= done.records
        seconds |= done.seconds
        if done.seconds:
            mean = math.fsum(done.seconds.values()) / len(done.seconds)
            self._seconds = max(1e-6, 0.5 * (self._seconds + mean))
        if done.error:
            raise done.error
