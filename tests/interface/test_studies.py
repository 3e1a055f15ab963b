"""Verify that a study is one declaration, registered or in a folder."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import click
import pytest

import tailslap.studies
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Table
from tailslap import cli, studies
from tailslap.case.case import CORNER, WHOLE_IMPACT
from tailslap.studies.study import Study

TRUCK = "mash-tl4-sut"


def heavier(case, place, factor):
    """Masses of the scene's vehicle."""
    mass = case.scene.vehicle.mass
    return [{"what": "as it is", "mass": mass}, {"what": "heavier", "mass": factor * mass}]


def masses_report(masses):
    table = Table((Column("what", "Vehicle"), Column("mass", "Mass", "kg", form=".5g")), masses)
    section = Section("Masses", tables=(table,))
    page = Page("Masses", Headline("A toy", "Two masses."), (section,), "", passed=len(masses) == 2)
    return Report(page, {"masses": masses}, (table,), {"masses.csv": table})


FACTOR = click.Option(["--factor"], type=float, default=2.0)
TOY = Study("toy", "Masses of a vehicle.", heavier, masses_report, options=(FACTOR,), needs_plate=False)


@pytest.fixture(autouse=True)
def registry(monkeypatch):
    monkeypatch.setattr(tailslap.studies, "_registered", {})


def test_a_study_from_outside_goes_all_the_way_to_its_report(tmp_path, monkeypatch, capsys):
    studies.register(TOY)
    monkeypatch.chdir(tmp_path)
    assert "toy" in studies.study_names()
    assert cli._status(["study", "toy", TRUCK, "--set", "vehicle.mass=10 t", "--factor", "3"]) == 0
    folder = Path("results") / f"{TRUCK}+vehicle.mass=10t-toy"
    output = capsys.readouterr().out
    assert "30000" in output
    assert f"Report: {folder / 'report.html'}" in output
    assert "Two masses." in (folder / "report.html").read_text()
    summary = json.loads((folder / "summary.json").read_text())
    assert (summary["answer"], summary["masses"][1]) == ("Two masses.", {"what": "heavier", "mass": 3e4})
    assert output.endswith("\nTwo masses.\n")
    with (folder / "masses.csv").open() as file:
        assert [float(row["mass"]) for row in csv.DictReader(file)] == [1e4, 3e4]


def test_a_study_that_fails_ends_with_one_and_wrong_input_with_two(tmp_path):
    studies.register(Study("toy", "", lambda case, place: [], masses_report, needs_plate=True))
    assert cli._status(["study", "toy", TRUCK, "--out", str(tmp_path / "out")]) == 1
    assert cli._status(["study", "toy", TRUCK, "--set", "plate=", "--out", str(tmp_path / "none")]) == 2
    assert cli._status(["study", "toy", "nowhere"]) == 2
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize(
    ("kind", "scene", "words"),
    [(CORNER, f"impact-{TRUCK}", "without this table"), (WHOLE_IMPACT, TRUCK, "with this table")],
)
def test_a_study_of_the_other_kind_of_scene_is_refused(kind, scene, words, tmp_path, capsys):
    studies.register(replace(TOY, analyses=(kind,)))
    assert cli._status(["study", "toy", scene, "--out", str(tmp_path / "out")]) == 2
    message = capsys.readouterr().err
    assert "contact: given" in message
    assert words in message
    assert not (tmp_path / "out").exists()


def test_a_name_is_taken_once():
    studies.register(TOY)
    with pytest.raises(ValueError, match="toy"):
        studies.register(TOY)
    with pytest.raises(ValueError, match="cost"):
        studies.register(Study("cost", "", heavier, masses_report))


def test_a_study_is_found_by_its_folder(tmp_path, monkeypatch, capsys):
    (tmp_path / "demo").mkdir()
    study = "STUDY = Study('demo', 'A demonstration.', 'json:loads', 'json:dumps')\n"
    (tmp_path / "demo" / "__init__.py").write_text(f"from tailslap.studies.study import Study\n{study}")
    monkeypatch.setattr(tailslap.studies, "__path__", [*tailslap.studies.__path__, str(tmp_path)])
    assert cli._status(["study", "demo", "--help"]) == 0
    assert "A demonstration." in capsys.readouterr().out
