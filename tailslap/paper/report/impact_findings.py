"""Findings on the whole impact: what Stages 1 to 3 assume of the contact, against a wall that only pushes."""

from __future__ import annotations

from postprocess.report.numbers import percent
from postprocess.report.page import Finding
from tailslap.paper.printed import PULSE, RESTITUTION
from tailslap.paper.review import Reaction
from tailslap.paper.whole_impact import NEARLY_RIGID, StiffnessCase, WholeImpact

SCENE = "tailslap rigid impact-mash-tl4-sut"
CHECKED = (
    "The whole impact of Table 1's truck, rigid, with e = 0.22 and μ_k = 0.47, was solved from event to event: corners "
    "that crush, a wall that only pushes"
)
MOTION = (
    "from solver.impact import *; m = solve_impact(ImpactVehicle(10, 2.438, 9979), "
    "WallContact(CrushLaw({:g}, 0, 0.22), 0.47), first_touch(ImpactVehicle(10, 2.438, 9979), 0.2617993878, 25.03424)"
)


def _set(case: StiffnessCase) -> str:
    return f'{SCENE} --set contact.stiffness="{case.stiffness / 1e6:g} MN/m"'


def _commands(found: WholeImpact) -> tuple[str, ...]:
    return tuple(_set(case) for case in found.cases)


def _stiffnesses(found: WholeImpact) -> str:
    *first, last = (f"{case.stiffness / 1e6:g}" for case in found.cases)
    return f"{', '.join(first)} and {last} MN/m"


def rebound_finding(found: WholeImpact) -> Finding:
    """The paper's 1 - e against the crush law's rebound."""
    paper, newton = found.omegas["paper"], found.omegas["newton"]
    after = ", ".join(f"{case.omega:.4f}" for case in found.cases)
    end = MOTION.format(NEARLY_RIGID)
    return Finding(
        "A corner that gives back e² of its energy leaves the first strike with Newton's 1 + e",
        f"{CHECKED}. ω after the first strike was held against Stage 1 with (1 - e), Eq 24, and with (1 + e).",
        (
            f"ω = {after} rad/s for a crush stiffness of {_stiffnesses(found)}, and {found.nearly_rigid:.4f} rad/s for "
            f"{NEARLY_RIGID / 1e6:g} MN/m.",
            f"(1 + e) gives {newton:.4f} rad/s; Eq 24, with (1 - e), {paper:.4f} rad/s, "
            f"{percent(paper / newton - 1.0, 1)}.",
        ),
        (
            f"python -c '{end}, 0.05); print(m.end.omega)'",
            "tailslap rigid mash-tl4-sut",
            "tailslap rigid mash-tl4-sut --set impact.convention=newton",
        ),
        ("Stage 2 of the paper starts with too small a rotation for any contact that rebounds.",),
    )


def push_finding(found: WholeImpact, reaction: Reaction) -> Finding:
    """Without a wall that pulls the corner leaves, and comes back."""
    gaps = ", ".join(f"{1e3 * case.gap:.0f}" for case in found.cases)
    middle = found.cases[len(found.cases) // 2]
    starts = ", ".join(f"{case.rear_start:.4f}" for case in found.cases)
    backs = ", ".join(f"{case.back:.4f}" for case in found.cases)
    command = MOTION.format(middle.stiffness)
    return Finding(
        "On a wall that only pushes the front corner leaves, and the rear corner strikes earlier",
        f"{CHECKED}. Distance of the front corner from the wall after the first strike, and instants of strikes.",
        (
            f"The front corner leaves at {', '.join(f'{case.released:.4f}' for case in found.cases)} s, for "
            f"{_stiffnesses(found)}, and is up to {gaps} mm off before the rear corner strikes at {starts} s. "
            f"It touches again at {backs} s, after the rear corner.",
            f"Stage 2, whose wall pulls with {abs(reaction.first) / 1e3:.2f} to {abs(reaction.last) / 1e3:.2f} kN, has "
            f"the tail-slap at {found.paper_time:.4f} s.",
        ),
        (
            *_commands(found),
            f"python -c '{command}); f, r = m.strikes[:2]; "
            "c = m.points_at([f.end, r.start]).crush[0]; print(c[0] - c[1])'",
        ),
        (
            "The corner's sliding along the wall between the strikes, and its friction, are no part of such an impact.",
        ),
    )


def mass_finding(found: WholeImpact) -> Finding:
    """Stage 3 stops the whole mass; a corner strike brings a quarter of it at twice the speed."""
    shares = ", ".join(f"{case.share:.4f}" for case in found.cases)
    impulses = ", ".join(f"{case.rear_impulse / 1e3:.2f}" for case in found.cases)
    middle = found.cases[len(found.cases) // 2]
    return Finding(
        "Stage 3 stops the whole mass; the rear corner brings about a quarter of it, twice as fast",
        "At angle zero, about a corner that stays on the wall, the rear corner moves at v_E = 2 v_GY; a blow there "
        "meets m_eff = m/(1 + 3 L²/(L² + B²)), with friction m/(1 + 3 L (L + μ B)/(L² + B²)). Both were held against "
        f"the rear strike of the whole impact. {CHECKED}.",
        (
            f"m_eff/m = {found.share:.4f}, with friction {found.share_friction:.4f}. The rear strike's impulse over "
            f"(1 + e) m v_E is {shares} for {_stiffnesses(found)}; v_E = {middle.closing:.3f} m/s for "
            f"{middle.stiffness / 1e6:g} MN/m.",
            f"For e = 0 Stage 3 has m v_GY = {found.plastic_impulse / 1e3:.2f} kN s; the corner's m_eff v_E is "
            f"{found.corner_impulse / 1e3:.2f} kN s, {found.corner_impulse / found.plastic_impulse:.3f} of it.",
            f"The rear strike's impulse for e = {RESTITUTION:g} is {impulses} kN s; Stage 3 has "
            f"{found.paper_impulse / 1e3:.2f} kN s.",
        ),
        (
            *_commands(found),
            "python -c 'L, B, mu = 10, 2.438, 0.47; print(1 / (1 + 3 * L**2 / (L**2 + B**2)), "
            "1 / (1 + 3 * L * (L + mu * B) / (L**2 + B**2)))'",
        ),
        (
            "Two assumptions work against each other in the paper's impulse: (1 - e) makes it smaller, the whole mass "
            "larger. What is left of them depends on e, and is no property of the vehicle.",
        ),
    )


def duration_finding(found: WholeImpact) -> Finding:
    """The paper's dt against the strike itself."""
    rows = "; ".join(
        f"{case.stiffness / 1e6:g} MN/m: {1e3 * case.rear_duration:.0f}, {1e3 * case.read['mean_50ms']:.0f}, "
        f"{1e3 * case.read['cfc60']:.0f} ms"
        for case in found.cases
    )
    added = ", ".join(f"{1e3 * (case.read['mean_50ms'] - case.rear_duration):.0f}" for case in found.cases)
    middle = found.cases[len(found.cases) // 2]
    force = 2.0 * middle.rear_impulse / middle.rear_duration
    read = 2.0 * middle.rear_impulse / middle.read["mean_50ms"]
    return Finding(
        "The duration that is read off a 50 ms mean is that of the strike and the mean together",
        f"{CHECKED}. The rear strike's duration was set beside what the paper's rule, valley to valley around the "
        "second peak, reads off the 50 ms mean and the CFC 60 curve of the same force.",
        (
            f"Strike, 50 ms mean, CFC 60: {rows}. The mean adds {added} ms.",
            f"The paper reads {PULSE:g} s in most rows. 2 F2/Δt of the strike at {middle.stiffness / 1e6:g} MN/m is "
            f"{force / 1e3:.0f} kN with its own duration, {read / 1e3:.0f} kN with the one read off the mean; its raw "
            f"peak is {middle.rear_peak / 1e3:.0f} kN.",
            "The duration follows from stiffness, mass and restitution, and is no constant of a vehicle.",
        ),
        tuple(f"{command} --json" for command in _commands(found)),
        (
            "A Δt of 0.1 s off a 50 ms mean stands for a strike of about half that length; what Eq 73 makes of it lies "
            "below the raw peak.",
        ),
    )
