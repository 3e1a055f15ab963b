"""Report of the study `flexibility`."""

import math
from collections.abc import Sequence

from postprocess.comparison.quantities import KEYS, QUANTITIES
from postprocess.figures.studies import SweepAxis, SweepLine, draw_sweep
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Form, Table, columns, listed
from postprocess.report.terminal import Part
from postprocess.svg.chart import FULL, HALF, Chart
from postprocess.units import known, measure, percent
from tailslap.campaign.levels import hertz
from tailslap.campaign.records import Record
from tailslap.case.impact.answers import COMPANION, COMPARED
from tailslap.case.impact.strike_columns import COLUMNS
from tailslap.case.impact.strike_columns import QUANTITIES as STRIKE_QUANTITIES
from tailslap.case.report_parts import study_page, study_summary
from tailslap.studies.flexibility.corner_flexibility import CONSERVED, LEVELS, MEASURED, STARTS
from tailslap.studies.flexibility.impact_flexibility import IMPACT_LEVELS, NAMES
from tailslap.studies.flexibility.plate_runs import Flexibility

START_NAMES = dict(zip(STARTS, ("inertia relief", "Stage 1's momenta", "unstressed"), strict=True))
SYMBOLS = {name: quantity.symbol for name, quantity in QUANTITIES.items()}
SYMBOLS |= {"reaction": "reaction", "stored": "stored energy", "v_p": "v_P"}
MAIN, MAIN_STRIKE = LEVELS.index(1e-2), "strike_2.impulse"
"""Level and quantity of the headlines."""

SIZE, DEPARTURE = known(".2e"), known(".2e", negligible=1e-9)
SIGNED, ONE = known("+.2e"), known(".1f")
F1 = Column("frequency", "f_1", form=hertz)
FILES = "points.csv (all plates, in SI); {scan}summary.json"
SCAN_FILE = "scan.csv (differences of the scan); "


POINTS = [
    Column(column, SYMBOLS[name], form=SIZE, below=Column(f"error_{name}", "", form=SIZE))
    for name, column in MEASURED.items()
]
PARTS = {"v_gy": "At the tail-slap", "v_gy_largest": "Largest", "v_gy_error": "Error"}
AT_START = {f"{name}_at_start": SYMBOLS[name] for name in CONSERVED}


STIFF = (Column("youngs_modulus", "E", "Pa", form=SIZE), Column("damping_rate", "Damping", "1/s", form=SIZE))
PLATE_COLUMNS = {
    "deflection_ratio": "Static deflection ratio",
}
READING = (
    "Inertia relief starts from the quasi-static elastic state of the rigid-body acceleration, with the angular "
    "velocity and corner speed of Stage 1, or with its momenta. The unstressed plate has the velocities and momenta "
    "of Stage 1 and oscillates. Levels of v_GY refer to the largest difference up to the tail-slap; <: reached "
    "down to that frequency at least, below which plates fail or the numerical error exceeds a third of the level.",
    "Errors are below the values: grid convergence index of three meshes, plus the effects of damping and ringing. "
    "Highlighted plates failed a check.",
)
WORDS = {f"strike_1.{name}": f"{name.replace('_', ' ')}, first strike" for name in COMPARED}
WORDS |= {f"strike_2.{name}": f"{name.replace('_', ' ')}, second strike" for name in COMPARED}
STRIKE_POINTS = [
    Column(f"difference.{name}", words, form=SIGNED, below=Column(f"error.{name}", "", form=SIGNED))
    for name, words in WORDS.items()
]
IMPACT_READING = (
    "FE/rigid - 1 of each strike, with the mesh error below it (change with elements of twice the order). Plates whose "
    "first two strikes occur at other corners than those of the rigid vehicle have no values. Levels: lowest first "
    "frequency at which the difference is below the level; >: above the range; <: below the level down to that "
    "frequency at least, below which plates end, have no values, or a numerical error above a third of the level."
)
PLATES = (
    "FE runs from soft to rigid, with the crush force of a corner distributed over a tenth of the length. Contacts "
    "of a corner within 50 ms count as one strike, filtered separately. Mesh: largest difference from a mesh of "
    "twice the element size; plates above 5 %, or with a failed check, are not reliable."
)
SHORT = ("mean_50ms", "impulse", "duration")
"""Quantities of the table on the terminal."""


def report(result: Flexibility) -> Report:
    """Return the report of the study."""
    return impact_report(result) if result.case.scene.contact else corner_report(result)


def corner_report(result: Flexibility) -> Report:
    """Return the report of a constrained corner."""
    starts, rows = {**result.levels, "all three starts": result.band}, [_shown(row) for row in result.rows]
    bands = [{"what": START_NAMES.get(name, name), "levels": reaches} for name, reaches in starts.items()]
    marked = {len(STARTS): "marked"}
    v_gy = Table(
        _good(LEVELS), bands, "Lowest first frequency at which rigid-body v_GY is within", marks=marked
    )
    at_end = [{"what": SYMBOLS[name], "levels": reaches} for name, reaches in result.other_levels.items()]
    failed = {i: "failed" for i, row in enumerate(rows) if not row["passed"]}
    first, *more = _every_plate().items()
    tables = [Table((F1, *first[1]), rows, first[0], marks=failed)]
    tables += [Table((F1, *heads), rows, title) for title, heads in more]
    by_start, differences, reaction, stored = figures(result)
    modelled, resolution = _modelled(result), _resolution(result)
    sections = (
        Section("Three starts", "", (by_start,), (v_gy,), (modelled, resolution, *READING)),
        Section("With inertia relief", "", (differences,), (Table(_good(LEVELS), at_end),)),
        Section("Reaction and stored energy", "", (reaction, stored)),
        Section("All plates", tables=tables),
    )
    numbers: Record = {"rigid": result.case.tail_slap, "levels_v_gy": result.levels}
    numbers |= {"levels_v_gy_any_start": result.band, "levels": result.other_levels}
    return _report(result, answer(result), sections, numbers, (v_gy, resolution, modelled))


def _good(levels: Sequence[float]) -> tuple[Column, ...]:
    """Return the columns of a table of levels."""
    named = {f"levels.{i}.text": f"{100.0 * level:g} %" for i, level in enumerate(levels)}
    return (Column("what", "Largest difference"), *columns(named, form=str))


def _of_starts(starts: Sequence[str], labels: dict[str, str], form: Form) -> list[Column]:
    """Return the columns of each start."""
    named = ({f"{start}:{key}": label for key, label in labels.items()} for start in starts)
    groups = (columns(keys, form=form, group=START_NAMES[k]) for k, keys in zip(starts, named, strict=True))
    return [column for group in groups for column in group]


def _every_plate() -> dict[str, Sequence[Column]]:
    """Return the columns of the tables of all plates."""
    return {
        "Differences at the tail-slap, with inertia relief": (Column("checks", "Checks"), *POINTS),
        "Difference of v_GY by start": _of_starts(STARTS, PARTS, SIZE),
        "Differences from Stage 1 at t = 0": _of_starts(STARTS[:2], AT_START, DEPARTURE),
        "Properties of the plates": (*STIFF, *columns(PLATE_COLUMNS, form=SIZE)),
    }


def _report(
    result: Flexibility,
    sentences: tuple[str, str],
    sections: Sequence[Section],
    numbers: Record,
    terminal: tuple[Part, ...],
) -> Report:
    """Return the report of either kind of case.

    `sentences` are answer and certainty.
    """
    any_passed, case = any(row.get("passed", not row.get("failed")) for row in result.rows), result.case
    set_up = f"{case.set_up} The plate of the scene has a first natural frequency of {hertz(result.own_frequency)}."
    headline = Headline(f"Effect of flexibility: {case.subject}", sentences[0], set_up, sentences[1])
    names = FILES.format(scan=SCAN_FILE if result.scan else "")
    page = study_page(
        case, "Finite elements against the rigid vehicle", headline, sections, names, any_passed
    )
    head = {**study_summary("flexibility", case), "passed": any_passed}
    summary = {**head, "own_frequency": result.own_frequency, **result.setup, **numbers}
    summary |= {"scan_runs": len(result.scan), "scan_step": result.step}
    summary |= {"points": result.rows, "cost": {"seconds": result.seconds}}
    # The last plate of a whole impact is the rigid vehicle.
    plates = len(result.rows) + len(result.scan) + max(0, len(result.plates) - 1)
    cost = f"Cost:   {plates} plates in {result.seconds:.0f} s"
    files = {"points.csv": listed(result.rows)} | ({"scan.csv": listed(result.scan)} if result.scan else {})
    return Report(page, summary, (*terminal, cost), files)


def _resolution(result: Flexibility) -> str:
    """Describe runs and step of the scan."""
    if not result.scan:
        return "No level is within the range."
    frequencies = [row["first_frequency"] for row in result.scan]
    return (
        f"Differences oscillate over the first frequency: levels are from {len(frequencies)} further runs from "
        f"{hertz(min(frequencies))} to {hertz(max(frequencies))}, at steps of {hertz(result.step)}, or beside a level "
        "5 % of the frequency if that is less, and are one step on the safe side."
    )


def _failures(rows: Sequence[tuple[float, str]]) -> str:
    """List the plates that failed, with reasons."""
    return f"Failed plates: {'; '.join(f'{hertz(frequency)}: {why}' for frequency, why in rows if why) or 'none'}."


def _shown(row: Record) -> Record:
    """Return the displayed row of a plate.

    It has the effect of half the patch, and no values of starts that failed.
    """
    checks = "passed" if row["passed"] else f"{'failed' if row['steps'] else 'none'}: {row['why']}"
    failed = tuple(f"{start}:" for start in STARTS if not row[f"{start}:passed"])
    values = {key: None if key.startswith(failed) else value for key, value in row.items()}
    return {**values, "frequency": row["first_frequency"], "checks": checks}


def answer(result: Flexibility) -> tuple[str, str]:
    """Return answer and certainty on v_GY."""
    if not any(math.isfinite(reaches[MAIN].frequency) for reaches in result.levels.values()):
        return "The error of rigid-body v_GY for a soft plate is not known: no run passed its checks.", ""
    by_start = ", ".join(
        f"{reaches[MAIN].text} ({START_NAMES[name]})" for name, reaches in result.levels.items()
    )
    subject = f"Lowest natural frequency at which rigid-body v_GY is within {100.0 * LEVELS[MAIN]:g} %"
    certainty = f"By start of the plate: {by_start}. Numerical errors are added to the differences."
    return f"{subject}: {result.band[MAIN].text}.", certainty


def _modelled(result: Flexibility) -> str:
    """Describe mesh, support of the corner and failed plates."""
    support, (along, across) = result.setup["corner"], result.setup["meshes"][-1]
    origin = "" if support["own_patch"] else " (added by the study)"
    return (
        f"Mesh: {along} x {across} elements; {support['constraint']} constraint of the corner over "
        f"{measure(support['patch'], 'm', 'g')}{origin}. "
        + _failures([(row["first_frequency"], "" if row["passed"] else row["why"]) for row in result.rows])
    )


def figures(result: Flexibility) -> list[Chart]:
    """Return the charts of a constrained corner."""
    values = {name: [row[name] for row in result.rows] for name in result.rows[0]}
    passed, relative = values["passed"], "relative difference, magnitude"
    largest = "largest difference, relative to the rigid reaction"
    any_start = zip(passed, *(values[f"{start}:passed"] for start in STARTS), strict=True)

    def size(name: str) -> SweepLine:
        sizes = [abs(x) for x in values[MEASURED[name]]]
        return SweepLine(SYMBOLS[name], sizes, values[f"error_{name}"])

    def start_line(start: str) -> SweepLine:
        largest, error = values[f"{start}:v_gy_largest"], values[f"{start}:v_gy_error"]
        return SweepLine(START_NAMES[start], largest, error, passed=values[f"{start}:passed"])

    def chart(
        name: str, caption: str, label: str, lines: Sequence[SweepLine], levels: Sequence[float] = ()
    ) -> Chart:
        reliable = [*map(any, any_start)] if name == "starts" else passed
        axis = SweepAxis(values["first_frequency"], reliable, result.own_frequency)
        width = FULL if name == "starts" else HALF
        return draw_sweep(f"flexibility-{name}", axis, lines, label, caption, levels, width)

    by_start = "Largest difference of v_GY from the rigid body, by start"
    differences = "Time, velocities of the centre of mass, angular velocity and slide at the tail-slap"
    energy = "Largest strain energy of the plate, relative to its initial kinetic energy"
    return [
        chart("starts", by_start, relative, [start_line(start) for start in STARTS], LEVELS),
        chart("difference", differences, relative, [size(name) for name in KEYS], LEVELS),
        chart("reaction", "Normal reaction of the wall", largest, [size("reaction")]),
        chart("stored", energy, "strain energy / kinetic energy", [size("stored")]),
    ]


def impact_report(result: Flexibility) -> Report:
    """Return the report of a whole impact."""
    rows = [{"what": WORDS[name], "levels": result.levels[name]} for name in NAMES]
    bands = Table(_good(IMPACT_LEVELS), rows, "Lowest first frequency at which the rigid vehicle is within")
    marks = {i: "failed" for i, row in enumerate(result.rows) if row["failed"]}
    heads = (F1, *STRIKE_POINTS, Column("failed", "Checks failed"))
    points = Table(heads, result.rows, "Differences of the two strikes", marks=marks)
    patch = measure(result.setup["patch_length"], "m", "g")
    failures = _failures([(row["frequency"], row["failed"]) for row in result.rows])
    plane = f"Plate and rigid vehicle are the {COMPANION}. " if result.case.space else ""
    crush = f"{plane}A corner's crush is spread over {patch} of its side. {failures}"
    resolution = _resolution(result)
    reasons = [
        f"{row['frequency']:g} Hz: {', '.join(row['failed'])}." for row in result.plates if row["failed"]
    ]
    sections = (
        Section(
            "Both strikes", "", (_strikes_figure(result),), (bands,), (crush, resolution, IMPACT_READING)
        ),
        Section("From 2 Hz to rigid", PLATES, (), (plates_table(result),), reasons),
        Section("All plates", tables=(points,)),
    )
    rigid = result.case.rigid_numbers() | result.case.in_plane.numbers()
    numbers = {"rigid": rigid, "levels": result.levels, "plates": result.plates}
    plates = plates_table(result, "The plate from soft to rigid", short=True)
    return _report(result, _impact_answer(result), sections, numbers, (bands, resolution, crush, plates))


def _impact_answer(result: Flexibility) -> tuple[str, str]:
    """Return answer and certainty on the impulse."""
    reaches = result.levels[MAIN_STRIKE]
    limits = ", ".join(f"{reach.text} (within {100 * reach.level:g} %)" for reach in reaches)
    sentence = (
        f"Lowest natural frequency at which the impulse of the rigid vehicle's second strike holds: {limits}."
    )
    soft = next((row for row in result.plates[:-1] if row["passed"]), None)
    if soft is None:
        return sentence, ""
    values, rigid = soft["values"], result.plates[-1]["values"]
    names = [f"strike_2.{name}" for name in ("impulse", "duration", "mean_50ms")]
    impulse, duration, mean = (percent(values[name] / rigid[name] - 1.0, 0) for name in names)
    effect = f"impulse {impulse}, duration {duration}, 50 ms mean {mean}"
    return sentence, f"Effect of a plate of {soft['frequency']:g} Hz on the second strike: {effect}."


def _strikes_figure(result: Flexibility) -> Chart:
    """Return the chart of differences of both strikes."""
    rows, own_frequency = result.rows, result.own_frequency

    def sizes(group: str, name: str) -> list[float]:
        return [abs(row[f"{group}.{name}"]) for row in rows]

    lines = [SweepLine(WORDS[name], sizes("difference", name), sizes("error", name)) for name in NAMES]
    axis = SweepAxis([row["frequency"] for row in rows], [not row["failed"] for row in rows], own_frequency)
    caption = "Difference of plate and rigid vehicle in both strikes, over the plate's first frequency"
    return draw_sweep("flexibility-strikes", axis, lines, "|FE/rigid - 1|", caption, IMPACT_LEVELS, FULL)


def plates_table(result: Flexibility, title: str = "", short: bool = False) -> Table:
    """Return the table of both strikes over the first frequency.

    The short one excludes raw and CFC 60 peaks.
    """
    rows: list[Record] = [
        {"frequency": "rigid" if row["frequency"] is None else f"{row['frequency']:g}", "error": row["error"]}
        for row in result.plates
    ]
    heads = [Column("frequency", "f_1", "Hz", form=str)]
    for column in COLUMNS:
        group, name = column.removeprefix("strike_").split(".")
        if short and name not in SHORT:
            continue
        label, unit, scale = STRIKE_QUANTITIES[name]
        heads.append(Column(column, label.replace(" mean", ""), unit, form=ONE, group=f"Strike {group}"))
        for row, plate in zip(rows, result.plates, strict=True):
            row[column] = plate["values"].get(column, math.nan) / scale
    heads.append(
        Column("error", "Mesh", form=lambda e: percent(e, 1).lstrip("+") if math.isfinite(e) else "–")
    )
    failed = {n: "failed" for n, row in enumerate(result.plates) if not row["passed"]}
    return Table(tuple(heads), rows, title, marks=failed)
