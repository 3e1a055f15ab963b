"""Read histories to compare, by this program's names and in SI.

They are those of a result, or of a file: text (`text_tables`), Parquet of this program, or nodes of other programs.
"""

import csv
import os
import re
import stat
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison import nodal
from tailslap.comparing.text_tables import MAX_BYTES, name_and_unit, read_table
from tailslap.comparing.units import ratio
from tailslap.errors import MACHINE_FAULTS, InputError, Verbatim, one_of, place_error, shortened
from tailslap.result.columns import column_units, read_columns
from tailslap.result.load import demand_listed, load
from tailslap.result.result import FE, Result

TIME = "t"
TIMES = ("t", "time")
"""Names of a column of instants, in small or capital letters."""

THEIRS = re.compile(r"(?P<minus>-?)\s*(?P<name>[^\[]+?)\s*(?:\[(?P<unit>[^\]]+)\])?")
OF_ONE = re.compile(r"\s*([0-9]{1,6})\s*:\s*(.+)")
"""Name in a mapping for one of the results, by its number."""

REMARK = re.compile(r"\s*(\[[^\]]*\]|\([^)]*\))")
NO_FILE = (
    "there is no file to which it applies; a result has columns of its own by its number, like 2:force=theta"
)
NO_NAMES = (
    'its first line has no column names; allowed are names, or numbers of columns, --columns "time=1,v_gy=2"'
)
PARQUET = b"PAR1"
"""First bytes of a Parquet file."""

Floats = NDArray[np.float64]
Read = TypeVar("Read")


@dataclass(frozen=True)
class Item:
    """History that is compared.

    Attributes
    ----------
    label : str
        Name of the scene, folder or file.
    columns : dict of ndarray, shape (rows,)
        Those of this program in SI, others in the unit of the reference; NaN is a missing value.
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
class Record:
    """Opened history with columns by the names in its file.

    Attributes
    ----------
    number : int
        Of the result in the command, from 1.
    label, place : str
        Name for pages, and for messages.
    units : dict of str
        By the names of the columns; "" without a unit.
    numbers : callable
        Function from a name to its numbers. Raises ValueError with the line of another cell.
    lines : sequence of int
        Of the rows, if any.
    is_named : bool
        False for a file without a line of names, whose columns have numbers.
    is_result : bool
        True for results of this program, which take mappings of their own alone.
    remarks : dict of str
        On missing entries, by name.
    summary : dict, optional
        Of a result.
    """

    number: int
    label: str
    place: str
    units: Mapping[str, str]
    numbers: Callable[[str], Floats]
    lines: Sequence[int] = ()
    is_named: bool = True
    is_result: bool = False
    remarks: Mapping[str, str] = field(default_factory=dict)
    summary: Mapping[str, Any] | None = None

    @property
    def file(self) -> str:
        """Name of the file."""
        return Path(self.place).name


@dataclass(frozen=True)
class Choice:
    """Column of a record that is read.

    stated: source of the unit, as `Item.unit_of_time`; against: unit of a mapping that the file contradicts.
    """

    name: str
    sign: float = 1.0
    unit: str = ""
    stated: str = "assumed"
    against: str = ""
    is_mapped: bool = False


def parse_mapping(text: str) -> dict[str, str]:
    """Return column names of a file by those of this program.

    The text is like "time=t,v_gy=VY [mph]". Raises InputError.
    """
    pairs = [part.partition("=") for part in text.split(",") if part.strip()]
    if not pairs or not all(key.strip() and value.strip() for key, _, value in pairs):
        raise InputError("--columns", text, "allowed is NAME=THEIRS,..., e.g. time=t,v_gy=VY")
    return {key.strip(): value.strip() for key, _, value in pairs}


def read_items(
    sources: Sequence[object],
    mapping: Mapping[str, str],
    force: bool = False,
    decimal_commas: Sequence[int] = (),
) -> list[Item]:
    """Read histories from results, their folders, or files.

    The first is the reference. force: also damaged ones; decimal_commas: numbers of files with such, from 1. Raises
    InputError.
    """
    records = [open_record(k, source, force, k in decimal_commas) for k, source in enumerate(sources, 1)]
    for number in decimal_commas:
        if not (record := records[_demand_number("--decimal-comma", number, len(sources)) - 1]).lines:
            raise InputError("--decimal-comma", number, f"{record.file} is no text; allowed are text files")
    alone: list[dict[str, str]] = [{} for _ in records]
    common = dict[str, str]()
    for key, theirs in mapping.items():
        match = OF_ONE.fullmatch(key)
        of = alone[_demand_number("--columns", int(match[1]), len(sources)) - 1] if match else common
        of[_time_as_t(match[2] if match else key)] = theirs
    _demand_used(common, records)
    choices = [
        _chosen(record, {} if record.is_result else common, of)
        for record, of in zip(records, alone, strict=True)
    ]
    names = [{*chosen, *_free(record, chosen)} for record, chosen in zip(records, choices, strict=True)]
    common_names = [set[str]().union(*names[1:]), *(names[0] for _ in names[1:])]
    for record, chosen, among in zip(records, choices, common_names, strict=True):
        chosen.update({name: _choice(record, name) for name in _free(record, chosen) if name in among})
    units = {ours: choice.unit for ours, choice in choices[0].items()}
    return [
        _item(record, chosen, units, among)
        for record, chosen, among in zip(records, choices, common_names, strict=True)
    ]


def _demand_number(key: str, number: int, count: int) -> int:
    """Return the number of a result. Raises InputError for another."""
    if not 1 <= number <= count:
        raise InputError(key, number, f"allowed are the numbers of the results, from 1 to {count}")
    return number


def open_record(number: int, source: object, force: bool = False, decimal_comma: bool = False) -> Record:
    """Open a history of a result, a folder or a file.

    number: of the result in the command; force: also damaged ones. Raises InputError.
    """
    if isinstance(source, Item):
        units = {name: source.units.get(name, "") for name in source.columns} | column_units(source.columns)
        numbers, place = _numbers_of(source.columns), source.label
        return Record(number, place, place, units, numbers, is_result=True, summary=source.summary)
    path = Path(str(source))
    if isinstance(source, Result):
        result, label = source, source.scene
    elif _is_folder(path):
        result, label = load(path, force=force), path.resolve().name
    else:
        is_listed = demand_listed(path, force)
        return _readable(path, partial(_open_file, number, path, is_listed, decimal_comma))
    if not result.histories:
        raise InputError(str(source), Verbatim(result.command), "it has no history; allowed is a run")
    columns = result.histories.get(FE) or next(iter(result.histories.values()))
    units = {name: columns.units.get(name, "") for name in columns}
    return Record(
        number, label, str(path), units, _numbers_of(columns), is_result=True, summary=result.summary
    )


def _numbers_of(columns: Mapping[str, np.ndarray]) -> Callable[[str], Floats]:
    """Return the function from a name to numbers.

    It raises ValueError for words.
    """

    def numbers(name: str) -> Floats:
        values = columns[name]
        if values.dtype.kind not in "fiub":
            raise ValueError(f"column {shortened(name)} has no numbers")
        return np.asarray(values, np.float64)

    return numbers


def _is_folder(path: Path) -> bool:
    """Return True for a folder.

    Raises InputError, or OSError of the machine, where that cannot be determined.
    """
    try:
        return stat.S_ISDIR(os.stat(path).st_mode)
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return False
    except OSError as error:
        raise place_error(path, "it cannot be read", error, "RESULT") from None


def _open_file(number: int, path: Path, is_listed: bool, decimal_comma: bool) -> Record:
    """Open a file by its content.

    is_listed: of this program, in SI. Raises OSError, ValueError or csv.Error.
    """
    lines: Sequence[int] = ()
    is_named, remarks = True, dict[str, str]()
    if _is_parquet(path):
        units, numbers = _open_parquet(path)
    elif nodal.reader_of(path):
        if path.stat().st_size > MAX_BYTES:
            raise ValueError(f"it is too large; the limit is {MAX_BYTES} bytes")
        motion = nodal.read_centre_of_mass(path)
        units, numbers = dict.fromkeys(motion, ""), motion.__getitem__
    else:
        cells = read_table(path, decimal_comma)
        units, numbers, lines, is_named = cells.units, cells.numbers, cells.lines, cells.is_named
        remarks = cells.missing()
    units = units | (column_units(units) if is_listed else {})
    return Record(number, path.stem, str(path), units, numbers, lines, is_named, False, remarks)


def _is_parquet(path: Path) -> bool:
    """Return True for a regular file that begins as Parquet. Raises OSError."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(PARQUET)) == PARQUET


def _open_parquet(path: Path) -> tuple[dict[str, str], Callable[[str], Floats]]:
    """Return units of the columns of a Parquet file, and their reader.

    Raises OSError or ValueError.
    """
    import pyarrow.parquet as pq

    rows, schema = pq.read_metadata(path).num_rows, pq.read_schema(path)
    if 8 * rows > MAX_BYTES:
        raise ValueError(f"it has {rows} rows; allowed are at most {MAX_BYTES // 8}")

    metadata = {field.name: field.metadata or {} for field in schema}
    units = {name: entry.get(b"unit", b"").decode("utf-8", "replace") for name, entry in metadata.items()}
    return units, lambda name: _numbers_of(read_columns(path, [name]))(name)


def _readable(path: Path, read: Callable[[], Read]) -> Read:
    """Return the outcome of reading a file.

    Raises InputError for a file that cannot be read.
    """
    try:
        return read()
    except FileNotFoundError:
        allowed = "the file or folder does not exist; allowed are result folders and files with named columns"
        raise InputError("RESULT", str(path), allowed) from None
    except (OSError, ValueError, csv.Error) as error:
        if isinstance(error, OSError) and error.errno in MACHINE_FAULTS:
            raise
        why = getattr(error, "strerror", None) or error
        advice = "" if "allowed" in str(why) else "; allowed is a file with named columns"
        raise InputError("RESULT", str(path), f"{why}{advice}") from None


def _time_as_t(name: str) -> str:
    """Return "t" for a name of time."""
    return TIME if name.lower() in TIMES else name


def _by_own_names(record: Record, mapped: Collection[str]) -> dict[str, str]:
    """Return names of a record by those of this program.

    They are not mapped. Remarks in brackets are no part of the latter. Raises InputError for two columns of one name.
    """
    bare = {name: _time_as_t(REMARK.sub("", name).strip()) for name in record.units}
    standard, by_name = {TIME, *column_units(bare.values())} - {*mapped}, dict[str, str]()
    for name in sorted(record.units, key=lambda name: name != bare[name]):  # those without a remark first
        ours = bare[name]
        if ours in standard and by_name.setdefault(ours, name) not in (ours, name):
            names = f'"{by_name[ours]}" and "{name}"'
            allowed = f'it has two columns {ours}, {names}; allowed is one, or --columns "{ours}={name}"'
            raise InputError("RESULT", record.place, allowed)
    return by_name


def _theirs(record: Record, theirs: str, alone: bool) -> Choice | None:
    """Return the column of a record that a mapping names.

    It is a name, or the number of a column without one. None for other columns.
    """
    match, names = THEIRS.fullmatch(theirs), [*record.units]
    if theirs in names:
        return replace(_choice(record, theirs), is_mapped=True)
    plain, sign, mapped = theirs, 1.0, ""
    if match:
        plain, sign, mapped = match["name"], -1.0 if match["minus"] else 1.0, match["unit"] or ""
    plain = plain if plain in names else name_and_unit(plain)[0]
    if plain not in names and (alone or not record.is_named):
        plain = {str(k): name for k, name in enumerate(names, 1)}.get(plain, plain)
    if plain not in names:
        return None
    return replace(_choice(record, plain, mapped, alone), sign=sign, is_mapped=True)


def _choice(record: Record, name: str, mapped: str = "", alone: bool = False) -> Choice:
    """Return a column with its unit."""
    unit = record.units[name]
    stated = "file" if unit or record.is_result or (mapped and alone) else "columns" if mapped else "assumed"
    return Choice(name, 1.0, unit or mapped, stated, mapped if unit and mapped != unit else "")


def _free(record: Record, chosen: Mapping[str, Choice]) -> list[str]:
    """Return names of a record that are not chosen."""
    used = {choice.name for choice in chosen.values()} | chosen.keys()
    return [name for name in record.units if name not in used]


def _chosen(record: Record, common: Mapping[str, str], alone: Mapping[str, str]) -> dict[str, Choice]:
    """Return columns of a record by the names in the comparison.

    A column of the common mapping that is not in the file, where it has the name of this program, belongs to another
    file. The first column of a file without names is assumed to be time. Raises InputError.
    """
    mapped = {**common, **alone}
    choices = {ours: _theirs(record, theirs, ours in alone) for ours, theirs in mapped.items()}
    chosen = {ours: choice for ours, choice in choices.items() if choice}
    by_name = _by_own_names(record, chosen)
    for ours in mapped.keys() - chosen.keys():
        if ours in alone or (ours not in by_name and ours not in record.units):
            allowed = one_of(
                mapped[ours], record.units, f"{record.file} does not have this column; allowed are"
            )
            raise InputError("--columns", mapped[ours], allowed)
        by_name.setdefault(ours, ours)
    first = next(iter(record.units))
    if not chosen and not record.is_named and first == "1":
        raise InputError("RESULT", record.place, NO_NAMES)
    if (
        not record.is_named
        and TIME not in chosen | by_name
        and first not in {c.name for c in chosen.values()}
    ):
        by_name[TIME] = first
    chosen |= {ours: _choice(record, name) for ours, name in by_name.items()}
    places = {name: k for k, name in enumerate(record.units)}
    return dict(sorted(chosen.items(), key=lambda pair: places[pair[1].name]))


def _demand_used(mapping: Mapping[str, str], records: Sequence[Record]) -> None:
    """Demand a file with each column of a mapping.

    Raises InputError.
    """
    files = [record for record in records if not record.is_result]
    for theirs in mapping.values():
        if not any(_theirs(record, theirs, False) for record in files):
            names = dict.fromkeys(name for record in files for name in record.units)
            allowed = one_of(theirs, names, "no file has this column; allowed are") if names else NO_FILE
            raise InputError("--columns", theirs, allowed)


def _item(
    record: Record, chosen: Mapping[str, Choice], reference: Mapping[str, str], among: set[str]
) -> Item:
    """Read the chosen columns of a record.

    reference: units of the reference; among: names of which another record has a column. Raises InputError.
    """
    si, columns = column_units(chosen), dict[str, Floats]()
    unread = {name: record.remarks.get(name, "") for name in _free(record, chosen)}
    for ours, choice in chosen.items():
        try:
            values = _readable(Path(record.place), partial(record.numbers, choice.name))
        except InputError as error:
            if choice.is_mapped or ours in si:
                raise
            unread[ours] = error.allowed
        else:
            target = si.get(ours, reference.get(ours, choice.unit))
            columns[ours] = choice.sign * _factor(record, ours, choice, target, ours in si) * values
    _demand_sound(columns, record)
    units = {name: si.get(name, reference.get(name, chosen[name].unit)) for name in columns}
    notes = tuple(_notes(record, {ours: chosen[ours] for ours in columns if ours in among}, si))
    time = chosen[TIME]
    return Item(record.label, columns, units, record.summary, notes, time.name, time.stated, unread)


def _notes(record: Record, read: Mapping[str, Choice], si: Mapping[str, str]) -> Iterator[str]:
    """Yield what is assumed of the columns that others have, too."""
    for ours, choice in read.items():
        if choice.against:
            yield f"{record.file}: {choice.name} is in {choice.unit} by the file, not in {choice.against}."
        if ours in si and REMARK.search(choice.name) and not choice.is_mapped:
            yield f'{record.file}: {ours} is its column "{choice.name}"; the remark is not considered.'
    time = read.get(TIME)
    if time and not record.is_named and not time.is_mapped and time.name not in TIMES:
        yield f"{record.file}: its first column is assumed to be time."
    assumed = [ours for ours, choice in read.items() if choice.stated == "assumed" and si.get(ours, "?")]
    if assumed:
        yield f"{record.file}: {', '.join(assumed)} without a unit, assumed in SI."


def _factor(record: Record, ours: str, choice: Choice, target: str, is_ours: bool) -> float:
    """Return the factor from the file's unit to the target.

    A column of this program without a unit is in SI. Raises InputError for another dimension, or one unit alone.
    """
    unit = choice.unit
    if unit == target or (is_ours and not (unit and target)):
        return 1.0
    key = f"unit of {ours} of {record.label}"
    if not (unit and target):
        alone = f"{record.number if target else 1}:{ours}={choice.name}"
        has = f'"{target}"' if target else "none"
        allowed = (
            f'the reference has {has}; allowed is a unit in both files, or by --columns "{alone} [UNIT]"'
        )
        raise InputError(key, unit or Verbatim("none"), allowed)
    try:
        return ratio(unit, target)
    except ValueError as error:
        of = "" if is_ours else ", as the reference has"
        raise InputError(key, unit, f"allowed is a unit of the dimension of {target}{of}: {error}") from None


def _demand_sound(columns: Mapping[str, Floats], record: Record) -> None:
    """Demand increasing instants and moderate numbers.

    Numbers must have finite squares. Raises InputError with line or row.
    """
    place, lines = record.place, record.lines
    if TIME not in columns:
        names = one_of("time", record.units, "its columns are")
        allowed = f"it has no time column; allowed is a column t or time, or --columns time=THEIRS; {names}"
        raise InputError("RESULT", place, allowed)
    where = lambda k: f"line {lines[k]}" if lines else f"row {k + 1}"  # noqa: E731
    t = columns[TIME]
    for k in np.flatnonzero(~np.isfinite(t))[:1]:
        raise InputError("RESULT", place, f"{where(k)}: the instant is missing; allowed is a number")
    for k in np.flatnonzero(np.diff(t) <= 0.0)[:1] + 1:
        after = f"{t[k]:.7g} s after {t[k - 1]:.7g} s"
        raise InputError("RESULT", place, f"{where(k)}: time does not increase from row to row, {after}")
    for name, values in columns.items():
        for k in np.flatnonzero(np.abs(values) > nodal.LARGEST)[:1]:  # NaN, a missing value, is not larger
            allowed = f"{where(k)}, column {shortened(name)}: {values[k]:g} in SI; {nodal.ALLOWED}"
            raise InputError("RESULT", place, allowed)
