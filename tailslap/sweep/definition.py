"""What a sweep is: a scene, and the values of the keys that vary. Its runs are numbered, and follow from it."""

from __future__ import annotations

import functools
import hashlib
import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

import tailslap
from tailslap.errors import InputError
from tailslap.planning.fe_plan import needed_plate
from tailslap.scene.files import Source, changed_tables, key_by_key, scene_text
from tailslap.scene.inputs import SceneInput, scene_inputs
from tailslap.sweep.values import MOST_RUNS, Choices, Span, parse_values, split_key
from tailslap.sweep.variation import Variation, grid_variation, sample_variation

Given = tuple[str, Span | Choices]


@dataclass(frozen=True)
class Definition:
    """A sweep; `given` are the --vary options as typed, `sample` the number of samples, None for a grid."""

    scene: str
    text: str
    changes: tuple[str, ...]
    given: tuple[str, ...]
    variations: tuple[Variation, ...]
    sample: int | None
    seed: int

    @property
    def runs(self) -> int:
        """How many there are."""
        return self.sample or math.prod(len(item.texts) for item in self.variations)

    def changes_of(self, run: int) -> tuple[str, ...]:
        """The changes of the scene, like those of --set, for a run."""
        pairs = zip(self.variations, self._places(run), strict=True)
        return (*self.changes, *(f"{item.key}={item.texts[i]}" for item, i in pairs))

    def inputs_of(self, run: int) -> dict[str, float | int | str]:
        """Values of the keys that vary, SI or words, for a run."""
        return {item.key: item.values[i] for item, i in zip(self.variations, self._places(run), strict=True)}

    def as_written(self) -> dict[str, Any]:
        """What `sweep.json` holds: two sweeps are the same if this is. The digest is of all runs' values."""
        values = json.dumps([[item.key, item.texts] for item in self.variations])
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
        return tuple(map(int, np.unravel_index(run, [len(item.texts) for item in self.variations])))


def make_definition(
    name: str, changes: tuple[str, ...], varied: tuple[str, ...], sample: int | None, seed: int
) -> Definition:
    """The sweep of scene `name`; varied: KEY=VALUES each. Raises InputError for what cannot be in any scene.

    Each value is checked by itself; what only a combination makes impossible is found when it is run.
    """
    text = scene_text(name)
    given = tuple(_given(words, bool(sample)) for words in varied)
    _refuse_twice([key for key, _ in given], changes)
    _refuse_too_many(given)
    first = tuple(f"{key}={_first(values)}" for key, values in given)
    scene = key_by_key(changed_tables(text, (*changes, *first), name)[0])
    needed_plate(scene)

    def read(key: str, value: str) -> SceneInput:
        tables, _ = changed_tables(text, (*changes, *first, f"{key}={value}"), name)
        return next(row for row in scene_inputs(key_by_key(tables), Source()) if row.key == key)

    readers = [functools.partial(read, key) for key, _ in given]
    if sample is None:
        variations = [grid_variation(*item, reader) for item, reader in zip(given, readers, strict=True)]
    else:
        shares = latin_hypercube(len(given), sample, seed).T
        variations = [
            sample_variation(*item, *rest) for item, *rest in zip(given, readers, shares, strict=True)
        ]
    return Definition(scene.name, text, changes, varied, tuple(variations), sample, seed)


def latin_hypercube(keys: int, runs: int, seed: int) -> np.ndarray:
    """Shares in [0, 1), shape (runs, keys): of each key one in each of `runs` equal parts."""
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(keys, seed=np.random.default_rng(seed)).random(runs))


def _given(words: str, sampled: bool) -> Given:
    key, text = split_key(words)
    return key, parse_values(key, text, sampled)


def _first(values: Span | Choices) -> str:
    return values.lower if isinstance(values, Span) else values.texts[0]


def _refuse_twice(keys: list[str], changes: tuple[str, ...]) -> None:
    fixed = {change.partition("=")[0].strip() for change in changes}
    for number, key in enumerate(keys):
        if key in keys[:number]:
            raise InputError("--vary", key, "it is varied twice; allowed is one --vary for each key")
        if key in fixed:
            raise InputError("--vary", key, "--set fixes it; leave out one of the two")


def _refuse_too_many(given: tuple[Given, ...]) -> None:
    counts = [(values.count or 1) if isinstance(values, Span) else len(values.texts) for _, values in given]
    if math.prod(counts) > MOST_RUNS:
        shown = " x ".join(map(str, counts)) + " runs"
        raise InputError("--vary", shown, f"allowed are at most {MOST_RUNS} runs")
