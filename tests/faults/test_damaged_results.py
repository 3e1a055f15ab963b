"""Verify that files that differ from their manifest are refused.

With force intact files are read; numbers of a damaged one never are, and no damage is an internal error.
"""

import os
import shutil
from unittest import mock

import numpy as np
import pytest

import tailslap
from tailslap import InputError
from tailslap.cli import _status
from tailslap.result import load
from tailslap.storage import folder, manifest
from tailslap.storage.manifest import NAME

SMALL = {"plate.elements": [6, 2], "output.fields": 3}


@pytest.fixture(scope="module")
def saved_results(tmp_path_factory):
    """Results of every kind, and another of a run, in folders."""
    place = tmp_path_factory.mktemp("saved_results")
    tailslap.run("paper-table-3", SMALL).save(place / "run", pictures=False)
    tailslap.run("paper-table-3", SMALL | {"corner.friction": 0.2}).save(place / "other", pictures=False)
    tailslap.rigid("impact-mash-tl4-sut").save(place / "rigid")
    tailslap.study("uncertainty", "mash-tl4-sut", samples=1000).save(place / "study")
    tailslap.sweep("paper-table-3", {"corner.friction": [0.2]}, SMALL, folder=place / "sweep", workers=1)
    return place


@pytest.fixture
def results(saved_results, tmp_path):
    shutil.copytree(saved_results, tmp_path / "a")
    return tmp_path / "a"


def flipped(path, undamaged):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)


def cut(path, undamaged):
    os.truncate(path, path.stat().st_size // 2)


def swapped(path, undamaged):
    shutil.copyfile(undamaged, path)


def removed(path, undamaged):
    path.unlink()


def linked(path, undamaged):
    path.unlink()
    path.symlink_to(undamaged)


def piped(path, undamaged):
    path.unlink()
    os.mkfifo(path)


DAMAGES = (flipped, cut, swapped, removed, linked, piped)


def everything(place, **more):
    """All that there is in a result, read again."""
    result = tailslap.load(place, **more)
    return result, result.make_fields and result.fields


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("name", ["summary.json", "history.csv", "rigid.csv", "fields.npz"])
def test_a_damaged_file_of_a_run_is_named(results, damage, name, capsys):
    damage(results / "run" / name, results / "other" / name)
    with pytest.raises(InputError, match=rf"its file {name} .*; --force \(Python: force=True\)"):
        everything(results / "run")
    if name != "fields.npz":
        words = ["compare", str(results / "run"), str(results / "other"), "--out", str(results / "out")]
        assert _status(words) == 2
        assert capsys.readouterr().err.count(f"its file {name}") == 1
    assert _status(["export", str(results / "run"), "--to", "csv", "--out", str(results / "out")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (results / "out").exists()


@pytest.mark.parametrize(
    "path", ["rigid/rigid.csv", "study/summary.json", "sweep/sweep.parquet", "sweep/summary.json"]
)
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_of_other_results_is_named(results, path, damage):
    file = results / path
    everything(file.parent)
    damage(file, results / "run" / "summary.json")
    with pytest.raises(InputError, match=f"its file {file.name}"):
        everything(file.parent)


def test_every_flip_in_a_manifest_is_found(results):
    path = results / "rigid" / NAME
    content = path.read_bytes()
    for k in range(0, len(content), 3):
        path.write_bytes(content[:k] + bytes([content[k] ^ 2]) + content[k + 1 :])
        with pytest.raises(InputError, match=f"{NAME} is missing or damaged"):
            tailslap.load(results / "rigid")
    path.unlink()
    with pytest.raises(InputError, match=f"{NAME} is missing or damaged"):
        tailslap.load(results / "rigid")
    with pytest.warns(UserWarning, match="missing or damaged"):
        assert tailslap.load(results / "rigid", force=True).rigid["t"].size > 10


WRONG = [
    *("", "{", "[]", "3", "null", '"a"', "{}", '{"fe": 3, "rigid": 4, "checks": 5}', "[" * 100_000, "\0"),
    '{"scene": 1, "passed": "x", "verdict": {}, "fe": {"t": "1"}, "rigid": [], "checks": {}}',
    '{"scene": "a", "passed": 1, "fe": {"strikes": [1]}, "rigid": {"strikes": "b"}, "checks": []}',
]


@pytest.mark.parametrize("text", WRONG)
def test_a_summary_of_wrong_types_is_refused_and_by_force_the_histories_are_there(results, text):
    """The manifest may list it as if the program had written it."""
    place = results / "run"
    (place / "summary.json").write_text(text)
    with pytest.raises(InputError, match=r"its file summary\.json is damaged"):
        tailslap.load(place)
    rows = (place / "history.csv").read_text().count("\n") - 1
    with pytest.warns(UserWarning, match=r"its file summary\.json"):
        result = tailslap.load(place, force=True)
    assert (result.command, result.scene, result.summary) == ("run", "paper-table-3", {})
    assert result.history["t"].size == result.rigid["t"].size == rows
    entries = {manifest.read_entry(place / name) for name in ("summary.json", "history.csv", "rigid.csv")}
    manifest.write_manifest(place, entries, manifest.Origin("run", "a"))
    with pytest.raises(InputError, match=r"its file summary\.json cannot be read"):
        tailslap.load(place)


def test_by_force_a_history_that_was_changed_is_read_with_a_remark(results, capsys):
    place, path = results / "run", results / "run" / "history.csv"
    rows = tailslap.load(place).history["t"].size
    path.write_text("\n".join(path.read_text().splitlines()[:-1]) + "\n")
    with pytest.warns(UserWarning, match=r"its file history\.csv is damaged or was modified"):
        assert tailslap.load(place, force=True).history["t"].size == rows - 1
    paths = [str(results / name) for name in ("run", "run/rigid.csv", "out")]
    words = ["compare", *paths[:2], "--out", paths[2]]
    assert _status(words) == 2
    capsys.readouterr()
    assert _status([*words, "--force"]) == 0
    said = capsys.readouterr().err
    assert said.startswith(f"tailslap: remark: {place}: its file history.csv is damaged")
    assert said.count("\n") == 1
    assert _status(["export", str(place), "--to", "csv", "--out", str(results / "csv"), "--force"]) == 0
    assert len((results / "csv" / "history.csv").read_text().splitlines()) == rows


@pytest.mark.parametrize(("text", "why"), [
    ("t,v_gy\n0,1\n2\n", "ValueError: "), ('"a", "b"\n1,2\n', "ValueError: its first line has no column names"),
])  # fmt: skip
def test_by_force_what_makes_no_sense_is_left_out(results, text, why):
    cut(results / "run" / "fields.npz", None)
    (results / "run" / "rigid.csv").write_text(text)
    with pytest.warns(UserWarning) as warned:  # noqa: PT030, PT031
        result = tailslap.load(results / "run", force=True)
        with pytest.raises(InputError, match="the result has no fields"):
            result.fields  # noqa: B018
    assert set(result.histories) == {"FE"}
    assert why in str(warned[1].message)
    texts = [str(warning.message).rpartition("/run: ")[2] for warning in warned]
    assert [text.replace(" or was modified", "").partition(",")[0] for text in texts] == [
        *("its file rigid.csv is damaged", "its file rigid.csv cannot be read"),
        *("its file fields.npz is damaged", "its file fields.npz cannot be read"),
    ]


def test_a_file_of_a_result_given_alone_is_what_the_manifest_beside_it_lists(results):
    tailslap.compare(results / "run", results / "run" / "rigid.csv")
    flipped(results / "run" / "rigid.csv", None)
    with pytest.raises(InputError, match=r"its file rigid\.csv is damaged"):
        tailslap.compare(results / "other", results / "run" / "rigid.csv")


def test_a_copy_has_no_damaged_file(results, tmp_path):
    result = tailslap.load(results / "run")
    flipped(results / "run" / "theta.svg", None)
    with pytest.raises(InputError, match=r"its file theta\.svg is damaged"):
        result.save(tmp_path / "copy")
    assert not (tmp_path / "copy").exists()
    with pytest.raises(InputError, match="it is an input of the command"):
        result.save(results / "run", force=True)
    (results / "run" / "theta.svg").unlink()
    with pytest.warns(UserWarning, match=r"its file theta\.svg cannot be read"):
        tailslap.load(results / "run", force=True).save(tmp_path / "copy")
    names = {path.name for path in (results / "run").iterdir()}
    assert {path.name for path in (tmp_path / "copy").iterdir()} == names


def test_a_result_that_is_replaced_while_it_is_read_is_one_of_the_two(results, monkeypatch):
    loaded = tailslap.load(results / "other")
    for forced in (False, True):
        place, demand = results / "run", load.Stored.demand_manifest

        def replace(stored, place=place, demand=demand):
            demand(stored)
            loaded.save(place, force=True)

        monkeypatch.setattr(load.Stored, "demand_manifest", replace)
        result = tailslap.load(place, force=forced)
        monkeypatch.setattr(load.Stored, "demand_manifest", demand)
        assert result.summary == loaded.summary
        np.testing.assert_array_equal(result.history["v_gy"], loaded.history["v_gy"])
        shutil.rmtree(place)
        shutil.copytree(results / "rigid", place)


def test_what_a_dead_command_left_is_finished_before_it_is_read(results, monkeypatch):
    loaded, place = tailslap.load(results / "other"), results / "run"
    with monkeypatch.context() as patch:
        died = pytest.raises(InputError, match="the next command completes it")
        with died, folder.result_folder(place, force=True) as new:
            assert loaded.fill is not None
            loaded.fill(new, True, "si")
            patch.setattr(folder, "_finish_log", mock.Mock(side_effect=PermissionError))  # it dies here
        assert (place / manifest.LOG).exists()
    with monkeypatch.context() as patch:
        patch.setattr(os, "access", lambda path, mode: False)  # a reader who may not write
        assert tailslap.load(place).summary == loaded.summary
    assert (place / manifest.LOG).exists()
    assert tailslap.load(place).summary == loaded.summary
    assert not (place / manifest.LOG).exists()


def test_a_sweep_is_exported_with_its_words(results):
    assert _status(["export", str(results / "sweep"), "--to", "csv", "--out", str(results / "out")]) == 0
    head, row = (line.split(",") for line in (results / "out" / "table.csv").read_text().splitlines())
    cells = dict(zip(head, row, strict=True))
    assert (cells["status"], cells["run"], float(cells["corner.friction"])) == ("passed", "0", 0.2)


def test_what_is_below_a_folder_that_may_not_be_searched_is_wrong_input(results):
    """As in the home of another user."""
    closed, user, run = results / "home", os.geteuid(), tailslap.load(results / "run")
    closed.mkdir(0o000)
    os.seteuid(user or 65534)
    try:
        readers = (lambda place: tailslap.export(place, "csv"), lambda place: tailslap.compare(run, place))
        for read in (tailslap.load, *readers):
            with pytest.raises(InputError, match=f"{closed}"):
                read(closed / "a")
    finally:
        os.seteuid(user)
        closed.chmod(0o700)
