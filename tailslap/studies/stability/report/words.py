"""The map in words."""

from __future__ import annotations

from collections import Counter

from tailslap.studies.stability.survey import Survey
from tailslap.studies.stability.verdict import CAUGHT, REFUSED, WRONG

MEANINGS = {
    "right": "every check passed, and the five quantities are those of the rigid motion to the tolerance",
    "flexible": "every check passed; it differs from the rigid motion, and refined models differ likewise",
    "refused": "wrong input: a message, and no run",
    "caught": "the run failed a check of its own, and says which",
    "wrong": "it passed every check and is neither right nor confirmed by refinement",
}


def headline(found: Survey) -> str:
    """The result in two sentences."""
    counts, total = found.counts, len(found.verdicts)
    wrong = "None is" if not counts[WRONG] else f"{counts[WRONG]} are"
    return (
        f"Of {total} cells {counts['right']} are right to {found.tolerance:g}, {counts['flexible']} flexible, "
        f"{counts[REFUSED]} refused, {counts[CAUGHT]} failed and caught. {wrong} wrong without being caught."
    )


def lines(found: Survey) -> list[str]:
    """What the command prints."""
    rows = [f"{kind:<9}{count:>6}  {MEANINGS[kind]}" for kind, count in found.counts.items()]
    wrong = [
        f"WRONG  {cell.key}: {verdict.reason}"
        for cell, verdict in found.verdicts.items()
        if verdict.kind == WRONG
    ]
    head = f"{found.plan.scene.name}: {len(found.verdicts)} cells in {found.seconds:.0f} s"
    return [head, *rows, *wrong]


def failed_checks(found: Survey) -> list[tuple[str, int]]:
    """How many cells each check caught, the most first."""
    caught = [verdict.reason.split(", ") for verdict in found.verdicts.values() if verdict.kind == CAUGHT]
    return Counter(name for names in caught for name in names).most_common()


def caught_alone(found: Survey) -> dict[str, int]:
    """How many cells each check caught without help."""
    reasons = (verdict.reason for verdict in found.verdicts.values() if verdict.kind == CAUGHT)
    return dict(Counter(reason for reason in reasons if ", " not in reason))


def refusals(found: Survey) -> list[tuple[str, int]]:
    """How many cells each key refused, the most first."""
    refused = (verdict.reason for verdict in found.verdicts.values() if verdict.kind == REFUSED)
    return Counter(_without_numbers(reason) for reason in refused).most_common()


def _without_numbers(reason: str) -> str:
    """The key and what is allowed, without what was given."""
    key, _, rest = reason.partition(": given ")
    return (
        f"{key}: {rest.partition('; ')[2]}"
        if not any(c.isdigit() for c in rest.partition("; ")[2][:60])
        else key
    )
