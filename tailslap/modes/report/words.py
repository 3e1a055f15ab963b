"""The modes in words: on standard output, and the sentences of the page."""

from __future__ import annotations

import math
from pathlib import Path

from postprocess.pages.pages import padded
from tailslap.modes.answer import Mode, ModesAnswer

CRITERION = (
    "longitudinal and transverse modes are symmetric about the long middle line, by more than half of their kinetic "
    "energy; longitudinal ones move along the length with more than half of it. The others bend the plate: bending, "
    "or shear where more than half of the strain energy is that of shear strain."
)


def headline(answer: ModesAnswer) -> str:
    """The first frequency, and of what."""
    first = answer.modes[0]
    return f"The first elastic mode of the free plate in its plane is {name(first)}, at {first.frequency:.4g} Hz."


def name(mode: Mode) -> str:
    """Kind and number among its like: "bending 2"."""
    return f"{mode.kind} {mode.order}"


def statements(answer: ModesAnswer) -> tuple[str, ...]:
    """What was computed and how to read it."""
    plate, model, beam = answer.fe_plan.plate, answer.fe_plan.model, answer.beam
    rigid = ", ".join(f"{frequency:.0e}" for frequency in answer.found.rigid_frequencies / (2.0 * math.pi))
    return (
        f"The plate is free: no wall, no corner. {model.loop.table.connectivity.shape[1]} elements ({plate.element}), "
        f"{plate.lumping} masses, the stiffness that the run has; its three rigid modes come out at {rigid} Hz.",
        f"Kinds: {CRITERION} Bending and shear modes are numbered together.",
        f"Beam theory: a free beam of length {beam.length:g} m and depth {beam.depth:g} m. For bending it is "
        "Timoshenko's, with shear and rotary inertia; Euler and Bernoulli's without them, which holds for slender "
        f"beams, stands beside it. For longitudinal modes it is n c / (2 L) with c = {beam.wave_speed:.5g} m/s, which "
        "leaves out that the plate grows thinner where it is stretched. A plate this deep leaves both with the higher "
        "modes.",
    )


def modes_lines(answer: ModesAnswer, place: Path) -> list[str]:
    """The table as text."""
    lines = [f"{answer.fe_plan.plan.scene.name}: {headline(answer)}", ""]
    lines.append(
        f"{'':>4}{'frequency':>12}  {'kind':<16}{'beam theory':>12}{'difference':>12}{'slender':>12}"
    )
    lines.append(f"{'':>4}{'[Hz]':>12}  {'':<16}{'[Hz]':>12}{'':>12}{'[Hz]':>12}")
    lines += [
        f"{mode.number:>4}{number(mode.frequency):>12}  {name(mode):<16}{number(mode.theory):>12}"
        f"{difference(mode):>12}{number(mode.slender):>12}"
        for mode in answer.modes
    ]
    return [*lines, "", f"Report: {place / 'report.html'}"]


def number(value: float | None) -> str:
    """A frequency, or a dash."""
    return "–" if value is None else padded(value, 5)


def difference(mode: Mode) -> str:
    """Difference from beam theory in per cent, or a dash."""
    return "–" if mode.difference is None else f"{100.0 * mode.difference:+.2f} %"
