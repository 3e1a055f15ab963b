"""Execution of parts of a campaign by workers.

Parts are computed in batches of half a second, so that many parts bear the cost of a call. Each worker computes one
batch while another one waits. Parts of batches during which a worker died are suspects. They are computed one by one at
the end, so that a part that kills its worker is identified with certainty.
"""

import contextlib
import functools
import math
import queue
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn

from tailslap import progress
from tailslap.campaign import pools
from tailslap.campaign.records import Journal, Key, Records, program
from tailslap.case import resources

BATCH_S = 0.5
"""Time that a batch is to take [s]."""
MAX_IN_BATCH = 1000
"""Most parts of a batch."""
BATCHES_A_WORKER = 2
"""Submitted batches of a worker, one of which is computed."""


Arguments = Mapping[str, tuple[object, ...]]
"""Arguments of parts by key."""

Group = tuple[Callable[..., object], Arguments, str]
"""A function, its arguments by key, and a label."""

Results = dict[str, Any]
"""Results of parts by key, as JSON returns them."""

Batch = Future[pools.BatchResult]


class Parts(NamedTuple):
    """A function and the arguments of each key.

    `died` returns the record of a key that kills its worker.
    """

    function: Callable[..., object]
    keys: list[Key]
    arguments: Callable[[Key], tuple[object, ...]]
    died: Callable[[Key], object]


@dataclass(frozen=True)
class CampaignEffort:
    """Number of parts, threads and times [s].

    `wall_s` is the wall time, `runs_s` the sum of the parts' own times.
    """

    runs: int = 0
    threads: int = 0
    wall_s: float = 0.0
    runs_s: float = 0.0

    @property
    def rate(self) -> float:
        """Return the number of parts per second."""
        return self.runs / self.wall_s if self.runs else 0.0

    @property
    def overhead_s(self) -> float:
        """Return the overhead of a part [s]."""
        return (self.wall_s * self.threads - self.runs_s) / self.runs if self.runs else 0.0


def run_parts(
    function: Callable[..., object],
    parts: Arguments,
    journal: Journal,
    label: str,
    workers: int | None = None,
    expected: Mapping[str, float] = MappingProxyType({}),
    pool_of: Callable[[int], pools.Pool] | None = None,
) -> None:
    """Compute the missing parts of a journal.

    An error of a part is raised. parts: arguments of the function by key; journal: open, receives the results; label:
    on the progress bar; workers: number of processes, by default one per core, a single one is this process; expected:
    processor time of each part [s] where it is known, such that the longest parts come first, and the sum is announced;
    pool_of: returns a pool of this number of workers that outlasts the call, by default one is started.
    """
    records = journal.records
    costs = {key: expected.get(key, 1.0) for key in parts if key not in records}
    missing: list[Key] = [*sorted(costs, key=costs.__getitem__, reverse=True)]
    if not missing:
        return
    count = resources.worker_count(workers, len(missing))
    work = (0.0, *accumulate(costs[str(key)] for key in reversed(missing)))
    if expected:
        cores = f"{count} cores" if count > 1 else "one core"
        wall = max(work[-1] / count, costs[str(missing[0])])
        progress.estimated(f"{label}: expected time {progress.clock(wall)} on {cores}")
    with contextlib.ExitStack() as stack:
        size = count if count > 1 else 0
        pool = pool_of(size) if pool_of else stack.enter_context(pools.local(size))
        total, before = len(parts), len(parts) - len(missing)
        work_left = lambda complete: work[round(total - complete)]  # noqa: E731
        show = stack.enter_context(progress.counted(label, total, before, work_left=work_left))
        todo = Parts(function, missing, lambda key: parts[str(key)], _died)
        Engine(todo, records, pool).run(lambda threads: show(sum(key in records for key in parts)))


@contextlib.contextmanager
def study(
    place: Path,
    definition: Mapping[str, object],
    workers: int | None = None,
    expected: Mapping[str, float] = MappingProxyType({}),
) -> Iterator[Callable[[Group], Results]]:
    """Yield a function that computes groups of parts.

    All groups have the same workers. An interrupted study resumes from its journal.
    """
    scene = definition["scene"]
    assert isinstance(scene, Mapping)
    with Journal(place, definition) as journal, contextlib.ExitStack() as stack:
        pool_of = functools.cache(lambda size: stack.enter_context(pools.local(size)))

        def results(group: Group) -> Results:
            function, parts, label = group
            run_parts(function, parts, journal, f"{scene['name']}: {label}", workers, expected, pool_of)
            return {key: journal.records[key] for key in parts}

        yield results


def run_study(
    place: Path,
    definition: Mapping[str, object],
    group: Group,
    workers: int | None = None,
    expected: Mapping[str, float] = MappingProxyType({}),
) -> Results:
    """Return the results of a group of parts by key."""
    with study(place, definition, workers, expected) as results:
        return results(group)


def _died(key: Key) -> NoReturn:
    """Raise an error for a part that killed its worker."""
    raise OSError(f"{key}: its process died in every attempt; insufficient memory is a possible cause")


class Engine:
    """State of the parts that wait, are submitted or suspect."""

    def __init__(self, parts: Parts, records: Records, pool: pools.Pool) -> None:
        self._parts, self._records, self._pool = parts, records, pool
        self._waiting: deque[Key] = deque(parts.keys)
        self._suspects: deque[Key] = deque()
        self._under_way: dict[Batch, list[Key]] = {}
        self._alone: Batch | None = None  # a suspect, with no other batch from start to end
        self._done: queue.SimpleQueue[Batch] = queue.SimpleQueue()
        self._seconds = BATCH_S  # of a part, so that the first batches are of one part
        self._own_s, self._threads = 0.0, 0

    def run(self, report: Callable[[int], None]) -> CampaignEffort:
        """Compute and record all parts and return the effort.

        The first error of a part is raised. After an interruption, finished parts are still recorded. report: takes the
        number of workers, about every second and after each batch.
        """
        began, threads = time.perf_counter(), 0
        try:
            while self._waiting or self._suspects or self._under_way:
                self._threads = self._pool.threads()
                threads = max(threads, self._threads)
                report(self._threads)
                self._fill()
                self._collect(pools.POLL_S)
        except KeyboardInterrupt:
            self._collect(0.0)
            raise
        return CampaignEffort(len(self._parts.keys), threads, time.perf_counter() - began, self._own_s)

    def _fill(self) -> None:
        """Submit batches, and suspects one by one at the end."""
        most = BATCHES_A_WORKER * max(1, self._threads)
        while self._waiting and len(self._under_way) < most:
            # Smaller batches towards the end, so that all workers end together.
            fair = math.ceil(len(self._waiting) / most / 2.0)
            size = max(1, min(int(BATCH_S / self._seconds), MAX_IN_BATCH, fair))
            self._submit([self._waiting.popleft() for _ in range(size)])
        if self._suspects and not self._under_way:
            self._alone = self._submit([self._suspects.popleft()])

    def _submit(self, keys: list[Key]) -> Batch:
        """Submit these parts as one batch."""
        batch = [(key, self._parts.arguments(key)) for key in keys]
        future = self._pool.submit(pools.run_batch, program(), self._parts.function, batch)
        self._under_way[future] = keys
        future.add_done_callback(self._done.put)
        return future

    def _collect(self, timeout: float) -> None:
        """Wait for a batch, then record finished ones."""
        records: dict[Key, object] = {}
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

    def _take(self, future: Batch, records: dict[Key, object], seconds: dict[Key, float]) -> None:
        """Add the records of a finished batch, or queue its parts again."""
        keys = self._under_way.pop(future)
        try:
            result: pools.BatchResult = future.result()
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
        records |= result.records
        seconds |= result.seconds
        if result.seconds:
            mean = math.fsum(result.seconds.values()) / len(result.seconds)
            self._seconds = max(1e-6, 0.5 * (self._seconds + mean))
        if result.error:
            raise result.error
