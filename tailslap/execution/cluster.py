"""The workers: processes of this machine, or those of a Dask scheduler. Both are a Dask client."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import signal
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import tailslap
from tailslap.case.cost import available_cores
from tailslap.errors import InputError, Verbatim
from tailslap.execution.worker import make_ready
from tailslap.progress import announced

if TYPE_CHECKING:
    from distributed import Client

ANSWER_S = 5.0
"""Seconds within which a scheduler must reply."""

SETTINGS = {
    "distributed.scheduler.allowed-failures": 1,  # deaths of a worker under a batch before its parts are tried singly
    "distributed.worker.profile.enabled": False,  # this and the next three keep Dask's own share of the cores small
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.scheduler.http.routes": [],  # its web server cannot be left out: it serves nothing
    "distributed.worker.http.routes": [],
    "distributed.nanny.pre-spawn-environ": dict.fromkeys(
        ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
    ),
}


@contextlib.contextmanager
def connected(cluster: str | None, workers: int | None) -> Iterator[Client]:
    """A client of the scheduler at the address `cluster`, or else of `workers` processes made here and ended after.

    None: as many as this process may use cores. All workers have been asked for their version of this program.
    Raises InputError for a scheduler that does not reply, or for workers with another version.
    """
    starting = "Connecting to the scheduler ..." if cluster else "Starting processes ..."
    with contextlib.ExitStack() as stack:
        with announced(starting):
            import dask
            import distributed  # noqa: F401  its own settings must be there before ours, which are taken back at the end

            stack.enter_context(_quiet())
            stack.enter_context(dask.config.set(SETTINGS))
            client = stack.enter_context(
                _remote(cluster) if cluster else _local(workers or available_cores())
            )
            _check_versions(client, cluster)
        yield client


@contextlib.contextmanager
def _local(workers: int) -> Iterator[Client]:
    from distributed import Client, LocalCluster, Security

    security = (
        Security.temporary()
    )  # who runs code here needs a certificate that never leaves these processes
    with _workers_deaf_to_interrupts():
        cluster = LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            protocol="tls://",
            security=security,
            dashboard_address=None,
            scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
            memory_limit=0,
            silence_logs=logging.CRITICAL,
        )
    with cluster, Client(cluster, security=security) as client:
        yield client


@contextlib.contextmanager
def _workers_deaf_to_interrupts() -> Iterator[None]:
    """What is started here, or restarted from its threads, never gets a Ctrl-C: it is for us, and we end the workers.

    The mask of signals is inherited by threads and processes. An interrupt that comes meanwhile is delivered after.
    """
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # when it starts, it would unblock the signal
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def _remote(address: str) -> Iterator[Client]:
    from distributed import Client

    try:  # not by making a client: one that cannot connect leaves threads behind
        kind = asyncio.run(asyncio.wait_for(_kind(address), ANSWER_S))
    except Exception as error:  # Dask raises half a dozen kinds for addresses that are none
        kind = str(error).splitlines()[0] if str(error) else f"nothing within {ANSWER_S:g} s"
    if kind != "Scheduler":
        allowed = f"no Dask scheduler answers there ({kind}); allowed is an address like tcp://127.0.0.1:8786"
        raise InputError("--cluster", address, allowed)
    with Client(address) as client:
        yield client


async def _kind(address: str) -> str:
    """What of Dask listens at the address, like Scheduler or Worker."""
    from distributed.core import rpc

    async with rpc(address, timeout=ANSWER_S) as there:
        return str((await there.identity())["type"])


def _check_versions(client: Client, cluster: str | None) -> None:
    """Ask each worker that is there; those that come later are asked with each batch."""
    for worker, reply in client.run(make_ready, on_error="return").items():
        if reply != tailslap.__version__:
            raise other_version(cluster, f"the worker at {worker} has", reply)


def other_version(cluster: str | None, who: str, reply: Any) -> InputError:
    """The error for a worker that has another version of this program, or cannot load it."""
    has = f"tailslap {reply}" if isinstance(reply, str) else f"no tailslap that loads ({reply})"
    allowed = f"{who} {has}; allowed is {tailslap.__version__}, as here, on all workers"
    return InputError("--cluster", Verbatim(cluster or "this machine"), allowed)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep what Dask says about connections and workers off the terminal: what matters we say ourselves."""
    loggers = [logging.getLogger(name) for name in ("distributed", "asyncio", "tornado")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", module="distributed")
            yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
