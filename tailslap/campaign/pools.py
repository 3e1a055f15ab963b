"""Workers: processes of this machine, or those of a Dask scheduler; both are a pool that takes calls."""

import asyncio
import contextlib
import fcntl
import importlib
import io
import logging
import multiprocessing
import os
import select
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from tailslap import errors, progress
from tailslap.campaign.records import Key, program

NEEDED = ("fem.run.corner", "tailslap.case.corner.plan", "tailslap.case.corner.run")
"""Modules that runs need, imported before a worker has its first part."""
LIBRARIES = ("llvmlite.binding", "scipy.linalg", "skfem")
"""Modules that those import when they are called."""

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)
DESCRIPTORS = Path("/proc/self/fd")
"""Open files of this process, which a worker opens once more for itself."""
ENDING = {signal.SIGTERM, signal.SIGHUP}
LOGGERS = ("distributed", "asyncio", "tornado")
ANSWER_S = 5.0
"""Seconds within which a scheduler must reply."""
LOOK_S = 1.0
"""Seconds between looks at a cluster, or at workers from which nothing comes."""

Errors = tuple[type[BaseException], ...]


class LostError(OSError):
    """The workers are gone, and what was under way with them."""


class OtherProgramError(Exception):
    """The worker has another version of this program than the one that sent the batch."""


class BatchResult(NamedTuple):
    """Results and times [s] by key, up to the first part that raised an error."""

    records: dict[Key, Any]
    seconds: dict[Key, float]
    error: Exception | None


def run_batch(
    sender: str, function: Callable[..., Any], parts: list[tuple[Key, tuple[Any, ...]]]
) -> BatchResult:
    """Call the function with each part's arguments, one after the other; sender: the program that asks for it."""
    if sender != program():
        raise OtherProgramError(program())
    records: dict[Key, Any] = {}
    seconds: dict[Key, float] = {}
    with contextlib.redirect_stderr(io.StringIO()):  # the progress of single runs is not for the terminal
        for key, arguments in parts:
            began = time.perf_counter()
            try:
                records[key] = function(*arguments)
            except Exception as error:
                return BatchResult(records, seconds, error)
            seconds[key] = time.perf_counter() - began
    return BatchResult(records, seconds, None)


def make_ready() -> str:
    """Import what runs need, once a worker; returns the program."""
    os.environ[progress.MODE] = "none"
    for module in NEEDED:
        importlib.import_module(module)
    return program()


class Pool:
    """Workers of one thread each: processes of this machine, forked from one that has imported what they need, and
    started anew if one dies.

    Attributes
    ----------
    died : tuple of exception classes
        Of a call under which its worker died.
    again : tuple of exception classes
        Of a call that was lost on its way and can be made again.
    """

    died: Errors = (BrokenProcessPool,)
    again: Errors = ()

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload([__name__, *NEEDED, *LIBRARIES])
        ours, self._lifeline = context.Pipe(duplex=False)
        self._executor = ProcessPoolExecutor(self._workers, context, _begin, (ours,))
        try:
            with _server_environment(), _hidden_script():
                first = self._executor.submit(make_ready)
            first.result()
        except BrokenProcessPool:
            raise LostError("no worker remains") from None
        except KeyboardInterrupt:  # processes that have just been started need this one for a moment yet
            self.close()
            raise

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Have a worker make the call."""
        with _hidden_script():
            try:
                return self._executor.submit(function, *arguments)
            except BrokenProcessPool:
                self.close()
                self._start()
                return self._executor.submit(function, *arguments)

    def threads(self) -> int:
        """Number of workers. Raises LostError."""
        return self._workers

    def fault(self, error: Exception) -> Exception:
        """Error to raise for another error of a call."""
        return error

    def close(self) -> None:
        """End all processes, whatever they do."""
        self._lifeline.close()
        self._executor.shutdown(cancel_futures=True)


class _ThisProcess(Pool):
    """This process as a pool of one worker: a call is made when it is submitted."""

    def __init__(self) -> None:
        self._workers = 1

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Make the call."""
        done: Future[Any] = Future()
        done.set_result(function(*arguments))
        return done

    def close(self) -> None:
        """End nothing: no process was started."""


def _begin(lifeline: Connection) -> None:
    """Have the kernel end this process when the other end of the pipe closes, which the death of its owner does too.

    A signal of the pipe, not a thread: compiled code may hold the interpreter for minutes.
    """
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    own = os.open(DESCRIPTORS / str(lifeline.fileno()), os.O_RDONLY | os.O_NONBLOCK)
    fcntl.fcntl(own, fcntl.F_SETOWN, os.getpid())
    # SIGIO ends a process that does not handle it.
    fcntl.fcntl(own, fcntl.F_SETFL, os.O_ASYNC | os.O_NONBLOCK)
    if select.select([own], [], [], 0.0)[0]:
        os._exit(1)


@contextlib.contextmanager
def _server_environment() -> Iterator[None]:
    """Processes started here never get a Ctrl-C, which is for us, use one thread, and see our modules.

    What else ends us waits until they are started: one that is left half-started would print its trace.
    """
    resource_tracker.ensure_running()  # when it starts, it would unblock the signals
    ours = {**ONE_THREAD, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONSAFEPATH": "1"}
    given = {name: os.environ.get(name) for name in ours}
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, *ENDING})
    os.environ.update(ours)
    try:
        yield
    finally:
        for name in ours:
            os.environ.pop(name)
        os.environ.update({name: value for name, value in given.items() if value is not None})
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


@contextlib.contextmanager
def _hidden_script() -> Iterator[None]:
    """Have processes that are started meanwhile not import the main module again, of which they need nothing: a script
    without `if __name__ == "__main__":` would start them anew."""
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


@contextlib.contextmanager
def local(workers: int) -> Iterator[Pool]:
    """So many processes of this machine, ended after; none, or without /proc: this process. Raises LostError."""
    if not workers or not DESCRIPTORS.is_dir():
        yield _ThisProcess()
        return
    with progress.announced("Starting processes ..."):
        pool = Pool(workers)
    with contextlib.closing(pool):
        yield pool


class _Cluster(Pool):
    """The workers of a scheduler, which may come and go."""

    def __init__(self, client: Any, address: str) -> None:
        from distributed import KilledWorker
        from distributed.comm import CommClosedError

        self.died = (KilledWorker,)
        self.again = (TimeoutError, CancelledError, asyncio.CancelledError, CommClosedError)
        self._client, self._address = client, address
        self._executor = client.get_executor(pure=False)
        self._workers, self._looked = 0, -LOOK_S

    def threads(self) -> int:
        """Number of threads of all workers, as of a second ago at most. Raises LostError without a scheduler."""
        try:
            if self._client.status != "running":
                raise TimeoutError
            if time.monotonic() - self._looked > LOOK_S:
                self._workers, self._looked = sum(self._client.nthreads().values()), time.monotonic()
        except (OSError, TimeoutError):
            raise LostError(f"the connection to the scheduler at {self._address} is lost") from None
        return self._workers

    def fault(self, error: Exception) -> Exception:
        """Wrong input: a worker that cannot load this program, or has another one."""
        return _other_program(self._address, "a worker has", error)


@contextlib.contextmanager
def cluster(address: str) -> Iterator[Pool]:
    """The workers of the scheduler at this address. All have been asked for their version of this program.

    Raises InputError for a scheduler that does not reply, or for workers with another version.
    """
    with contextlib.ExitStack() as stack:
        with progress.announced("Connecting to the scheduler ..."):
            from distributed import Client

            stack.enter_context(warnings.catch_warnings())
            warnings.filterwarnings("ignore", module="distributed")
            for logger in map(logging.getLogger, LOGGERS):  # what matters of connections we say ourselves
                stack.callback(logger.setLevel, logger.level)
                logger.setLevel(logging.CRITICAL + 1)
            try:  # not by making a client: one that cannot connect leaves threads behind
                kind = asyncio.run(asyncio.wait_for(_kind(address), ANSWER_S))
            except Exception as error:  # Dask raises half a dozen kinds for addresses that are none
                kind = str(error).splitlines()[0] if str(error) else f"no reply within {ANSWER_S:g} s"
            if kind != "Scheduler":
                allowed = (
                    f"no Dask scheduler replies ({kind}); allowed is an address like tcp://127.0.0.1:8786"
                )
                raise errors.InputError("--cluster", address, allowed)
            client = stack.enter_context(Client(address))
            for worker, reply in client.run(make_ready, on_error="return").items():
                if reply != program():
                    raise _other_program(address, f"the worker at {worker} has", reply)
        yield _Cluster(client, address)


async def _kind(address: str) -> str:
    """Part of Dask that listens at the address, like Scheduler or Worker."""
    from distributed.core import rpc

    async with rpc(address, timeout=ANSWER_S) as there:
        return str((await there.identity())["type"])


def _other_program(address: str, who: str, reply: Any) -> errors.InputError:
    """The error for a worker that has another version of this program, or cannot load it."""
    reply = str(reply) if isinstance(reply, OtherProgramError) else reply
    has = f"tailslap {reply}" if isinstance(reply, str) else f"no working tailslap ({reply})"
    allowed = f"{who} {has}; all workers require {program()}"
    return errors.InputError("--cluster", errors.Verbatim(address), allowed)
