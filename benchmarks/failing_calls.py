"""Calls of a process to the kernel that fail, by any library.

A function runs in a child process under a filter of seccomp, which asks the parent before each call to a file
(`seccomp_unotify(2)`, Linux 5.5 or later on x86-64). The parent names the files of the call; one chosen call returns
an error and the kernel does nothing for it.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import platform
import select
import socket
import struct
from collections.abc import Callable, Iterator
from typing import NamedTuple

ARGUMENTS = {
    "read": (0, "f"), "write": (1, "f"), "open": (2, "p"), "close": (3, "f"), "stat": (4, "p"),
    "fstat": (5, "f"), "lstat": (6, "p"), "mmap": (9, "----f"), "pread64": (17, "f"), "pwrite64": (18, "f"),
    "readv": (19, "f"), "writev": (20, "f"), "access": (21, "p"), "sendfile": (40, "ff"), "flock": (73, "f"),
    "fsync": (74, "f"), "fdatasync": (75, "f"), "truncate": (76, "p"), "ftruncate": (77, "f"),
    "rename": (82, "pp"), "mkdir": (83, "p"), "rmdir": (84, "p"), "unlink": (87, "p"), "readlink": (89, "p"),
    "chmod": (90, "p"), "getdents64": (217, "f"), "openat": (257, "dp"), "mkdirat": (258, "dp"),
    "newfstatat": (262, "dp"), "unlinkat": (263, "dp"), "renameat": (264, "dpdp"), "preadv": (295, "f"),
    "pwritev": (296, "f"), "renameat2": (316, "dpdp"), "copy_file_range": (326, "f-f"), "statx": (332, "dp"),
    "faccessat2": (439, "dp"),
}  # fmt: skip
"""Number of each call on x86-64, and its arguments: file, path, directory of the next path, anything else."""
NAMES = {number: name for name, (number, _) in ARGUMENTS.items()}

SECCOMP, NO_NEW_PRIVILEGES = 317, 38
SET_FILTER, NEW_LISTENER = 1, 8
LOAD, JUMP_IF_EQUAL, RETURN = 0x20, 0x15, 0x06
ALLOW, ASK_PARENT = 0x7FFF0000, 0x7FC00000
RECEIVE, SEND, CONTINUE = 0xC0502100, 0xC0182101, 1
QUESTION, ANSWER = struct.Struct("QIIiIQ6Q"), struct.Struct("QqiI")
"""Codes and records of linux/seccomp.h and linux/filter.h."""
LONGEST_PATH, PAGE = 4096, 4096

libc = ctypes.CDLL(None, use_errno=True)


class Call(NamedTuple):
    """Name of a call, and a file that it uses."""

    name: str
    path: str


def is_supported() -> bool:
    """Return True where the kernel has user notification, and /proc is mounted."""
    action = ctypes.c_uint32(ASK_PARENT)
    if platform.machine() != "x86_64" or not os.path.isdir("/proc/self"):
        return False
    return bool(libc.syscall(SECCOMP, 2, 0, ctypes.byref(action)) == 0)


def run_in_child(
    function: Callable[[], str], folder: str, number: int = 0, error: int = 0
) -> tuple[str, list[Call]]:
    """Run a function in a child, and return its text and calls.

    Calls are those to files below a folder. The call of this number, from 1, fails with the error, and is the last one
    of the list; without a number none fails.
    """
    ours, theirs = socket.socketpair()
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        try:
            listener = _listener()
            socket.send_fds(theirs, [b"."], [listener])
            os.close(listener)  # so that nothing waits for a parent that has died
            text = function()
        except BaseException as fault:
            text = f"{type(fault).__name__}: {fault}"
        os.write(writing, text.encode())
        os._exit(0)
    os.close(writing)
    listener = socket.recv_fds(ours, 1, 1)[1][0]
    calls: list[Call] = []
    for question in _questions(listener):
        is_over = 0 < number <= len(calls)  # what follows the failure is not looked at
        path = next((path for path in _paths(question) if path.startswith(folder)), "") if not is_over else ""
        if path:
            calls.append(Call(NAMES[question[3]], path))
        _answer(listener, question[0], error if path and len(calls) == number else 0)
    with os.fdopen(reading) as file:
        text = file.read()
    os.waitpid(child, 0)
    os.close(listener)
    ours.close()
    theirs.close()
    return text, calls


def _listener() -> int:
    """Put this thread under the filter, and return its descriptor."""
    count = len(ARGUMENTS)
    lines = [(LOAD, 0, 0, 0)]
    lines += [(JUMP_IF_EQUAL, count - i, 0, number) for i, (number, _) in enumerate(ARGUMENTS.values())]
    lines += [(RETURN, 0, 0, ALLOW), (RETURN, 0, 0, ASK_PARENT)]
    program = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *line) for line in lines))
    head = ctypes.create_string_buffer(struct.pack("HP", len(lines), ctypes.addressof(program)))
    libc.prctl(NO_NEW_PRIVILEGES, 1, 0, 0, 0)
    listener = int(libc.syscall(SECCOMP, SET_FILTER, NEW_LISTENER, head))
    if listener < 0:
        raise OSError(ctypes.get_errno(), "the filter of seccomp cannot be set")
    return listener


def _questions(listener: int) -> Iterator[tuple[int, ...]]:
    """Yield the calls about which a child asks until it ends."""
    poll = select.poll()
    poll.register(listener, select.POLLIN)
    while True:
        if any(event & select.POLLHUP for _, event in poll.poll()):
            return
        record = bytearray(QUESTION.size)
        try:
            fcntl.ioctl(listener, RECEIVE, record)
        except OSError as fault:
            if fault.errno == errno.ENOENT:  # the thread has ended
                continue
            raise
        yield QUESTION.unpack(record)


def _answer(listener: int, identity: int, error: int) -> None:
    """Let a call fail with an error, or continue without one."""
    record = bytearray(ANSWER.pack(identity, 0, -error, 0 if error else CONTINUE))
    try:
        fcntl.ioctl(listener, SEND, record)
    except OSError as fault:
        if fault.errno != errno.ENOENT:
            raise


def _paths(question: tuple[int, ...]) -> Iterator[str]:
    """Yield the absolute paths of a call's files."""
    process, arguments = question[1], question[6:]
    directory = -1
    for kind, value in zip(ARGUMENTS[NAMES[question[3]]][1], arguments, strict=False):
        file = ctypes.c_int32(value).value
        if kind == "d":
            directory = file
        elif kind == "f":
            yield _link(process, file)
        elif kind == "p":
            name = _text(process, value)
            yield name if name.startswith("/") else os.path.join(_link(process, directory), name)
            directory = -1


def _link(process: int, file: int) -> str:
    """Return the path of an open file, or the working directory."""
    try:
        return os.readlink(f"/proc/{process}/" + (f"fd/{file}" if file >= 0 else "cwd"))
    except OSError:
        return ""


def _text(process: int, address: int) -> str:
    """Return the text at an address in the memory of a process."""
    content = b""
    with open(f"/proc/{process}/mem", "rb", buffering=0) as memory:
        while b"\0" not in content and len(content) < LONGEST_PATH:
            memory.seek(address + len(content))
            content += memory.read(PAGE - (address + len(content)) % PAGE)
    return os.fsdecode(content.partition(b"\0")[0])
