"""Lets each call of a command to a result folder fail with each of six errors, and counts what came of it.

    .venv/bin/python benchmarks/io_errors.py [COMMAND...] [--every N]

COMMAND is `run`, `export` or `compare`, by default all; N: only every Nth call fails. The folder has an earlier result;
afterwards it must have that or the new one, whole, if need be after the next command has completed it. The status is 3,
2 where the folder itself cannot be used, or that of a command which does not need the call: the usual one only with the
new result. Anything else is printed with the number of the call, and the status is 1.
"""

from __future__ import annotations

import argparse
import builtins
import contextlib
import errno
import fcntl
import io
import os
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

ERRORS = (errno.ENOMEM, errno.EACCES, errno.ESTALE, errno.ENOSPC, errno.EIO, errno.EMFILE)
CALLS = (
    *(
        (os, name)
        for name in ("open", "stat", "lstat", "unlink", "replace", "mkdir", "rmdir", "listdir", "scandir")
    ),
    *((builtins, "open"), (io, "open"), (os, "fsync"), (os, "truncate"), (fcntl, "flock")),
)
"""Calls that may fail, where their first argument is a path in the folder or one of its open files."""
MODE = ("--set", "plate.elements=[6,2]", "--no-pictures")
EARLIER = {
    "run": ("run", "paper-table-3", *MODE, "--set", "corner.friction=0.2"),
    "export": ("export", "{given}", "--to", "csv"),
    "compare": ("compare", "{given}", "{other}"),
}
NEW = {
    "run": ("run", "paper-table-3", *MODE),
    "export": ("export", "{other}", "--to", "csv"),
    "compare": ("compare", "{other}", "{given}"),
}
ALLOWED = (0, 2, 3)
"""Exit statuses."""


class Injection:
    """Errors of the calls to files below a folder; number: the call that fails, 0: none; calls: how many there were."""

    def __init__(self, folder: Path, number: int, error: int) -> None:
        self._folder, self._number, self._error, self.calls = str(folder), number, error, 0

    @contextlib.contextmanager
    def active(self) -> Iterator[None]:
        """Intercept the calls in this block."""
        with contextlib.ExitStack() as stack:
            for module, name in CALLS:
                stack.enter_context(mock.patch.object(module, name, self._failing(getattr(module, name))))
            yield

    def _failing(self, call: Callable[..., Any]) -> Callable[..., Any]:
        def called(*given: Any, **options: Any) -> Any:
            if given and self._is_below(given[0]):
                self.calls += 1
                if self.calls == self._number:
                    raise OSError(self._error, os.strerror(self._error), str(given[0]))
            return call(*given, **options)

        return called

    def _is_below(self, given: Any) -> bool:
        if isinstance(given, int):
            with contextlib.suppress(OSError):
                given = os.readlink(f"/proc/self/fd/{given}")
        return isinstance(given, str | os.PathLike) and os.fspath(given).startswith(self._folder)


def said_by(words: tuple[str, ...]) -> tuple[int, str]:
    """Exit status and messages of a command."""
    from tailslap.cli import _status

    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as told:
        return _status(list(words)), told.getvalue()


def texts_of(folder: Path) -> dict[str, bytes] | None:
    """Histories and charts of a whole result by name; None for what is none."""
    from tailslap.files import manifest

    listed = manifest.read_manifest(folder)
    if listed is None or any(manifest.entry(folder / item.path) != item for item in listed):
        return None
    return {
        item.path: (folder / item.path).read_bytes()
        for item in listed
        if item.path.endswith((".csv", ".svg"))
    }


def judged(status: int, told: str, text: str, found: Any, before: Any, after: Any) -> str:
    """What came of a command; "BAD" where that must not be."""
    if status not in ALLOWED or "internal error" in told:
        return f"BAD status {status}: {told}"
    if found is None or found not in (before, after):
        return f"BAD folder with status {status}: {told}"
    if status == 0:
        return "new result" if found == after else f"BAD status 0 without the new result: {told}"
    lines = [line for line in told.splitlines() if ": remark: " not in line]
    if len(lines) != 1 or text not in told:
        return f"BAD message with status {status}: {told}"
    return f"status {status}, {'earlier' if found == before else 'new'} result"


def injected(kind: str, every: int, errors: tuple[int, ...] = ERRORS) -> Iterator[tuple[str, str]]:
    """Number and error of each call of a command, and what came of it."""
    from tailslap.files.folder import locked

    with tempfile.TemporaryDirectory() as name:
        root = Path(os.path.realpath(name))
        places = {label: root / label for label in ("given", "other", "earlier", "expected", "out")}
        words = {label: str(path) for label, path in places.items()}
        for label, line in (("given", EARLIER["run"]), ("other", NEW["run"])):
            assert said_by((*line, "--out", words[label]))[0] == 0
        for label, line in (("earlier", EARLIER[kind]), ("expected", NEW[kind])):
            usual = said_by((*(w.format(**words) for w in line), "--out", words[label]))[0]
        before, after = texts_of(places["earlier"]), texts_of(places["expected"])
        assert usual in (0, 1)
        assert before
        assert after
        assert before != after
        command = (*(w.format(**words) for w in NEW[kind]), "--out", words["out"])

        def attempt(number: int, error: int) -> tuple[int, int, str]:
            shutil.rmtree(places["out"], ignore_errors=True)
            shutil.copytree(places["earlier"], places["out"])
            injection = Injection(root, number, error)
            with injection.active():
                status, told = said_by(command)
            return injection.calls, status, told

        count, status, told = attempt(0, 0)
        assert (status, texts_of(places["out"])) == (usual, after), told
        for number in range(1, count + 1, every):
            for error in errors:
                _, status, told = attempt(number, error)
                with locked(places["out"]):  # as the next command does first
                    found = texts_of(places["out"])
                said = judged(
                    0 if status == usual else status, told, os.strerror(error), found, before, after
                )
                yield f"{kind}, call {number} of {count}, {errno.errorcode[error]}", said


def main() -> None:
    """Let calls fail, and print what came of it."""
    parser = argparse.ArgumentParser(description="Lets calls to a result folder fail.")
    parser.add_argument("commands", nargs="*", choices=[*NEW, []])
    parser.add_argument("--every", type=int, default=1)
    options = parser.parse_args()
    counted = Counter[str]()
    for kind in options.commands or NEW:
        for call, said in injected(kind, options.every):
            counted[f"{kind}: {said.partition(':')[0]}"] += 1
            if said.startswith("BAD"):
                print(f"{call}: {said}", flush=True)
    print(*(f"{times:6d}  {said}" for said, times in sorted(counted.items())), sep="\n")
    sys.exit(any("BAD" in said for said in counted))


if __name__ == "__main__":
    main()
