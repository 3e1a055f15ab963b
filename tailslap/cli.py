"""Run the command `tailslap` as a process.

Messages go to standard error, results to standard output.
"""

import contextlib
import gc
import io
import logging
import os
import re
import signal
import sys
import warnings
from typing import TYPE_CHECKING, TextIO

import click

if TYPE_CHECKING:
    from typing_extensions import Buffer

# The matrices are small or sparse: BLAS threads slow them down, up to a hundredfold on busy cores.
# Set before NumPy is loaded; inherited by worker processes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Scenes use no Pydantic plugins; the search for them reads the metadata of all installed packages.
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")

# Nearly all objects of a command live until its end; with the default of 700 they are visited many times.
gc.set_threshold(400_000, 20, 10)

from machine_code.system.operating_system import ENDING  # noqa: E402
from tailslap import errors  # noqa: E402
from tailslap.commands import COMPLETE, commands  # noqa: E402
from tailslap.delivery import DONE  # noqa: E402

WRONG_INPUT, CANNOT_RUN, INTERRUPTED = 2, 3, 130
"""Exit statuses of other commands; CANNOT_RUN: the installation or the machine is insufficient."""

UNDONE = "interrupted; nothing was written, and no progress is saved"
"""Message of commands that save no progress."""

STDERR = 2

ENVIRONMENT = {"SOURCE_DATE_EPOCH": ("[0-9]{1,11}", "a whole number of seconds since 1970")}
"""Environment variables with which libraries fail on import: pattern of their values, and its description."""

FOLDERS = tuple(
    f"XDG_{name}" for name in ("CACHE_HOME", "CONFIG_HOME", "DATA_HOME", "STATE_HOME", "RUNTIME_DIR")
)
"""Environment variables that are ignored if their path is relative (XDG Base Directory Specification)."""


def main(arguments: list[str] | None = None) -> None:
    """Run a command and exit with its status."""
    open_closed_streams()
    take_signals_as_interrupts()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters shows question marks
    sys.stderr = _Messages.instead_of(sys.stderr)
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it warns of a home that cannot be written
    status = _status(arguments)
    if status == INTERRUPTED:  # the end of the interpreter restores what ends it with another status
        for number in (signal.SIGINT, *ENDING):
            signal.signal(number, signal.SIG_IGN)
    drop_unwritten()
    gc.freeze()  # the end of the interpreter visits no object; with the threshold a sixth of a run's time
    sys.exit(status)


def _status(arguments: list[str] | None) -> int:
    """Run the command and return its exit status.

    Errors become a message and an exit status.
    """
    try:
        status = _run(arguments)
        sys.stdout.flush()
        return status
    except errors.InputError as error:
        return _complain(str(error), WRONG_INPUT)
    except click.ClickException as error:
        message = io.StringIO()
        error.show(message)
        click.echo(errors.escaped(message.getvalue()), err=True, nl=False)
        return WRONG_INPUT
    except (KeyboardInterrupt, click.Abort) as error:
        cause = error.__cause__ if isinstance(error.__cause__, errors.Interrupted) else error
        return _complain(str(cause) or UNDONE, INTERRUPTED)
    except BrokenPipeError:
        return DONE
    except MemoryError:
        return _complain("insufficient memory for this mesh; reduce plate.elements", CANNOT_RUN)
    except ImportError as error:
        return _complain(errors.import_fault(error), CANNOT_RUN)
    except OSError as error:
        return _complain(errors.machine_fault(error), CANNOT_RUN)
    except Exception as error:  # a fault of the program, whose traceback is printed on demand
        from machine_code.values import TranslationError

        if isinstance(error, TranslationError):  # a law from outside
            return _complain(str(error), WRONG_INPUT)
        if os.environ.get("TAILSLAP_TRACEBACK"):
            raise
        why = f"internal error, {type(error).__name__}: {errors.shortened(str(error))}"
        return _complain(f"{why}\nTAILSLAP_TRACEBACK=1 shows the traceback; please report it", CANNOT_RUN)


def _run(arguments: list[str] | None) -> int:
    """Run the command and return its exit status.

    `commands.main` is not used: it ends with 1 where the reader of a pipe has ended.
    """
    typed = sys.argv[1:] if arguments is None else list(arguments)
    _prepare_environment()
    for text in typed:
        errors.demand_encodable("argument", text)
    if COMPLETE in os.environ:
        from click.shell_completion import shell_complete

        with contextlib.suppress(errors.InputError):  # of an unknown study, which has no completions
            return shell_complete(commands, {}, "tailslap", COMPLETE, os.environ[COMPLETE])
        return DONE
    try:
        with warnings.catch_warnings(), commands.make_context("tailslap", typed, obj=tuple(typed)) as context:
            warnings.simplefilter("always", UserWarning)
            warnings.showwarning = _remark
            status = commands.invoke(context)
    except click.exceptions.Exit as end:
        return end.exit_code
    return status if isinstance(status, int) else DONE


def _prepare_environment() -> None:
    """Drop or replace environment variables that libraries misread.

    Raises InputError for those with which they fail.
    """
    os.environ["MPLBACKEND"] = "agg"  # a command opens no windows
    for name in FOLDERS:
        if not os.path.isabs(os.environ.get(name, os.sep)):
            del os.environ[name]
    for name, (pattern, words) in ENVIRONMENT.items():
        value = os.environ.get(name)
        if value is not None and not re.fullmatch(pattern, value):
            raise errors.InputError(f"environment variable {name}", value, f"allowed is {words}; or unset it")


def _remark(message: Warning | str, *_: object, **__: object) -> None:
    """Print the first line of a warning."""
    first = str(message).strip().partition("\n")[0]  # some continue with a traceback
    click.echo(f"tailslap: remark: {errors.escaped(first)}", err=True)


def _complain(message: str, status: int) -> int:
    """Print an error message and return the status."""
    click.echo(f"tailslap: {errors.escaped(message)}", err=True)
    return status


def open_closed_streams() -> None:
    """Open closed standard streams as the null device.

    Otherwise the next opened file would take their place.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.dup2(os.open(os.devnull, os.O_RDWR), number)
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w" if number else "r"))  # noqa: SIM115


class _Messages(io.FileIO):
    """Standard error that ignores failed writes.

    On a full disk or a closed pipe messages are lost, so that no command ends or changes its status for one.
    """

    def write(self, data: "Buffer") -> int:
        """Write a message, or drop it. Returns the number of bytes."""
        try:
            return super().write(data) or 0
        except OSError:
            return memoryview(data).nbytes

    @classmethod
    def instead_of(cls, stream: TextIO) -> TextIO:
        """Return a replacement of standard error."""
        if not isinstance(stream, io.TextIOWrapper) or stream.fileno() != STDERR:
            return stream
        buffer = io.BufferedWriter(cls(STDERR, "w", closefd=False))
        return io.TextIOWrapper(buffer, stream.encoding, stream.errors, line_buffering=True)


def take_signals_as_interrupts() -> None:
    """Treat TERM and HUP as Ctrl-C.

    Its cleanup is the same then. HUP is ignored under nohup.
    """
    for number in ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, signal.default_int_handler)


def drop_unwritten() -> None:
    """Write buffered output, or drop it where it cannot be written.

    Otherwise the interpreter would print an error at its end.
    """
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):
            with contextlib.suppress(OSError, ValueError, io.UnsupportedOperation):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


if __name__ == "__main__":
    main()
