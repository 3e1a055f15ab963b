"""Verify that benchmarks/release.py measures every figure of docs/accuracy.md."""

import re

import pytest
import release

from tailslap.storage.folder import result_folder

LINES = release.statements(release.ACCURACY.read_text(encoding="utf-8"))
WORDS = [words for every in release.FIGURES.values() for words in every]
NOT_MEASURED = ("| quantity |", "| code |", "|---", "On two cores", "All figures", "Scene `paper-abaqus` to")


def test_every_statement_with_a_figure_has_a_command():
    measured = [line for line in LINES if any(words in line for words in WORDS)]
    unmeasured = [line[:60] for line in LINES if line not in measured and not line.startswith(NOT_MEASURED)]
    assert unmeasured == []


@pytest.mark.parametrize("words", WORDS)
def test_words_name_one_statement(words):
    assert release.stated(words, LINES)


def test_every_command_is_a_file():
    for command in release.FIGURES:
        assert command.startswith("-m tailslap ") or (release.ROOT / command.split()[0]).is_file()


def test_page_has_what_the_commands_printed(tmp_path):
    """One that succeeds, one that fails, one without its requirement."""
    requirements = {"OTHERS": None, "EARLIER": "elsewhere"}
    commands = ("-m platform", "-c raise(SystemExit(3))", "benchmarks/speed.py OTHERS")
    runs = [release.measure(command, requirements) for command in commands]
    assert [run.outcome for run in runs] == ["ran", "exit status 3", "not run"]
    release_page = release.report(dict.fromkeys(commands, ("108 cases:",)), runs, "abc")
    assert not release_page.passed
    with result_folder(tmp_path / "out") as folder:
        release.write_report(release_page, folder)
    text = (tmp_path / "out" / "report.html").read_text().replace("\u00a0", " ")
    assert runs[0].text.split()[0] in text
    assert "all correct within" in text
    assert re.search("exit status 3", text)
    assert (tmp_path / "out" / "m-platform.txt").read_text() == runs[0].text
