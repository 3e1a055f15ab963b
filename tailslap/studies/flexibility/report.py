"""Report of the study `flexibility`."""

import math
from collections.abc import Sequence
from typing import Any

from postprocess.comparison.quantities import KEYS, QUANTITIES
from postprocess.figures.studies import DOTS, RINGS, SweepAxis, SweepLine, draw_plates, draw_sweep
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns, listed
from postprocess.svg.chart import FULL, HALF, Chart
from postprocess.units import known, measure, percent
from tailslap.campaign.levels import hertz
from tailslap.case.impact.answers import COLUMNS, COMPARED
from tailslap.case.impact.answers import QUANTITIES as OF_STRIKES
from tailslap.case.report import study_page, study_summary
from tailslap.studies.flexibility import compute
from tailslap.studies.flexibility.compute import LEVELS, NAMES, STARTS, Flexibility, Record

START_NAMES = dict(zip(STARTS, ("inertia relief", "Stage 1's momenta", "unstressed"), strict=True))
SYMBOLS = {name: quantity.symbol for name, quantity in QUANTITIES.items()}
SYMBOLS |= {"reaction": "reaction", "stored": "stored energy", "v_p": "v_P"}
# Level and quantity of the headlines.
MAIN, MAIN_STRIKE = LEVELS.index(1e-2), "strike_2.impulse"

SIZE, DEPARTURE = known(".2e"), known(".2e", negligible=1e-9)
SIGNED, ONE = known("+.2e"), known(".1f")
F1 = Column("frequency", "f_1", form=hertz)
FILES = "points.csv (all plates, in SI); {scan}summary.json"
SCAN_FILE = "scan.csv (differences of the scan); "


def _good(levels: Sequence[float], *more: Column) -> tuple[Column, ...]:
    named = {f"levels.{i}.text": f"{100.0 * level:g} %" for i, level in enumerate(levels)}
    return (Column("what", "Largest difference"), *columns(named, form=str), *more)


LAWS = (
    Column("law.exponent", "Exponent of f_1", form=".3f"),
    *columns({"law.highest": "From", "law.lowest": "To"}, form=hertz),
)
POINTS = [
    Column(column, SYMBOLS[name], form=SIZE, below=Column(f"error_{name}", "", form=SIZE))
    for name, column in compute.MEASURED.items()
]
PARTS = {"v_gy": "At the tail-slap", "v_gy_largest": "Largest", "v_gy_error": "Error"}
AT_START = {f"{name}_at_start": SYMBOLS[name] for name in compute.KEPT}


def _of_starts(starts: Sequence[str], labels: dict[str, str], form: Any) -> list[Column]:
    named = ({f"{start}:{key}": label for key, label in labels.items()} for start in starts)
    groups = (columns(its, form=form, group=START_NAMES[k]) for k, its in zip(starts, named, strict=True))
    return [column for group in groups for column in group]


STIFF = (Column("youngs_modulus", "E", "Pa", form=SIZE), Column("damping_rate", "Damping", "1/s", form=SIZE))
PLATE_COLUMNS = {
    "deflection_ratio": "Static deflection ratio",
    "half_change": "Change of v_GY for half the patch",
    "thickness_apart": "Difference of thickness and E",
}
EVERY_PLATE = {
    "Differences at the tail-slap, with inertia relief": (Column("checks", "Checks"), *POINTS),
    "Difference of v_GY by start": _of_starts(STARTS, PARTS, SIZE),
    "Differences from Stage 1 at t = 0": _of_starts(STARTS[:2], AT_START, DEPARTURE),
    "Properties of the plates": (*STIFF, *columns(PLATE_COLUMNS, form=SIZE)),
}
MODAL = {
    "modal_v_gy": "v_GY",
    "modal_apart": "Largest difference from FE",
    "modal_estimate": "Estimated error",
}
READING = (
    "Inertia relief starts from the quasi-static elastic state of the rigid-body acceleration, with the angular "
    "velocity and corner speed of Stage 1, or with its momenta. The unstressed plate has the velocities and momenta "
    "of Stage 1 and oscillates. Levels of v_GY refer to the largest difference up to the tail-slap; unknown: the "
    "numerical error exceeds a third of the level.",
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
    "frequency at which the difference is below the level; <: below the range, >: above the range."
)
PLATES = (
    "FE runs from soft to rigid, with the crush force of a corner distributed over a tenth of the length. Contacts "
    "of a corner within 50 ms count as one strike, filtered separately. Mesh: largest difference from a mesh of "
    "twice the element size; plates above 5 %, or with a failed check, are not reliable."
)
# Quantities of the table on the terminal.
SHORT = ("mean_50ms", "impulse", "duration")
PLATE_PANELS = {"impulse": "impulse", "raw": "peak", "mean_50ms": "50 ms mean", "duration": "duration"}


def report(found: Flexibility) -> Report:
    """Report of the study."""
    return impact_report(found) if found.case.scene.contact else corner_report(found)


def corner_report(found: Flexibility) -> Report:
    """Report of a constrained corner: three starts, the other quantities, the modal model."""
    starts, rows = {**found.levels, "all three starts": found.band}, [_shown(row) for row in found.rows]
    good = [{"what": START_NAMES.get(name, name), "levels": its} for name, its in starts.items()]
    marked = {len(STARTS): "marked"}
    v_gy = Table(
        _good(LEVELS), good, "Lowest first frequency at which rigid-body v_GY is within", marks=marked
    )
    laws = [{"what": SYMBOLS[n], "levels": found.others.get(n), "law": law} for n, law in found.laws.items()]
    failed = {i: "failed" for i, row in enumerate(rows) if not row["passed"]}
    marks = [failed, *[{}] * (len(EVERY_PLATE) - 1)]
    tables = [Table((F1, *EVERY_PLATE[k]), rows, k, marks=m) for k, m in zip(EVERY_PLATE, marks, strict=True)]
    modal = Table((F1, Column("modal_why", "Checks failed"), *columns(MODAL, form=SIZE)), rows)
    three, five, reaction, stored, modes = figures(found)
    modelled, resolution = _modelled(found), _resolution(found)
    sections = (
        Section("Three starts", "", (three,), (v_gy,), (modelled, resolution, *READING)),
        Section("With inertia relief", "", (five,), (Table(_good(LEVELS, *LAWS), laws),)),
        Section("Reaction and stored energy", "", (reaction, stored)),
        Section("Modal model against finite elements", "", (modes,), (modal,)),
        Section("All plates", tables=tables),
    )
    numbers: Record = {"rigid": found.case.tail_slap, "levels_v_gy": found.levels}
    numbers |= {"levels_v_gy_any_start": found.band, "levels": found.others, "power_laws": found.laws}
    return _report(found, answer(found), sections, numbers, (v_gy, resolution, modelled))


def _report(
    found: Flexibility, sentences: tuple[str, str], sections: Any, numbers: Record, terminal: tuple[Any, ...]
) -> Report:
    """Page, summary, plates as a file, and text for the terminal; sentences: answer and certainty."""
    passed, case = any(row.get("passed", not row.get("failed")) for row in found.rows), found.case
    set_up = (
        f"{case.set_up} The plate of the scene has a first natural frequency of {hertz(found.own_frequency)}."
    )
    headline = Headline(f"Effect of flexibility: {case.subject}", sentences[0], set_up, sentences[1])
    names = FILES.format(scan=SCAN_FILE if found.scan else "")
    page = study_page(case, "Finite elements against the rigid vehicle", headline, sections, names, passed)
    head = {**study_summary("flexibility", case), "passed": passed}
    summary = {**head, "own_frequency": found.own_frequency, **found.setup, **numbers}
    summary |= {"scan_runs": len(found.scan), "scan_step": found.step}
    summary |= {"points": found.rows, "cost": {"seconds": found.seconds}}
    plates = (
        len(found.rows) + len(found.scan) + max(0, len(found.plates) - 1)
    )  # the last is the rigid vehicle
    cost = f"Cost:   {plates} plates in {found.seconds:.0f} s"
    files = {"points.csv": listed(found.rows)} | ({"scan.csv": listed(found.scan)} if found.scan else {})
    return Report(page, summary, (*terminal, cost), files)


def _resolution(found: Flexibility) -> str:
    """Runs and step of the scan."""
    if not found.scan:
        return "No level is within the range."
    frequencies = [row["first_frequency"] for row in found.scan]
    return (
        f"Differences oscillate over the first frequency: levels are from {len(frequencies)} further runs from "
        f"{hertz(min(frequencies))} to {hertz(max(frequencies))}, at steps of {hertz(found.step)} or 5 % of the "
        "frequency if that is less, and are one step on the safe side."
    )


def _failures(rows: Sequence[tuple[float, str]]) -> str:
    """Frequencies of the plates that failed, with the reasons."""
    return f"Failed plates: {'; '.join(f'{hertz(frequency)}: {why}' for frequency, why in rows if why) or 'none'}."


def _shown(row: Record) -> Record:
    """Row of a plate, with the effect of half the patch and without starts that failed."""
    checks = "passed" if row["passed"] else f"{'failed' if row['steps'] else 'none'}: {row['why']}"
    failed = tuple(f"{start}:" for start in STARTS if not row[f"{start}:passed"])
    known_starts = {key: None if key.startswith(failed) else value for key, value in row.items()}
    half = row["half_patch_v_gy"] / row["difference_v_gy"] - 1.0
    more = {"frequency": row["first_frequency"], "checks": checks, "half_change": half}
    return {**known_starts, **more}


def answer(found: Flexibility) -> tuple[str, str]:
    """Lowest natural frequency at which rigid-body v_GY is within the main level, and that of each start."""
    if not any(math.isfinite(its[MAIN].frequency) for its in found.levels.values()):
        return "The error of rigid-body v_GY for a soft plate is not known: no run passed its checks.", ""
    each = ", ".join(f"{its[MAIN].text} ({START_NAMES[name]})" for name, its in found.levels.items())
    what = f"Lowest natural frequency at which rigid-body v_GY is within {100.0 * LEVELS[MAIN]:g} %"
    certainty = f"By start of the plate: {each}. Numerical errors are added to the differences."
    return f"{what}: {found.band[MAIN].text}.", certainty


def _modelled(found: Flexibility) -> str:
    """Mesh, support of the corner and failed plates."""
    support, (along, across) = found.setup["corner"], found.setup["meshes"][-1]
    added = "" if support["own_patch"] else " (added by the study)"
    return (
        f"Mesh: {along} x {across} elements; {support['constraint']} constraint of the corner over "
        f"{measure(support['patch'], 'm', 'g')}{added}. "
        + _failures([(row["first_frequency"], "" if row["passed"] else row["why"]) for row in found.rows])
    )


def figures(found: Flexibility) -> list[Chart]:
    """Charts of v_GY by start, of the five quantities, reaction and stored energy, and of the modal model."""
    values = {name: [row[name] for row in found.rows] for name in found.rows[0]}
    passed, relative = values["passed"], "relative difference, magnitude"
    largest = "largest difference, relative to the rigid reaction"
    begun = zip(passed, *(values[f"{start}:passed"] for start in STARTS), strict=True)

    def size(name: str) -> SweepLine:
        sizes = [abs(x) for x in values[compute.MEASURED[name]]]
        return SweepLine(SYMBOLS[name], sizes, values[f"error_{name}"])

    def start_line(start: str) -> SweepLine:
        largest, error = values[f"{start}:v_gy_largest"], values[f"{start}:v_gy_error"]
        return SweepLine(START_NAMES[start], largest, error, passed=values[f"{start}:passed"])

    def chart(name: str, caption: str, label: str, lines: Sequence[SweepLine], levels: Any = ()) -> Chart:
        good = [*map(any, begun)] if name == "starts" else passed
        axis = SweepAxis(values["first_frequency"], good, found.own_frequency)
        width = FULL if name == "starts" else HALF
        return draw_sweep(f"flexibility-{name}", axis, lines, label, caption, levels, width)

    modal = [
        size("v_gy")._replace(label="v_GY, FE"),
        SweepLine("v_GY, modal", [abs(x) for x in values["modal_v_gy"]], form=RINGS),
        SweepLine("largest difference of both", values["modal_apart"], form=DOTS),
        SweepLine("estimated error, modal", values["modal_estimate"], form=DOTS),
    ]
    five = "Time, velocities of the centre of mass, angular velocity and slide at the tail-slap"
    three = "Largest difference of v_GY from the rigid body, by start"
    energy = "Largest strain energy of the plate, relative to its initial kinetic energy"
    both = "v_GY by finite elements and by the modal model"
    return [
        chart("starts", three, relative, [start_line(start) for start in STARTS], LEVELS),
        chart("difference", five, relative, [size(name) for name in KEYS], LEVELS),
        chart("reaction", "Normal reaction of the wall", largest, [size("reaction")]),
        chart("stored", energy, "strain energy / kinetic energy", [size("stored")]),
        chart("modal", both, relative, modal, LEVELS[:2]),
    ]


def impact_report(found: Flexibility) -> Report:
    """Report of a whole impact: strikes of plates of decreasing stiffness and of the rigid vehicle."""
    rows = [{"what": WORDS[name], "levels": found.levels[name]} for name in NAMES]
    good = Table(
        _good(compute.IMPACT_LEVELS), rows, "Lowest first frequency at which the rigid vehicle is within"
    )
    marks = {i: "failed" for i, row in enumerate(found.rows) if row["failed"]}
    heads = (F1, *STRIKE_POINTS, Column("failed", "Checks failed"))
    points = Table(heads, found.rows, "Differences of the two strikes", marks=marks)
    patch = measure(found.setup["patch_length"], "m", "g")
    failures = _failures([(row["frequency"], row["failed"]) for row in found.rows])
    crush = f"A corner's crush is spread over {patch} of its side. {failures}"
    resolution = _resolution(found)
    why = [f"{row['frequency']:g} Hz: {', '.join(row['failed'])}." for row in found.plates if row["failed"]]
    sections = (
        Section("Both strikes", "", (_strikes_figure(found),), (good,), (crush, resolution, IMPACT_READING)),
        Section("From 2 Hz to rigid", PLATES, _plate_figures(found), (plates_table(found),), why),
        Section("All plates", tables=(points,)),
    )
    numbers = {"rigid": found.case.rigid_numbers(), "levels": found.levels, "plates": found.plates}
    plates = plates_table(found, "The plate from soft to rigid", short=True)
    return _report(found, _impact_answer(found), sections, numbers, (good, resolution, crush, plates))


def _impact_answer(found: Flexibility) -> tuple[str, str]:
    """Lowest natural frequencies at which the second strike's impulse is the rigid vehicle's; differences of the
    softest plate that passed its checks."""
    each = ", ".join(f"{level.text} (within {100 * level.level:g} %)" for level in found.levels[MAIN_STRIKE])
    sentence = (
        f"Lowest natural frequency at which the impulse of the rigid vehicle's second strike holds: {each}."
    )
    soft = next((row for row in found.plates[:-1] if row["passed"]), None)
    if soft is None:
        return sentence, ""
    ours, rigid = soft["values"], found.plates[-1]["values"]
    names = [f"strike_2.{name}" for name in ("impulse", "duration", "mean_50ms")]
    impulse, duration, mean = (percent(ours[name] / rigid[name] - 1.0, 0) for name in names)
    effect = f"impulse {impulse}, duration {duration}, 50 ms mean {mean}"
    return sentence, f"Effect of a plate of {soft['frequency']:g} Hz on the second strike: {effect}."


def _strikes_figure(found: Flexibility) -> Chart:
    rows, own = found.rows, found.own_frequency

    def sizes(group: str, name: str) -> list[float]:
        return [abs(row[f"{group}.{name}"]) for row in rows]

    lines = [SweepLine(WORDS[name], sizes("difference", name), sizes("error", name)) for name in NAMES]
    axis = SweepAxis([row["frequency"] for row in rows], [not row["failed"] for row in rows], own)
    caption = "Difference of plate and rigid vehicle in both strikes, over the plate's first frequency"
    return draw_sweep(
        "flexibility-strikes", axis, lines, "|FE/rigid - 1|", caption, compute.IMPACT_LEVELS, FULL
    )


def _plate_figures(found: Flexibility) -> list[Chart]:
    """Both strikes against the first frequency; none where no plate has run."""
    soft, rigid = [row for row in found.plates[:-1] if row["values"]], found.plates[-1]["values"]
    panels: dict[str, dict[int, tuple[list[float], float]]] = {}
    for name, words in PLATE_PANELS.items():
        _, unit, scale = OF_STRIKES[name]
        keys = {k: f"strike_{k}.{name}" for k in (1, 2)}
        panels[f"{words} [{unit}]"] = {
            k: ([row["values"][key] / scale for row in soft], rigid[key] / scale) for k, key in keys.items()
        }
    frequencies, passed = ([row[key] for row in soft] for key in ("frequency", "passed"))
    return [draw_plates(frequencies, passed, panels)] if soft else []


def plates_table(found: Flexibility, title: str = "", short: bool = False) -> Table:
    """Both strikes against the first frequency; short: without the raw and CFC 60 peaks."""
    rows: list[Record] = [
        {"frequency": "rigid" if row["frequency"] is None else f"{row['frequency']:g}", "error": row["error"]}
        for row in found.plates
    ]
    heads = [Column("frequency", "f_1", "Hz", form=str)]
    for column in COLUMNS:
        group, name = column.removeprefix("strike_").split(".")
        if short and name not in SHORT:
            continue
        label, unit, scale = OF_STRIKES[name]
        heads.append(Column(column, label.replace(" mean", ""), unit, form=ONE, group=f"Strike {group}"))
        for row, plate in zip(rows, found.plates, strict=True):
            row[column] = plate["values"].get(column, math.nan) / scale
    heads.append(
        Column("error", "Mesh", form=lambda e: percent(e, 1).lstrip("+") if math.isfinite(e) else "–")
    )
    failed = {n: "failed" for n, row in enumerate(found.plates) if not row["passed"]}
    return Table(tuple(heads), rows, title, marks=failed)
