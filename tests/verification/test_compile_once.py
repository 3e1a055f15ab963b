"""Verification: one process of a machine compiles, the others wait for it and load what it has compiled."""

from __future__ import annotations

import fcntl
import os
import re
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fem.explicit.time_loop import advance
from fem.machine_code import compiled, folder
from fem.machine_code.compiled import compile_once
from fem.machine_code.folder import USUAL_S, one_process_compiles
from fem.run.corner import Stepper

pytestmark = pytest.mark.verification


def test_who_comes_second_waits_and_who_compiles_another_kind_does_not(tmp_path: Path) -> None:
    """The lock is held here, as another process would hold it."""
    code, entered = tmp_path / "code" / "kind.code", threading.Event()

    def compile_there(path: Path, told: threading.Event) -> threading.Thread:
        def compile_it() -> None:
            with one_process_compiles(path):
                told.set()

        thread = threading.Thread(target=compile_it)
        thread.start()
        return thread

    with one_process_compiles(code):
        other, third = compile_there(code, entered), threading.Event()
        assert not entered.wait(0.2)
        compile_there(code.with_name("other.code"), third).join(60.0)
        assert third.is_set()
    assert entered.wait(60.0)
    other.join()
    with open(tmp_path / "code" / "kind.lock") as file:  # it is free again
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def test_without_a_folder_each_compiles_for_itself(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with one_process_compiles(tmp_path / "file" / "code" / "kind.code"):
        assert not (tmp_path / "file").is_dir()


def test_code_is_known_by_the_types_of_its_arguments(outcome: Callable[..., Any]) -> None:
    """After a run its step has code; for arguments of other types there is none."""
    model = outcome("paper-table-3").fe_plan.model
    kernel, *arguments = Stepper(model).step_call
    assert kernel.has_code(*arguments)
    assert not advance.has_code(1, 2.0, np.zeros(3))


def double(value: float) -> float:
    """A function to compile."""
    return 2.0 * value


def test_compiling_is_told_once_a_kind_with_the_time_of_the_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folder, "cache_folder", lambda: tmp_path / "code")
    told: list[tuple[float, bool]] = []

    def use(value: float) -> None:
        function = compiled.compiled(double)  # as a new process has it
        compile_once(lambda: function(value), function, value, told=lambda *given: told.append(given))

    use(1.0)
    (expected, before), (spent, after) = told
    assert (expected, before, after) == (USUAL_S, False, True)
    assert 0.0 < spent < USUAL_S
    use(2.0)
    assert len(told) == 2
    use(3)  # another kind
    assert told[2] == (pytest.approx(spent, abs=0.01), False)
    assert len(told) == 4


@pytest.mark.long
def test_first_run_says_that_it_compiles_and_the_second_does_not(tmp_path: Path) -> None:
    """Standard error is no terminal here."""
    command = [sys.executable, "-m", "tailslap.cli", "run", "paper-table-3", "--no-pictures"]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "code")}

    def said() -> str:
        done = subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return done.stderr

    assert re.search(r"compiling the time loop .*: about 10 s\n.*compiled in \d+ s", said(), re.DOTALL)
    assert "compil" not in said()
