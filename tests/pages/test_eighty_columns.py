"""Verify that output fits 80 columns and equals the JSON."""

import json
import re
import shutil
import subprocess
import sys
import tomllib

import click
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postprocess.report import terminal
from postprocess.report.page import Headline
from postprocess.report.tables import Column, Table
from postprocess.report.terminal import MORE, labelled, printed, table_lines
from tailslap import cli
from tailslap.scene import read, schema, write
from tailslap.scene.validate import key_by_key, validate

QUICK = (
    ("scenes",), ("rigid", "mash-tl4-sut", "--units", "us"), ("rigid", "impact-mash-tl4-sut"),
    ("check", "mash-tl4-sut", "--units", "us"), ("check", "impact-mash-tl4-sut"),
    ("run", "mash-tl4-sut", "--no-pictures", "--out", "run-us", "--units", "us"),
)  # fmt: skip
FLUTTER = ("--set", "impact.friction=0.8", "--set", "corner.penalty_scale=3", "--set", "damping.kind=none")


@pytest.fixture
def said(tmp_path, monkeypatch, capsys):
    """Output of a command on a terminal of 80 columns."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")

    def run(*arguments, statuses=(0, 1)):
        status = cli._status(list(arguments))
        out, err = capsys.readouterr()
        assert status in statuses, err
        return out

    return run


@pytest.mark.parametrize("arguments", QUICK, ids=" ".join)
def test_no_line_is_longer_than_80_columns(arguments, said):
    """Check commands that the test of their first lines does not have."""
    demand_narrow(said(*arguments))


def demand_narrow(out):
    assert out.strip()
    assert [line for line in out.splitlines() if len(line) > 80] == []


@pytest.mark.parametrize("arguments", [("--help",), ("study", "--help")], ids=" ".join)
def test_every_command_is_listed_with_its_whole_purpose(arguments, said):
    _, purposes = said(*arguments).split("Commands:\n")
    assert len(purposes.splitlines()) > 5
    assert [line for line in purposes.splitlines() if not line.endswith(".") or line.endswith("...")] == []


OPENED = (
    ("rigid", "mash-tl4-sut"), ("rigid", "impact-mash-tl1-car"), ("check", "mash-tl4-sut"),
    ("modal", "paper-table-3"), ("modes", "paper-table-3", "--count", "1", "--out", "modes"),
    ("run", "paper-table-3", "--no-pictures", "--out", "run"), ("paper", "--out", "paper"),
    ("study", "uncertainty", "mash-tl4-sut", "--samples", "500", "--out", "study"),
    ("sweep", "paper-table-3", "--vary", "corner.friction=0.3,0.4", "--out", "sweep"),
)  # fmt: skip


@pytest.mark.parametrize("arguments", OPENED, ids=" ".join)
def test_set_up_certainty_and_answer_end_the_terminal(arguments, said, tmp_path):
    """Within 23 lines of 80 columns, as they stand in the summary."""
    out = said(*arguments)
    demand_narrow(out)
    last = " ".join(" ".join(out.splitlines()[-23:]).split())
    summary = json.loads(said(*arguments, "--json"))
    lines = [summary[name] for name in ("set_up", "certainty", "band", "answer") if summary[name]]
    lines = [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]
    assert len(lines) >= 3
    assert sorted(map(last.index, lines)) == [*map(last.index, lines)]
    assert last.endswith(lines[-1])
    for place in tmp_path.glob("*/summary.json"):
        assert json.loads(place.read_text()) == summary


ALIKE = re.compile("97-kip|en-tb(?!11|51|81)|mash-tl[12]|tl6|tl5cmb|7069")
"""Scenes that differ from another one in numbers, whose rigid motions and answers `test_headlines.py` has."""


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=pytest.mark.long if ALIKE.search(name) else ()) for name in read.shipped_scenes()
])  # fmt: skip
def test_a_shipped_scene_passes_in_forty_lines_that_end_with_its_answer(name, said):
    out = said("run", name, "--no-pictures", "--out", "a", statuses=(0,))
    demand_narrow(out)
    assert len(out.splitlines()) <= 40
    with open("a/summary.json", encoding="utf-8") as file:
        answer = json.load(file)["answer"].replace("\N{NO-BREAK SPACE}", " ")
    assert " ".join(out.split()).endswith(answer)


def test_full_prints_every_table(said):
    words = "run", "impact-mash-tl4-sut", "--no-pictures", "--out", "a"
    short, full = said(*words), said(*words, "--full")
    assert MORE in short
    assert MORE not in full
    assert "60 Hz cut-off" not in short
    for text in ("60 Hz cut-off", "Stated error", "Chosen: time.safety_factor"):
        assert text in full


@pytest.mark.parametrize(("most", "body"), [
    (8, ["a", "a", "a", "b", "b", "c", ""]), (7, ["a", "a", "a", "c", "", MORE]),
    (6, ["a", "a", "a", "", MORE]), (5, ["b", "b", "", MORE]), (4, ["c", "", MORE]), (3, [MORE]),
])  # fmt: skip
def test_parts_without_room_are_left_out(most, body):
    """The last ones go first, and the answer always remains."""
    text = terminal.concluded(Headline("title", "answer"), "a\na\na", "b\nb", "c", most=most)
    assert text.splitlines() == [*body, "answer"]
    assert len(text.splitlines()) <= most


PHRASES = st.lists(st.text("abc", min_size=1, max_size=16), min_size=1, max_size=6).map(" ".join)
NUMBERS = st.text("123", min_size=1, max_size=9)


@settings(max_examples=100, deadline=None)
@given(st.data(), st.integers(40, 100), st.integers(1, 3), st.integers(1, 9))
def test_every_word_and_number_of_a_table_is_whole(data, width, words, numbers):
    """Lines are no longer than the terminal where columns fit in pairs."""
    kinds = [PHRASES] * words + [NUMBERS] * numbers
    rows = [[data.draw(kind) for kind in kinds] for _ in range(3)]
    heads = [Column(str(i), f"h{i}", form="" if i < words else str) for i in range(len(kinds))]
    lines = table_lines(Table(tuple(heads), rows), width)
    assert {part for row in rows for cell in row for part in cell.split()} <= {*" ".join(lines).split()}
    longest = [max(len(part) for row in rows for part in row[i].split()) for i in range(len(kinds))]
    if sum(longest[:words]) + max(longest[words:]) + 2 * words <= width / 2:
        assert max(map(len, lines)) <= width


def test_a_failed_run_fits_too_ends_with_one_and_keeps_its_files(said):
    out = said("run", "mash-tl4-sut", "--no-pictures", "--out", "bad", *FLUTTER, statuses=(1,))
    demand_narrow(out)
    with (
        open("bad/summary.json", encoding="utf-8") as summary,
        open("bad/report.html", encoding="utf-8") as page,
    ):
        assert (json.load(summary)["passed"], "Failed" in page.read()) == (False, True)
    assert "Remedy: remove damping.kind" in " ".join(out.split())


def test_labels_hang(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    lines = labelled("steps        " + "many words " * 8, 13)
    assert all(line.startswith((" " * 13, "steps")) for line in lines)
    assert labelled("  no label here at all" * 2, 13) == ["  no label here at all  no label here at", "  all"]
    assert labelled("", 13) == [""]
    assert labelled("Strike 10 is longer than a line of forty columns", 10)[1].startswith("columns")
    assert max(map(len, lines)) <= 40


def test_paths_are_not_broken(monkeypatch):
    from postprocess.report.terminal import place_line

    monkeypatch.setenv("COLUMNS", "40")
    path = "/a folder/" + "x" * 60
    assert printed((place_line("Report:", path),)) == f"Report: {path}"


@pytest.mark.parametrize("arguments", [
    ("scenes",), ("check", "mash-tl4-sut"), ("check", "impact-mash-tl4-sut"), ("rigid", "mash-tl4-sut"),
    ("run", "paper-table-3", "--no-pictures"), ("modes", "paper-table-3", "--count", "1"),
    ("modal", "paper-table-3"), ("completion", "fish"), ("new", "my-truck"),
], ids=" ".join)  # fmt: skip
def test_every_command_speaks_json_or_not_at_all(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli._status([*arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)
    for path in tmp_path.iterdir():
        path.unlink() if path.is_file() else shutil.rmtree(path)
    assert cli._status([*arguments, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_no_command_lacks_them():
    study = cli.commands.commands["study"]
    assert isinstance(study, click.Group)
    context = click.Context(study)
    all_commands = {name: cmd for name, cmd in cli.commands.commands.items() if name != "study"}  # a group
    studies = ((name, study.get_command(context, name)) for name in study.list_commands(context))
    all_commands |= {name: command for name, command in studies if command}
    for name, command in all_commands.items():
        options = {option for parameter in command.params for option in parameter.opts}
        assert options >= {"--json", "--quiet"}, name


def test_us_units_of_a_run(tmp_path, capsys):
    """Terminal, page and curves are in US units, files in SI."""
    place = tmp_path / "us"
    words = ["run", "mash-tl4-sut", "--no-pictures", "--out", str(place), "--units", "us", "--full"]
    assert cli._status(words) == 0
    out = capsys.readouterr().out
    force = json.loads((place / "summary.json").read_text())["stage3"]["peak_force"]
    assert 600e3 < force < 700e3, "SI"
    assert f"{force / 4448.2216152605:.1f}" in out
    assert {"[kip]", "ft/s", "ft"} <= set(out.split())
    assert f"{-3.289 / 0.3048:.5g}" in out.split(), "the paper's too"
    assert not {"[kN]", "m/s"} & set(out.split())
    assert "[ft/s]" in (place / "v_gx.svg").read_text()
    assert "[kip]" in (place / "reaction_normal.svg").read_text()
    assert "54.0" in out, "AASHTO's force for TL-4, as printed there"


def leaves(tables, prefix=""):
    """Dotted keys of values, of lists of tables those of the first."""
    for key, value in tables.items():
        inner = value[0] if f"{prefix}{key}" in schema.LISTED else value
        yield from leaves(inner, f"{prefix}{key}.") if isinstance(inner, dict) else (f"{prefix}{key}",)


def test_every_key_stands_in_a_new_scene():
    text = write.new_scene("my-truck")
    assert validate(tomllib.loads(text)).name == "my-truck"
    bare = [line.lstrip("# ") for line in text.splitlines()]
    for key in schema.MEANINGS:
        assert any(line.startswith(f"{key.rpartition('.')[2]} = ") for line in bare), key
    everything = "\n".join([line for line in bare if "=" in line or line.startswith("[")])
    tables = tomllib.loads(everything)
    assert set(leaves(tables)) == set(schema.MEANINGS)


def test_examples_in_a_new_scene_are_allowed():
    """Each example alone, in its table."""
    text = "\n".join(line.lstrip("# ") for line in write.new_scene("x").splitlines()[1:])
    assert key_by_key(tomllib.loads(text)).name


def test_a_new_scene_is_not_written_over(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli._status(["new", "my-truck", "-q"]) == 0
    assert cli._status(["check", "my-truck.toml", "-q"]) == 0
    written = (tmp_path / "my-truck.toml").read_text()
    assert cli._status(["new", "my-truck", "-q"]) == 2
    assert (tmp_path / "my-truck.toml").read_text() == written
    assert cli._status(["new", "../x", "-q"]) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["my-truck.toml"]


def test_further_columns_stand_beside_all_words_that_name_a_row():
    """Both columns of words above the numbers that have no room."""
    numbers = [Column(f"n{k}", f"number {k}", form=".6f") for k in range(8)]
    row = {"result": "first", "column": "v_gy"} | {f"n{k}": 1234.5 for k in range(8)}
    lines = table_lines(Table((Column("result", "Result"), Column("column", "Column"), *numbers), [row]), 80)
    assert max(map(len, lines)) <= 80
    assert " ".join(lines).split().count("1234.500000") == 8
    assert [line.split()[:2] for line in lines if "first" in line] == [["first", "v_gy"]] * 2


def test_a_shell_completes_scenes_and_keys(monkeypatch, capfd):
    def completed(*words, call=cli._status):
        monkeypatch.setenv("COMP_WORDS", " ".join(("tailslap", *words)))
        monkeypatch.setenv("COMP_CWORD", str(len(words)))
        assert not call([])
        return [row.partition(",")[2] for row in capfd.readouterr().out.splitlines()]

    monkeypatch.setenv("_TAILSLAP_COMPLETE", "bash_complete")
    by_process = completed("ru", call=lambda _: subprocess.check_call([sys.executable, "-m", "tailslap"]))
    assert by_process == completed("ru")
    assert "run" in completed("ru")
    assert completed("run", "paper-t") == ["paper-table-3"]
    assert "plate.thickness=" in completed("run", "paper-table-3", "--set", "plate.th")
    assert completed("study", "unknown", "paper-t") == []
    keys = [f"trailer.0.{key}=" for key in ("hitch", "hitch_length", "hitch_height")]
    assert completed("run", "paper-table-3", "--set", "trailer.0.hit") == keys
    assert "--tolerance" in completed("run", "paper-table-3", "--to")


def test_progress_off_a_terminal(capsys, monkeypatch):
    """Lines on request have count, rate and remaining time."""
    from tailslap import progress

    monkeypatch.setattr(progress, "LINES_INTERVAL", 0.0)

    def work():
        with progress.progress_bar("steps", 200) as outer:
            outer(0.5)
            with progress.counted("inner", 3, 0) as inner:
                inner(2)
        return capsys.readouterr().err

    assert work() == ""
    with progress.shown_as("lines"):
        assert work().startswith("tailslap: steps: 100 of 200, ")
        assert "inner" not in work()
        assert "/s, 0:0" in work()
    with progress.shown_as("none"):
        assert work() == ""
