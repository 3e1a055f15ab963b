"""Findings on the forces: the sign of restitution, and Tables 4 and 5."""

from __future__ import annotations

from postprocess.report.numbers import percent
from postprocess.report.page import Finding
from tailslap.paper.forces import CHART_READING, ForceResult
from tailslap.paper.printed import FACTOR_RANGE_PLASTIC, ROW_B_GIVEN
from tailslap.paper.restitution import Restitution


def restitution_finding(cases: dict[str, Restitution]) -> Finding:
    """What the sign of restitution does to the peak force."""
    paper, newton, plastic = cases["paper"], cases["newton"], cases["e = 0"]
    return Finding(
        "Restitution enters with the sign that softens the impact: (1 - e), not (1 + e)",
        "The corner's velocity across the wall after Stage 1 was taken from Eq 21, and all three stages were "
        "repeated with a corner that rebounds (Newton's restitution).",
        (
            f"In Eqs 24 and 31 the corner goes on into the wall at {abs(paper.corner_recoil):.3f} m/s after the "
            f"impact; with Newton's restitution it leaves it at {newton.corner_recoil:.3f} m/s. Stage 2 starts "
            "without that velocity either way.",
            f"Peak force for Δt = 0.1 s: {paper.peak_force / 1e3:.0f} kN as printed, {newton.peak_force / 1e3:.0f} kN "
            f"with (1 + e), {percent(newton.change, 1)}; ω_0 = {paper.omega:.3f} and {newton.omega:.3f} rad/s. "
            f"For e = 0 both give {plastic.peak_force / 1e3:.0f} kN, {percent(plastic.change, 1)}.",
            "Section 3.2 calls the forces for e = 0 extremely conservative; with (1 + e) they are the lower bound.",
        ),
        (
            "tailslap rigid mash-tl4-sut",
            "tailslap rigid mash-tl4-sut --set impact.convention=newton",
            "tailslap rigid mash-tl4-sut --set impact.restitution=0",
        ),
    )


def ratios_finding(table_4: tuple[ForceResult, ...], table_5: tuple[ForceResult, ...]) -> Finding:
    """F(e = 0)/F(e = 0.22), row by row; rows a to e of Table 5 are those of Table 4."""
    seen = [*table_4, table_5[-1]]
    rounding = [_ratio(result) for result in seen if result.rounds]
    near = [_ratio(result) for result in seen if not result.rounds and _near(result)]
    far = [result for result in seen if not _near(result)]
    rows = sorted({result.printed.row for result in far})
    impulses = ", ".join(f"{result.printed.row} {result.impulse / 1e3:.2f}" for result in table_4)
    return Finding(
        f"Rows {', '.join(rows[:-1])} and {rows[-1]} of Tables 4 and 5 do not keep the ratio of the paper's formulas",
        f"F(e = 0)/F(e = 0.22) is 1/(1 - e) = {table_4[0].ratio.computed:.4f} for any vehicle, speed, angle, friction "
        "and duration: Eq 31 makes ω_0 proportional to 1 - e, and v_GY at the tail-slap is proportional to ω_0. In "
        "brackets: exact/printed - 1.",
        (
            f"Off: {'; '.join(map(_ratio, far))}. No input was adjusted to match them.",
            f"Off by less than {100 * CHART_READING:.1f} %: {'; '.join(near)}. "
            f"Right to the rounding of the forces: {'; '.join(rounding)}.",
            f"The impulses F Δt/2 behind the forces for e = 0.22 are {impulses} kN s.",
        ),
        (
            "tailslap rigid mash-tl4-sut --set strike.duration=0.08",
            "tailslap rigid mash-tl4-sut --set strike.duration=0.08 --set impact.restitution=0",
        ),
        (
            f"Rows {', '.join(rows[:-1])} and {rows[-1]} are not from one vehicle and one impact, or not from these "
            f"formulas; the reading of charts may explain what is below {100 * CHART_READING:.1f} %.",
            "As the impulses differ, so do the rows in vehicle or impact, of which the paper gives nothing.",
        ),
    )


def _near(result: ForceResult) -> bool:
    return abs(result.ratio.difference) < CHART_READING


def _ratio(result: ForceResult) -> str:
    row = result.printed
    return f"{row.row} (Δt = {row.duration:g} s) {result.ratio.printed:.3f} ({percent(result.ratio.difference, 1)})"


def factors_finding(
    table_4: tuple[ForceResult, ...], table_5: tuple[ForceResult, ...], known: ForceResult
) -> Finding:
    """phi_a against its own row, against the text, and for Table 1's vehicle."""
    results = [*(("Table 4", result) for result in table_4), *(("Table 5", result) for result in table_5)]
    pairs = [
        (f"{name} row {result.printed.row}", printed, own)
        for name, result in results
        for printed, own in zip(result.printed.factor, result.factor_of_print, strict=True)
    ]
    off = [
        f"{place} {printed:.2f} for {own:.3f}"
        for place, printed, own in pairs
        if f"{own:.2f}" != f"{printed:.2f}"
    ]
    plastic = [result.printed.factor[1] for result in table_4]
    computed = [result.factor[0].computed for result in table_4]
    return Finding(
        "The adjustment factors follow from the printed forces, but for the last digit of some",
        "Each φ_a was divided again from the printed forces, and once more from the forces computed for Table 1's "
        "vehicle.",
        (
            f"{len(off)} of {len(pairs)} printed factors are not the rounded quotient: {'; '.join(off)}.",
            f"Section 3.2 gives {FACTOR_RANGE_PLASTIC[0]} to {FACTOR_RANGE_PLASTIC[1]} as the range for e = 0; Table 4 "
            f"holds {min(plastic):.2f} to {max(plastic):.2f}.",
            f"With Table 1's vehicle in every row, φ_a for e = 0.22 runs from {min(computed):.2f} to "
            f"{max(computed):.2f} in Table 4. Row b with the {ROW_B_GIVEN} of its test: "
            f"{known.peak[0].computed / 1e3:.0f} kN, {percent(known.peak[0].difference, 1)} to the printed force.",
        ),
        ('tailslap rigid mash-tl4-sut --set impact.speed="57.4 mph" --set impact.angle="15.4 deg"',),
    )
