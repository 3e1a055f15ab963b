"""Hands parts to workers in batches, and takes their records as they come.

A batch is as large as half a second's work, so that what a task costs Dask is shared by many parts; each worker has one
batch to do and one in waiting. A batch under which workers die again and again is taken apart at the end: each
of its parts is made alone, with nothing else under way, so that one that kills its worker is known for certain.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import math
import queue
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import tailslap
from tailslap.execution.cluster import other_version
from tailslap.execution.record_file import Key
from tailslap.execution.worker import Finished, OtherVersionError, Part, run_batch

if TYPE_CHECKING:
    from distributed import Client, Future

BATCH_S = 0.5
MAX_IN_BATCH = 1000
BATCHES_A_WORKER = 2
LOOK_S = 1.0
"""Seconds between looks at the cluster where nothing comes."""
RESULT_S = 5.0
"""Seconds within which the records of a finished batch must come; its worker may have died with them: then again."""
PATIENCE_S = 60.0
"""Seconds without any worker of this machine after which one gives up: Dask restarts one in two or three."""


class SchedulerLostError(OSError):
    """The connection to the scheduler is gone, and what the scheduler knew with it."""


class WorkersLostError(OSError):
    """No worker has been there for longer than it takes Dask to start one again."""


@dataclass(frozen=True)
class Work:
    """A function to call with the arguments of each key; died: the record of a key under which workers only die."""

    function: Callable[..., Any]
    keys: Sequence[Key]
    arguments: Callable[[Key], tuple[Any, ...]]
    died: Callable[[Key], Any]


class Dispatcher:
    """The parts that are still to do, those under way, and how long a part takes.

    take: what is done with records; patience: seconds without any worker after which it gives up.
    """

    def __init__(
        self,
        client: Client,
        work: Work,
        take: Callable[[Mapping[Key, Any]], None],
        patience: float = PATIENCE_S,
    ) -> None:
        self._client, self._work, self._take = client, work, take
        self._waiting: deque[Key] = deque(work.keys)
        self._suspects: deque[Key] = deque()
        self._under_way: dict[Any, list[Key]] = {}
        self._alone: Future | None = None  # under way with nothing beside it from its start to its end
        self._done: queue.SimpleQueue[Future] = queue.SimpleQueue()
        self._seconds = BATCH_S  # of a part: until one is known, a batch is one part
        self._threads, self._looked = 0, -math.inf
        self._patience, self._worked = patience, time.monotonic()

    def run(self, look: Callable[[int], None]) -> None:
        """Until all is done or an error is raised in a part; look(threads of all workers) is called every second.

        Interrupted, it takes what is finished already.
        """
        try:
            while self._looked_and_filled(look):
                self._collect(LOOK_S)
        except KeyboardInterrupt:
            self._collect(0.0)
            raise

    def _looked_and_filled(self, look: Callable[[int], None]) -> bool:
        """Whether anything is under way."""
        self._look()
        look(self._threads)
        self._fill()
        return bool(self._under_way)

    def _look(self) -> None:
        if self._client.status != "running":
            raise SchedulerLostError("the scheduler is gone")
        if time.monotonic() - self._looked > LOOK_S:
            try:
                self._threads = sum(self._client.nthreads().values())
            except (OSError, TimeoutError):
                raise SchedulerLostError("the scheduler is gone") from None
            self._looked = time.monotonic()
        if self._threads:
            self._worked = time.monotonic()
        elif time.monotonic() - self._worked > self._patience:
            raise WorkersLostError("no worker is left")

    def _fill(self) -> None:
        while self._waiting and len(self._under_way) < BATCHES_A_WORKER * max(1, self._threads):
            self._submit([self._waiting.popleft() for _ in range(self._batch_size())])
        if self._suspects and not self._under_way:
            self._alone = self._submit([self._suspects.popleft()])

    def _batch_size(self) -> int:
        """Parts of half a second, but at the end few enough that all workers end together."""
        fair = len(self._waiting) / (BATCHES_A_WORKER * max(1, self._threads))
        return max(1, min(int(BATCH_S / self._seconds), MAX_IN_BATCH, math.ceil(fair / 2.0)))

    def _submit(self, keys: list[Key]) -> Future:
        parts = [Part(key, self._work.arguments(key)) for key in keys]
        batch = (tailslap.__version__, self._work.function, parts)
        future = self._client.submit(run_batch, *batch, pure=False)
        self._under_way[future] = keys
        future.add_done_callback(self._done.put)
        return future

    def _collect(self, timeout: float) -> None:
        """Wait for a batch, and take it with all others that are there: they go to disk in one piece."""
        records: dict[Key, Any] = {}
        try:
            self._add_records_of(self._done.get(timeout=timeout), records)
            while True:
                self._add_records_of(self._done.get_nowait(), records)
        except queue.Empty:
            pass
        finally:
            if records:
                self._take(records)

    def _add_records_of(self, future: Future, records: dict[Key, Any]) -> None:
        from distributed.comm import CommClosedError

        keys = self._under_way.pop(future)
        try:
            done: Finished = future.result(timeout=RESULT_S)
        except (TimeoutError, asyncio.CancelledError, concurrent.futures.CancelledError, CommClosedError):
            if self._client.status != "running":
                raise SchedulerLostError("the scheduler is gone") from None
            future.cancel()
            self._waiting.extendleft(reversed(keys))
            return
        except Exception as error:
            records |= self._failed(keys, error, future is self._alone)
            return
        self._seconds = max(1e-6, 0.5 * (self._seconds + done.seconds))
        records |= done.records
        if done.error:
            raise done.error

    def _failed(self, keys: list[Key], error: Exception, alone: bool) -> dict[Key, Any]:
        """What is known of a batch that did not come back: nothing, or that its only part kills its worker."""
        from distributed import KilledWorker

        if not isinstance(error, KilledWorker):
            reply = str(error) if isinstance(error, OtherVersionError) else error
            raise other_version(self._client.scheduler.address, "a worker has", reply)
        if alone:
            return {keys[0]: self._work.died(keys[0])}
        self._suspects.extend(keys)
        return {}
