"""`summary.json`: a run's numbers for other programs, SI, in strict JSON.

JSON has no infinity and no not-a-number: such a value is written as null. The check that the value belongs to
fails on its own, because no comparison with a limit holds for it.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from postprocess.report.units import SI


def write_summary(path: Path, summary: Mapping[str, Any]) -> Path:
    """Writes the mapping, nested as wished, with its own key order, indented by two."""
    path.write_text(summary_text(summary) + "\n", encoding="utf-8")
    return path


def summary_text(summary: Mapping[str, Any]) -> str:
    """The mapping as strict JSON."""
    return json.dumps(plain(summary), indent=2, allow_nan=False, ensure_ascii=False)


def plain(value: Any) -> Any:
    """The value in the types that JSON has: records as mappings, NumPy scalars and arrays unwrapped, non-finite numbers
    None."""
    if is_dataclass(value):
        value = vars(value)
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, str):
        return SI.rendered(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
