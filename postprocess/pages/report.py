"""Records that older pages share."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Result:
    """A line of a table: what, its value (number or words), unit and a remark."""

    name: str
    value: float | int | str | None
    unit: str = ""
    remark: str = ""
