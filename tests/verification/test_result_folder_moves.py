"""Verification: an interrupt or a failure at any step of the move leaves the earlier result and all that was added."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tailslap.errors import InputError, Interrupted
from tailslap.files.folder import result_folder
from tailslap.files.manifest import NAME

ADDED = {"notes.txt": "mine", "plots/a.txt": "mine too"}
FAILURES = [OSError(5, "the disk is broken"), KeyboardInterrupt()]
MOVES = 4
"""The earlier result aside, the new one in, and two things that were added."""


def fill(place: Path, text: str, failure: BaseException | None = None) -> None:
    with result_folder(place) as folder:
        (folder / "report.html").write_text(text)
        if failure:
            raise failure
        (folder / f"{text}.csv").write_text(text)


def tree(folder: Path) -> dict[str, str]:
    return {str(path.relative_to(folder)): path.read_text() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def place(tmp_path):
    """An earlier result to which a file and a folder were added."""
    fill(tmp_path / "a", "old")
    for name, text in ADDED.items():
        (tmp_path / "a" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "a" / name).write_text(text)
    return tmp_path / "a"


def break_renames(
    monkeypatch: pytest.MonkeyPatch, breaks: Callable[[int], bool], failure: BaseException, done: bool = False
) -> list[int]:
    """Renames of folders and of what was added fail where `breaks` says, before they are done or after."""
    rename, count = os.rename, [0]

    def broken(source: Any, target: Any) -> None:
        count[0] += 1
        if not breaks(count[0]) or done:
            rename(source, target)
        if breaks(count[0]):
            raise failure

    monkeypatch.setattr(os, "rename", broken)
    return count


@pytest.mark.parametrize("failure", FAILURES)
def test_failure_while_it_is_filled(place, failure):
    before = tree(place.parent)
    with pytest.raises(type(failure)):
        fill(place, "new", failure)
    assert tree(place.parent) == before
    assert [path.name for path in place.parent.iterdir()] == ["a"]


@pytest.mark.parametrize("failure", FAILURES)
@pytest.mark.parametrize("done", [False, True])
@pytest.mark.parametrize("step", range(1, MOVES + 1))
def test_failure_at_each_step_of_the_move(place, monkeypatch, step, done, failure):
    before = tree(place.parent)
    expected = InputError if isinstance(failure, OSError) else KeyboardInterrupt
    break_renames(monkeypatch, lambda count: count == step, failure, done)
    with pytest.raises(expected):
        fill(place, "new")
    assert tree(place.parent) == before
    assert [path.name for path in place.parent.iterdir()] == ["a"]


def test_the_steps_are_these(place, monkeypatch):
    count = break_renames(monkeypatch, lambda count: False, KeyboardInterrupt())
    fill(place, "new")
    assert count == [MOVES]
    assert set(tree(place)) == {"report.html", "new.csv", NAME, *ADDED}


@pytest.mark.parametrize("failure", FAILURES)
@pytest.mark.parametrize("step", range(1, MOVES + 1))
def test_what_cannot_be_moved_back_is_left_and_named(place, monkeypatch, step, failure):
    """From one step on every rename fails: the old files and those that were added are all still there somewhere."""
    before = tree(place)
    break_renames(monkeypatch, lambda count: count >= step, failure)
    with pytest.raises((InputError, KeyboardInterrupt)) as caught:
        fill(place, "new")
    after = tree(place.parent)
    kept = {name.split("/", 1)[1]: text for name, text in after.items()}
    assert set(kept) >= set(before)
    for name, text in before.items():
        assert text in [found for path, found in after.items() if path.endswith(f"/{name}")]
    moved = {name.split("/", 1)[0] for name in after} - {"a"}
    assert all(str(place.parent / folder) in str(caught.value) for folder in moved)
    assert bool(moved) == (step > 1)
    assert not any(folder.startswith(".") for folder in moved)


def test_killed_within_the_move_every_file_is_in_a_folder_that_is_not_hidden(place, monkeypatch):
    """Looked at before each rename: what a kill -9 would leave."""
    rename = os.rename

    def look(source: Any, target: Any) -> None:
        shown = [
            path
            for path in place.parent.glob("*/**/*")
            if not path.relative_to(place.parent).parts[0].startswith(".")
        ]
        assert {"notes.txt", "a.txt"} <= {path.name for path in shown}
        rename(source, target)

    monkeypatch.setattr(os, "rename", look)
    fill(place, "new")


def test_a_file_changed_within_the_move_is_left_and_named(place, monkeypatch, capsys):
    rename = os.rename

    def edit(source: Any, target: Any) -> None:
        rename(source, target)
        if Path(source) == place:
            (Path(target) / "old.csv").write_text("mine")

    monkeypatch.setattr(os, "rename", edit)
    fill(place, "new")
    (aside,) = (path for path in place.parent.iterdir() if path != place)
    assert (aside / "old.csv").read_text() == "mine"
    assert str(aside) in capsys.readouterr().err


def test_an_interrupt_when_the_result_is_there_says_so(place, monkeypatch):
    def interrupt(path: Path, missing_ok: bool = False) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "unlink", interrupt)
    with pytest.raises(Interrupted, match="the result is in"):
        fill(place, "new")
    assert set(tree(place)) == {"report.html", "new.csv", NAME, *ADDED}


@pytest.mark.parametrize("failure", FAILURES)
def test_failure_of_the_first_result_leaves_nothing(tmp_path, monkeypatch, failure):
    break_renames(monkeypatch, lambda count: True, failure)
    with pytest.raises((InputError, KeyboardInterrupt)):
        fill(tmp_path / "x" / "y", "new")
    assert not list(tmp_path.iterdir())
