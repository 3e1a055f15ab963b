"""Results side by side: each beside the first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from postprocess.comparison.side_by_side import Beside, beside
from tailslap.comparing.source import TIME, Item, parse_mapping, read_item
from tailslap.errors import InputError, Verbatim

USUAL = (
    *("theta", "omega", "v_gx", "v_gy", "slide", "reaction_normal", "reaction_tangential"),
    *("x_g", "y_g", "force_normal", "force_tangential"),
)
"""Columns that are compared unless the caller says otherwise."""


@dataclass(frozen=True)
class Comparison:
    """The first of the items is the reference; beside: of each of the others, by its label, the columns in common."""

    items: tuple[Item, ...]
    beside: Mapping[str, tuple[Beside, ...]]

    @property
    def reference(self) -> Item:
        """What the others are compared with."""
        return self.items[0]

    @property
    def within(self) -> bool:
        """Whether all metrics are within their customary limits."""
        return all(each.within for columns in self.beside.values() for each in columns)

    @property
    def names(self) -> list[str]:
        """Columns that were compared, of any item."""
        return list(dict.fromkeys(each.name for columns in self.beside.values() for each in columns))


def compare_items(
    given: Sequence[object], columns: Mapping[str, str] | str | None = None, only: Sequence[str] = ()
) -> Comparison:
    """Compare results, folders and files with the first of them. Raises InputError."""
    if len(given) < 2:
        raise InputError(
            "RESULT", Verbatim(len(given)), "allowed are two or more, the first is the reference"
        )
    mapping = parse_mapping(columns) if isinstance(columns, str) else dict(columns or {})
    items = _labelled([read_item(each, mapping) for each in given])
    found = {item.label: _columns(item, items[0], only) for item in items[1:]}
    return Comparison(items, found)


def _labelled(items: Sequence[Item]) -> tuple[Item, ...]:
    """The items with labels that differ."""
    labels = [item.label for item in items]
    return tuple(
        replace(item, label=f"{item.label} ({k})") if labels.count(item.label) > 1 else item
        for k, item in enumerate(items, 1)
    )


def _columns(item: Item, reference: Item, only: Sequence[str]) -> tuple[Beside, ...]:
    common = [name for name in reference.columns if name in item.columns and name != TIME]
    for name in only:
        if name not in common:
            raise InputError("--only", name, f"allowed are the columns in common, {', '.join(common)}")
    chosen = only or [name for name in USUAL if name in common] or common
    found = [beside(name, item.columns, reference.columns) for name in chosen]
    known = tuple(each for each in found if each is not None)
    if not known:
        allowed = f"it has no column over a common time with {reference.label}; see --columns"
        raise InputError("RESULT", item.label, allowed)
    return known
