"""Page of `tailslap explore`, one file with kernels, scenes and texts."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import warnings
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

import tailslap
from machine_code import web_assembly
from postprocess.report.page import template, template_text
from postprocess.signals.design_forces import design_forces
from postprocess.signals.filters import LABELS
from postprocess.units import SYSTEMS
from solver import rules
from solver.impact import Strike
from solver.space import SpaceAnswers, columns
from tailslap.browser import bands, kernels, model, packaged, plate, space, space_model
from tailslap.campaign import band_samples, sampling
from tailslap.campaign.input_ranges import Range
from tailslap.case.force_band import LEAST_NAMED, MOST_NAMED, PERCENTILES, Calibration, ForceBand
from tailslap.case.impact import rigid
from tailslap.case.of_arguments import case_of_scene
from tailslap.case.report_parts import design_forces_of
from tailslap.errors import InputError, place_error
from tailslap.scene import schema, units
from tailslap.scene.read import read_text, scene_text, scenes
from tailslap.scene.validate import value_in
from tailslap.scene.write import quantity_at

if TYPE_CHECKING:
    from tailslap.case.impact.case import ImpactCase

DISPLAYED = {
    "m/s": ("km/h", "mph"),
    "m": ("m", "ft"),
    "kg": ("kg", "lb"),
    "N": ("kN", "kip"),
    "N s": ("kN s", "kip s"),
    "N/m": ("MN/m", "kip/ft"),
    "N/m^2": ("MN/m^2", "kip/ft^2"),
    "rad": ("deg", "deg"),
    "N m/rad": ("MN m/rad", "kip ft/rad"),
    "kg m^2": ("kg m^2", "lb ft^2"),
    "s": ("s", "s"),
    "": ("", ""),
}
"""Units in which a page shows quantities, in SI and US units, as a scene file may have them."""

SLIDERS = {
    "speed": (5.0, 40.0),
    "angle": (math.radians(5.0), math.radians(45.0)),
    "mass": (500.0, 40_000.0),
    "friction": (0.0, 1.0),
    "restitution": (0.0, 0.7),
}
"""Ends of sliders by name of the quantity [SI]; of others half and twice the scene's value."""

REASONS = {
    kernels.PLATEAU: rules.PLATEAU,
    kernels.LINE: rules.LINE,
    kernels.UNLOADING: rules.UNLOADING,
    kernels.HARDENING: rules.HARDENING,
    kernels.CENTRE: rules.CENTRE,
    kernels.INERTIA: rules.INERTIA._replace(allowed=rules.INERTIA.allowed.partition(" = {")[0]),
    kernels.AXLE: rules.AXLE._replace(allowed="from 0 to the length of the unit, {length:.6g} m"),
    kernels.AXLE_LOAD: rules.AXLE_LOAD,
}
"""Rules of the theory by the kernels' number."""

REASONS |= {space.OF_COLUMNS + k: getattr(rules, name) for k, name in enumerate(columns.REASONS) if name}
REASONS |= {space.STEPS: rules.SPACE_STEPS, space.LOST: rules.SPACE_LOST, space.NO_CONTACT: rules.NO_CONTACT}

FIELDS = {"units": space_model.UNIT, "axles": space_model.AXLE, "strips": space_model.STRIP}
"""Quantities of parts in space, in the order of their values."""

PLACES = {
    kernels.PLATEAU: ("strips", "plateau"), kernels.LINE: ("strips", "restitution"),
    kernels.UNLOADING: ("strips", "unloading_stiffness"), kernels.HARDENING: ("strips", "hardening"),
    kernels.CENTRE: ("units", "centre_of_mass"), kernels.INERTIA: ("units", "yaw_inertia"),
    **{space.OF_COLUMNS + k: place for k, place in enumerate(columns.PLACES)},
}  # fmt: skip
"""Parts and quantities of vehicles in space that a reason refuses."""

DRAWN = "band.ranges.drawn", "space_band.ranges.drawn"
"""Places within ranges, which the script of a page makes."""

GROUPS, OTHERS = {"impact-mash-": "MASH", "impact-en-": "EN 1317-2, not confirmed"}, "Other impacts"
"""Groups of scenes by the beginning of their names."""

READ = (
    "space.values", "space.parts.units", "space.parts.axles", "space.parts.strips", "space.parts.common",
    "space.room.values.units", "space.room.values.axles", "space.room.values.strips", "space.room.fleet.profile",
    "space.room.fleet.axle_unit", "space.room.fleet.strip_unit", "space.room.fleet.strip_axle", "space.room.answers",
    "space.room.limit", "space.room.clock.parts", "space.curves.rows", "space.curves.force", "space.curves.peaks",
    "space_band.values", "space_band.ranges.ends", "space_band.percentiles", "space_band.outcomes",
    "space_band.ranges.fractions",
    "space_band.place", "space_wall.place", "space_wall.walls", "space_wall.lowest",
    "space_one.room.answers", "space_one.curves.rows", "space_one.curves.force", "space_one.curves.peaks",
    "space_one.motions.result", "space_one.motions.heights",
    "motion.values", "motion.parts.units", "motion.parts.axles", "motion.parts.points", "motion.parts.places",
    "motion.case.0.group", "motion.case.0.plateau_force", "motion.case.1.load", "motion.case.1.unit",
    "motion.case.4.reached", "motion.outcome.rows", "motion.outcome.interval", "motion.outcome.strikes",
    "motion.outcome.error", "motion.motion.values", "motion.motion.curves", "motion.motion.strike_means",
    "motion.motion.times", "motion.motion.peaks", "motion.paper.mean", "band.ranges.fractions", "band.growth.speeds",
    "band.growth.ratio", "band.ranges.ends", "band.percentiles", "band.forces", *DRAWN,
)  # fmt: skip
"""Arrays that the script of a page reads or fills."""

SCRIPTS = "explore.js", "explore_space.js", "explore_plate.js"
"""Parts of the script of a page, of which the last begins."""

MARK = '<meta name="generator" content="tailslap explore">'
"""Part of every page, by which one is known."""

FIRST = "impact-mash-tl4-sut"
"""Scene of a page without another one."""

STALE = "the page of this installation is not that of its kernels, and is made again"

LARGEST = 2**22
"""Largest file that is looked at [bytes]."""

Item = TypeVar("Item", str, bytes)


def write(name: str, path: Path) -> Path:
    """Write the page of a scene.

    Those of the program follow. Raises InputError for a scene that a page cannot compute, and where another file or
    folder is in place.
    """
    text = packaged_text() if name == FIRST else ""
    text = text or page_of(all_scenes(name))
    try:
        if path.exists() and MARK not in read_text(path, LARGEST):
            raise ValueError("it is not a page of this command")
        path.write_text(text, encoding="utf-8")
    except ValueError as error:
        raise InputError("--out", str(path), f"{error}; choose another file") from None
    except OSError as error:
        raise place_error(path, "the file cannot be written", error) from None
    return path


def make_packaged() -> None:
    """Make the page of this installation, unless it is current."""
    if not packaged.is_current():
        text = page_of(all_scenes(FIRST)).rstrip()
        packaged.PATH.write_text(f"{text}\n{packaged.mark()}", encoding="utf-8")


def packaged_text() -> str:
    """Return the page of this installation, empty without one.

    That of other sources is made again.
    """
    if packaged.is_current():
        return packaged.PATH.read_text(encoding="utf-8")
    if packaged.PATH.is_file():
        warnings.warn(STALE, stacklevel=2)
    return ""


def page_of(names: Iterable[str]) -> str:
    """Return the page of scenes, of which the first is shown.

    names: of scenes, or files. Raises InputError for a scene that a page cannot compute, if it is the first.
    """
    texts, contents, calls = _Numbered[str](), _Numbered[bytes](), dict[str, Any]()
    shown, beyond = list[dict[str, Any]](), list[dict[str, str]]()
    plates, of_plates = list[dict[str, Any]](), _Numbered[bytes]()
    for name in names:
        case: Any = case_of_scene(name, None)
        try:
            if case.scene.contact is None:
                plates.append(plate.plate_of(case, of_plates.number))
                continue
            built = (space_model if case.scene.body else model).model_of(case)
        except InputError as error:
            if not (shown or plates):
                raise
            beyond.append({"name": case.scene.name, "why": str(error)})
            continue
        calls = {**built.calls, **calls}
        shown.append(_scene(case, name, built, texts, contents))
    data = {
        "digest": web_assembly.digest_of(calls),
        "module": contents.number(web_assembly.module(calls)),
        "stack": web_assembly.STACK,
        "texts": [*texts],
        "scenes": shown,
        "beyond": beyond,
        "units": {unit: [_displayed(unit, name) for name in pair] for unit, pair in DISPLAYED.items()},
        "reasons": {number: [rule.why, rule.allowed] for number, rule in REASONS.items()},
        "most_elements": plate.MOST_ELEMENTS,
        "random": [
            hex(np.random.default_rng(sampling.SEED).bit_generator.state["state"][k])
            for k in ("state", "inc")
        ],
        "filters": [*LABELS.items()],
        "named": [LEAST_NAMED, MOST_NAMED],
        "growth": band_samples.SPEEDS,
        "places": {number: [table, _field(table, name)] for number, (table, name) in PLACES.items() if table},
        "answers": SpaceAnswers._fields[:-1],
        "percentiles": len(PERCENTILES),
        "force": rigid.RigidImpact.force_words,
        "band": ForceBand().name,
        "rounding": rigid.ROUNDING,
        "equal": rigid.EQUAL,
        "of_scene": rigid.OF_SCENE,
    }
    script = "".join(map(template_text, SCRIPTS))
    return template("explore.html.j2").render(
        data=_packed(data, contents),
        plates=_packed({"stack": web_assembly.STACK, "plates": plates}, of_plates),
        script=script,
        digest=_base64(hashlib.sha256(script.encode()).digest()),
        version=tailslap.__version__,
    )


def _packed(data: dict[str, Any], contents: _Numbered[bytes]) -> str:
    """Return numbers and contents of a page, deflated.

    The length of the numbers as JSON is before them, with four bytes.
    """
    numbers = data | {"sizes": [*map(len, contents)]}
    text = json.dumps(numbers, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    packer = zlib.compressobj(9, wbits=-zlib.MAX_WBITS)
    packed = packer.compress(b"".join([len(text).to_bytes(4, "little"), text, *contents])) + packer.flush()
    return _base64(packed)


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")


def all_scenes(first: str) -> list[str]:
    """Return a scene, those of the program behind it, and plates."""
    shipped, whole = scenes(), f"impact-{first}"
    impacts = [name for name in shipped if name.startswith("impact-")]
    return list(dict.fromkeys([first, *([whole] if whole in shipped else []), *impacts, *plate.SCENES]))


class _Numbered(dict[Item, int]):
    """Texts or contents of memory, each once, with their numbers."""

    def number(self, item: Item) -> int:
        """Return the number of an item."""
        return self.setdefault(item, len(self))


def _displayed(unit: str, name: str) -> tuple[float, str]:
    """Return the factor from SI, and the name of a displayed unit."""
    return (units.converted(1.0, unit, name) if unit else 1.0), name


def _field(table: str, name: str) -> int:
    """Return the number of a quantity of a part in space."""
    names = FIELDS[table]
    return names.index(name if name in names else f"{name}.0")


def _scene(
    case: ImpactCase, name: str, built: model.Model, texts: _Numbered[str], contents: _Numbered[bytes]
) -> dict[str, Any]:
    """Return a scene for a page."""
    memory, parts = web_assembly.layout(built.calls), cast(Any, next(iter(built.calls.values()))[1][1])
    arrays, band = memory.arrays.items(), built.calls["space_band" if case.scene.body else "band"]
    filled = [(place.at, place.content) for key, place in arrays if place.content and key not in DRAWN]
    loads = [[load, design.force] for load, design in design_forces_of(case.scene).items()]
    text = scene_text(name)
    return {
        "name": case.scene.name,
        "title": text.splitlines()[0].removeprefix("#").strip() if text.startswith("#") else case.scene.name,
        "choice": _choice(case),
        "loads": loads,
        "compared": _compared(case),
        "text": text,
        "calls": memory.calls,
        "arrays": {key: [p.at, p.kind, p.shape, p.slot] for key, p in memory.arrays.items() if key in READ},
        "contents": [(at, contents.number(content)) for at, content in [*filled, *memory.slots]],
        "drawn": contents.number(_parts_of(cast(bands.Ranges, band[1][3]).drawn)),
        "size": memory.size,
        "quantities": [
            _quantity(case, key, column, texts)
            for column, key in enumerate(built.quantities)
            if _is_offered(case, key)
        ],
        "ranges": [_range(item) for item in built.ranges],
        "speed": _speed(case),
        "parts": [Strike(group, 0.0, 0.0, 0.0, 0.0).part for group in case.names],
        "rows": space_model.column_names(case) if case.scene.body else [],
        "units": parts.units[:, [0, 1, 3]].tolist(),
        "classes": [
            [ForceBand(calibration=one).name, one.sentence]
            for one in (Calibration(**found.calibration) for found in model.classes_of(case))
        ],
    }


def _parts_of(drawn: np.ndarray) -> bytes:
    """Return the parts of a Latin hypercube, shape (columns, rows), less 1.

    The script of a page draws the places within them, see `sampling.latin_hypercube`.
    """
    columns, rows = drawn.shape
    offsets = np.random.default_rng(sampling.SEED).uniform(size=(rows, columns)).T
    return (np.rint(rows * drawn + offsets) - 1).astype(np.uint8).tobytes()


def _choice(case: ImpactCase) -> tuple[str, str]:
    """Return the group and the text of a choice of scene."""
    scene = case.scene
    level = scene.impact and str(scene.impact.test_level)
    group = next((group for prefix, group in GROUPS.items() if scene.name.startswith(prefix)), OTHERS)
    test = scene.name.rpartition("-")[2].upper()
    name = {"MASH": level, OTHERS: scene.name}.get(group, f"{test}, {level}")
    return group, f"{name}: {case.subject}"


def _compared(case: ImpactCase) -> tuple[str, float] | None:
    """Return the design force of `Case.design_ratio`, if any."""
    level = case.scene.impact.test_level if case.scene.impact else None
    if level is None or not case.design_ratio(1.0):
        return None
    first = design_forces(level)[0]
    return f"{first.name}, {level}", first.force


def _is_offered(case: ImpactCase, key: str) -> bool:
    """Return True for a quantity that stands in the scene."""
    is_of_scene = bool(key) and not key[-1].isdigit() and not {"@", "*"} & {*key}
    return is_of_scene and isinstance(value_in(case.source.tables, key), int | float | str)


def _range(item: Range) -> list[Any]:
    """Return key, origin, name, scale and units of a range."""
    scale, unit = (1e-6, "MN/m") if item.unit == "N/m" else (1.0, item.unit)
    displayed = [system.of(unit) for system in SYSTEMS.values()]
    return [item.key, item.origin, band_samples.input_name(item.key), scale, displayed]


def _speed(case: ImpactCase) -> tuple[float, str]:
    """Return factor and name of the scene's unit of speed."""
    unit = case.quantity("impact.speed").partition(" ")[2] or "m/s"
    return units.converted(1.0, "m/s", unit), unit


def _quantity(case: ImpactCase, key: str, column: int, texts: _Numbered[str]) -> dict[str, Any]:
    """Return a quantity with its bounds and slider, SI."""
    quantity, value = quantity_at(key, case.source.tables), float(schema.value_at(case.scene, key))
    assert quantity
    low, high = SLIDERS.get(key.rpartition(".")[2], (0.5 * value, 2.0 * value or 1.0))
    least, most = model.key_bounds(key, case)
    table, *_, name = key.split(".")
    return {
        "key": key,
        "note": "of the paper's method alone" if key in model.PAPER else "",
        "column": column,
        "value": value,
        "unit": quantity.unit,
        "meaning": texts.number(schema.MEANINGS.get(f"{table}.{name}", "").partition(";")[0]),
        "least": least,
        "most": most,
        "low": min(low, value),
        "high": max(high, value),
        "allowed": [texts.number(quantity.allowed(unit)) for unit in DISPLAYED[quantity.unit]],
    }
