"""Cases of scenes, each made and solved once a process."""

import functools
from pathlib import Path
from typing import Any

from tailslap.case import case_of
from tailslap.scene.read import read_scene, read_source
from tailslap.scene.vary import vary

EXAMPLES = Path(__file__).parents[1] / "examples"
LINEAR_TRUCK, LINEAR_TRAIN = (str(EXAMPLES / f"linear-{name}.toml") for name in ("truck", "train"))


@functools.cache
def case(name: str, *changes: str) -> Any:
    """Return the case of a scene, which all tests share."""
    return case_of(*read_scene(name, changes))


def changed(scene: str, **changes: Any) -> Any:
    """Return the case of a scene with values by keys.

    "__" in place of a dot.
    """
    return case_of(*vary(read_source(scene), {key.replace("__", "."): x for key, x in changes.items()}))
