"""Define errors of the input and format their messages."""

from __future__ import annotations

import difflib
import errno
import os
import shlex
import textwrap
from collections.abc import Collection, Iterable

APT_INSTALL = "apt-get install -y --no-install-recommends"
APT_PACKAGES = (  # the same names on Debian 12 and 13 and on Ubuntu 22.04 and 24.04
    "libegl1 libfontconfig1 libgl1 libglu1-mesa libgomp1 libx11-6 libxcursor1 libxext6 libxfixes3 libxft2 "
    "libxinerama1 libxrender1"
)
DNF_PACKAGES = (
    "fontconfig libgomp libX11 libXcursor libXext libXfixes libXft libXinerama libXrender mesa-dri-drivers "
    "mesa-libEGL mesa-libGL mesa-libGLU"
)
"""System libraries that gmsh and VTK load; bootstrap.py installs them."""

MACHINE_FAULTS = {
    *(errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EMFILE, errno.ENFILE),
    *(errno.ENOMEM, errno.EIO, errno.ESTALE),
}
"""Errors of the machine, not of the input: full or broken disk, lost server, limits of the process."""

ABSENT = {errno.ENOENT, errno.ENOTDIR}
"""Errors of a path at which there is nothing."""

MAX_SHOWN, LONG = 120, 160
"""Largest length of a value in a message, and length of a list above which it is wrapped."""


class InputError(Exception):
    """Invalid input.

    Attributes
    ----------
    key : str
        Dotted key of the scene, or option of the command.
    value : object
        Its value; `Missing` for an absent key.
    allowed : str
        Allowed values, or the reason of the error.
    """

    def __init__(self, key: str, value: object, allowed: str) -> None:
        self.key, self.value, self.allowed = key, value, allowed
        super().__init__(f"{shortened(key)}: given {_quoted(value)}; {allowed}")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, object, str]]:
        """Pickle the error as its three parts."""
        return type(self), (self.key, self.value, self.allowed)


class Interrupted(KeyboardInterrupt):
    """Interrupt of a command with a partial result.

    The message names it.
    """


class Missing:
    """Value of an absent key."""


class Verbatim(str):
    """Text that messages show without quotes."""


def nearest(name: str, names: Collection[str], form: str = "{}") -> str:
    """Return a hint at the known name nearest to a wrong one.

    It is "; did you mean NAME?", empty without a near name. Names that contain all words of the wrong one come
    first. form: of the name in the hint.
    """
    words = set(name.split("-"))
    candidates = [other for other in names if words <= set(other.split("-"))] if len(words) > 1 else []
    matches = difflib.get_close_matches(name, candidates or list(names), 1, 0.1 if candidates else 0.6)
    return f"; did you mean {form.format(matches[0])}?" if matches else ""


def one_of(name: str, options: Iterable[str], which: str = "allowed is one of") -> str:
    """List allowed names with the nearest one.

    A long list is on separate lines.
    """
    options = list(options)
    names = " " + ", ".join(options)
    if len(names) > LONG:
        names = "\n" + textwrap.fill(names, 78, subsequent_indent=" ", break_on_hyphens=False)
    return f"{which}{names}{nearest(name, options)}"


def demand_encodable(key: str, text: str) -> None:
    """Raise InputError for text that files of results cannot contain."""
    try:
        is_encodable = b"\0" not in text.encode()
    except UnicodeEncodeError:
        is_encodable = False
    if not is_encodable:
        raise InputError(key, text, "allowed is text in UTF-8 without null characters")


def place_error(place: object, what: str, error: OSError, key: str = "--out") -> Exception:
    """Return the error for an unwritable result.

    It is an InputError, or an OSError for a fault of the machine.
    """
    if error.errno in MACHINE_FAULTS:
        return OSError(error.errno, f"{what}: {error.strerror}", str(place))
    return InputError(key, str(place), f"{what}: {error.strerror or error}")


def machine_fault(error: OSError) -> str:
    """Return the message of an OSError."""
    where = f": {shortened(str(error.filename))}" if error.filename else ""
    return f"{error.strerror or error}{where}"


def is_there(path: str | os.PathLike[str]) -> bool:
    """Return True where there is a file, a folder or a link.

    Raises OSError where the system does not answer.
    """
    try:
        os.lstat(path)
    except ValueError:  # of a null character
        return False
    except OSError as error:
        if error.errno not in {*ABSENT, errno.ENAMETOOLONG}:
            raise
        return False
    return True


def import_fault(error: ImportError) -> str:
    """Return the message for a missing library.

    The packages of a missing system library follow.
    """
    if ".so" not in str(error):
        return f"{error}\n`python3 bootstrap.py` in the checkout installs missing packages"
    return f"{error}\nas root: {APT_INSTALL} {APT_PACKAGES}\nor: dnf install -y {DNF_PACKAGES}"


def escaped(text: str) -> str:
    """Return text with escape sequences for unprintable characters.

    Line feeds stay.
    """
    return "".join(letter if letter.isprintable() or letter == "\n" else _escape(letter) for letter in text)


def typed_command(*more: str) -> str:
    """Return the command line of this process.

    It has the additional arguments at its end, is quoted for a shell, and is "" outside a command.
    """
    import click

    context = click.get_current_context(silent=True)
    return shlex.join(["tailslap", *context.find_root().obj, *more]) if context else ""


def shortened(text: str) -> str:
    """Return text of at most MAX_SHOWN characters on one line, escaped."""
    text = text if len(text) <= MAX_SHOWN else text[: MAX_SHOWN - 3] + "..."
    return escaped(text).replace("\n", "\\n")


def _escape(letter: str) -> str:
    """Return the escape sequence of a character."""
    return letter.encode("unicode_escape", "backslashreplace").decode("ascii")


def _quoted(value: object) -> str:
    """Return a value as text for messages.

    Texts are in quotes.
    """
    if value is Missing:
        return "no value"
    if isinstance(value, str) and not isinstance(value, Verbatim):
        return f'"{shortened(value)}"'
    try:
        return shortened(str(value))
    except (ValueError, RecursionError):  # Python prints no integer of more than 4 300 digits
        return f"a {type(value).__name__} of too many digits"
