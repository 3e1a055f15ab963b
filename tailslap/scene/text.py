"""Text files that the user gives, scenes and histories."""

import codecs
import os
import stat
from pathlib import Path

UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def read_text(path: Path, most: int, undecodable: str = "strict") -> str:
    """Text of a regular file of at most so many bytes, in UTF-8 or, behind a byte order mark, UTF-16; lines end with
    line feeds. Devices and pipes are not even opened.

    undecodable: what becomes of bytes that are no text, as of `bytes.decode`.

    Raises OSError, and ValueError, saying why.
    """
    if not stat.S_ISREG(path.stat().st_mode):
        raise ValueError("it is no regular file")
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f"it is too large; allowed are {most} bytes")
    try:
        text = content.decode("utf-16" if content.startswith(UTF_16) else "utf-8-sig", undecodable)
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise ValueError("it is not text in UTF-8, nor in UTF-16 with a byte order mark")
    return text.replace("\r\n", "\n")
