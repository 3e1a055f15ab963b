"""Verification: a result folder is complete or absent, and nothing is lost that the program did not write."""

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import pytest

from tailslap.cli import _status
from tailslap.errors import InputError
from tailslap.files.folder import demand_place, result_folder
from tailslap.files.manifest import NAME

RESULT = {"report.html": "page", "summary.json": "{}", "history.csv": "t\n"}


def fill(place: Path, **more: str) -> None:
    with result_folder(place) as folder:
        for name, text in (RESULT | {f"{name}.txt": text for name, text in more.items()}).items():
            (folder / name).write_text(text)


def tree(folder: Path) -> dict[str, str | None]:
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


def refused(place: Path, named: str) -> None:
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
    assert found == {
        name: (len(text), hashlib.sha256(text.encode()).hexdigest()) for name, text in texts.items()
    }


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


def forged(**more: Any) -> str:
    item = {"path": "thesis.txt", "size": 1, "sha256": hashlib.sha256(b"x").hexdigest()} | more
    return json.dumps({"program": "tailslap", "version": "0.1.0", "files": [item]})


@pytest.mark.parametrize(
    "manifest",
    [
        *("", "{", "[]", "null", "[" * 100_000, "\0", '{"program": "tailslap"}', '{"files": []}'),
        *('{"program": "tailslap", "files": {}}', '{"program": "tailslap", "files": [3]}'),
        *(
            forged(path=path)
            for path in ("../thesis.txt", "/etc/hostname", "a/../../x", "..", ".", "", "a\0b")
        ),
        *(forged(path=3), forged(path=NAME), forged(size="1"), forged(sha256=None), forged(sha256="x")),
    ],
)
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
