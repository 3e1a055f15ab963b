"""The study in words: what was found, and how."""

from __future__ import annotations

from tailslap.studies.features.costs import FEWEST_ROWS, ROWS, SETUP_TURNS, Costs
from tailslap.studies.features.loops import CHUNK_S
from tailslap.studies.features.parts import ONE_POINT
from tailslap.studies.features.processes import TURNS
from tailslap.studies.features.proof import COSTS, FREE, SAME, Proof
from tailslap.studies.features.timing import CONFIDENCE, RESAMPLES, Ratio


def headline(costs: Costs) -> str:
    """The conclusion, and the dearest part."""
    dearest = max((cost for cost in costs.costs if cost.ratio), key=lambda cost: cost.ratio.median)  # type: ignore[union-attr]
    assert dearest.ratio is not None
    return (
        f"{conclusion(costs.proof)} Of the parts, {dearest.part.name} costs most: "
        f"{ratio_words(dearest.ratio)} times the loop without it."
    )


def conclusion(proof: Proof) -> str:
    """One plain sentence: does a part left out cost time?"""
    measured = (
        f"the program's loop takes {ratio_words(proof.program)} times a loop that never had the parts, "
        f"and {ratio_words(proof.noise)} times itself"
    )
    if not proof.same:
        apart = f"{proof.difference:.1e} of the plate's length after {proof.steps} steps"
        return f"FAILED: the two loops do not compute the same, they differ by {apart}."
    if proof.verdict == FREE:
        return f"A part left out costs no measurable time: {measured}."
    if proof.verdict == COSTS:
        return f"FAILED: a part left out costs measurable time: {measured}."
    return f"This machine is too noisy to tell whether a part left out costs time: {measured}."


def ratio_words(ratio: Ratio) -> str:
    """A ratio with its interval."""
    form = ".3f" if ratio.high < 2.0 else ".3g"
    return f"{ratio.median:{form}} ({ratio.low:{form}} to {ratio.high:{form}})"


def statements(costs: Costs) -> tuple[str, ...]:
    """What a reader must know beside the numbers."""
    proof = costs.proof
    made = [
        f"All loops take turns, forwards and backwards, {costs.turns} times, each for about {1e3 * CHUNK_S:.0f} ms on "
        f"the scene's {costs.elements} elements from its start; ratios are taken turn by turn, and the intervals are "
        f"{CONFIDENCE:g} % of {RESAMPLES} bootstrap resamples of their median. Compiling, or loading what was compiled "
        f"before, is not in them: it took {sum(cost.compile_s for cost in costs.costs):.2f} s in all.",
        "Each part is added alone to the plain scene: internal forces, penalty spring, drift, and the sums from which "
        f"the ledger is made. Hourglass control is held against {ONE_POINT} without it, whose numbers mean nothing "
        "but time.",
        "Threads wait for each other by spinning: on few elements, or on busy cores, they are slower than one.",
        "The bare loop has no code for friction, damping, dashpot, hourglass control, patch or sums; its source is "
        f"tailslap/studies/features/bare.py. After {proof.steps} steps its positions differ by {proof.difference:.1e} "
        f"of the plate's length from the program's ({SAME:g} is allowed).",
        f"The proof fails if the whole interval is above {proof.limit:.3f}: 5 %, or what the same loop differs from "
        "itself.",
        f"From {FEWEST_ROWS} to {ROWS} rows of the history the ledger adds {ratio_words(costs.history.loop_share)} "
        "times the whole time loop of the plain scene.",
        f"Set-up is the best of {SETUP_TURNS}; whole commands are run {TURNS} times in fresh processes, and once more "
        "for their imports, of which Python's own report says where the time goes.",
        *(f"Left out: {name}. {why}" for name, why in costs.refused),
    ]
    return tuple(made)
