"""Hands the runs of a sweep to workers in batches, and takes their rows as they come.

A batch is as large as half a second's work, so that what a task costs Dask is shared by many runs; each worker has one
batch to do and one in waiting. A batch under which workers die again and again is taken apart at the end: each
of its runs is made alone, with nothing else under way, so that a run that kills its worker is known for certain.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import math
import queue
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import tailslap
from tailslap.sweep.cluster import other_version
from tailslap.sweep.row import broken_row
from tailslap.sweep.worker import Finished, OtherVersionError, Task, finished, run_batch

if TYPE_CHECKING:
    from distributed import Client, Future

BATCH_S = 0.5
MOST_IN_BATCH = 1000
BATCHES_A_WORKER = 2
LOOK_S = 1.0
"""Seconds between looks at the cluster where nothing comes."""
RESULT_S = 5.0
"""Seconds within which the rows of a finished batch must come; its worker may have died with them: then again."""

KILLS = "its worker died each time that it was computed, alone at last"

Compute = Callable[[str, str, Sequence[Task]], list[Finished]]


class SchedulerLostError(Exception):
    """The connection to the scheduler is gone, and what the scheduler knew with it."""


class WorkersLostError(Exception):
    """No worker has been there for longer than it takes Dask to start one again."""


class Dispatcher:
    """The runs that are still to do, those under way, and how long a run takes.

    text: the scene's; compute: what a worker does with a batch; take: what is done with rows; patience: seconds
    without any worker after which it gives up.
    """

    def __init__(
        self,
        client: Client,
        text: str,
        tasks: Sequence[Task],
        take: Callable[[list[Finished]], None],
        compute: Compute = run_batch,
        patience: float = math.inf,
    ) -> None:
        self._client, self._text, self._take, self._compute = client, text, take, compute
        self._waiting: deque[Task] = deque(tasks)
        self._suspects: deque[Task] = deque()
        self._under_way: dict[Any, list[Task]] = {}
        self._alone: Future | None = None  # under way with nothing beside it from its start to its end
        self._done: queue.SimpleQueue[Future] = queue.SimpleQueue()
        self._seconds = BATCH_S  # of a run: until one is known, a batch is one run
        self._threads, self._looked = 0, -math.inf
        self._patience, self._worked = patience, time.monotonic()

    def run(self, look: Callable[[int], None]) -> None:
        """Until all is done; look(threads of all workers) is called at least every second."""
        while True:
            self._look()
            look(self._threads)
            self._fill()
            if not self._under_way:
                return
            self._collect(LOOK_S)

    def collect_now(self) -> None:
        """Take what is finished already."""
        self._collect(0.0)

    def _look(self) -> None:
        if self._client.status != "running":
            raise SchedulerLostError
        if time.monotonic() - self._looked > LOOK_S:
            try:
                self._threads = sum(self._client.nthreads().values())
            except (OSError, TimeoutError):
                raise SchedulerLostError from None
            self._looked = time.monotonic()
        if self._threads:
            self._worked = time.monotonic()
        elif time.monotonic() - self._worked > self._patience:
            raise WorkersLostError

    def _fill(self) -> None:
        while self._waiting and len(self._under_way) < BATCHES_A_WORKER * max(1, self._threads):
            self._submit([self._waiting.popleft() for _ in range(self._batch_size())])
        if self._suspects and not self._under_way:
            self._alone = self._submit([self._suspects.popleft()])

    def _batch_size(self) -> int:
        """Runs of half a second, but at the end few enough that all workers end together."""
        fair = len(self._waiting) / (BATCHES_A_WORKER * max(1, self._threads))
        return max(1, min(int(BATCH_S / self._seconds), MOST_IN_BATCH, math.ceil(fair / 2.0)))

    def _submit(self, tasks: list[Task]) -> Future:
        future = self._client.submit(self._compute, tailslap.__version__, self._text, tasks, pure=False)
        self._under_way[future] = tasks
        future.add_done_callback(self._done.put)
        return future

    def _collect(self, timeout: float) -> None:
        """Wait for a batch, and take it with all others that are there: they go to disk in one piece."""
        rows: list[Finished] = []
        try:
            rows += self._rows_of(self._done.get(timeout=timeout))
            while True:
                rows += self._rows_of(self._done.get_nowait())
        except queue.Empty:
            pass
        finally:
            if rows:
                self._take(rows)

    def _rows_of(self, future: Future) -> list[Finished]:
        from distributed.comm import CommClosedError

        tasks = self._under_way.pop(future)
        try:
            rows: list[Finished] = future.result(timeout=RESULT_S)
        except (TimeoutError, asyncio.CancelledError, concurrent.futures.CancelledError, CommClosedError):
            if self._client.status != "running":
                raise SchedulerLostError from None
            future.cancel()
            self._waiting.extendleft(reversed(tasks))
            return []
        except Exception as error:
            return self._failed(tasks, error, future is self._alone)
        measured = sum(row.seconds for row in rows) / len(rows)
        self._seconds = max(1e-6, 0.5 * (self._seconds + measured))
        return rows

    def _failed(self, tasks: list[Task], error: Exception, alone: bool) -> list[Finished]:
        from distributed import KilledWorker

        if isinstance(error, OtherVersionError):
            raise other_version(self._client.scheduler.address, "a worker has", str(error))
        if not isinstance(error, KilledWorker):
            raise other_version(self._client.scheduler.address, "a worker has", error)
        if alone:
            return [finished(broken_row(tasks[0].run, KILLS))]
        self._suspects.extend(tasks)
        return []
