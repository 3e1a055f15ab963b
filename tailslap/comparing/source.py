"""Read histories to compare, by this program's names and in SI.

They are those of a result, or of a file: text (`text_tables`), Parquet of this program, or nodes of other programs.
"""

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from postprocess.comparison import nodal
from tailslap.comparing.text_tables import BRACKETS, MAX_BYTES, Floats, Source, name_and_unit, read_table
from tailslap.comparing.units import ratio
from tailslap.errors import MACHINE_FAULTS, InputError, Verbatim, one_of, shortened
from tailslap.result.columns import column_units, read_columns
from tailslap.result.load import demand_listed, load
from tailslap.result.result import FE, Result

TIME = "t"
TIMES = ("t", "time")
"""Names of a column of instants, in small or capital letters."""

OF_ONE = re.compile(r"\s*([0-9]{1,6})\s*:\s*(.+)")
"""Name in a mapping for one of the results, by its number."""

NO_FILE = "there is no file to which it applies; a result has columns by its number, like 2:force=theta"
NO_NAMES = 'its first line has no column names; allowed are names, or numbers, --columns "time=1,v_gy=2"'
PARQUET = b"PAR1"
"""First bytes of a Parquet file."""


@dataclass(frozen=True)
class Item:
    """History that is compared.

    Attributes
    ----------
    label : str
        Name of the scene, folder or file.
    columns : dict of ndarray, shape (rows,)
        Those of this program in SI, common in the unit of the reference; NaN is a missing value.
    units : dict of str
        Of the columns.
    summary : dict, optional
        Of a result.
    notes : tuple of str
        Assumptions.
    time_name : str
        Name of the column of instants in the file.
    unit_of_time : str
        Source of the unit of time: "file", also for an option for this file alone, "columns" for the option for all,
        or "assumed".
    unread : dict of str
        Remarks by the names of the other columns; "" without one.
    """

    label: str
    columns: Mapping[str, Floats]
    units: Mapping[str, str]
    summary: Mapping[str, Any] | None = None
    notes: tuple[str, ...] = ()
    time_name: str = TIME
    unit_of_time: str = "file"
    unread: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Choice:
    """Column of a history that is read.

    name: in its file; stated: source of the unit, as `Item.unit_of_time`; against: unit of a mapping that the file
    contradicts.
    """

    name: str
    unit: str
    stated: str
    sign: float = 1.0
    against: str = ""
    is_mapped: bool = False


Choices = Mapping[str, Choice]
"""Columns by the names in the comparison."""


def parse_mapping(text: str) -> dict[str, str]:
    """Return column names of a file by those of this program.

    The text is like "time=t,v_gy=VY [mph]". Raises InputError.
    """
    pairs = [part.partition("=") for part in text.split(",") if part.strip()]
    if not pairs or not all(key.strip() and value.strip() for key, _, value in pairs):
        raise InputError("--columns", text, "allowed is NAME=THEIRS,..., e.g. time=t,v_gy=VY")
    return {key.strip(): value.strip() for key, _, value in pairs}


def read_items(
    sources: Sequence[object], mapping: Mapping[str, str], force: bool, decimal_commas: Sequence[int]
) -> list[Item]:
    """Read histories from results, their folders, or files.

    The first is the reference. force: also damaged ones; decimal_commas: numbers of files with such, from 1. Raises
    InputError.
    """
    opened = [open_source(k, source, force, k in decimal_commas) for k, source in enumerate(sources, 1)]
    for number in decimal_commas:
        if not (text := _numbered(opened, number, "--decimal-comma")).lines:
            raise InputError("--decimal-comma", number, f"{text.file} is no text; allowed are text files")
    choices = [*map(_choices, opened, _mapped(opened, mapping))]
    common = [set[str]().union(*choices[1:]), *({*choices[0]} for _ in choices[1:])]
    units = {ours: choice.unit for ours, choice in choices[0].items()}
    return [_item(*parts, units) for parts in zip(opened, choices, common, strict=True)]


def _numbered(opened: Sequence[Source], number: int, option: str) -> Source:
    """Return a history by its number. Raises InputError for another."""
    if not 1 <= number <= len(opened):
        raise InputError(option, number, f"allowed are the numbers of the results, from 1 to {len(opened)}")
    return opened[number - 1]


def open_source(number: int, history: object, force: bool = False, decimal_comma: bool = False) -> Source:
    """Open a history of a result, a folder or a file.

    number: of the result in the command; force: also damaged ones. Raises InputError.
    """
    if isinstance(history, Item):
        units = {name: history.units.get(name, "") for name in history.columns} | column_units(
            history.columns
        )
        numbers = partial(_numbers, history.columns)
        source = Source(units, numbers, is_result=True, summary=history.summary)
        return replace(source, number=number, label=history.label, place=history.label)
    path = Path(str(history))
    with _reading(path):
        is_file = not isinstance(history, Result) and not path.is_dir()
    if is_file:
        is_listed = demand_listed(path, force)
        with _reading(path):
            source = _open_file(path, decimal_comma)
        units = {**source.units, **(column_units(source.units) if is_listed else {})}
        return replace(source, units=units, number=number, label=path.stem, place=str(path))
    result = history if isinstance(history, Result) else load(path, force=force)
    if not result.histories:
        raise InputError(str(history), Verbatim(result.command), "it has no history; allowed is a run")
    columns = result.histories.get(FE) or next(iter(result.histories.values()))
    label = result.scene if result is history else path.resolve().name
    return replace(open_source(number, Item(label, columns, columns.units, result.summary)), place=str(path))


def _numbers(columns: Mapping[str, np.ndarray], name: str) -> Floats:
    """Return the numbers of a column. Raises ValueError for words."""
    if columns[name].dtype.kind not in "fiub":
        raise ValueError(f"column {shortened(name)} has no numbers")
    return np.asarray(columns[name], np.float64)


def _open_file(path: Path, decimal_comma: bool) -> Source:
    """Open a file by its content. Raises OSError, ValueError or csv.Error."""
    if path.is_file():
        with path.open("rb") as file:
            is_parquet = file.read(len(PARQUET)) == PARQUET
        if is_parquet:
            return _open_parquet(path)
    if not nodal.reader_of(path):
        return read_table(path, decimal_comma)
    if path.stat().st_size > MAX_BYTES:
        raise ValueError(f"it is too large; the limit is {MAX_BYTES} bytes")
    motion = nodal.read_centre_of_mass(path)
    return Source(dict.fromkeys(motion, ""), motion.__getitem__)


def _open_parquet(path: Path) -> Source:
    """Open a Parquet file. Raises OSError or ValueError."""
    import pyarrow.parquet as pq

    rows, schema = pq.read_metadata(path).num_rows, pq.read_schema(path)
    if 8 * rows > MAX_BYTES:
        raise ValueError(f"it has {rows} rows; allowed are at most {MAX_BYTES // 8}")
    metadata = {entry.name: entry.metadata or {} for entry in schema}
    units = {name: of.get(b"unit", b"").decode("utf-8", "replace") for name, of in metadata.items()}
    return Source(units, lambda name: _numbers(read_columns(path, [name]), name))


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Raise InputError for a file that cannot be read."""
    try:
        yield
    except FileNotFoundError:
        allowed = "the file or folder does not exist; allowed are result folders and files with named columns"
        raise InputError("RESULT", str(path), allowed) from None
    except (OSError, ValueError, csv.Error) as error:
        if isinstance(error, OSError) and error.errno in MACHINE_FAULTS:
            raise
        why = str(getattr(error, "strerror", None) or error)
        advice = "" if "allowed" in why else "; allowed is a file with named columns"
        raise InputError("RESULT", str(path), f"{why}{advice}") from None


@cache
def _own_name(name: str) -> str:
    """Return this program's name of a column.

    It is without remarks in brackets. Other columns keep their name.
    """
    bare = " ".join(BRACKETS.sub(" ", name).split())
    bare = TIME if bare.lower() in TIMES else bare
    return bare if column_units([bare]) else name


def _mapped(opened: Sequence[Source], mapping: Mapping[str, str]) -> list[dict[str, Choice]]:
    """Return mapped columns of each history, by this program's names.

    Names for one history hold against those for all files. A column that is not in a file, which has one of this
    program's name, belongs to another file. Raises InputError.
    """
    mapped: list[dict[str, Choice]] = [{} for _ in opened]
    for key, theirs in sorted(mapping.items(), key=lambda entry: not OF_ONE.fullmatch(entry[0])):
        alone = OF_ONE.fullmatch(key)
        ours = _own_name(alone[2] if alone else key)
        among = [source for source in opened if not source.is_result]
        among = [_numbered(opened, int(alone[1]), "--columns")] if alone else among
        choices = [_theirs(source, theirs, bool(alone)) for source in among]
        lacking = []
        for source, choice in zip(among, choices, strict=True):
            if choice:
                mapped[source.number - 1].setdefault(ours, choice)
            elif not any(choices) or ours not in (*mapped[source.number - 1], *map(_own_name, source.units)):
                lacking.append(source)
        if lacking or not among:
            which = f"{lacking[0].file} does not have" if alone or any(choices) else "no file has"
            names = dict.fromkeys(name for source in lacking for name in source.units)
            allowed = one_of(theirs, names, f"{which} this column; allowed are") if names else NO_FILE
            raise InputError("--columns", theirs, allowed)
    return mapped


def _own(source: Source, name: str) -> Choice:
    """Return a column that no mapping names."""
    unit = source.units[name]
    return Choice(name, unit, "file" if unit or source.is_result else "assumed")


def _theirs(source: Source, theirs: str, alone: bool) -> Choice | None:
    """Return the column that a mapping names, None without one.

    Columns without a name have their number.
    """
    sign, name, mapped = 1.0, theirs, ""
    if theirs not in source.units:
        sign = -1.0 if theirs.startswith("-") else 1.0
        name, mapped = name_and_unit(theirs.removeprefix("-"))
    if name not in source.units and (alone or not source.is_named):
        name = {str(k): name for k, name in enumerate(source.units, 1)}.get(name, name)
    if name not in source.units:
        return None
    choice = replace(_own(source, name), sign=sign, is_mapped=True)
    if choice.unit or not mapped:
        return replace(choice, against=mapped if mapped != choice.unit else "")
    return replace(choice, unit=mapped, stated="file" if alone or source.is_result else "columns")


def _choices(source: Source, mapped: Choices) -> dict[str, Choice]:
    """Return all columns of a history by the names in the comparison.

    They are those of a mapping, of this program, or of the file. The first column of a file without names is assumed
    to be time. Raises InputError for two columns of one name.
    """
    chosen, used = dict(mapped), {choice.name for choice in mapped.values()}
    first = source.names[0]
    if not source.is_named and not mapped and first == "1":
        raise InputError("RESULT", source.place, NO_NAMES)
    if not source.is_named and first not in used and TIME not in {*mapped, *map(_own_name, source.names)}:
        chosen[TIME] = _own(source, first)
        used.add(first)
    exact_first = sorted(source.names, key=lambda name: name != _own_name(name))
    for name in exact_first:
        ours = _own_name(name)
        if ours in mapped or (ours in chosen and chosen[ours].name == ours):
            ours = name
        if ours in chosen and ours != name:
            names = f'"{chosen[ours].name}" and "{name}"'
            allowed = f'it has two columns {ours}, {names}; allowed is one, or --columns "{ours}={name}"'
            raise InputError("RESULT", source.place, allowed)
        if name not in used or column_units([ours]):
            chosen.setdefault(ours, _own(source, name))
    return dict(sorted(chosen.items(), key=lambda pair: source.names.index(pair[1].name)))


def _item(source: Source, choices: Choices, common: set[str], reference: Mapping[str, str]) -> Item:
    """Read columns of a history.

    They are those of this program, mapped ones, and common ones. common: columns that others have, too; reference:
    units of the reference. Raises InputError.
    """
    si, columns, unread = column_units(choices), dict[str, Floats](), dict[str, str]()
    units = {ours: si.get(ours, reference.get(ours, choice.unit)) for ours, choice in choices.items()}
    for ours, choice in choices.items():
        is_demanded = choice.is_mapped or ours in si
        if not is_demanded and ours not in common:
            unread[ours] = source.remarks.get(ours, "")
            continue
        try:
            with _reading(Path(source.place)):
                values = source.numbers(choice.name)
        except InputError as error:
            if is_demanded:
                raise
            unread[ours] = error.allowed
        else:
            columns[ours] = choice.sign * _factor(source, ours, choice, units[ours], ours in si) * values
    _demand_sound(columns, source)
    notes = tuple(_notes(source, {ours: choices[ours] for ours in columns if ours in common}, si))
    time, units = choices[TIME], {name: units[name] for name in columns}
    return Item(source.label, columns, units, source.summary, notes, time.name, time.stated, unread)


def _notes(source: Source, read: Choices, si: Mapping[str, str]) -> Iterator[str]:
    """Yield what is assumed of the columns that others have, too."""
    for ours, choice in read.items():
        if choice.against:
            yield f"{source.file}: {choice.name} is in {choice.unit} by the file, not in {choice.against}."
        if ours in si and BRACKETS.search(choice.name) and not choice.is_mapped:
            yield f'{source.file}: {ours} is its column "{choice.name}"; the remark is not considered.'
        if ours == TIME and not source.is_named and _own_name(choice.name) != TIME and not choice.is_mapped:
            yield f"{source.file}: its first column is assumed to be time."
    assumed = [ours for ours, choice in read.items() if choice.stated == "assumed" and si.get(ours, "?")]
    if assumed:
        yield f"{source.file}: {', '.join(assumed)} without a unit, assumed in SI."


def _factor(source: Source, ours: str, choice: Choice, target: str, is_ours: bool) -> float:
    """Return the factor from the file's unit to the target.

    A column of this program without a unit is in SI. Raises InputError for another dimension, or one unit alone.
    """
    unit = choice.unit
    if unit == target or (is_ours and not (unit and target)):
        return 1.0
    of = "" if is_ours else ", as the reference has"
    try:
        if unit and target:
            return ratio(unit, target)
        alone = f"{source.number if target else 1}:{ours}={choice.name}"
        has = f'"{target}"' if target else "none"
        allowed = f'the reference has {has}; allowed is a unit in both files, or --columns "{alone} [UNIT]"'
    except ValueError as error:
        allowed = f"allowed is a unit of the dimension of {target}{of}: {error}"
    raise InputError(f"unit of {ours} of {source.label}", unit or Verbatim("none"), allowed)


def _demand_sound(columns: Mapping[str, Floats], source: Source) -> None:
    """Demand increasing instants and moderate numbers.

    Numbers must have finite squares. Raises InputError with line or row.
    """
    if TIME not in columns:
        names = one_of("time", source.units, "its columns are")
        allowed = f"it has no time column; allowed is a column t or time, or --columns time=THEIRS; {names}"
        raise InputError("RESULT", source.place, allowed)
    for k, why in _faults(columns):
        where = f"line {source.lines[k]}" if source.lines else f"row {k + 1}"
        raise InputError("RESULT", source.place, f"{where}{why}")


def _faults(columns: Mapping[str, Floats]) -> Iterator[tuple[int, str]]:
    """Yield rows and faults of instants and numbers."""
    t = columns[TIME]
    for k in np.flatnonzero(~np.isfinite(t)).tolist():
        yield k, ": the instant is missing; allowed is a number"
    for k in (np.flatnonzero(np.diff(t) <= 0.0) + 1).tolist():
        yield k, f": time does not increase from row to row, {t[k]:.7g} s after {t[k - 1]:.7g} s"
    for name, values in columns.items():
        for k in np.flatnonzero(
            np.abs(values) > nodal.LARGEST
        ).tolist():  # NaN, a missing value, is not larger
            yield k, f", column {shortened(name)}: {values[k]:g} in SI; {nodal.ALLOWED}"
