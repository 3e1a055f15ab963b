"""A check from outside, that the plate does not rise."""

import numpy as np

from tailslap.case.check import CheckKind, Evaluation
from tailslap.case.corner.corner_checks import CHECKS
from tailslap.case.corner.outcome import CornerOutcome


def rise(outcome: CornerOutcome) -> Evaluation | None:
    if "height" not in outcome.history:
        return None
    risen = float(np.diff(outcome.history["height"]).max()) / outcome.fe_plan.case.body.width
    return Evaluation(risen, 0.0, "largest rise of the plate between two rows over its width")


CHECK = CheckKind("rise", rise, "less of everything")
CHECKS.register(CHECK)
