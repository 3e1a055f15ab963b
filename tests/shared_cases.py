"""Cases of scenes, each made and solved once a process."""

import functools
from typing import Any

from tailslap.case import case_of
from tailslap.scene.read import read_scene


@functools.cache
def case(name: str, *changes: str) -> Any:
    """Return the case of a scene, which all tests share."""
    return case_of(*read_scene(name, changes))
