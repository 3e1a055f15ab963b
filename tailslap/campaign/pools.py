"""Pools of workers, processes of this machine or of a Dask cluster."""

import asyncio
import contextlib
import importlib
import io
import logging
import os
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from machine_code.system import operating_system
from tailslap import errors, progress
from tailslap.campaign.records import Key, program
from tailslap.case import resources

if TYPE_CHECKING:
    from distributed import Client

T = TypeVar("T")

NEEDED = ("fem.run.corner", "tailslap.case.corner.corner_plan", "tailslap.case.corner.corner_run")
"""Modules of runs, imported before the first part of a worker."""
LIBRARIES = ("llvmlite.binding", "scipy.linalg", "skfem")
"""Libraries that these modules import when they are called."""

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
LOGGERS = ("distributed", "distributed.client", "distributed.gc", "asyncio", "tornado", "tornado.application")
"""Loggers of Dask with levels of their own, silenced because connection errors are reported here."""
START_S = 120.0
"""Time within which the processes of this machine must start [s]."""
REPLY_S = 5.0
"""Time within which a scheduler must reply [s]."""
POLL_S = 1.0
"""Interval between checks of a cluster, or of idle workers [s]."""

LEAST_ADDRESS_SPACE = 512e6
"""Address space with which the libraries of a run and of its table can be loaded [bytes]; without it they hang."""

Errors = tuple[type[BaseException], ...]

BROKEN: Errors = (BrokenProcessPool, EOFError, ConnectionError)
"""Errors of starting a worker: it has died, or the process from which it is forked."""


class LostError(OSError):
    """The workers and their unfinished parts are lost."""


class OtherProgramError(Exception):
    """The worker has another program than the sender."""


class BatchResult(NamedTuple):
    """Results and times [s] of a batch by key.

    They end at the first part that raised an error.
    """

    records: dict[Key, Any]
    seconds: dict[Key, float]
    error: Exception | None


def run_batch(
    sender: str, function: Callable[..., object], parts: list[tuple[Key, tuple[object, ...]]]
) -> BatchResult:
    """Call the function with the arguments of each part.

    sender: program that sends the batch, see `program`; parts: key and arguments of each part. Raises OtherProgramError
    if this program is not the sender's.
    """
    if sender != program():
        raise OtherProgramError(program())
    records: dict[Key, object] = {}
    seconds: dict[Key, float] = {}
    with contextlib.redirect_stderr(io.StringIO()):  # hide the progress of single runs
        for key, arguments in parts:
            began = time.perf_counter()
            try:
                records[key] = function(*arguments)
            except Exception as error:
                return BatchResult(records, seconds, error)
            seconds[key] = time.perf_counter() - began
    return BatchResult(records, seconds, None)


def make_ready() -> str:
    """Import the modules of runs and return the program."""
    os.environ[progress.MODE] = "none"
    for module in NEEDED:
        importlib.import_module(module)
    return program()


class Pool:
    """Worker processes of this machine, one thread each.

    They are forked from a process that has imported the modules of runs, and restarted if one dies.

    Attributes
    ----------
    died : tuple of exception classes
        Errors of a call during which its worker died.
    again : tuple of exception classes
        Errors of a call that was lost in transit and can be repeated.
    """

    died: Errors = (BrokenProcessPool,)
    again: Errors = ()

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._start()

    def _start(self) -> None:
        """Start the processes and import the modules of runs.

        Raises LostError if no worker remains.
        """
        context = operating_system.worker_context([__name__, *NEEDED, *LIBRARIES])
        ours, self._lifeline = context.Pipe(duplex=False)
        self._executor = ProcessPoolExecutor(self._workers, context, operating_system.end_with_owner, (ours,))
        first: Future[str] = Future()

        def start() -> None:
            try:
                with _server_environment(), _hidden_script():
                    worker = self._executor.submit(make_ready)
                first.set_result(worker.result())
            except BaseException as error:
                first.set_exception(error)

        # It waits in the system with its signals blocked, so that another thread takes them.
        threading.Thread(target=start, daemon=True).start()
        try:
            first.result(START_S)
        except BROKEN:
            self._end()
            raise LostError("no worker remains") from None
        except TimeoutError:
            self._end()
            raise LostError(f"no process of workers has started within {START_S:g} s") from None
        except KeyboardInterrupt:
            self._end()
            raise

    def _end(self) -> None:
        """End processes that may be starting."""
        operating_system.end_starting_workers()
        self.close()

    def submit(self, function: Callable[..., T], *arguments: object) -> Future[T]:
        """Submit a call to a worker. Raises LostError."""
        with _hidden_script(), contextlib.suppress(*BROKEN):
            return self._executor.submit(function, *arguments)
        self.close()
        self._start()
        try:
            with _hidden_script():
                return self._executor.submit(function, *arguments)
        except BROKEN:
            raise LostError("no worker remains") from None

    def threads(self) -> int:
        """Return the number of workers. Raises LostError."""
        return self._workers

    def fault(self, error: Exception) -> Exception:
        """Return the error to raise for an error of a call."""
        return error

    def close(self) -> None:
        """Terminate all processes."""
        self._lifeline.close()
        self._executor.shutdown(cancel_futures=True)


class _ThisProcess(Pool):
    """This process as a pool of one worker."""

    def __init__(self) -> None:
        self._workers = 1

    def submit(self, function: Callable[..., T], *arguments: object) -> Future[T]:
        """Make the call."""
        future: Future[T] = Future()
        future.set_result(function(*arguments))
        return future

    def close(self) -> None:
        """Do nothing, since no process was started."""


@contextlib.contextmanager
def _server_environment() -> Iterator[None]:
    """Set environment and signals of new processes.

    They use one thread, find the modules of this process and never receive Ctrl-C. Other signals that end this process
    wait until they have started, because a process that is interrupted at its start prints a trace.
    """
    variables = {**ONE_THREAD, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONSAFEPATH": "1"}
    before = {name: os.environ.get(name) for name in variables}
    with operating_system.held_signals():
        os.environ.update(variables)
        try:
            yield
        finally:
            for name in variables:
                os.environ.pop(name)
            os.environ.update({name: value for name, value in before.items() if value is not None})


@contextlib.contextmanager
def _hidden_script() -> Iterator[None]:
    """Prevent new processes from importing the main module.

    They do not need it, and a script without `if __name__ == "__main__":` would start them again.
    """
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


@contextlib.contextmanager
def local(workers: int) -> Iterator[Pool]:
    """Start processes of this machine and end them.

    Without workers the pool is this process. Raises LostError.
    """
    if (limit := resources.address_space()) < LEAST_ADDRESS_SPACE:
        raise LostError(
            f"the address space of a process is limited to {limit / 1e6:.0f} MB (ulimit -v); "
            f"required are {LEAST_ADDRESS_SPACE / 1e6:.0f} MB"
        )
    if not workers:
        yield _ThisProcess()
        return
    with progress.announced("Starting processes ..."):
        pool = Pool(workers)
    with contextlib.closing(pool):
        yield pool


class _Cluster(Pool):
    """Workers of a scheduler, whose number may change."""

    def __init__(self, client: "Client", address: str) -> None:
        from distributed import KilledWorker
        from distributed.comm import CommClosedError

        self.died = (KilledWorker,)
        self.again = (TimeoutError, CancelledError, asyncio.CancelledError, CommClosedError)
        self._client, self._address = client, address
        self._executor = client.get_executor(pure=False)
        self._workers, self._looked = 0, -POLL_S

    def threads(self) -> int:
        """Return the number of threads of all workers.

        It is at most one second old. Raises LostError without a scheduler.
        """
        try:
            if self._client.status != "running":
                raise TimeoutError
            if time.monotonic() - self._looked > POLL_S:
                self._workers, self._looked = sum(self._client.nthreads().values()), time.monotonic()
        except (OSError, TimeoutError):
            raise LostError(f"the connection to the scheduler at {self._address} is lost") from None
        return self._workers

    def fault(self, error: Exception) -> Exception:
        """Return the error for a worker without this program."""
        return _other_program(self._address, "a worker has", error)


@contextlib.contextmanager
def cluster(address: str) -> Iterator[Pool]:
    """Connect to the workers of a scheduler.

    Raises InputError for a scheduler that does not reply, or for workers with another version of this program.
    """
    with contextlib.ExitStack() as stack:
        with progress.announced("Connecting to the scheduler ..."):
            from distributed import Client

            stack.enter_context(warnings.catch_warnings())
            warnings.filterwarnings("ignore", module="distributed")
            for logger in map(logging.getLogger, LOGGERS):
                stack.callback(logger.setLevel, logger.level)
                logger.setLevel(logging.CRITICAL + 1)
            try:  # without a client, since one that cannot connect leaves threads behind
                kind = asyncio.run(asyncio.wait_for(_kind(address), REPLY_S))
            except Exception as error:  # Dask raises many kinds of errors for invalid addresses
                kind = str(error).splitlines()[0] if str(error) else f"no reply within {REPLY_S:g} s"
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
    """Return the kind of Dask server at the address."""
    from distributed.core import rpc

    async with rpc(address, timeout=REPLY_S) as server:
        return str((await server.identity())["type"])


def _other_program(address: str, who: str, reply: object) -> errors.InputError:
    """Return the error for a worker without this program."""
    reply = str(reply) if isinstance(reply, OtherProgramError) else reply
    has = f"tailslap {reply}" if isinstance(reply, str) else f"no working tailslap ({reply})"
    allowed = f"{who} {has}; all workers require {program()}"
    return errors.InputError("--cluster", errors.Verbatim(address), allowed)
