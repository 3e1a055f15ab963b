"""Definition of a sweep: a scene, and the values of the keys that vary. Its runs are numbered, and follow from it.

VALUES of --vary are a range or a list; each is read as the scene would read it: with its units, bounds and messages.

A run is a row of the table of all rows, `sweep.parquet`, in the order of the runs.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import json
import math
import re
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import tailslap
from fem import cache
from postprocess.comparison.quantities import TAIL_SLAP, Compared
from postprocess.report import data_files
from tailslap.campaign import engine, records
from tailslap.case import case_of, kind_of
from tailslap.case.cost import demand_affordable
from tailslap.errors import InputError
from tailslap.options import MAX_RUNS
from tailslap.scene import read, schema, validate, vary, write

if TYPE_CHECKING:
    import pyarrow as pa

    from postprocess.report.command_report import Report


ALLOWED = (
    "allowed is KEY=VALUES with VALUES a:b:n, log:a:b:n or a list v1,v2,v3, e.g. corner.friction=0:0.6:13; "
    "with --sample a:b, log:a:b or a list"
)
BRACKETS = {"[": 1, "]": -1}
LOGARITHMIC = "log"

Read = Callable[[str], tuple[Any, str]]
"""From a value's text to the value that the scene has then, in SI or a word, and its unit. Raises InputError."""


class TypedRange(NamedTuple):
    """A range as typed: its ends, how many values (None for samples), and whether they are in equal ratios."""

    lower: str
    upper: str
    number: int | None
    logarithmic: bool


Given = TypedRange | tuple[str, ...]
"""A range, or the texts of a list."""


@dataclass(frozen=True)
class Variation:
    """A key's values, as the scene has them: in SI, words, or tuples.

    In a grid each value is combined with those of the other keys; of samples the i-th belongs to run i.
    """

    key: str
    unit: str
    settings: tuple[Any, ...]
    logarithmic: bool

    @property
    def values(self) -> tuple[float | int | str, ...]:
        """The values as numbers and words."""
        return tuple(map(plain, self.settings))

    @property
    def numeric(self) -> bool:
        """True if the values are numbers."""
        return all(isinstance(value, int | float) for value in self.settings)


def plain(value: Any) -> float | int | str:
    """A number or a word for a value: of a tuple, its members."""
    return value if isinstance(value, int | float | str) else " x ".join(map(str, value))


@dataclass(frozen=True)
class Definition:
    """A sweep of a scene's text; `changes` and `given` are the --set and --vary options as typed, `source` is the
    scene with the former put in, `sample` the number of samples, None for a grid; `kinds` and `compared` are what its
    case tells of a run, see `Case`."""

    scene: str
    text: str
    changes: tuple[str, ...]
    source: vary.Source
    given: tuple[str, ...]
    variations: tuple[Variation, ...]
    sample: int | None
    seed: int
    kinds: Mapping[str, type] = field(default_factory=dict)
    compared: Compared = TAIL_SLAP

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.sample or math.prod(len(item.settings) for item in self.variations)

    def changes_of(self, run: int) -> dict[str, Any]:
        """Changes of a run in the scene; in a grid the last key's value changes from run to run."""
        places: Any = (run,) * len(self.variations)
        if not self.sample:
            places = np.unravel_index(run, [len(item.settings) for item in self.variations])
        return {item.key: item.settings[int(i)] for item, i in zip(self.variations, places, strict=True)}

    def inputs_of(self, run: int) -> dict[str, float | int | str]:
        """Values of the keys that vary, SI or words, for a run."""
        return {key: plain(value) for key, value in self.changes_of(run).items()}

    def as_written(self) -> dict[str, Any]:
        """Contents of `sweep.json`: two sweeps are the same if this is. The digest is of all runs' values."""
        values = json.dumps([[item.key, item.settings] for item in self.variations])
        return {
            "scene": self.scene,
            "set": list(self.changes),
            "vary": list(self.given),
            "sample": self.sample,
            "seed": self.seed if self.sample else None,
            "runs": self.runs,
            "digest": hashlib.sha256(values.encode()).hexdigest(),
            "version": tailslap.__version__,
            "program": records.program(),
            "text": self.text,
        }


def make_definition(
    name: str, changes: tuple[str, ...], varied: tuple[str, ...], sample: int | None, seed: int
) -> Definition:
    """The sweep of scene `name`; varied: KEY=VALUES each. Raises InputError for what cannot be in any scene.

    Each value is checked by itself; what only a combination makes impossible is found when it is run.
    """
    scene_source = read.read_source(name)
    given = [parse_varied(each, bool(sample)) for each in varied]
    source = _fixed(scene_source, changes, [key for key, _ in given])
    counts = [(values.number or 1) if isinstance(values, TypedRange) else len(values) for _, values in given]
    if math.prod(counts) > MAX_RUNS:
        shown = " x ".join(map(str, counts)) + " runs"
        raise InputError("--vary", shown, f"the limit is {MAX_RUNS} runs")
    first = {key: vary.parse_value(values[0]) for key, values in given}
    scene = _scene(source, first)
    kind = kind_of(scene)

    def read_value(key: str, value: str) -> tuple[Any, str]:
        scene = _scene(source, {**first, key: vary.parse_value(value)})
        row = next((row for row in write.scene_inputs(scene, source) if row.key == key), None)
        if row is None:
            raise InputError("--vary", key, "this is a table; allowed are its keys")
        return vary.value_at(scene, key), row.unit

    fractions = latin_hypercube(len(given), sample, seed).T if sample else [None] * len(given)
    variations = tuple(
        _variation(key, values, functools.partial(read_value, key), places)
        for (key, values), places in zip(given, fractions, strict=True)
    )
    fixed = (scene.name, scene_source.text, changes, source, varied, variations, sample, seed)
    return Definition(*fixed, kind.columns(scene), kind.compared)


def varied_source(asked: Definition) -> vary.Source:
    """The source of a sweep with a value of each key as typed, a number without unit if there is one."""
    first = {}
    for text in asked.given:
        key, values = parse_varied(text, bool(asked.sample))
        typed = [
            vary.parse_value(value) for value in (values[:2] if isinstance(values, TypedRange) else values)
        ]
        first[key] = next((value for value in typed if isinstance(value, int | float)), typed[0])
    tables = vary.changed_tables(asked.source.given, first)[0]
    return vary.Source(asked.source.text, tables, asked.source.changed | first.keys())


def latin_hypercube(keys: int, runs: int, seed: int) -> np.ndarray:
    """Fractions in [0, 1), shape (runs, keys): of each key one in each of `runs` equal parts."""
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(keys, seed=np.random.default_rng(seed)).random(runs))


def _scene(source: vary.Source, changes: vary.Changes) -> schema.Scene:
    return validate.key_by_key(vary.changed_tables(source.given, changes)[0])


def _fixed(source: vary.Source, changes: tuple[str, ...], keys: list[str]) -> vary.Source:
    """The source with the changes that all runs have; the keys are those that vary."""
    fixed = vary.parse_changes(changes, source.given)
    for number, key in enumerate(keys):
        if key in keys[:number]:
            raise InputError("--vary", key, "this key is varied twice")
        if key in fixed:
            raise InputError("--vary", key, "--set and --vary exclude each other; remove one of the two")
    tables, noted = vary.changed_tables(source.given, fixed)
    return vary.Source(source.text, tables, frozenset(noted))


def parse_varied(varied: str, sampled: bool) -> tuple[str, Given]:
    """Key and values of KEY=VALUES as typed; sampled: by --sample, so that a range has no count. Raises InputError."""
    key, _, text = (part.strip() for part in varied.partition("="))
    if not (text and re.fullmatch(vary.KEY, key)):
        raise InputError("--vary", varied, ALLOWED)
    if key == "name":
        allowed = "the name does not affect a run; allowed are the other keys"
        raise InputError("--vary", varied, allowed)
    parts = split_outside(text, ":")
    if len(parts) == 1:
        texts = tuple(split_outside(text, ","))
        if not all(texts):
            raise InputError(key, text, ALLOWED)
        return key, texts
    logarithmic = parts[0] == LOGARITHMIC
    ends = parts[logarithmic:]
    if not 2 <= len(ends) <= 3 or not all(ends):
        raise InputError(key, text, ALLOWED)
    lower, upper, count = (*ends, "")[:3]
    if sampled and count:
        raise InputError(key, text, "with --sample a range is a:b or log:a:b")
    if not sampled and (not re.fullmatch("[0-9]{1,9}", count) or int(count) < 2):
        raise InputError(key, text, "a range is a:b:n with a number n of values of at least 2")
    return key, TypedRange(lower, upper, None if sampled else int(count), logarithmic)


def split_outside(text: str, separator: str) -> list[str]:
    """Parts of the text between separators that stand neither in brackets nor in quotes, stripped."""
    parts, depth, quote = [""], 0, ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        else:
            depth += BRACKETS.get(letter, 0)
        if letter == separator and not depth and not quote:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def _variation(key: str, given: Given, read_value: Read, fractions: np.ndarray | None) -> Variation:
    """All values of a list, or of a range both ends and the others evenly or in equal ratios between.

    fractions: of samples, where in the range or list each run's value lies, shape (runs,), each in [0, 1).
    """
    if not isinstance(given, TypedRange):
        listed, units = zip(*map(read_value, given), strict=True)
        chosen = listed if fractions is None else tuple(listed[int(f * len(listed))] for f in fractions)
        return Variation(key, units[0], chosen, False)
    lower, upper, unit = _ends(key, given, read_value)
    if fractions is not None:
        if isinstance(lower, int):
            shown = f"{given.lower}:{given.upper}"
            raise InputError(key, shown, "with --sample whole numbers require a list v1,v2,v3")
        even = lower + (upper - lower) * fractions
        between = lower * (upper / lower) ** fractions if given.logarithmic else even
        return Variation(key, unit, tuple(between.tolist()), given.logarithmic)
    assert given.number is not None
    values = (np.geomspace if given.logarithmic else np.linspace)(lower, upper, given.number).tolist()
    if isinstance(lower, int) and isinstance(upper, int):
        if any(value != round(value) for value in values):
            shown = f"{given.lower}:{given.upper}:{given.number}"
            raise InputError(key, shown, f"all values must be whole numbers; {values[1]:g} is not")
        values = [round(value) for value in values]
    return Variation(key, unit, tuple(values), given.logarithmic)


def _ends(key: str, given: TypedRange, read_value: Read) -> tuple[Any, Any, str]:
    """Both ends in SI, and the unit."""
    (lower, unit), (upper, _) = read_value(given.lower), read_value(given.upper)
    shown = f"{given.lower}:{given.upper}"
    if not (isinstance(lower, int | float) and isinstance(upper, int | float)):
        raise InputError(key, shown, "a range requires numbers; allowed is a list v1,v2,v3")
    if lower == upper:
        raise InputError(key, shown, "the ends of a range must differ")
    if given.logarithmic and not min(lower, upper) > 0.0:
        raise InputError(key, shown, "the ends of a logarithmic range must be above 0")
    return lower, upper, unit


TABLE = "sweep.parquet"
CHUNK = 20_000
"""Rows that are in memory at a time."""

PASSED, FAILED, REFUSED, ERROR = STATUSES = ("passed", "failed", "refused", "error")
"""All checks passed; a check failed; the theory or the model refuses the combination; the run broke down."""

KILLS = "its worker process died in every attempt"

TIMES = ("cost.run_s", "cost.setup_s", "cost.time_loop_s")
REUSED = "cost.reused"
"""Column with the parts of the model that were there already, from runs that this worker has made before."""

CIRCUMSTANCES = (*TIMES, REUSED)
"""Columns that differ when the same run is made again; all others are the same to the bit."""


@dataclass(frozen=True)
class FinishedSweep:
    """A sweep that is complete: how many rows have each status, what the last call's runs took, and its report."""

    definition: Definition
    statuses: dict[str, int]
    effort: engine.CampaignEffort
    report: Report | None = None

    @property
    def failures(self) -> int:
        """Runs that failed a check or ended in an error."""
        return self.statuses[FAILED] + self.statuses[ERROR]


def compute_row(run: int, source: vary.Source, changes: vary.Changes) -> dict[str, Any]:
    """Make a run of the scene with these changes. Whatever goes wrong is the row's status and reason."""
    began, before = time.perf_counter(), cache.counts()
    try:
        case = case_of(*vary.vary(source, changes))
        demand_affordable(case.scene, case.duration)
        found = case.row(case.run() if case.scene.plate else None)
    except InputError as refusal:
        found = {"status": REFUSED, "reason": str(refusal)}
    except MemoryError:
        found = {"status": ERROR, "reason": "insufficient memory for this mesh"}
    except Exception as error:  # a sweep goes on, whatever one of its runs does
        found = {"status": ERROR, "reason": f"{type(error).__name__}: {error}"}
    inputs = {key: plain(value) for key, value in changes.items()}
    spent = {REUSED: ", ".join(cache.reused(before)), "cost.run_s": time.perf_counter() - began}
    return {"run": run, **inputs, **found, **versions(), **spent}


@functools.cache
def versions() -> Mapping[str, str]:
    """Columns with the versions that a row was computed with."""
    libraries = {name: version(name) for name in ("numba", "numpy", "scipy")}
    given = {"tailslap": tailslap.__version__, **libraries}
    return {f"version.{name}": each for name, each in given.items()}


def write_table(folder: Path, definition: Definition, rows: records.Records) -> Path:
    """Write the table of all rows that there are."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = table_schema(definition, sorted(name for name in rows.columns if name.startswith("check.")))
    path, found = folder / TABLE, map(data_files.plain, rows.in_order())
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        while chunk := list(itertools.islice(found, CHUNK)):
            writer.write_table(pa.Table.from_pylist(chunk, schema=schema))
    return path


def table_schema(definition: Definition, checks: list[str]) -> pa.Schema:
    """Columns of the table and their types; checks: their columns, which depend on the runs."""
    import pyarrow as pa

    real, whole, text = pa.float64(), pa.int64(), pa.string()
    kinds = {float: real, int: whole, str: text}
    columns: dict[str, Any] = {"run": whole, "status": text, "reason": text}
    for item in definition.variations:
        is_whole = all(isinstance(value, int) for value in item.values)
        columns[item.key] = (whole if is_whole else real) if item.numeric else text
    types = {name: kinds[kind] for name, kind in definition.kinds.items()}
    columns |= {name: kind for name, kind in types.items() if not name.startswith("cost.")}
    columns |= dict.fromkeys(checks, real) | types
    columns |= dict.fromkeys(TIMES, real) | {REUSED: text} | dict.fromkeys(versions(), text)
    return pa.schema(list(columns.items()))
