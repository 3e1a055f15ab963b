"""Independent parts of a study on several processes, noted in a journal as they finish."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any

from tailslap.progress import progress_bar
from tailslap.studies.journal import Journal


def run_parts(
    function: Callable[..., Any],
    parts: Mapping[str, tuple[Any, ...]],
    journal: Journal,
    label: str,
    workers: int | None = None,
) -> None:
    """Call function(*arguments) for every part that the journal lacks; the results are records of the journal."""
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from multiprocessing import active_children, get_context

    left = {key: arguments for key, arguments in parts.items() if key not in journal.records}
    if not left:
        return
    count = min(workers or os.cpu_count() or 1, len(left))
    with (
        progress_bar(label) as progress,
        ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=_quiet) as pool,
    ):
        try:
            waiting = {pool.submit(function, *arguments): key for key, arguments in left.items()}
            for future in as_completed(waiting):
                journal.add(waiting[future], future.result())
                progress(1.0 - (len(parts) - len(journal.records)) / len(parts))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in active_children():  # a part may take minutes more, and its result would be lost
                process.terminate()
            raise


def _quiet() -> None:
    """An interrupt is the parent's to handle; numerical libraries keep to one thread."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)
