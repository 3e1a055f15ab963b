"""Verification: one process of a machine compiles, the others wait for it and load what it has compiled."""

from __future__ import annotations

import fcntl
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fem import compiled
from fem.compiled import has_code, one_process_compiles
from fem.explicit.simulate import Stepper
from fem.explicit.time_loop import advance

pytestmark = pytest.mark.verification


def test_who_comes_second_waits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The lock is held here, as another process would hold it."""
    monkeypatch.setattr(compiled, "cache_folder", lambda: tmp_path / "code")
    entered = threading.Event()

    def compile_there() -> None:
        with one_process_compiles():
            entered.set()

    with one_process_compiles():
        other = threading.Thread(target=compile_there)
        other.start()
        assert not entered.wait(0.2)
    assert entered.wait(60.0)
    other.join()
    with open(tmp_path / "code" / "lock") as file:  # it is free again
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def test_without_a_folder_each_compiles_for_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(compiled, "cache_folder", lambda: tmp_path / "file" / "code")
    with one_process_compiles():
        assert not (tmp_path / "file").is_dir()


def test_code_is_known_by_the_types_of_its_arguments(outcome: Callable[..., Any]) -> None:
    """After a run its step has code; for arguments of other types there is none."""
    model = outcome("paper-table-3").fe_plan.model
    assert Stepper(model).has_code
    assert not has_code(advance, 1, 2.0, np.zeros(3))
