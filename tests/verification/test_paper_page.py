"""Verification: the command `paper`: its page, its files, its exit statuses."""

import html
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from typing import Any

import pytest
from test_command_line import imported
from test_postprocess_report import Parsed

from postprocess.report.page import glued, prose
from postprocess.report.table import Column, Table
from tailslap.cli import _status
from tailslap.files.manifest import NAME as MANIFEST
from tailslap.paper import tables
from tailslap.paper.page import MARK_LOOKS, MOTION_LOOKS, figure, sections, summary
from tailslap.paper.tables import FIGURES

FILES = {"paper.html", "summary.json", "figures_10_to_14_drag.csv", "figures_10_to_14_none.csv", MANIFEST}
FILES |= {f"{name}.svg" for name in FIGURES.values()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("paper") / "out"
    assert _status(["paper", "--out", str(place)]) == 0
    return place


@pytest.fixture(scope="module")
def page(folder):
    return Parsed((folder / "paper.html").read_text(encoding="utf-8"))


def strict(text: str) -> Any:
    def refuse(word: str) -> None:
        raise ValueError(word)

    return json.loads(text, parse_constant=refuse)


def test_the_page_holds_every_cell_and_note(page):
    packed = "".join(
        page.text.replace("\N{NO-BREAK SPACE}", " ").split()
    )  # a subscript is an element of its own
    shown = [table for part in sections(tables.review(), {}) for table in part.tables]
    words = [text for table in shown for text in (table.title, *table.notes)]
    words += [column.text(row) for table in shown for row in table.rows for column in table.columns]
    missing = [
        text
        for text in (re.sub("<[^>]+>", "", html.unescape(str(prose(word)))) for word in words)
        if "".join(text.replace("_", "").split()) not in packed.replace("_", "")
    ]
    assert missing == []


def test_the_page_fetches_nothing(page):
    links = {value for _, name, value in page.attributes if name in ("src", "href", "xlink:href")}
    assert all(link.startswith("#") for link in links)
    assert {f"#part-{number}" for number in range(1, 8)} <= links
    ids = [value for _, name, value in page.attributes if name == "id"]
    assert len(ids) == len({*ids})
    assert {link[1:] for link in links} <= {*ids}


def test_the_figures_are_drawn_with_their_marks(folder):
    """Two lines, a legend, and a mark in its own colour for each printed point."""
    courses = {reaction: tables.course(reaction) for reaction in ("drag", "none")}
    curves = [figure(number, name, courses) for number, name in FIGURES.items()]
    assert [curve.name for curve in curves] == ["theta", "v_gy", "v_gx", "omega", "slide"]
    for curve in curves:
        said = {*" ".join(ElementTree.fromstring(curve.svg).itertext()).split()}
        assert {"drag", "none", "paper"} <= said
        assert ("ABAQUS" in said) == (curve.name != "theta")
        groups = dict(re.findall(r'<g class="(\w+)"[^>]*>(<path data-label.*?)</g>', curve.svg))
        for points, look in zip(tables.marks(curve.name).values(), MARK_LOOKS, strict=True):
            assert groups.get(look["colour"], "").count("Z") == len(points)
        assert {look["colour"] for look in MOTION_LOOKS} <= set(groups)
        assert (folder / f"{curve.name}.svg").read_text().startswith("<svg xmlns=")
    assert (folder / "paper.html").read_text().count("<svg") == 5


def test_files_and_numbers(folder, capsys, tmp_path):
    """The folder is complete; `--json` prints what `summary.json` holds, without NaN or infinity."""
    assert {path.name for path in folder.iterdir()} == FILES
    assert _status(["paper", "--json", "--out", str(tmp_path / "other")]) == 0
    said = strict(capsys.readouterr().out)
    assert said == strict((folder / "summary.json").read_text())
    assert said == strict(json.dumps(summary(tables.review())))
    rows = (folder / "figures_10_to_14_drag.csv").read_text().splitlines()
    assert rows[0] == "t,theta,v_gy,v_gx,omega,slide"
    assert float(rows[-1].split(",")[2]) == pytest.approx(-3.2755267205, abs=5e-11)


def test_nothing_heavy_is_imported(tmp_path):
    """jinja2, for the page, SciPy, for the whole impact, and no mesh, FE or picture library."""
    scipy = {"scipy.integrate", "scipy.optimize", "scipy.sparse"}
    assert imported("paper", "--json", cwd=tmp_path) == {"jinja2", *scipy}
    assert {path.name for path in (tmp_path / "results" / "paper").iterdir()} == FILES


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        (("--out", "file"), "--out"),
        (("--out", "foreign"), "--out"),
        (("--out", "file/x"), "--out"),
        (("--fast",), "--fast"),
        (("mash-tl4-sut",), "mash-tl4-sut"),
    ],
)
def test_wrong_input_ends_with_two_and_nothing_written(arguments, key, tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "thesis.tex").write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    monkeypatch.chdir(tmp_path)
    assert _status(["paper", *arguments]) == 2
    out, err = capsys.readouterr()
    assert (out, sorted(tmp_path.rglob("*"))) == ("", before)
    assert key in err


def test_a_reader_of_the_pipe_may_leave(tmp_path, besides_compiling):
    command = f"{sys.executable} -m tailslap.cli paper | head -n 1; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, besides_compiling(done.stderr)) == (0, "")
    assert done.stdout.startswith("B. Chuong and R. B. Malla")


def test_an_earlier_result_is_replaced_and_what_was_added_stays(tmp_path):
    place = tmp_path / "out"
    assert _status(["paper", "--out", str(place)]) == 0
    (place / "notes.txt").write_text("mine")
    assert _status(["paper", "--out", str(place)]) == 0
    assert {path.name for path in place.iterdir()} == FILES | {"notes.txt"}


def test_symbols_in_prose_become_subscripts_and_numbers_keep_their_units():
    assert glued("v = 3 m/s and 4 %") == "v\u00a0=\u00a03\u00a0m/s and 4\u00a0%"
    assert prose("v_GY < 1 & θ_0") == "<i>v</i><sub>GY</sub> &lt; 1 &amp; <i>θ</i><sub>0</sub>"
    assert prose("paper_page") == "paper_page"


def test_headings_over_several_columns():
    columns = tuple(
        Column(key, key, group=group) for key, group in zip("abcd", ("", "g", "g", "h"), strict=True)
    )
    assert Table(columns, ()).groups == (("", 1), ("g", 2), ("h", 1))
    assert Table((Column("a", "a"),), ()).groups == ()
