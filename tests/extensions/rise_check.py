"""A check from outside: the plate comes down, its nodes never rise in the mean."""

import numpy as np

from tailslap.case.check import CheckKind, Evaluation
from tailslap.case.corner.corner_checks import CHECKS
from tailslap.case.corner.outcome import CornerOutcome


def rise(given: CornerOutcome) -> Evaluation | None:
    if "height" not in given.history:
        return None
    risen = float(np.diff(given.history["height"]).max()) / given.fe_plan.case.body.width
    return Evaluation(risen, 0.0, "largest rise of the plate between two rows over its width")


CHECK = CheckKind("rise", rise, "less of everything")
CHECKS.register(CHECK)
