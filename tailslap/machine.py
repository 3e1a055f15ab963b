"""What this machine has: cores and memory that this process may use."""

from __future__ import annotations

import contextlib
import os
import resource
from pathlib import Path

CGROUP = Path("/sys/fs/cgroup")


def available_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0))


def available_memory() -> float:
    """Memory [bytes] that this process may still take: what is free, within the limits of its container and its own."""
    return float(min((_free(), *_container(), *_own_limit())))


def _free() -> float:
    for line in Path("/proc/meminfo").read_text().splitlines():
        if line.startswith("MemAvailable:"):
            return 1024.0 * float(line.split()[1])
    return float("inf")


def _container() -> list[float]:
    with contextlib.suppress(OSError, ValueError):
        most, used = ((CGROUP / name).read_text() for name in ("memory.max", "memory.current"))
        return [max(0.0, float(most) - float(used))]
    return []


def _own_limit() -> list[float]:
    most = resource.getrlimit(resource.RLIMIT_AS)[0]
    used = float(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    return [] if most == resource.RLIM_INFINITY else [max(0.0, most - used)]
