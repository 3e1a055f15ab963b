"""Verification: a result folder is complete or absent whatever fails, and nothing of others is lost."""

import hashlib
import json
import os
from pathlib import Path

import pytest

from tailslap.cli import _status
from tailslap.errors import InputError, Interrupted
from tailslap.files.folder import demand_place, result_folder
from tailslap.files.manifest import NAME

RESULT = {"report.html": "page", "summary.json": "{}", "history.csv": "t\n"}


def fill(place, **more):
    with result_folder(place) as folder:
        for name, text in (RESULT | {f"{name}.txt": text for name, text in more.items()}).items():
            (folder / name).write_text(text)


def tree(folder):
    """All paths below, with the text of files and the targets of links."""
    paths = {str(path.relative_to(folder)): path for path in folder.rglob("*")}
    return {
        name: os.readlink(path) if path.is_symlink() else path.read_text() if path.is_file() else None
        for name, path in paths.items()
    }


@pytest.fixture
def place(tmp_path):
    """The place of a result, with an earlier one in it; nothing else is in the folder above it."""
    fill(tmp_path / "results" / "a", old="old")
    return tmp_path / "results" / "a"


def refused(place, named):
    """Both by `demand_place` and by the folder itself, which is never yielded to work in; nothing is changed."""
    before = tree(place.parent)
    for begin in (demand_place, lambda place: result_folder(place).__enter__()):
        with pytest.raises(InputError, match=named) as caught:
            begin(place)
        assert caught.value.key == "--out"
        assert str(place) in str(caught.value)
    assert tree(place.parent) == before


def test_the_manifest_lists_what_was_written(place):
    manifest = json.loads((place / NAME).read_text())
    assert manifest["program"] == "tailslap"
    found = {item["path"]: (item["size"], item["sha256"]) for item in manifest["files"]}
    texts = {**RESULT, "old.txt": "old"}
    digests = {name: (len(text), hashlib.sha256(text.encode()).hexdigest()) for name, text in texts.items()}
    assert found == digests


def test_absent_and_empty_folders_are_places_and_a_result_is_replaced(place):
    fill(place)
    assert set(tree(place)) == {*RESULT, NAME}
    (place.parent / "empty").mkdir(mode=0o700)
    fill(place.parent / "empty")
    assert set(tree(place.parent / "empty")) == {*RESULT, NAME}
    assert (place.parent / "empty").stat().st_mode & 0o777 == 0o700
    assert {path.name for path in place.parent.iterdir()} == {"a", "empty"}


def test_a_folder_with_a_summary_is_no_result(tmp_path, capsys):
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("x")
    (mine / "summary.json").write_text("{}")
    assert _status(["run", "paper-table-3", "--out", str(mine)]) == 2
    assert "thesis.txt" in capsys.readouterr().err
    refused(mine, r"it holds other files \(summary.json, thesis.txt\); allowed is a new or empty folder")


def test_results_within_are_kept(place):
    """Results at results/a; then a result at results itself, first refused, then one that a was put into."""
    refused(place.parent, r"other files \(a\)")
    outer = place.parents[1] / "outer"
    fill(outer)
    fill(outer / "b", kept="kept")
    before = tree(outer / "b")
    fill(outer)
    assert tree(outer / "b") == before


def test_what_was_added_stays(place, tmp_path):
    (place / "notes.txt").write_text("mine")
    (place / "plots" / "deep").mkdir(parents=True)
    (place / "plots" / "deep" / "a.txt").write_text("mine")
    (tmp_path / "elsewhere").mkdir()
    (place / "link").symlink_to(tmp_path / "elsewhere")
    (place / "history.csv").unlink()
    fill(place)
    added = {"notes.txt", "plots", "plots/deep", "plots/deep/a.txt", "link"}
    assert set(tree(place)) == {*RESULT, NAME, *added}
    assert (place / "plots" / "deep" / "a.txt").read_text() == "mine"
    assert os.readlink(place / "link") == str(tmp_path / "elsewhere")
    assert [path.name for path in place.parent.iterdir()] == ["a"]


@pytest.mark.parametrize("as_what", ["file", "link", "folder"])
def test_a_file_of_the_result_that_was_changed_is_refused(place, tmp_path, as_what):
    file = place / "history.csv"
    file.unlink()
    if as_what == "file":
        file.write_text("u\n")  # of the same size
    elif as_what == "link":
        (tmp_path / "saved.csv").write_text(RESULT["history.csv"])
        file.symlink_to(tmp_path / "saved.csv")
    else:
        file.mkdir()
    refused(place, r"history\.csv in it was changed since")


def test_an_added_file_that_the_result_would_overwrite_is_refused_at_the_end(place):
    (place / "picture.txt").write_text("mine")
    before = tree(place.parent)
    demand_place(place)
    with pytest.raises(InputError, match=r"picture\.txt in it was added, and the new result has"):
        fill(place, picture="ours")
    assert tree(place.parent) == before


def forged(**more):
    item = {"path": "thesis.txt", "size": 1, "sha256": hashlib.sha256(b"x").hexdigest()} | more
    return json.dumps({"program": "tailslap", "version": "0.1.0", "files": [item]})


FOREIGN = [
    *("", "{", "[]", "null", "[" * 100_000, "\0", '{"program": "tailslap"}', '{"files": []}'),
    *('{"program": "tailslap", "files": {}}', '{"program": "tailslap", "files": [3]}'),
    *(forged(path=path) for path in ("../thesis.txt", "/etc/hostname", "a/../../x", "..", ".", "", "a\0b")),
    *(forged(path=3), forged(path=NAME), forged(size="1"), forged(sha256=None), forged(sha256="x")),
]


@pytest.mark.parametrize("manifest", FOREIGN)
def test_a_manifest_that_is_not_ours_makes_no_result(tmp_path, manifest):
    (tmp_path / "thesis.txt").write_text("x")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("x")
    (tmp_path / "mine" / NAME).write_text(manifest)
    refused(tmp_path / "mine", "other files")


def test_a_forged_manifest_reaches_nothing_outside(tmp_path):
    """It lists a link to a file outside with that file's digest; or the manifest itself is a link."""
    (tmp_path / "thesis.txt").write_text("x")
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").symlink_to(tmp_path / "thesis.txt")
    (mine / NAME).write_text(forged())
    refused(mine, r"thesis\.txt in it was changed")
    (mine / NAME).rename(tmp_path / "manifest")
    (mine / NAME).symlink_to(tmp_path / "manifest")
    refused(mine, "other files")
    (mine / NAME).unlink()
    os.mkfifo(mine / NAME)
    with pytest.raises(InputError, match="other files"):
        demand_place(mine)


def test_a_link_to_a_folder_is_followed(place, tmp_path):
    link, dangling = tmp_path / "link", tmp_path / "dangling"
    link.symlink_to(place)
    dangling.symlink_to(tmp_path / "new")
    (place / "notes.txt").write_text("mine")
    for path, real in ((link, place), (dangling, tmp_path / "new")):
        fill(path)
        assert path.is_symlink()
        assert {*RESULT, NAME} <= set(tree(real))
    assert (place / "notes.txt").read_text() == "mine"
    (tmp_path / "file").write_text("mine")
    (tmp_path / "to-file").symlink_to(tmp_path / "file")
    with pytest.raises(InputError, match="this is a file"):
        fill(tmp_path / "to-file")


def test_a_sweep_s_folder_is_refused_even_with_a_manifest(place):
    (place / "sweep.json").write_text("{}")
    refused(place, "other files")


def test_a_result_of_more_than_files_is_a_mistake(tmp_path):
    with pytest.raises(ValueError, match="plain files"), result_folder(tmp_path / "a") as folder:
        (folder / "sub").mkdir()
    assert not list(tmp_path.iterdir())


ADDED = {"notes.txt": "mine", "plots/a.txt": "mine too"}
FAILURES = [OSError(5, "the disk is broken"), KeyboardInterrupt()]
MOVES = 4
"""The earlier result aside, the new one in, and two things that were added."""


def fill_or_fail(place_with_more, text, failure=None):
    with result_folder(place_with_more) as folder:
        (folder / "report.html").write_text(text)
        if failure:
            raise failure
        (folder / f"{text}.csv").write_text(text)


def texts(folder):
    return {str(path.relative_to(folder)): path.read_text() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def place_with_more(tmp_path):
    """An earlier result to which a file and a folder were added."""
    fill_or_fail(tmp_path / "a", "old")
    for name, text in ADDED.items():
        (tmp_path / "a" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "a" / name).write_text(text)
    return tmp_path / "a"


def break_renames(monkeypatch, breaks, failure, done=False):
    """Renames of folders and of what was added fail where `breaks` says, before they are done or after."""
    rename, count = os.rename, [0]

    def broken(source, target):
        count[0] += 1
        if not breaks(count[0]) or done:
            rename(source, target)
        if breaks(count[0]):
            raise failure

    monkeypatch.setattr(os, "rename", broken)
    return count


@pytest.mark.parametrize("failure", FAILURES)
def test_failure_while_it_is_filled(place_with_more, failure):
    before = texts(place_with_more.parent)
    with pytest.raises(type(failure)):
        fill_or_fail(place_with_more, "new", failure)
    assert texts(place_with_more.parent) == before
    assert [path.name for path in place_with_more.parent.iterdir()] == ["a"]


@pytest.mark.parametrize("failure", FAILURES)
@pytest.mark.parametrize("done", [False, True])
@pytest.mark.parametrize("step", range(1, MOVES + 1))
def test_failure_at_each_step_of_the_move(place_with_more, monkeypatch, step, done, failure):
    before = texts(place_with_more.parent)
    expected = InputError if isinstance(failure, OSError) else KeyboardInterrupt
    break_renames(monkeypatch, lambda count: count == step, failure, done)
    with pytest.raises(expected):
        fill_or_fail(place_with_more, "new")
    assert texts(place_with_more.parent) == before
    assert [path.name for path in place_with_more.parent.iterdir()] == ["a"]


def test_the_steps_are_these(place_with_more, monkeypatch):
    count = break_renames(monkeypatch, lambda count: False, KeyboardInterrupt())
    fill_or_fail(place_with_more, "new")
    assert (count, set(texts(place_with_more))) == ([MOVES], {"report.html", "new.csv", NAME, *ADDED})


@pytest.mark.parametrize("failure", FAILURES)
@pytest.mark.parametrize("step", range(1, MOVES + 1))
def test_what_cannot_be_moved_back_is_left_and_named(place_with_more, monkeypatch, step, failure):
    """From one step on every rename fails: the old files and those that were added are all still there somewhere."""
    before = texts(place_with_more)
    break_renames(monkeypatch, lambda count: count >= step, failure)
    with pytest.raises((InputError, KeyboardInterrupt)) as caught:
        fill_or_fail(place_with_more, "new")
    after = texts(place_with_more.parent)
    kept = {name.split("/", 1)[1]: text for name, text in after.items()}
    assert set(kept) >= set(before)
    for name, text in before.items():
        assert text in [found for path, found in after.items() if path.endswith(f"/{name}")]
    moved = {name.split("/", 1)[0] for name in after} - {"a"}
    assert all(str(place_with_more.parent / folder) in str(caught.value) for folder in moved)
    assert bool(moved) == (step > 1)
    assert not any(folder.startswith(".") for folder in moved)


def test_killed_within_the_move_every_file_is_in_a_folder_that_is_not_hidden(place_with_more, monkeypatch):
    """Looked at before each rename: what a kill -9 would leave."""
    rename = os.rename

    def look(source, target):
        above = place_with_more.parent
        found = {path.relative_to(above) for path in above.glob("*/**/*")}
        shown = [path for path in found if not path.parts[0].startswith(".")]
        assert {"notes.txt", "a.txt"} <= {path.name for path in shown}
        rename(source, target)

    monkeypatch.setattr(os, "rename", look)
    fill_or_fail(place_with_more, "new")


def test_a_file_changed_within_the_move_is_left_and_named(place_with_more, monkeypatch, capsys):
    rename = os.rename

    def edit(source, target):
        rename(source, target)
        if Path(source) == place_with_more:
            (Path(target) / "old.csv").write_text("mine")

    monkeypatch.setattr(os, "rename", edit)
    fill_or_fail(place_with_more, "new")
    (aside,) = (path for path in place_with_more.parent.iterdir() if path != place_with_more)
    assert (aside / "old.csv").read_text() == "mine"
    assert str(aside) in capsys.readouterr().err


def test_an_interrupt_when_the_result_is_there_says_so(place_with_more, monkeypatch):
    def interrupt(path, missing_ok=False):
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "unlink", interrupt)
    with pytest.raises(Interrupted, match="the result is in"):
        fill_or_fail(place_with_more, "new")
    assert set(texts(place_with_more)) == {"report.html", "new.csv", NAME, *ADDED}


@pytest.mark.parametrize("failure", FAILURES)
def test_failure_of_the_first_result_leaves_nothing(tmp_path, monkeypatch, failure):
    break_renames(monkeypatch, lambda count: True, failure)
    with pytest.raises((InputError, KeyboardInterrupt)):
        fill_or_fail(tmp_path / "x" / "y", "new")
    assert not list(tmp_path.iterdir())
