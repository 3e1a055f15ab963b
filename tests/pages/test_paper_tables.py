"""Verify cells, closed forms, prose and files of the command `paper`."""

import html
import json
import math
import re
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from browser.pages import Parsed
from processes import imported

from postprocess.report.prose import prose
from postprocess.report.provenance import CRATE
from postprocess.report.tables import Column, Table
from postprocess.report.terminal import printed
from postprocess.units import MPH, percent
from solver import plane_motion
from solver.impact import CrushLaw, ImpactState, WallContact, solve_impact
from tailslap.cli import _status
from tailslap.replication import paper_numbers, paper_page, paper_values
from tailslap.replication.paper_numbers import FIGURES, corner_fraction
from tailslap.replication.paper_page import MARK_STYLES, MOTION_STYLES, figure, sections, summary
from tailslap.replication.paper_values import ABAQUS, MASS, ForceRow
from tailslap.storage.manifest import NAME as MANIFEST


@pytest.fixture(scope="module")
def review():
    return paper_numbers.review()


def test_a_difference_is_computed_over_printed_less_one():
    cell = paper_numbers.beside(-4.0, -3.0)
    assert cell == {"printed": -4.0, "computed": -3.0, "difference": -0.25}
    columns = (paper_page.printed("cell", ".1f"), *paper_page.computed("cell", ".1f"))
    assert [column.text({"cell": cell}) for column in columns] == ["-4.0", "-3.0", "-25.000 %"]
    rounded = paper_page.computed("0", paper_page.scaled(0.5, ".0f"), decimals=1)
    assert [column.text((cell,)) for column in rounded] == ["-6", "-25.0 %"]


def test_inputs_in_si_by_hand():
    values = {item.name: item.value for item in paper_values.INPUTS}
    assert values["speed"] == pytest.approx(25.0, rel=1e-15)
    assert values["angle"] == pytest.approx(math.pi / 12.0, rel=1e-15)
    assert (values["mass"], values["width"], values["length"]) == (9979.0, 2.438, 10.0)


def test_a_row_of_table_4_by_hand(review):
    """The force is inverse to duration and to 1 - e.

    phi_a is force over measured force.
    """
    row = paper_numbers.force_row(ForceRow("x", "made up", 0.2, 100e3, (300e3, 400e3), (3.0, 4.0)))
    first = review["table_4"][0]
    assert first["printed"]["duration"] == 0.1
    elastic, plastic = (cell["computed"] for cell in row["peak"])
    assert elastic == pytest.approx(first["peak"][0]["computed"] / 2.0, rel=1e-14)
    assert plastic == pytest.approx(elastic / 0.78, rel=1e-13)
    assert row["factor"][1]["computed"] == pytest.approx(plastic / 100e3, rel=1e-14)
    assert row["ratio"]["printed"] == pytest.approx(4.0 / 3.0, rel=1e-15)
    assert row["ratio"]["computed"] == pytest.approx(1.0 / 0.78, rel=1e-15)
    assert (row["factor_of_print"], row["impulse"]) == ([3.0, 4.0], pytest.approx(30e3, rel=1e-15))


@pytest.mark.parametrize(
    ("plastic", "rounds"), [(1282e3, True), (1281e3, True), (1284e3, False), (1280e3, False)]
)
def test_ratios_that_rounding_explains(plastic, rounds):
    """1000 kN is 999.5 to 1000.5, so 1/0.78 makes 1281.4 to 1282.7."""
    row = ForceRow("x", "made up", 0.1, 1e6, (1e6, plastic), (1.0, 1.0))
    assert paper_numbers.force_row(row)["rounds"] is rounds


def test_the_instant_at_which_a_quantity_has_a_value():
    motion = plane_motion(paper_numbers.TRUCK, 0.26, 0.707, 25.053, 0.47)
    for name in ("slide", "v_gx", "theta", "omega"):
        value = float(getattr(motion.at(0.2), name))
        assert paper_numbers.instant(motion, name, value) == pytest.approx(0.2, abs=1e-9)


def test_earlier_methods_by_hand():
    """Olson stops over A_L sin(theta) - B (1 - cos(theta)).

    Hirsch is pi/2 times, Ritter twice that.
    """
    theta, speed = math.radians(15.0), 56.0 * 0.44704
    travel = 5.0 * math.sin(theta) - 1.219 * (1.0 - math.cos(theta))
    olson = 9979.0 * (speed * math.sin(theta)) ** 2 / (2.0 * travel)
    methods = paper_numbers.earlier_methods()
    assert methods["olson"] == pytest.approx(olson, rel=1e-13)
    assert methods["olson_first_member"] == pytest.approx(olson / 2.0, rel=1e-13)
    assert methods["hirsch"] == pytest.approx(math.pi / 2.0 * olson, rel=1e-13)
    assert methods["ritter"] == pytest.approx(2.0 * olson, rel=1e-13)


def test_marks_are_the_printed_points():
    assert paper_numbers.marks("theta") == {"paper": ((0.0, 0.26), (0.38, 0.0)), "ABAQUS": ()}
    assert paper_numbers.marks("omega") == {"paper": ((0.0, 0.707), (0.383, 0.65)), "ABAQUS": ((0.37, 0.66),)}
    assert paper_numbers.marks("v_gx") == {"paper": ((0.383, 23.27),), "ABAQUS": ((0.37, 23.305),)}


def test_the_fraction_of_the_mass_that_a_corner_brings():
    """A blow J at the rear corner adds J/m and J (L/2)^2/I."""
    inertia = MASS * (10.0**2 + 2.438**2) / 12.0
    assert corner_fraction(0.0) * MASS == pytest.approx(1.0 / (1.0 / MASS + 25.0 / inertia), rel=1e-13)
    assert corner_fraction(0.0) == pytest.approx(0.261, abs=5e-5)
    assert corner_fraction(0.47) < corner_fraction(0.0)


@pytest.mark.parametrize("friction", [0.0, 0.47])
def test_the_fraction_against_a_strike_of_the_rear_corner_alone(friction):
    """The impulse is (1 + e) m_eff v_E.

    At angle zero v_E = 2 v_GY.
    """
    start = ImpactState(0.0, 1.219 + 0.01, -0.002, 20.0, -3.0, 0.6)  # the front corner 20 mm off
    contact = WallContact(CrushLaw(1e11, 0.0, 0.5), friction)
    strike = solve_impact(paper_numbers.IMPACT_TRUCK, contact, start, 1e-3).strikes[0]
    assert strike.corner == "rear"
    assert strike.impulse == pytest.approx(1.5 * corner_fraction(friction) * MASS * 2.0 * 3.0, rel=3e-3)


def test_the_whole_impact(review):
    """Fraction, omega, filtered duration and sequence of the corners are consistent."""
    impact = review["whole_impact"]
    for case in impact["cases"]:
        assert case["share"] == pytest.approx(impact["share_friction"], rel=5e-3)
        assert case["closing"] == pytest.approx(2.0 * 4.55, rel=1e-2)
        assert case["read"]["mean_50ms"] - case["rear_duration"] == pytest.approx(0.05, abs=2e-3)
        assert 0.0 < case["released"] < case["rear_start"] < case["back"]
        assert case["gap"] > 0.1
    ratio = impact["corner_impulse"] / impact["plastic_impulse"]
    assert ratio == pytest.approx(2.0 * impact["share"], rel=1e-13)
    newton = impact["omegas"]["newton"]
    off = [abs(omega - newton) for omega in (*(c["omega"] for c in impact["cases"]), impact["nearly_rigid"])]
    assert off == sorted(off, reverse=True)
    assert off[-1] < 2e-4 * newton


def test_the_corners_speed_is_the_rate_of_its_crush():
    moving = paper_numbers.impact_motion(2e6)
    before, after = moving.contact_depths([0.2 - 1e-5, 0.2 + 1e-5])[1]
    assert paper_numbers.rear_speed(moving, 0.2) == pytest.approx((after - before) / 2e-5, rel=1e-7)


SAID_ELSEWHERE = [
    ((), "table_1.starts.56 mph.omega.computed"),
    (("impact.speed=90 km/h",), "table_1.starts.90 km/h.corner_speed.computed"),
    (("impact.convention=newton",), "restitution.newton.peak_force"),
    (("impact.restitution=0",), "restitution.e = 0.peak_force"),
    (("strike.duration=0.08",), "table_4.3.peak.0.computed"),
    (("impact.speed=57.4 mph", "impact.angle=15.4 deg"), "row_b.0.peak.0.computed"),
]


@pytest.mark.parametrize(("changes", "place"), SAID_ELSEWHERE)
def test_a_scene_says_the_tables_numbers(changes, place, review, capsys):
    """`tailslap rigid` prints them for the paper's truck."""
    assert (
        _status(["rigid", "mash-tl4-sut", *(word for change in changes for word in ("--set", change))]) == 0
    )
    value = Column(place, "").value(review)
    numbers = [float(word) for word in re.findall(r"-?\d+\.\d*(?:e[-+]?\d+)?", capsys.readouterr().out)]
    value = value / 1e3 if value > 1e3 else value
    assert any(number == pytest.approx(value, rel=1e-6) for number in numbers), value


def statements(review):
    """Statements of docs/paper.md with computed numbers, in order."""
    groups = (analytical, abaqus, stages, printed_forces, earlier_methods, whole_impact)
    return [statement for group in groups for statement in group(review)]


def analytical(review):
    start, table = review["table_1"]["starts"], review["table_3"]
    column, exact = table["analytical"], table["analytical_15"]
    worst = max(abs(column[name]["difference"]) for name in ("v_gy", "v_gx", "slide"))
    longer = exact["slide"]["computed"] / column["slide"]["computed"] - 1.0
    slower = start["90 km/h"]["peak_force"] / start["56 mph"]["peak_force"] - 1.0
    return [
        f"v_GY, v_GX and s to {100 * worst:.2f} %, t to {100 * abs(column['t']['difference']):.1f} %, omega to "
        f"{100 * abs(column['omega']['difference']):.1f} %",
        f"for a pulse of 0.1 s is {table['peak_force']['computed'] / 1e3:.0f} kN",
        f"rounds to 0.26 rad, t is {exact['t']['computed']:.4f} s and s {exact['slide']['computed']:.3f} m, "
        f"{percent(longer, 1)}",
        f"{start['56 mph']['omega']['computed']:.4f} rad/s and {start['56 mph']['corner_speed']['computed']:.3f} m/s "
        f"against the printed {paper_values.START['omega']} and {paper_values.START['corner_speed']}",
        f"The 90 km/h of Table 1 lead to {start['90 km/h']['omega']['computed']:.4f} and "
        f"{start['90 km/h']['corner_speed']['computed']:.3f}, and a peak force that is {percent(slower, 2)} off",
        f"belongs to {review['table_1']['implied_speed'] / MPH:.3f} mph",
    ]


def abaqus(review):
    table = review["table_3"]
    read, drag = table["abaqus_read"], table["abaqus_drag"]
    strike, (fallen, slid) = table["abaqus"]["t"]["computed"], table["crossing"]
    return [
        f"t = {table['reading']:g} s**, {1e3 * (strike - table['reading']):.0f} ms before the strike at {strike:.4f} s",
        f"the printed s = {ABAQUS['slide']} m, its v_GX is {read['v_gx']['computed']:.3f} m/s "
        f"({percent(read['v_gx']['difference'], 2)}), v_GY {read['v_gy']['computed']:.3f} "
        f"({percent(read['v_gy']['difference'], 2)}) and omega {read['omega']['computed']:.3f}",
        f"The printed t is {ABAQUS['t']} s, when s is {table['slide_at_printed_time']:.3f} m",
        f"at the same s, v_GX is {drag['v_gx']['computed']:.3f} m/s ({percent(drag['v_gx']['difference'], 2)})",
        f"falls through the printed {ABAQUS['v_gx']} m/s at {fallen:.3f} s, after {slid:.2f} m",
        f"From the 25 m/s of Table 2 the frictionless v_GX would be {table['v_gx_25']:.3f} m/s",
    ]


def stages(review):
    pull, signs, force = review["reaction"], review["restitution"], review["earlier"]["paper"]
    return [
        f"N from {pull['first'] / 1e3:.2f} to {pull['last'] / 1e3:.2f} kN",
        f"still has a velocity into the wall of {-signs['paper']['corner_recoil']:.3f} m/s",
        f"the peak force of {force / 1e3:.0f} kN (from 15 deg, not rounded) "
        f"{signs['newton']['peak_force'] / 1e3:.0f} kN, {percent(signs['newton']['change'], 0)}; "
        f"e = 0 makes it {signs['e = 0']['peak_force'] / 1e3:.0f} kN, "
        f"{percent(signs['e = 0']['change'], 0)}",
    ]


def printed_forces(review):
    """Tables 4 and 5."""
    four, five = review["table_4"], review["table_5"]
    differences = [cell["difference"] for row in four for cell in row["peak"]]
    both = [cell["difference"] for row in five for cell in row["peak"]]
    low, high = (f"{percent(end(differences), 1)}" for end in (min, max))
    assert [percent(end(both), 1) for end in (min, max)] == [low, high]
    off = {row["printed"]["row"]: abs(row["ratio"]["difference"]) for row in four}
    off_5 = [abs(row["ratio"]["difference"]) for row in five if row["printed"]["row"] in "aef"]
    far, near = [off[row] for row in "aef"] + off_5, [off[row] for row in "cd"]
    assert min(far) > 5e-3 > max(near)
    assert [row["printed"]["row"] for row in four if row["rounds"]] == ["b"]
    impulses, wrong = [row["impulse"] / 1e3 for row in four], wrong_digits(four)
    assert not wrong_digits(five)
    plastic = [row["printed"]["factor"][1] for row in four]
    factors = [row["factor"][0]["computed"] for row in four]
    return [
        f"differ by {100 * min(differences):.1f} to {percent(max(differences), 1)} in both tables; row b with the "
        f"57.4 mph and 15.4 deg of its test by {percent(review['row_b'][0]['peak'][0]['difference'], 1)}",
        f"must be {four[0]['ratio']['computed']:.3f}: rows a, e and f are off by {100 * min(far):.1f} to "
        f"{100 * max(far):.1f} %, rows c and d by less than 0.5 %",
        f"run from {min(impulses):.2f} to {max(impulses):.2f} kN s",
        f"the last digit of {wrong} of {4 * len(four)}",
        "1.32 to 2.78 as the range for e = 0, where Table 4 holds "  # Section 3.2
        f"{min(plastic)} to {max(plastic)}",
        f"they run from {min(factors):.2f} to {max(factors):.2f} there",
    ]


def wrong_digits(rows):
    """Number of printed factors that differ from those of the printed forces."""
    pairs = [
        pair for row in rows for pair in zip(row["printed"]["factor"], row["factor_of_print"], strict=True)
    ]
    return sum(f"{exact:.2f}" != f"{printed:.2f}" for printed, exact in pairs)


def earlier_methods(review):
    methods = ("olson", "hirsch", "ritter")
    earlier = review["earlier"]
    olson, hirsch, ritter = (f"{earlier[name] / 1e3:.0f} kN" for name in methods)
    return [
        f"A_L = {earlier['front_distance']:g} m, B = {earlier['half_width']:g} m and D = 0 assumed: "
        f"Olson {olson} (average), Hirsch {hirsch}, Ritter {ritter}"
    ]


def whole_impact(review):
    impact, cases = review["whole_impact"], review["whole_impact"]["cases"]
    keys = ("omega", "released", "gap", "rear_start", "share", "rear_impulse")
    omega, leaves, away, begins, fraction, impulse = ([case[name] for case in cases] for name in keys)
    lasts = [f"{1e3 * case['rear_duration']:.0f}" for case in cases]
    as_read = [f"{1e3 * case['read']['mean_50ms']:.0f}" for case in cases]
    assert np.ptp(fraction) < 1e-3
    assert np.ptp(impulse) < 100.0
    return [
        f"is {min(omega):.3f} to {max(omega):.3f} rad/s for 1 to 3 MN/m, {impact['nearly_rigid']:.4f} for 200 MN/m",
        f"leads to {impact['omegas']['newton']:.4f}, the paper's 1 - e {impact['omegas']['paper']:.4f}",
        f"separates from the wall** at {min(leaves):.3f} to {max(leaves):.3f} s, is {min(away):.1f} to "
        f"{max(away):.1f} m off",
        f"strikes at {min(begins):.3f} to {max(begins):.3f} s, in Stage 2, with the corner on the wall, at "
        f"{impact['paper_time']:.3f} s",
        f"= {impact['share']:.3f} m ({impact['share_friction']:.3f} with friction; the rear strike of the whole "
        f"impact has {fraction[1]:.3f}) at about 2 v_GY. For e = 0 the impulse is "
        f"{impact['corner_impulse'] / 1e3:.1f} instead of {impact['plastic_impulse'] / 1e3:.1f} kN s",
        f"For e = 0.22 the whole impact has {impulse[1] / 1e3:.1f} kN s, Stage 3 {impact['paper_impulse'] / 1e3:.1f}",
        f"strikes of {lasts[0]}, {lasts[1]} and {lasts[2]} ms (1, 2, 3 MN/m) appear as {as_read[0]}, {as_read[1]} and "
        f"{as_read[2]} ms",
    ]


def test_the_prose_on_the_paper_states_computed_numbers(review):
    """Each number of docs/paper.md is in a statement computed here.

    Excepted are two numbers of the paper itself.
    """
    text = " ".join((Path(__file__).parents[2] / "docs" / "paper.md").read_text(encoding="utf-8").split())
    computed = statements(review)
    assert [statement for statement in computed if statement not in text] == []
    for statement in computed:
        text = text.replace(statement, "")
    references = r"(?:Section|Tables?|Figures?|Stages?) [\d.]+\d?(?:(?:, \d)* (?:and|to) \d+)?"
    text = re.sub(rf"`[^`]*`|{references}", "", text)
    assert {*re.findall(r"\d+\.\d+", text)} <= {"0.22", "0.1"}


def test_tables_are_rectangular_and_without_empty_or_undefined_words(review):
    tables = [table for section in paper_page.sections(review, {}) for table in section.tables]
    assert len(tables) == 15
    for table in tables:
        assert len(table.records()) == len(table.rows)
        assert sum(span for _, span in table.groups) in (0, len(table.columns))
        cells = [column.text(row) for row in table.rows for column in table.columns]
        words = " ".join((table.title, *table.notes, *cells))
        assert not {"nan", "inf", "None", "–", "infinite", "number"} & {*words.split()}


def test_a_terminal_shows_the_tables_whole(review, monkeypatch):
    """A wide terminal neither cuts nor wraps, and keeps markup."""
    monkeypatch.setenv("COLUMNS", "100")
    out = printed(paper_page.paper_report(review).terminal)
    lines = out.splitlines()
    assert "…" not in out
    assert "\N{NO-BREAK SPACE}" not in out
    rows_printed = {" ".join(line.split()) for line in lines}
    for section in paper_page.sections(review, {}):
        assert section.title in lines
        for table in section.tables:
            for row in table.rows:
                cells = " ".join(column.text(row) for column in table.columns)
                assert " ".join(cells.split()) in rows_printed


@pytest.mark.parametrize("width", [60, 64, 72, 80, 100])
def test_a_terminal_breaks_no_line_before_a_unit(review, width, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(width))
    lines = printed(paper_page.paper_report(review).terminal).splitlines()
    for line, after in pairwise(line for line in lines if "  " not in line.strip()):
        assert not re.search(r"(\d\n *(%|kN|m/s|rad|s|m|ms|mph)(?!\w)| =\n)", f"{line}\n{after}"), line


FILES = {
    "paper.html", "summary.json", "figures_10_to_14_drag.csv", "figures_10_to_14_none.csv", MANIFEST, CRATE,
}  # fmt: skip
FILES |= {f"{name}.svg" for name in FIGURES.values()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("paper") / "out"
    assert _status(["paper", "--out", str(place)]) == 0
    return place


@pytest.fixture(scope="module")
def parsed(folder):
    return Parsed((folder / "paper.html").read_text(encoding="utf-8"))


def strict(text):
    def refuse(word):
        raise ValueError(word)

    return json.loads(text, parse_constant=refuse)


def test_the_page_holds_every_cell_and_note(parsed):
    # Without spaces: a subscript is an element of its own.
    packed = "".join(parsed.text.replace("\N{NO-BREAK SPACE}", " ").split())
    tables = [table for part in sections(paper_numbers.review(), {}) for table in part.tables]
    words = [text for table in tables for text in (table.title, *table.notes)]
    words += [column.text(row) for table in tables for row in table.rows for column in table.columns]
    plain = [re.sub("<[^>]+>", "", html.unescape(str(prose(word)))) for word in words]
    pieces = ["".join(text.replace("_", "").split()) for text in plain]
    missing = [text for text in pieces if text not in packed.replace("_", "")]
    assert missing == []


def test_the_figures_are_drawn_with_their_marks(folder):
    """Two lines, a legend, and a coloured mark for each printed point."""
    courses = {reaction: paper_numbers.course(reaction) for reaction in ("drag", "none")}
    curves = [figure(number, name, courses) for number, name in FIGURES.items()]
    assert [curve.name for curve in curves] == ["theta", "v_gy", "v_gx", "omega", "slide"]
    for curve in curves:
        words = {*" ".join(ElementTree.fromstring(curve.svg).itertext()).split()}
        assert {"drag", "none", "paper"} <= words
        assert ("ABAQUS" in words) == (curve.name != "theta")
        groups = dict(re.findall(r'<g class="(\w+)"[^>]*>(<path data-label.*?)</g>', curve.svg))
        for points, style in zip(paper_numbers.marks(curve.name).values(), MARK_STYLES, strict=True):
            assert groups.get(style["colour"], "").count("Z") == len(points)
        assert {style["colour"] for style in MOTION_STYLES} <= set(groups)
        assert (folder / f"{curve.name}.svg").read_text().startswith("<svg xmlns=")
    page = (folder / "paper.html").read_text()
    assert page.count("<svg") - page.count("<template>") == 5


def test_files_and_numbers(folder, capsys, tmp_path):
    """The folder is complete, and `--json` prints `summary.json` in strict JSON."""
    assert {path.name for path in folder.iterdir()} == FILES
    assert _status(["paper", "--json", "--out", str(tmp_path / "other")]) == 0
    printed_summary = strict(capsys.readouterr().out)
    assert printed_summary == strict((folder / "summary.json").read_text())
    headline = {
        name: printed_summary.pop(name) for name in ("title", "answer", "set_up", "certainty", "band")
    }
    assert headline["answer"].startswith(
        "Velocities and slide of Table 3's analytical column are reproduced within 0.0"
    )
    assert printed_summary == strict(json.dumps(summary(paper_numbers.review())))
    rows = (folder / "figures_10_to_14_drag.csv").read_text().splitlines()
    assert rows[0] == "t,theta,v_gy,v_gx,omega,slide"
    assert float(rows[-1].split(",")[2]) == pytest.approx(-3.2755267205, abs=5e-11)


def test_nothing_heavy_is_imported(tmp_path):
    """jinja2, rich and charts, and no SciPy, mesh, FE or picture library."""
    assert imported("paper", "--json", cwd=tmp_path) == {"jinja2", "rich", "postprocess.svg.chart"}
    assert {path.name for path in (tmp_path / "results" / "paper").iterdir()} == FILES


def test_headings_over_several_columns():
    groups = zip("abcd", ("", "g", "g", "h"), strict=True)
    columns = tuple(Column(key, key, group=group) for key, group in groups)
    assert Table(columns, ()).groups == (("", 1), ("g", 2), ("h", 1))
    assert Table((Column("a", "a"),), ()).groups == ()
