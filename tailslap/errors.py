"""The one error by which wrong input reaches the user."""

from __future__ import annotations


class InputError(Exception):
    """Wrong input.

    Attributes
    ----------
    key : str
        Dotted key of the scene, or an option of the command.
    given : object
        Its value; `Missing` where there is none.
    allowed : str
        What is allowed instead.
    """

    def __init__(self, key: str, given: object, allowed: str) -> None:
        self.key, self.given, self.allowed = key, given, allowed
        super().__init__(f"{key}: given {_shown(given)}; {allowed}")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, object, str]]:
        """It travels between processes with what it was made of."""
        return type(self), (self.key, self.given, self.allowed)


class Interrupted(KeyboardInterrupt):
    """An interrupt after which something is kept; the message says what."""


class Missing:
    """Stands for a value that was not given at all."""


class Verbatim(str):
    """Text that is shown as it stands, without quotes."""


def _shown(given: object) -> str:
    if given is Missing:
        return "nothing"
    text = f'"{given}"' if isinstance(given, str) and not isinstance(given, Verbatim) else str(given)
    return text if len(text) <= 120 else text[:117] + "..."
