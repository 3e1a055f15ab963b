"""What the study of features reports."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from postprocess.figures.features_plots import draw_ratios
from postprocess.report.numbers import duration
from postprocess.report.page import Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, pairs
from tailslap.report.common import study_page, study_summary
from tailslap.studies.features.costs import FEWEST_ROWS, ROWS, SETUP_TURNS, Costs
from tailslap.studies.features.proof import COSTS, FREE, SAME, UNSETTLED, Proof
from tailslap.studies.features.timing import CONFIDENCE, SEED, Ratio

KICKER = "What each part of a scene costs, and whether a part left out costs anything"
FILES = "summary.json, all numbers; features.csv, a line a part; turns.csv, the time of each loop in each turn [ns]"

VERDICTS = {
    FREE: "A part left out costs no measurable time",
    COSTS: "FAILED: a part left out costs measurable time",
    UNSETTLED: "This machine is too noisy to tell whether a part left out costs time",
}


def ratio_text(ratio: Ratio | None) -> str:
    """A ratio with its interval."""
    if ratio is None:
        return ""
    form = ".3f" if ratio.high < 2.0 else ".3g"
    return f"{ratio.median:{form}} ({ratio.low:{form}} to {ratio.high:{form}})"


BEST = Column("update_ns.best", "", form="best {:.1f}".format)
COLUMNS = (
    Column("part", "Part", below=Column("what", "")),
    Column("update_ns.median", "Element update", "ns", ".1f", below=BEST),
    Column("ratio", "Times the loop without", form=ratio_text, style="strong"),
    Column("steps", "Steps", form="d"),
    Column("time_loop_s", "Time loop", form=duration),
    Column("setup_s.best", "Set-up", form=duration),
)


def costs_report(found: Costs) -> Report:
    """Page, summary, table of parts, times of each turn."""
    said, name = headline(found), found.plan.scene.name
    note = "Medians, with the 95 % interval of the ratio. Time loop: of the whole run, its steps included."
    page = study_page(
        found.plan,
        KICKER,
        said,
        (
            Section(
                "What each part adds to a step", figures=(draw_ratios(found.ratios | found.proof.ratios),)
            ),
            Section("Parts", tables=(Table(COLUMNS, found.costs, notes=(note,)),)),
            Section("The proof", tables=(pairs(_proof(found)),), layout="half"),
            Section("Beside the loop", tables=(pairs(_beside(found)),), layout="half"),
            Section("What was measured, and how", sentences=sentences(found)),
        ),
        FILES,
        found.proof.passed,
    )
    parts = Table(COLUMNS[:-1], found.costs, f"{name}: what each part of the time loop costs")
    terminal = (parts, conclusion(found.proof), f"Cost:   {found.turns} turns, {found.seconds:.0f} s")
    tables, turns = {"features.csv": costs_table(found)}, {"turns.csv": found.table}
    return Report(page, summary(found), terminal, tables, turns)


def headline(found: Costs) -> str:
    """The conclusion, and the dearest part."""
    part, its = max(found.ratios.items(), key=lambda item: item[1].median)
    most = f"Of the parts, {part} costs most: {ratio_text(its)} times the loop without it."
    return f"{conclusion(found.proof)} {most}"


def conclusion(proof: Proof) -> str:
    """One plain sentence: does a part left out cost time?"""
    measured = (
        f"the program's loop takes {ratio_text(proof.program_over_bare)} times a loop that never had the parts, "
        f"and {ratio_text(proof.program_over_itself)} times itself"
    )
    if not proof.same:
        apart = f"{proof.difference:.1e} of the plate's length after {proof.steps} steps"
        return f"FAILED: the two loops do not compute the same, they differ by {apart}."
    return f"{VERDICTS[proof.verdict]}: {measured}."


def summary(found: Costs) -> dict[str, Any]:
    """The numbers of the study."""
    proof, updates = found.proof, {"bare_ns": asdict(found.bare), "again_ns": asdict(found.again)}
    return {
        **study_summary("features", found.plan),
        "passed": proof.passed,
        "conclusion": conclusion(proof),
        "elements": found.elements,
        "turns": found.turns,
        "seed": SEED,
        "proof": {"verdict": proof.verdict, "limit": proof.limit, **asdict(proof), **updates},
        "parts": [asdict(cost) for cost in found.costs],
        "left_out": [{"part": part, "why": why} for part, why in found.refused.items()],
        "history": asdict(found.history),
        "wall": asdict(found.wall),
        "cost": {"seconds": found.seconds},
    }


def costs_table(found: Costs) -> Table:
    """A line a part, every number of it in a column of its own."""
    rows = [cost.entries for cost in found.costs]
    names = dict.fromkeys((name for row in rows for name in row), "")
    return Table(tuple(Column(name, name) for name in names), [names | row for row in rows])


def _proof(found: Costs) -> dict[str, Any]:
    proof, plain = found.proof, found.costs[0].update_ns
    return {
        "program's loop, best and median [ns]": f"{plain.best:.2f}, {plain.median:.2f}",
        "bare loop, best and median [ns]": f"{found.bare.best:.2f}, {found.bare.median:.2f}",
        "it fails if the whole interval is above": f"{proof.limit:.3f}",
        f"positions differ by, of the length, {SAME:g} allowed": f"{proof.difference:.1e}",
    }


def _beside(found: Costs) -> dict[str, Any]:
    row, without, with_mesh = found.history.row_s, found.wall.setup_without_s, found.wall.setup_with_s
    return {
        "a row of the history, best and median": f"{duration(row.best)}, {duration(row.median)}",
        f"{ROWS} rows instead of {FEWEST_ROWS}, over the time loop": ratio_text(found.history.over_loop),
        "set-up without and with the wall's mesh": f"{duration(without.best)}, {duration(with_mesh.best)}",
    }


def sentences(found: Costs) -> list[str]:
    """What a reader must know beside the numbers."""
    compiling = sum(cost.compile_s for cost in found.costs)
    return [
        f"All loops take turns, {found.turns} times, on {found.elements} elements; ratios are taken turn by turn, with "
        f"the {100 * CONFIDENCE:g} % bootstrap interval of their median. Compiling or loading, {compiling:.2f} s in "
        f"all, is not in them; set-up is the best of {SETUP_TURNS}.",
        "Each part is added alone to the plain scene: internal forces, penalty spring, drift, and the sums of the "
        "ledger. Hourglass control is compared with one-point elements without it, which mean nothing but time.",
        "Threads wait for each other by spinning: on few elements, or on busy cores, they are slower than one.",
        "The bare loop, tailslap/studies/features/bare.py, has no code for friction, damping, dashpot, hourglass "
        f"control, patch or sums; positions are compared after {found.proof.steps} steps.",
        *(f"Omitted: {part}. {why}" for part, why in found.refused.items()),
    ]
