"""What a sweep is: a scene, and the values of the keys that vary. Its runs are numbered, and follow from it."""

from __future__ import annotations

import functools
import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import tailslap
from postprocess.comparison.comparison import TAIL_SLAP, Compared
from tailslap.case import kind_of
from tailslap.errors import InputError
from tailslap.scene.read import scene_text, source_of_text
from tailslap.scene.schema import Scene
from tailslap.scene.validate import key_by_key
from tailslap.scene.vary import Changes, Source, changed_tables, parse_changes, parse_value
from tailslap.scene.write import scene_inputs
from tailslap.sweeps.values import MAX_RUNS, Choices, Span, parse_values, split_key
from tailslap.sweeps.variation import Variation, grid_variation, plain, sample_variation

Given = tuple[str, Span | Choices]


@dataclass(frozen=True)
class Definition:
    """A sweep of a scene's text; `changes` and `given` are the --set and --vary options as typed, `source` is the
    scene with the former put in, `sample` the number of samples, None for a grid; `kinds` and `compared` are what its
    case tells of a run, see `Case`."""

    scene: str
    text: str
    changes: tuple[str, ...]
    source: Source
    given: tuple[str, ...]
    variations: tuple[Variation, ...]
    sample: int | None
    seed: int
    kinds: Mapping[str, type] = field(default_factory=dict)
    compared: Compared = TAIL_SLAP

    @property
    def runs(self) -> int:
        """How many there are."""
        return self.sample or math.prod(len(item.settings) for item in self.variations)

    def changes_of(self, run: int) -> dict[str, Any]:
        """What a run changes in the scene."""
        pairs = zip(self.variations, self._places(run), strict=True)
        return {item.key: item.settings[i] for item, i in pairs}

    def inputs_of(self, run: int) -> dict[str, float | int | str]:
        """Values of the keys that vary, SI or words, for a run."""
        return {key: plain(value) for key, value in self.changes_of(run).items()}

    def as_written(self) -> dict[str, Any]:
        """What `sweep.json` holds: two sweeps are the same if this is. The digest is of all runs' values."""
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
            "text": self.text,
        }

    def _places(self, run: int) -> tuple[int, ...]:
        """Number of each key's value; in a grid the last key's changes from run to run."""
        if self.sample:
            return (run,) * len(self.variations)
        return tuple(map(int, np.unravel_index(run, [len(item.settings) for item in self.variations])))


def make_definition(
    name: str, changes: tuple[str, ...], varied: tuple[str, ...], sample: int | None, seed: int
) -> Definition:
    """The sweep of scene `name`; varied: KEY=VALUES each. Raises InputError for what cannot be in any scene.

    Each value is checked by itself; what only a combination makes impossible is found when it is run.
    """
    text = scene_text(name)
    given = tuple(_given(each, bool(sample)) for each in varied)
    source = _fixed(source_of_text(text, name), changes, [key for key, _ in given])
    _refuse_too_many(given)
    first = {key: parse_value(_first(values)) for key, values in given}
    scene = _scene(source, first)
    kind = kind_of(scene)

    def read(key: str, value: str) -> tuple[Any, str]:
        scene = _scene(source, {**first, key: parse_value(value)})
        row = next((row for row in scene_inputs(scene, source) if row.key == key), None)
        if row is None:
            raise InputError("--vary", key, "this is a table; allowed are its keys")
        return functools.reduce(getattr, key.split("."), scene), row.unit

    readers = [functools.partial(read, key) for key, _ in given]
    if sample is None:
        variations = [grid_variation(*item, reader) for item, reader in zip(given, readers, strict=True)]
    else:
        shares = latin_hypercube(len(given), sample, seed).T
        variations = [
            sample_variation(*item, *rest) for item, *rest in zip(given, readers, shares, strict=True)
        ]
    fixed = (scene.name, text, changes, source, varied, tuple(variations), sample, seed)
    return Definition(*fixed, kind.columns(scene), kind.compared)


def latin_hypercube(keys: int, runs: int, seed: int) -> np.ndarray:
    """Shares in [0, 1), shape (runs, keys): of each key one in each of `runs` equal parts."""
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(keys, seed=np.random.default_rng(seed)).random(runs))


def _given(option: str, sampled: bool) -> Given:
    key, text = split_key(option)
    return key, parse_values(key, text, sampled)


def _first(values: Span | Choices) -> str:
    return values.lower if isinstance(values, Span) else values.texts[0]


def _scene(source: Source, changes: Changes) -> Scene:
    return key_by_key(changed_tables(source.given, changes)[0])


def _fixed(source: Source, changes: tuple[str, ...], keys: list[str]) -> Source:
    """The source with the changes that all runs have; the keys are those that vary."""
    fixed = parse_changes(changes, source.given)
    for number, key in enumerate(keys):
        if key in keys[:number]:
            raise InputError("--vary", key, "it is varied twice; allowed is one --vary for each key")
        if key in fixed:
            raise InputError("--vary", key, "--set fixes it; leave out one of the two")
    tables, noted = changed_tables(source.given, fixed)
    return Source(source.text, tables, frozenset(noted))


def _refuse_too_many(given: tuple[Given, ...]) -> None:
    counts = [(values.count or 1) if isinstance(values, Span) else len(values.texts) for _, values in given]
    if math.prod(counts) > MAX_RUNS:
        shown = " x ".join(map(str, counts)) + " runs"
        raise InputError("--vary", shown, f"allowed are at most {MAX_RUNS} runs")
