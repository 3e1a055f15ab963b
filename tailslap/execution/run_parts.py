"""The parts of a study, computed and noted in its journal as they finish."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from typing import Any

import tailslap
from tailslap.case.cost import available_cores
from tailslap.execution.cluster import connected
from tailslap.execution.dispatch import Dispatcher, Work
from tailslap.execution.journal import Journal
from tailslap.execution.record_file import Key
from tailslap.execution.worker import Part, run_batch
from tailslap.progress import counted


def run_parts(
    function: Callable[..., Any],
    parts: Mapping[str, tuple[Any, ...]],
    journal: Journal,
    label: str,
    workers: int | None = None,
) -> None:
    """Call function(*arguments) for every part that the journal lacks; the results are records of the journal.

    workers: processes, None for one a core; a single one is this process itself. An error in a part is raised here.
    """
    left = [key for key in parts if key not in journal.records]
    if not left:
        return
    count = min(workers or available_cores(), len(left))
    with contextlib.ExitStack() as stack:
        client = stack.enter_context(connected(None, count)) if count > 1 else None
        show = stack.enter_context(counted(label, len(parts), len(parts) - len(left)))

        def take(records: Mapping[Key, Any]) -> None:
            journal.records.add(records)
            show(len(journal.records))

        if client:
            work = Work(function, left, lambda key: parts[str(key)], _died)
            Dispatcher(client, work, take).run(lambda threads: show(len(journal.records)))
            return
        for key in left:
            done = run_batch(tailslap.__version__, function, [Part(key, parts[key])])
            if done.error:
                raise done.error
            take(done.records)


def _died(key: Key) -> Any:
    raise OSError(f"{key}: its process died each time that it was computed; perhaps memory ran out")
