"""Verify that the description for archives lists all files and digests."""

import hashlib
import json
import re
import subprocess

import pytest

import tailslap
from postprocess.report.provenance import CRATE, files_digest
from tailslap import cli
from tailslap.storage.manifest import NAME, read_manifest

SHELL = "ls | grep -v -e report.html -e ro-crate-metadata.json | LC_ALL=C sort | xargs sha256sum | sha256sum"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("provenance") / "run"
    assert cli._status(["run", "paper-table-3", "--no-pictures", "--out", str(place)]) == 0
    return place


@pytest.fixture(scope="module")
def entities(folder):
    content = json.loads((folder / CRATE).read_text())
    assert content["@context"] == "https://w3id.org/ro/crate/1.1/context"
    return {entity["@id"]: entity for entity in content["@graph"]}


def test_every_file_is_listed_with_size_and_digest(folder, entities):
    names = {path.name for path in folder.iterdir()} - {CRATE, NAME}
    assert {part["@id"] for part in entities["./"]["hasPart"]} == names
    for name in names:
        content = (folder / name).read_bytes()
        assert entities[name]["@type"] == "File"
        assert entities[name]["sha256"] == hashlib.sha256(content).hexdigest()
        assert entities[name]["contentSize"] == str(len(content))
    assert entities["history.csv"]["encodingFormat"] == "text/csv"
    assert entities["theta.svg"]["encodingFormat"] == "image/svg+xml"


def test_digests_are_those_of_the_manifest(folder, entities):
    entries = read_manifest(folder)
    assert entries is not None
    listed = {entry.path: entry.sha256 for entry in entries}
    assert CRATE in listed
    assert {name: listed[name] for name in listed if name != CRATE} == {
        name: entity["sha256"] for name, entity in entities.items() if entity["@type"] == "File"
    }


def test_root_has_what_the_profile_demands(entities):
    """RO-Crate 1.1 requires a descriptor, name, description and date."""
    descriptor, root = entities[CRATE], entities["./"]
    assert descriptor["@type"] == "CreativeWork"
    assert descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert descriptor["about"] == {"@id": "./"}
    assert root["@type"] == "Dataset"
    assert root["name"].startswith("Tail-slap force: 9979 kg")
    assert "654 kN" in root["description"]
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", root["datePublished"])
    assert entities["#tailslap"]["softwareVersion"] == tailslap.__version__
    assert "`tailslap run paper-table-3 --no-pictures" in entities["#run"]["description"]


def test_page_shows_the_digest_that_the_shell_computes(folder, entities):
    digest = subprocess.run(["sh", "-c", SHELL], cwd=folder, capture_output=True, text=True).stdout.split()[0]
    assert entities["./"]["identifier"] == f"sha256:{digest}"
    assert digest in (folder / "report.html").read_text()


def test_another_number_has_another_digest(tmp_path):
    (tmp_path / "summary.json").write_text("1")
    before = files_digest(tmp_path, "report.html")
    (tmp_path / "report.html").write_text("page")
    assert files_digest(tmp_path, "report.html") == before
    (tmp_path / "summary.json").write_text("2")
    assert files_digest(tmp_path, "report.html") != before
