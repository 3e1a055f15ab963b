"""The one error by which wrong input reaches the user, and how what was given is shown in messages."""

from __future__ import annotations

import difflib
import errno
import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

MACHINE_FAULTS = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EMFILE, errno.ENFILE, errno.ENOMEM}
"""Faults that no other place would mend: a full disk, limits of the process."""

MAX_SHOWN = 120
"""Characters of what was given that a message shows."""


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
        super().__init__(f"{shortened(key)}: given {_shown(given)}; {allowed}")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, object, str]]:
        """Pickle the error by its three parts: workers raise it too."""
        return type(self), (self.key, self.given, self.allowed)


class Interrupted(KeyboardInterrupt):
    """Interrupt after which something is left; the message says what."""


class Missing:
    """Stands for a value that was not given at all."""


class Verbatim(str):
    """Text that is shown as it stands, without quotes."""


def nearest(name: str, known: Iterable[str], form: str = "{}") -> str:
    """Hint at the known name that is nearest to a wrong one, "; did you mean NAME?"; empty where none is near.

    form: of the name in the hint.
    """
    found = difflib.get_close_matches(name, list(known), 1)
    return f"; did you mean {form.format(found[0])}?" if found else ""


def one_of(name: str, known: Iterable[str], which: str = "allowed is one of") -> str:
    """List the names that are allowed in place of a wrong one, with the nearest; which: the words before the list."""
    known = list(known)
    return f"{which} {', '.join(known)}{nearest(name, known)}"


def named_arguments(function: Function) -> Function:
    """Decorator: a keyword argument that the function does not have raises TypeError with the nearest that it has."""
    known = inspect.signature(function).parameters

    @functools.wraps(function)
    def checked(*arguments: Any, **options: Any) -> Any:
        for name in options.keys() - known.keys():
            hint = one_of(name, known, "its arguments are")
            raise TypeError(f"{function.__name__}() has no argument {name!r}; {hint}")
        return function(*arguments, **options)

    return checked  # type: ignore[return-value]


def place_error(place: object, what: str, error: OSError, key: str = "--out") -> Exception:
    """Error to raise where a result cannot be written: wrong input, or the machine's fault as it is."""
    if error.errno in MACHINE_FAULTS:
        return OSError(error.errno, f"{what}: {error.strerror}", str(place))
    return InputError(key, str(place), f"{what}: {error.strerror or error}")


def machine_fault(error: OSError) -> str:
    """Fault of the machine, as a sentence."""
    where = f": {shortened(str(error.filename))}" if error.filename else ""
    return f"{error.strerror or error}{where}"


def escaped(text: str) -> str:
    """The text on lines of its own, with all that a terminal would not show as it stands written as an escape."""
    return "".join(letter if letter.isprintable() or letter == "\n" else _escape(letter) for letter in text)


def shortened(text: str, most: int = MAX_SHOWN) -> str:
    """No more than so many characters of a text, on one line, escaped."""
    text = text if len(text) <= most else text[: most - 3] + "..."
    return escaped(text).replace("\n", "\\n")


def _escape(letter: str) -> str:
    return letter.encode("unicode_escape", "backslashreplace").decode("ascii")


def _shown(given: object) -> str:
    if given is Missing:
        return "nothing"
    if isinstance(given, str) and not isinstance(given, Verbatim):
        return f'"{shortened(given)}"'
    try:
        return shortened(str(given))
    except (ValueError, RecursionError):  # Python prints no integer of more than 4 300 digits
        return f"a {type(given).__name__} too long to be shown"
