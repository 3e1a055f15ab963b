"""Lay out the page of `tailslap validate`."""

from collections.abc import Sequence
from typing import Any, Literal

import tailslap
from postprocess.figures.studies import BandBar, draw_ratios
from postprocess.figures.tipping import draw_outcomes
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Table, columns
from tailslap.arguments import checked_arguments
from tailslap.case.force_band import CONFIDENCE, PERCENTILES, Calibration, central_part
from tailslap.case.report_parts import CALIBRATED, CALIBRATION, footer
from tailslap.result.result import Result, of_report
from tailslap.validation import predictions
from tailslap.validation.outcomes import OURS, OVER, SAMPLES, SIDE, STATED, UPRIGHT, Score, scores
from tailslap.validation.predictions import QUANTITIES, SAMPLES_IN_SPACE, Row, Validation

PAGE = "validation.html"

ROWS = (
    *columns({"case": "Case", "label": "Quantity"}),
    Column("kind", "Compared"),
    Column("predicted", "Predicted", form=".3g", style="strong"),
    *columns({"lower": f"{PERCENTILES[0]:g} %", "upper": f"{PERCENTILES[-1]:g} %"}, form=".3g"),
    Column("published", "Published", form=".3g"),
    Column("unit", "Unit"),
    Column("ratio", "Ratio", form=".2f"),
    Column("verdict", "In the band"),
    Column("former", "First set"),
    Column("plateau", "Plateaus", form=".2f"),
    Column("source", "Source", style="soft"),
)
SHORT = tuple(column for column in ROWS if column.key not in ("source", "plateau", "former"))
INPUTS = (
    *columns({"vehicle": "Vehicle", "key": "Key", "lower": "From", "upper": "To"}),
    Column("source", "Source", style="soft"),
)


def probability(fraction: float) -> str:
    """Return a fraction of the samples of an outcome in words.

    Of none and all, it is its bound with 95 % confidence.
    """
    bound = (1.0 - CONFIDENCE) ** (1.0 / SAMPLES)
    return {0.0: f"≤ {1.0 - bound:.3f}", 1.0: f"≥ {bound:.3f}"}.get(fraction, f"{fraction:.2f}")


OUTCOMES = (
    Column("case", "Test"),
    Column("wall", "Wall", "m", form=".2f"),
    Column("published", "Published", style="strong"),
    *columns(
        {f"probabilities.{name}": name.capitalize() for name in (UPRIGHT, SIDE, OVER)}, form=probability
    ),
    Column("stated", "Of the published", form=probability, style="strong"),
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

SETS = {
    "first": "first.toml was committed before the first prediction",
    "second": "second.toml was committed before it was scored, but the published values were known when it was chosen: "
    "its predictions are not blind",
}

METHOD = (
    "Predicted: median of rigid impacts whose inputs are independent and uniform over the ranges; the band is that of "
    "5 to 95 % of them. Ratio: predicted over published.",
    "Compared: forces of crash tests are mass times a 50 ms mean of a measured acceleration, predicted at a sensor on "
    "the frame, its place assumed; forces of FE models and design loads are those on the wall. Durations are read off "
    "the 50 ms mean, as the paper does. Values with a stated height of the wall are predicted in space.",
    "Plateaus: fraction of the variance that the plateaus of the crush law explain, by linear regression. "
    "No measured crush of a truck's corner was found; the plateaus are assumed, so that agreement of a row which they "
    "decide is no evidence for the model.",
    "The projected forces of Table 5, rows a to e, are the authors' multiples of Table 4 and are omitted. The planar "
    "model excludes roll, pitch, shifting load and deflection of the barrier, which changes speeds after impacts on "
    "barriers on posts and forces of vehicles that lean on the wall.",
    f"Rows in space: {SAMPLES_IN_SPACE} vehicles each, outcomes {SAMPLES}, with roll and pitch, on a rigid wall with "
    "its profile. Springs, tyres, centres of mass, inertias and crush are assumed over wide ranges.",
)


@checked_arguments
def validate(ranges: Literal["first", "second"] = "second") -> Result:
    """Compare published forces, durations and speeds with predictions.

    Parameters
    ----------
    ranges : str
        Set of ranges of the inputs: fixed before the first prediction, or chosen with the published values known.

    Returns
    -------
    Result
        `summary["rows"]` contains median, band, published value, ratio and source of each row in SI.

    Raises
    ------
    InputError
        For another name of a set.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.validate("first").summary["forces"]["geometric_mean"]  # doctest: +SKIP
    1.0
    """
    report = validation_report(predictions.validate(ranges))
    return of_report("validate", report, scene="", page_name=PAGE)


def validation_report(validation: Validation) -> Report:
    """Report the rows with their picture, inputs and method."""
    rows, scored = validation.rows, scores(validation.outcomes) if validation.outcomes else ()
    former = [*validation.former, *len(rows) * [None]]
    table = Table(ROWS, [_shown(row, before) for row, before in zip(rows, former, strict=False)], "")
    classes = Table(CALIBRATION, validation.calibrations, notes=CALIBRATED)
    method = (
        f"Ranges of tailslap/validation/{SETS[validation.name]}. No value was adjusted to a published one.",
        *METHOD,
    )
    sections = (
        Section("Predicted over published", figures=[draw_ratios(_bars(rows))]),
        Section("Rows", tables=[table], sentences=_worse(validation)),
        Section("Calibrated bands", tables=[classes]),
        *_outcome_sections(validation, scored),
        Section("Method", sentences=method, layout="half"),
        Section("Inputs", tables=[Table(INPUTS, validation.inputs, "")]),
    )
    texts: list[Table | str] = [Table(SHORT, table.rows, "Predictions"), *_worse(validation), classes]
    if scored:
        texts.append(Table(OUTCOMES[:-1], validation.outcomes, "Outcomes"))
        texts.append(Table(SCORES, scored, "Event: over the wall"))
    page = Page("Validation", _headline(validation, scored), sections, footer())
    return Report(page, _summary(validation, scored), tuple(texts), {"validation.csv": table})


def _headline(validation: Validation, scored: Sequence[Score]) -> Headline:
    """Return the numbers of values within their bands."""
    rows, independent = validation.rows, validation.independent
    blind = "blind prediction" if validation.name == "first" else "prediction"
    answer = (
        f"{sum(row.inside for row in rows)} of {len(rows)} published values lie in the {central_part()} band of the "
        f"inputs of their {blind}, {validation.name} set of ranges. Forces: geometric mean of predicted over published "
        f"{validation.geometric_mean:.2f}, spread by a factor of {validation.spread:.2f}, "
        f"{len(validation.force_ratios)} values."
    )
    certainty = (
        f"{sum(row.inside for row in independent)} of {len(independent)} rows that the assumed plateaus do not decide "
        f"lie in the band. {validation.impacts} rigid impacts in {validation.seconds:.0f} s."
    )
    if scored:
        worst = min(validation.outcomes, key=lambda row: row.stated)
        least = f"Least probability of a published outcome: {probability(worst.stated)}, {worst.case}."
        answer += f" {_scores_in_words(scored)} {least}"
    return Headline("Predictions beside published tests", answer, "", certainty)


def _summary(validation: Validation, scored: Sequence[Score]) -> dict[str, Any]:
    """Return the content of `summary.json`."""
    independent = validation.independent
    return {
        "version": tailslap.__version__,
        "set": validation.name,
        "rows": [row._asdict() for row in validation.rows],
        "worse": [row.case for row in validation.worse],
        "calibration": {one.name: _calibration(one) for one in validation.calibrations},
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


def _calibration(one: Calibration) -> dict[str, Any] | str:
    """Return a calibration, or the reason why there is none."""
    if one.factor is None:
        return one.sentence
    held = {"left_out_rows": one.rows_held, "left_out_studies": one.studies_held}
    return {"factor": one.factor, "rows": one.rows, "studies": one.studies} | held


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


def _worse(validation: Validation) -> tuple[str, ...]:
    """Return the sentence on rows that got worse, if any."""
    if not validation.former:
        return ()
    names = "; ".join(f"{row.case} ({QUANTITIES[row.quantity][0]})" for row in validation.worse)
    inside = sum(row.inside for row in validation.former)
    return (
        f"The published values were known when the second set was chosen; with the first set {inside} of "
        f"{len(validation.rows)} lie in their bands. Worse than with the first set: {names or 'none'}.",
    )


def _shown(row: Row, former: Row | None) -> dict[str, object]:
    """Return the entries of a row of the table in its unit.

    former: the row by the first set, if this is another one.
    """
    label, unit, factor = QUANTITIES[row.quantity]
    scaled = {name: factor * getattr(row, name) for name in ("predicted", "lower", "upper", "published")}
    kind = ", ".join(filter(None, (row.kind, "in space" if row.space else "")))
    texts = {"case": row.case, "label": label, "unit": unit, "verdict": _verdict(row), "kind": kind}
    texts |= {"former": _verdict(former) if former else ""}
    return {**texts, **scaled, "ratio": row.ratio, "plateau": row.plateau, "source": row.source}


def _verdict(row: Row) -> str:
    """Return whether the published value lies in the band."""
    return "yes" if row.inside else "no"


def _bars(rows: Sequence[Row]) -> list[BandBar]:
    """Return the bands of the rows relative to the published values."""
    bars = []
    for row in rows:
        case = row.case.rpartition(":")[0] or row.case
        ends = tuple(value / row.published for value in (row.lower, row.predicted, row.upper))
        bars.append(BandBar(f"{case}: {QUANTITIES[row.quantity][0]}", row.inside, ends))
    return bars
