"""What the study of uncertainty reports."""

from __future__ import annotations

from typing import Any

from postprocess.figures.uncertainty_plots import draw_histogram, draw_sensitivity
from postprocess.report.numbers import grouped
from postprocess.report.page import Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, pairs
from tailslap.report.common import study_page, study_summary
from tailslap.studies.uncertainty.indices import RESAMPLES
from tailslap.studies.uncertainty.sampling import SEED
from tailslap.studies.uncertainty.spread import PERCENTILES, Spread, VariedInput


def spread_report(found: Spread) -> Report:
    """Page, summary, combinations, and what the terminal says."""
    inputs = sorted(found.inputs, key=lambda item: -item.total)
    table = Table((*COLUMNS, *INDICES), inputs, notes=("Below each index its 95 % confidence interval.",))
    said, name = headline(found, inputs), found.plan.scene.name
    page = study_page(
        found.plan,
        "Uncertainty of the peak force of the tail-slap, by the rigid-body method",
        said,
        (
            Section("Distribution", figures=(draw_histogram(*found.histogram),), layout="half"),
            Section("Sensitivity", figures=(draw_sensitivity(inputs),), layout="half"),
            Section("Inputs, and the share of the variance that comes from each", tables=(table,)),
            Section("Peak force", tables=(pairs(_forces(found)),), layout="half"),
            Section("What was computed, and what it means", sentences=_sentences(found), layout="half"),
        ),
        "summary.json, these numbers in SI; samples.csv, the combinations of the distribution",
    )
    short = Table((*COLUMNS[:2], *INDICES), inputs, title=f"{name}: Sobol indices of the peak force")
    cost = f"Cost:   {found.samples.combinations} combinations in {found.seconds:.2f} s"
    return Report(
        page,
        summary(found),
        (short, said, refusals(found), cost),
        histories={"samples.csv": found.columns},
    )


def _interval(ends: Any) -> str:
    return " to ".join(f"{end:.3f}" for end in ends)


COLUMNS = (
    Column("key", "Input"),
    Column("range", "Range", form=str),
    Column("origin", "From"),
    Column("value", "Scene", form=str),
)
INDICES = (
    Column("first_order", "Alone", form=".3f", below=Column("first_order_interval", "", form=_interval)),
    Column("total", "With interactions", form=".3f", below=Column("total_interval", "", form=_interval)),
)


def summary(found: Spread) -> dict[str, Any]:
    """The numbers of the study, SI; the inputs as the scene lists them."""
    samples, its = found.samples, found.distribution
    forces = {"mean": its.mean, "standard_deviation": its.standard_deviation}
    forces |= {f"percentile_{p}": x for p, x in zip(PERCENTILES, its.percentiles, strict=True)}
    forces["of_the_scene"] = float(found.plan.force.peak_force)
    return {
        **study_summary("uncertainty", found.plan),
        "seed": SEED,
        "rows": samples.force_a.size,
        "combinations": samples.combinations,
        "refused": samples.refused,
        "rows_left_out": samples.rows_left_out,
        "first_refusal": found.first_refusal or None,
        "peak_force": forces | {"histogram": {"edges": its.edges, "counts": its.counts}},
        "inputs": [vars(item) for item in found.inputs],
        "held": found.fixed,
        "cost": {"seconds": found.seconds},
    }


def _forces(found: Spread) -> list[tuple[str, float, str]]:
    its = found.distribution
    rows = [("mean", its.mean), ("standard deviation", its.standard_deviation)]
    rows += [(f"{p} % lie below", x) for p, x in zip(PERCENTILES, its.percentiles, strict=True)]
    rows.append(("of the scene's own values", float(found.plan.force.peak_force)))
    return [(name, force / 1e3, "kN") for name, force in rows]


def headline(found: Spread, inputs: list[VariedInput]) -> str:
    """The result in three sentences, or four."""
    its = found.distribution
    low, _, high = (force / 1e3 for force in its.percentiles)
    refused = (
        f"The theory refuses {_refused_share(found)} of the combinations, which are not in these numbers."
    )
    return (
        f"Mean {its.mean / 1e3:.0f} kN, standard deviation {its.standard_deviation / 1e3:.0f} kN; nine in ten "
        f"combinations lie between {low:.0f} and {high:.0f} kN. The scene's own values give "
        f"{found.plan.force.peak_force / 1e3:.0f} kN, more than {100.0 * found.share_below:.0f} % of them. The "
        f"largest part of the variance comes from {inputs[0].key}, with an index of {inputs[0].first_order:.2f}. "
        f"{refused if found.samples.refused else ''}"
    ).rstrip()


def _sentences(found: Spread) -> list[str]:
    """What a reader must know beside the numbers."""
    samples, fixed = (
        found.samples,
        f"Fixed at the scene's value: {', '.join(found.fixed)}; --range varies these too.",
    )
    return [
        f"Each input varies evenly over its range, independently of the others. {grouped(samples.force_a.size)} rows "
        f"of Sobol points, scrambled with the seed {SEED}, give {grouped(samples.combinations)} combinations; each is "
        "solved exactly by Stages 1 to 3. The same call gives the same numbers.",
        refusals(found),
        *([fixed] if found.fixed else []),
        "An index is the share of the variance that comes from an input: alone (first order), and with its "
        f"interactions (total). The 95 % intervals are a bootstrap's, of {RESAMPLES} resamples, and err on the wide "
        "side.",
        "The duration of the strike is an input of the method, which does not predict it: the peak force is that "
        "of a triangular pulse of this duration.",
    ]


def refusals(found: Spread) -> str:
    """How many combinations the theory refuses, and what became of them."""
    samples = found.samples
    if not samples.refused:
        return "The theory refuses none of the combinations."
    return (
        f"The theory refuses {grouped(samples.refused)} of {grouped(samples.combinations)} combinations "
        f"({_refused_share(found)}): they have no force, and the distribution is that of the others. "
        f"{grouped(samples.rows_left_out)} of {grouped(samples.force_a.size)} rows have one and are left out of the "
        "indices, which are then approximate, for the inputs of the rest are no longer independent. "
        f"The first: {found.first_refusal}."
    )


def _refused_share(found: Spread) -> str:
    return f"{100.0 * found.samples.refused / found.samples.combinations:.2g} %"
