"""Lay out the page of `tailslap validate`."""

from collections.abc import Sequence
from typing import Any

import tailslap
from postprocess.figures.studies import RatioBar, draw_ratios
from postprocess.figures.tipping import draw_outcomes
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Table, columns
from tailslap.arguments import checked_arguments
from tailslap.case.force_band import PERCENTILES, central_part
from tailslap.case.report_parts import footer
from tailslap.result.result import Result, of_report
from tailslap.validation import predictions
from tailslap.validation.outcomes import OURS, OVER, SAMPLES, SIDE, STATED, UPRIGHT, Score, scores
from tailslap.validation.predictions import QUANTITIES, Row, Validation

PAGE = "validation.html"

ROWS = (
    *columns({"case": "Case", "label": "Quantity"}),
    Column("predicted", "Predicted", form=".3g", style="strong"),
    *columns({"lower": f"{PERCENTILES[0]:g} %", "upper": f"{PERCENTILES[-1]:g} %"}, form=".3g"),
    Column("published", "Published", form=".3g"),
    Column("unit", "Unit"),
    Column("ratio", "Ratio", form=".2f"),
    Column("verdict", "In the band"),
    Column("plateau", "Plateaus", form=".2f"),
    Column("source", "Source", style="soft"),
)
SHORT = tuple(column for column in ROWS if column.key not in ("source", "plateau"))
INPUTS = (
    *columns({"vehicle": "Vehicle", "key": "Key", "lower": "From", "upper": "To"}),
    Column("source", "Source", style="soft"),
)

OUTCOMES = (
    Column("case", "Test"),
    Column("wall", "Wall", "m", form=".2f"),
    Column("published", "Published", style="strong"),
    *columns({f"probabilities.{name}": name.capitalize() for name in (UPRIGHT, SIDE, OVER)}, form=".2f"),
    Column("stated", "Of the published", form=".2f", style="strong"),
    Column("source", "Source", style="soft"),
)
SCORES = (
    Column("name", "Forecast"),
    Column("score", "Brier score", form=".3f", style="strong"),
    *columns({"right": "Right", "cases": "Of"}, form="d"),
)
SKIPPED = columns({"name": "Published test", "why": "Not computed because"})

SCORED = (
    'Brier score: mean square of the probability of "over the wall" minus 1 or 0; a test reported as passed or '
    "contained is not over the wall, upright or on its side. 0 is perfect; 0.25 is that of one half always.",
    "Rules: a wall of at least their height holds, otherwise the vehicle goes over it. Few tests are published, and "
    'almost all of them of walls that hold: "always contained" scores the fraction of the others.',
)

METHOD = (
    "Vehicles, ranges and published values stand in tailslap/validation/parameters.toml, which was committed before "
    "the first prediction. No value was adjusted to a published one.",
    "Predicted: median of rigid impacts whose inputs are independent and uniform over the ranges; the band is that of "
    "5 to 95 % of them. Ratio: predicted over published.",
    "Plateaus: fraction of the variance that the plateaus of the crush law explain alone (first-order Sobol indices). "
    "No measured crush of a truck's corner was found; the plateaus are assumed, so that agreement of a row which they "
    "decide is no evidence for the model.",
    "The projected forces of Table 5, rows a to e, are the authors' multiples of Table 4 and are omitted. The planar "
    "model excludes roll, pitch, shifting load and deflection of the barrier, which changes speeds after impacts on "
    "barriers on posts and forces of vehicles that lean on the wall.",
    f"Rows in space and outcomes: {SAMPLES} vehicles in space each, with roll and pitch, on a rigid wall with its "
    "profile. Springs, tyres, centres of mass, inertias and crush are assumed over wide ranges.",
)


@checked_arguments
def validate() -> Result:
    """Compare published forces, durations and speeds with blind predictions.

    Returns
    -------
    Result
        `summary["rows"]` contains median, band, published value, ratio and source of each row in SI.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.validate().summary["forces"]["geometric_mean"]  # doctest: +SKIP
    0.9
    """
    report = validation_report(predictions.validate())
    return of_report("validate", report, scene="", page_name=PAGE)


def validation_report(validation: Validation) -> Report:
    """Report the rows with their picture, inputs and method."""
    rows, scored = validation.rows, scores(validation.outcomes) if validation.outcomes else ()
    table = Table(ROWS, [_shown(row) for row in rows], "")
    sections = (
        Section("Predicted over published", figures=[draw_ratios(_bars(rows))]),
        Section("Rows", tables=[table]),
        *_outcome_sections(validation, scored),
        Section("Method", sentences=METHOD, layout="half"),
        Section("Inputs", tables=[Table(INPUTS, validation.inputs, "")]),
    )
    texts = [Table(SHORT, table.rows, "Blind predictions")]
    if scored:
        texts.append(Table(OUTCOMES[:-1], validation.outcomes, "Outcomes"))
        texts.append(Table(SCORES, scored, "Event: over the wall"))
    page = Page("Validation", _headline(validation, scored), sections, footer())
    return Report(page, _summary(validation, scored), tuple(texts), {"validation.csv": table})


def _headline(validation: Validation, scored: Sequence[Score]) -> Headline:
    """Return the numbers of values within their bands."""
    rows, independent = validation.rows, validation.independent
    answer = (
        f"{sum(row.inside for row in rows)} of {len(rows)} published values lie in the {central_part()} band of their "
        f"blind prediction. Forces: geometric mean of predicted over published {validation.geometric_mean:.2f}, spread "
        f"by a factor of {validation.spread:.2f}, {len(validation.force_ratios)} values."
    )
    certainty = (
        f"{sum(row.inside for row in independent)} of {len(independent)} rows that the assumed plateaus do not decide "
        f"lie in the band. {validation.impacts} rigid impacts in {validation.seconds:.0f} s."
    )
    if scored:
        worst = min(validation.outcomes, key=lambda row: row.stated)
        least = f"Least probability of a published outcome: {worst.stated:.2f}, {worst.case}."
        answer += f" {_scores_in_words(scored)} {least}"
    return Headline("Predictions beside published tests", answer, "", certainty)


def _summary(validation: Validation, scored: Sequence[Score]) -> dict[str, Any]:
    """Return the content of `summary.json`."""
    independent = validation.independent
    return {
        "version": tailslap.__version__,
        "rows": [row._asdict() for row in validation.rows],
        "inside": sum(row.inside for row in validation.rows),
        "forces": {"geometric_mean": validation.geometric_mean, "spread": validation.spread}
        | {"count": len(validation.force_ratios)},
        "independent_of_plateaus": {
            "rows": len(independent),
            "inside": sum(row.inside for row in independent),
        },
        "outcomes": [row._asdict() for row in validation.outcomes],
        "scores": [score._asdict() for score in scored],
        "not_computed": validation.skipped,
        **{name: getattr(validation, name) for name in ("inputs", "impacts", "seconds")},
    }


def _scores_in_words(scored: Sequence[Score]) -> str:
    """Return the Brier scores in a sentence."""
    of_others = ", ".join(f"{score.name} {score.score:.3f}" for score in scored if score.name != OURS)
    return f"Outcomes of {scored[0].cases} tests, Brier score {scored[0].score:.3f}; {of_others}."


def _outcome_sections(validation: Validation, scored: Sequence[Score]) -> list[Section]:
    """Return picture and tables of the outcomes, none without any."""
    if not scored:
        return []
    cases = [row.case for row in validation.outcomes]
    parts = [[*row.probabilities.values()] for row in validation.outcomes]
    stated = [[name in STATED[row.published] for name in row.probabilities] for row in validation.outcomes]
    tables = (
        Table(OUTCOMES, validation.outcomes),
        Table(SCORES, scored, notes=SCORED),
        Table(SKIPPED, validation.skipped),
    )
    return [Section("Outcomes of crash tests", "", [draw_outcomes(cases, parts, stated)], tables)]


def _shown(row: Row) -> dict[str, object]:
    """Return the entries of a row of the table in its unit."""
    label, unit, factor = QUANTITIES[row.quantity]
    scaled = {name: factor * getattr(row, name) for name in ("predicted", "lower", "upper", "published")}
    texts = {"case": row.case, "label": label, "unit": unit, "verdict": "yes" if row.inside else "no"}
    return {**texts, **scaled, "ratio": row.ratio, "plateau": row.plateau, "source": row.source}


def _bars(rows: Sequence[Row]) -> list[RatioBar]:
    """Return the bands of the rows relative to the published values."""
    bars = []
    for row in rows:
        case = row.case.rpartition(":")[0] or row.case
        ends = tuple(value / row.published for value in (row.lower, row.predicted, row.upper))
        bars.append(RatioBar(f"{case}: {QUANTITIES[row.quantity][0]}", ends, row.inside))
    return bars
