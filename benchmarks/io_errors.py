"""Let calls of commands to files fail, and count the outcomes.

    .venv/bin/python benchmarks/io_errors.py [TRIAL...] [--every N] [--first N] [--errors NAME ...] [--in-turn]

All calls to the kernel below the working folder are intercepted, also those to open files (failing_calls.py). Scene,
input folders and an earlier result lie in that folder. Afterwards the result must be the earlier or the new one, whole,
if need be once the next command has completed it, and no other file may remain. The status is 3, 2 where the folder
itself cannot be used, or the usual one together with the new result; one message states the error. Anything else is
printed with the number of the call, and the status is 1.

With --every and --first only these calls fail, with --in-turn each by one error instead of six.
Computation and page layout, which use no file, are done once and remembered. A whole trial takes 5 to 60 minutes;
TMPDIR=/dev/shm spares the disk.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import pkgutil
import re
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import command_line
from command_line import run_command
from failing_calls import Call, run_in_child

ERRORS = (errno.ENOMEM, errno.EACCES, errno.ESTALE, errno.ENOSPC, errno.EIO, errno.EMFILE)
CHANGES = ("--set", "plate.elements=[2,1]", "--set", "output.fields=2", "--no-pictures")
RUN = ("run", "{root}/scene.toml", *CHANGES, "--force", "--out", "{root}/out")
OTHER_RUN = (*RUN, "--set", "corner.friction=0.2")
INTERRUPTED_RUN = (*RUN, "--set", "corner.friction=0.3")
COMPARE = ("compare", "{root}/first", "{root}/second", "{root}/measured.csv", "--out", "{root}/out")
OTHER_COMPARE = ("compare", "{root}/second", "{root}/first", "--out", "{root}/out")
REMEMBERED = (
    "tailslap.case.corner.corner_run.run_corner", "postprocess.svg.chart.Chart._drawn",
    "postprocess.report.page.page_text", "tailslap.comparing.validation.page_text",
)  # fmt: skip
"""Functions that use no file."""
COMPLETE = re.compile("the next command completes it|the result .*is complete")
"""Part of a message where the new result is in the folder, or will be."""


class Trial(NamedTuple):
    """Command whose calls fail, and the one of the earlier result.

    interrupted: folder whose files are still to be renamed.
    """

    command: tuple[str, ...]
    earlier: tuple[str, ...] = ()
    interrupted: str = ""


def _export(format_: str, source: str = "first") -> tuple[str, ...]:
    return ("export", f"{{root}}/{source}", "--to", format_, "--force", "--out", "{root}/out")


TRIALS = {
    "run": Trial(RUN, OTHER_RUN),
    "run-new": Trial(RUN),
    "run-interrupted": Trial(RUN, OTHER_RUN, "out"),
    **{
        f"export-{kind}": Trial(_export(kind), _export(kind, "second"))
        for kind in ("csv", "parquet", "vtkhdf", "xdmf", "vtu", "msh")
    },
    "export-interrupted": Trial(_export("csv"), _export("csv", "second"), "first"),
    "compare": Trial(COMPARE, OTHER_COMPARE),
}

Files = dict[str, bytes]
"""Contents by name; empty where they differ between two equal commands."""


def status_and_message(words: tuple[str, ...]) -> tuple[int, str]:
    """Return exit status and messages of a command."""
    status, _, messages = run_command(*words)
    return status, messages


class Memory:
    """Answers of functions without files, recorded once and repeated."""

    def __init__(self) -> None:
        self._answers: dict[str, list[Any]] = {place: [] for place in REMEMBERED}

    def _record(self, place: str) -> Callable[..., Any]:
        function, answers = pkgutil.resolve_name(place), self._answers[place]

        def call(*values: Any, **options: Any) -> Any:
            answers.append(function(*values, **options))
            return answers[-1]

        return call

    @contextlib.contextmanager
    def active(self, is_recording: bool) -> Iterator[None]:
        """Record the answers in this block, or return them in order."""
        with contextlib.ExitStack() as stack:
            for place, answers in self._answers.items():
                call = self._record(place) if is_recording else _repeat(answers)
                stack.enter_context(mock.patch(place, call))
            yield


def _repeat(answers: list[Any]) -> Callable[..., Any]:
    """Return a function, or method, that returns these answers in order."""
    remaining = iter(list(answers))
    return lambda *values, **options: next(remaining)


class Laboratory:
    """Folder in which a trial begins from the same state each time.

    Attributes
    ----------
    before, after : dict of bytes
        Files of the earlier and of the new result.
    calls : list of Call
        Calls of the undisturbed command.
    usual : int
        Status of the undisturbed command.
    """

    def __init__(self, trial: Trial, folder: Path) -> None:
        self._root, self._store = folder / "root", folder / "store"
        self._memory = Memory()
        self._command = tuple(word.format(root=self._root) for word in trial.command)
        self._prepare(trial)
        self._restore()
        self._settle()
        self.before, self._inputs = self._files("out"), self._input_files()
        self._restore()
        with self._memory.active(is_recording=True):
            self.usual = status_and_message(self._command)[0]
        first = self._files("out")
        message, self.calls = self._attempt(0, 0)
        again = self._files("out")
        self._volatile = {name for name in first if first[name] != again.get(name)}
        self.before, self.after = self._comparable(self.before), self._comparable(again)
        assert message == (self.usual, ""), message
        assert self.usual in (0, 1)
        assert first.keys() == again.keys()
        assert self.before != self.after

    def outcome(self, number: int, error: int) -> str:
        """Return the outcome where this call fails, BAD if wrong."""
        (status, message), _ = self._attempt(number, error)
        self._settle()
        files, remains = self._comparable(self._files("out")), self._remains()
        lines = [line for line in message.splitlines() if ": remark: " not in line]
        if status not in (self.usual, 2, 3) or "internal error" in message:
            return f"BAD status {status}: {message}"
        if files not in (self.before, self.after):
            return f"BAD result with status {status}: {message}"
        if remains or self._input_files() != self._inputs:
            return f"BAD remains {remains} with status {status}: {message}"
        if status == self.usual:
            return "new result" if files == self.after else f"BAD status {status} without result: {message}"
        if len(lines) != 1 or os.strerror(error) not in message:
            return f"BAD message with status {status}: {message}"
        if files == self.after and not COMPLETE.search(message):
            return f"BAD message about the new result, status {status}: {message}"
        return f"status {status}, {'earlier' if files == self.before else 'new'} result"

    def _prepare(self, trial: Trial) -> None:
        """Fill the folder in its first state with required results."""
        from tailslap.scene.read import shipped_scenes
        from tailslap.storage import manifest

        def make(words: tuple[str, ...], *more: str) -> int:
            line = tuple(word.format(root=self._root) for word in (*words, *more))
            return status_and_message(line)[0]

        self._root.mkdir()
        (self._root / "scene.toml").write_text(shipped_scenes()["paper-table-3"].read_text())
        if trial.command[0] != "run":
            assert make(RUN, "--out", "{root}/first") == make(OTHER_RUN, "--out", "{root}/second") == 0
            shutil.copy(self._root / "first" / "history.csv", self._root / "measured.csv")
        if trial.earlier:
            assert make(trial.earlier) in (0, 1)
        if trial.interrupted:
            with mock.patch.object(os, "replace", _refuse_manifest):
                assert make(INTERRUPTED_RUN, "--out", f"{{root}}/{trial.interrupted}") == 3
            assert (self._root / trial.interrupted / manifest.LOG).exists()
        shutil.move(self._root, self._store)

    def _restore(self) -> None:
        shutil.rmtree(self._root, ignore_errors=True)
        shutil.copytree(self._store, self._root)

    def _settle(self) -> None:
        """Lock the folders, as the next command does first."""
        from tailslap.storage.folder import locked

        for name in ("out", "first", "second"):
            if (self._root / name).exists():
                with locked(self._root / name):
                    pass

    def _attempt(self, number: int, error: int) -> tuple[tuple[int, str], list[Call]]:
        self._restore()
        with self._memory.active(is_recording=False):
            command = lambda: json.dumps(status_and_message(self._command))  # noqa: E731
            text, calls = run_in_child(command, str(self._root), number, error)
        status, message = json.loads(text)
        return (status, message), calls

    def _files(self, name: str) -> Files:
        """Return the files of a manifest, none where one differs."""
        from tailslap.storage import manifest

        folder = self._root / name
        listed = manifest.read_manifest(folder)
        if listed is None or any(manifest.entry(folder / item.path) != item for item in listed):
            return {}
        return {item.path: (folder / item.path).read_bytes() for item in listed}

    def _input_files(self) -> list[Files]:
        return [self._files(name) for name in ("first", "second")]

    def _comparable(self, files: Files) -> Files:
        return {name: b"" if name in self._volatile else content for name, content in files.items()}

    def _remains(self) -> list[str]:
        """Return files other than the scene and those of results."""
        names = {"scene.toml", "measured.csv"}
        for folder in ("out", "first", "second"):
            if files := self._files(folder):
                names |= {folder, f"{folder}/.tailslap-result.json", *(f"{folder}/{name}" for name in files)}
        return sorted({str(path.relative_to(self._root)) for path in self._root.rglob("*")} - names)


def _refuse_manifest(source: Path, target: Path) -> None:
    """Rename a file, except the manifest into a result folder."""
    from tailslap.storage import manifest

    if Path(target).name == manifest.NAME:
        raise OSError(errno.EIO, os.strerror(errno.EIO), str(target))
    os.rename(source, target)


def outcomes(
    name: str, numbers: slice = slice(None), errors: tuple[int, ...] = ERRORS, in_turn: bool = False
) -> Iterator[tuple[str, str]]:
    """Yield the calls of a trial with their errors and outcomes.

    numbers: of the calls, all by default; in_turn: with one error for each call instead of all.
    """
    with tempfile.TemporaryDirectory() as folder:
        laboratory = Laboratory(TRIALS[name], Path(os.path.realpath(folder)))
        count = len(laboratory.calls)
        for number in range(1, count + 1)[numbers]:
            call = laboratory.calls[number - 1]
            for error in [errors[number % len(errors)]] if in_turn else errors:
                label = f"{name}, {call.name} {number} of {count}, {errno.errorcode[error]}, {call.path}"
                yield label, laboratory.outcome(number, error)
            print(f"\r{name}: {number} of {count}", end="", file=sys.stderr, flush=True)


def main() -> None:
    """Let calls fail, and print the outcomes."""
    names = tuple(errno.errorcode[error] for error in ERRORS)
    options = command_line.options(__doc__, ("trials", TRIALS), every=1, first=1, errors=names, in_turn=False)
    counts, numbers = Counter[str](), slice(options.first - 1, None, options.every)
    errors = tuple(getattr(errno, name) for name in options.errors)
    for name in options.trials:
        for label, outcome in outcomes(name, numbers, errors, options.in_turn):
            counts[f"{name}: {outcome.partition(':')[0]}"] += 1
            if outcome.startswith("BAD"):
                print(f"{label}: {outcome}", flush=True)
    print(command_line.counts(counts))
    sys.exit(any("BAD" in outcome for outcome in counts))


if __name__ == "__main__":
    main()
