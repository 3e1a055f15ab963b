"""Definition of a sweep over varied keys.

VALUES of --vary are a range or a list. Each value is read as in the scene, with its units, bounds and messages. The
definition determines number and order of the runs.
"""

import functools
import hashlib
import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

import tailslap
from postprocess.comparison.quantities import IN_SPACE, TAIL_SLAP, Compared
from tailslap.campaign import records, sampling
from tailslap.case import kind_of
from tailslap.errors import InputError
from tailslap.options import MAX_RUNS
from tailslap.scene import read, schema, validate, vary, write

ALLOWED = (
    "allowed is KEY=VALUES with VALUES a:b:n, log:a:b:n or a list v1,v2,v3, e.g. corner.friction=0:0.6:13; "
    "with --sample a:b, log:a:b or a list"
)
BRACKETS = {"[": 1, "]": -1}
LOGARITHMIC = "log"

Setting = float | int | str | tuple[float | int, ...]
"""A value of a key in a scene: a number in SI, a word, or several numbers."""

ValueReader = Callable[[str], tuple[Setting, str]]
"""Function from a value's text to its value in the scene and its unit; raises InputError."""


class TypedRange(NamedTuple):
    """A range as typed.

    `number` counts its values, and is None for samples. A logarithmic range has values in equal ratios.
    """

    lower: str
    upper: str
    number: int | None
    logarithmic: bool


TypedValues = TypedRange | tuple[str, ...]
"""A range, or the texts of a list."""


@dataclass(frozen=True)
class Variation:
    """Values of a varied key, in SI, words or tuples.

    A grid combines each value with those of the other keys. Of samples, value i belongs to run i.
    """

    key: str
    unit: str
    settings: tuple[Setting, ...]
    logarithmic: bool

    @property
    def values(self) -> tuple[float | int | str, ...]:
        """Return the values as numbers and words."""
        return tuple(map(plain, self.settings))

    @property
    def numeric(self) -> bool:
        """Return True if all values are numbers."""
        return all(isinstance(value, int | float) for value in self.settings)


def plain(value: Setting) -> float | int | str:
    """Convert a value to a number or word.

    Of a tuple, it joins the members.
    """
    return value if isinstance(value, int | float | str) else " x ".join(map(str, value))


@dataclass(frozen=True)
class Definition:
    """A sweep of a scene.

    Attributes
    ----------
    scene, text : str
        Name and text of the scene.
    changes, varied : tuple of str
        Options --set and --vary as typed.
    source : Source
        The scene with the changes of --set.
    variations : tuple of Variation
        Values of the varied keys.
    sample : int, optional
        Number of samples, None for a grid.
    seed : int
        Seed of the samples.
    column_types : dict of str to type
        Columns of a run in the table, by the kind of case.
    compared : Compared
        Quantities that the kind of case compares.
    """

    scene: str
    text: str
    changes: tuple[str, ...]
    source: vary.Source
    varied: tuple[str, ...]
    variations: tuple[Variation, ...]
    sample: int | None
    seed: int
    column_types: Mapping[str, type] = field(default_factory=dict)
    compared: Compared = TAIL_SLAP

    @property
    def runs(self) -> int:
        """Return the number of runs."""
        return self.sample or math.prod(len(item.settings) for item in self.variations)

    def changes_of(self, run: int) -> dict[str, Setting]:
        """Return the scene changes of a run.

        In a grid, the value of the last key changes from run to run.
        """
        sizes = [len(item.settings) for item in self.variations]
        places = [run] * len(sizes) if self.sample else map(int, np.unravel_index(run, sizes))
        return {item.key: item.settings[i] for item, i in zip(self.variations, places, strict=True)}

    def inputs_of(self, run: int) -> dict[str, float | int | str]:
        """Return the values of the varied keys of a run."""
        return {key: plain(value) for key, value in self.changes_of(run).items()}

    def as_written(self) -> records.Record:
        """Return the contents of `sweep.json`, which identify the sweep.

        The digest covers the values of all runs.
        """
        values = json.dumps([[item.key, item.settings] for item in self.variations])
        return {
            "scene": self.scene,
            "set": list(self.changes),
            "vary": list(self.varied),
            "sample": self.sample,
            "seed": self.seed if self.sample else None,
            "runs": self.runs,
            "digest": hashlib.sha256(values.encode()).hexdigest(),
            "version": tailslap.__version__,
            "program": records.program(),
            "text": self.text,
        }


def make_definition(
    scene: read.Scene, changes: tuple[str, ...], varied: tuple[str, ...], sample: int | None, seed: int
) -> Definition:
    """Define the sweep of a scene.

    Each value is checked alone. Combinations are checked when they are run. scene: name, path or tables; changes,
    varied: options --set (KEY=VALUE) and --vary (KEY=VALUES); sample: number of samples, None for a grid; seed: of the
    samples. Raises InputError where a key or value is invalid in every scene.
    """
    scene_source = read.read_source(scene)
    typed = [parse_varied(text, bool(sample)) for text in varied]
    source = _fixed(scene_source, changes, [key for key, _ in typed])
    counts = [(values.number or 1) if isinstance(values, TypedRange) else len(values) for _, values in typed]
    if math.prod(counts) > MAX_RUNS:
        product = " x ".join(map(str, counts)) + " runs"
        raise InputError("--vary", product, f"the limit is {MAX_RUNS} runs")
    first = {key: vary.parse_value(values[0]) for key, values in typed}
    example = _scene(source, first)
    kind = kind_of(example)

    def read_value(key: str, value: str) -> tuple[Setting, str]:
        scene = _scene(source, {**first, key: vary.parse_value(value)})
        row = next((row for row in write.scene_inputs(scene, source) if row.key == key), None)
        if row is None:
            raise InputError("--vary", key, "this is a table; allowed are its keys")
        return schema.value_at(scene, key), row.unit

    random = np.random.default_rng(seed).spawn(1)[0]
    fractions = sampling.latin_hypercube(len(typed), sample, random) if sample else [None] * len(typed)
    variations = tuple(
        _variation(key, values, functools.partial(read_value, key), places)
        for (key, values), places in zip(typed, fractions, strict=True)
    )
    fixed = (example.name, write.scene_text(scene_source), changes, source, varied, variations, sample, seed)
    in_space = example.body and not example.plate
    return Definition(*fixed, kind.columns(example), IN_SPACE if in_space else kind.compared)


def varied_source(definition: Definition) -> vary.Source:
    """Return the source with one value of each varied key.

    Values are as typed, and numbers without unit where there are any.
    """
    first = {}
    for text in definition.varied:
        key, values = parse_varied(text, bool(definition.sample))
        candidates = [
            vary.parse_value(value) for value in (values[:2] if isinstance(values, TypedRange) else values)
        ]
        first[key] = next((value for value in candidates if isinstance(value, int | float)), candidates[0])
    tables = vary.changed_tables(definition.source.tables, first)[0]
    return vary.Source(definition.source.text, tables, definition.source.changed | first.keys())


def _scene(source: vary.Source, changes: vary.Changes) -> schema.Scene:
    """Validate the scene with these changes, key by key."""
    return validate.key_by_key(vary.changed_tables(source.tables, changes)[0])


def _fixed(source: vary.Source, changes: tuple[str, ...], keys: list[str]) -> vary.Source:
    """Return the source with the changes of --set."""
    fixed = vary.parse_changes(changes, source.tables)
    for number, key in enumerate(keys):
        if key in keys[:number]:
            raise InputError("--vary", key, "this key is varied twice")
        if key in fixed:
            raise InputError("--vary", key, "--set and --vary exclude each other; remove one of the two")
    tables, noted = vary.changed_tables(source.tables, fixed)
    return vary.Source(source.text, tables, frozenset(noted))


def parse_varied(varied: str, sampled: bool) -> tuple[str, TypedValues]:
    """Parse KEY=VALUES.

    With samples, a range has no number of values. Raises InputError.
    """
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
    """Split a text at separators outside brackets and quotes."""
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


def _variation(
    key: str, typed: TypedValues, read_value: ValueReader, fractions: np.ndarray | None
) -> Variation:
    """Return all values of a list or range.

    The values of a range are evenly spaced or in equal ratios, both ends included. Of samples, `fractions` are the
    positions in the range or list, shape (runs,), in [0, 1).
    """
    if not isinstance(typed, TypedRange):
        listed, units = zip(*map(read_value, typed), strict=True)
        chosen = listed if fractions is None else tuple(listed[int(f * len(listed))] for f in fractions)
        return Variation(key, units[0], chosen, False)
    lower, upper, unit = _ends(key, typed, read_value)
    if fractions is not None:
        if isinstance(lower, int):
            ends = f"{typed.lower}:{typed.upper}"
            raise InputError(key, ends, "with --sample whole numbers require a list v1,v2,v3")
        even = lower + (upper - lower) * fractions
        between = lower * (upper / lower) ** fractions if typed.logarithmic else even
        return Variation(key, unit, tuple(between.tolist()), typed.logarithmic)
    assert typed.number is not None
    values = (np.geomspace if typed.logarithmic else np.linspace)(lower, upper, typed.number).tolist()
    if isinstance(lower, int) and isinstance(upper, int):
        if any(value != round(value) for value in values):
            ends = f"{typed.lower}:{typed.upper}:{typed.number}"
            raise InputError(key, ends, f"all values must be whole numbers; {values[1]:g} is not")
        values = [round(value) for value in values]
    return Variation(key, unit, tuple(values), typed.logarithmic)


def _ends(key: str, typed: TypedRange, read_value: ValueReader) -> tuple[float, float, str]:
    """Return a range's limits with their unit."""
    (lower, unit), (upper, _) = read_value(typed.lower), read_value(typed.upper)
    ends = f"{typed.lower}:{typed.upper}"
    if not (isinstance(lower, int | float) and isinstance(upper, int | float)):
        raise InputError(key, ends, "a range requires numbers; allowed is a list v1,v2,v3")
    if lower == upper:
        raise InputError(key, ends, "the ends of a range must differ")
    if typed.logarithmic and not min(lower, upper) > 0.0:
        raise InputError(key, ends, "the ends of a logarithmic range must be above 0")
    return lower, upper, unit
