"""Records that older pages share."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """A check of the result.

    Attributes
    ----------
    name : str
        As the report shows it.
    value, limit : float
        What was found and what is allowed, in the same unit [as `name` says].
    passed : bool
        The outcome.
    meaning : str
        What it guards against.
    """

    name: str
    value: float
    limit: float
    passed: bool
    meaning: str = ""

    @classmethod
    def at_most(cls, name: str, value: float, limit: float, meaning: str) -> "Check":
        """A check that passes where the value is a finite number and not above the limit.

        Parameters
        ----------
        name, meaning : str
            As in `Check`.
        value, limit : float
            What was found, and the largest that passes [as `name` says].

        Returns
        -------
        Check
            The outcome included.
        """
        return cls(name, float(value), limit, bool(math.isfinite(value) and value <= limit), meaning)


@dataclass(frozen=True)
class Result:
    """A line of a table: what, its value (number or words), unit and a remark."""

    name: str
    value: float | int | str | None
    unit: str = ""
    remark: str = ""
