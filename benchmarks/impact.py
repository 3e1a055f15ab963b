"""Accuracy and cost of whole impacts.

    .venv/bin/python benchmarks/impact.py [PART...]

Parts are the functions below that yield rows, e.g. loop_time and whole_run; all if none is named.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import command_line
import numpy as np
from command_line import spread
from process import ROOT, process

from fem.explicit.impact_loop import ImpactMeasures
from fem.model.impact_model import build_impact_model
from fem.plate.properties import ContactProperties, PlateProperties, StepProperties, UnitProperties
from fem.run.impact import FirstTouch, ImpactStepper, simulate_impact
from meshes import plate_mesh
from postprocess.report.tables import pairs
from postprocess.report.terminal import printed
from solver.impact import solve_impact
from solver.impact.many import MANY_TOLERANCE, Impacts
from tailslap.campaign.planar_ranges import impact_ranges
from tailslap.case.impact.answers import COMPARED
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.checks import energy_error
from tailslap.case.impact.run import attempt
from tailslap.scene.read import read_scene

EXAMPLES, LAWS = Path(__file__).parents[1] / "examples", ("penalty", "exact")
SCENE, TRAIN = str(EXAMPLES / "linear-truck.toml"), str(EXAMPLES / "linear-train.toml")
Row = tuple[str, str]


def bar(elements: int, law: str, **plate: Any) -> Any:
    """A bar that meets the wall head on.

    E = 900, rho = 1 and L = 10, or those of SDNV100.
    """
    values = {"thickness": 1.0, "density": 1.0, "youngs_modulus": 900.0, **plate}
    length, width = values.pop("length", 10.0), values.pop("width", 10.0 / elements)
    properties = PlateProperties(poissons_ratio=0.0, lumping="row-sum", **values)
    mesh = plate_mesh(length, width, (elements, 1))
    return build_impact_model(
        [UnitProperties(mesh, properties, ContactProperties(None, law))], StepProperties()
    )


def bounce(elements: int, law: str, periods: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Instants over tau, force over theory, energy over the first.

    Theory is rho c (v0 + g t), at small strains.
    """
    model, gravity, tau = bar(elements, law), 1e-3, 1.0 / 3.0
    step, stepper = model.parameters.time_step, ImpactStepper(model)
    state = stepper.at_touch(FirstTouch(math.pi / 2.0, 0.0, 0.0))
    state.positions[1] += 5e-4
    instants: list[tuple[float, float]] = []
    for _ in range(round(16.0 * tau * periods / step)):
        state.velocities[1] -= gravity * step
        rows, _, state = stepper.record(state, 1, 1)
        values = dict(zip(ImpactMeasures._fields, rows[0], strict=False))
        energy_of_plate = sum(values[name] for name in ("kinetic_energy", "strain_energy", "contact_energy"))
        instants.append((values["normal_impulse"], energy_of_plate + gravity * model.mass * values["y_g"]))
    impulse, energy = np.array(instants).T
    t = step * np.arange(1, impulse.size + 1)
    force = np.diff(impulse, prepend=0.0) / step / (30.0 * gravity * t * 10.0 / elements)
    return t / tau, force, energy / energy[0] - 1.0


def bouncing_bar() -> Iterator[Row]:
    """Contact times of two periods, energy and noise over ten."""
    for law in LAWS:
        t, force, _ = bounce(100, law, 2.0)
        contacts = []
        for low, high in ((1.5, 6.5), (9.5, 14.5)):
            pressed = t[(t > low) & (t < high) & (force > 1e-9)]
            contacts.append(f"{pressed[0]:.3f} to {pressed[-1]:.3f}")
        inside = (t > 3.2) & (t < 4.8)
        yield f"bouncing bar, {law}: contact over tau (3 to 5, 11 to 13)", ", ".join(contacts)
        noise = f"{force[inside].mean() - 1.0:+.1e}, noise {force[inside].std():.1e}"
        yield f"bouncing bar, {law}: force over theory - 1", noise
        ends = [abs(_end(n, law) - 5.0) for n in (25, 50, 100, 200)]
        order = np.polyfit(np.log([25, 50, 100, 200]), np.log(ends), 1)[0]
        yield f"bouncing bar, {law}: order of the end of contact", f"{-order:.2f}"
        energy = bounce(50, law, 10.0)[2]
        text = f"{energy.max():+.1e}, {energy[-1]:+.1e}"
        yield f"bouncing bar, {law}: energy, ten periods: most, last", text


def _end(elements: int, law: str) -> float:
    t, force, _ = bounce(elements, law, 0.4)
    return float(t[(t < 6.0) & (force > 0.5)][-1])


def striking_bars() -> Iterator[Row]:
    """Pressure and time of contact of a bar, and SDNV100."""
    steel = {"thickness": 0.02, "density": 8000.0, "youngs_modulus": 2e11, "length": 0.2, "width": 0.02}
    bars: Any = ("bar", {}, 1e-3, 30.0, 10.0), ("SDNV100", steel, 1.0, 5000.0, 0.2)
    for name, plate, speed, wave, length in bars:
        for law in LAWS:
            errors = []
            for elements in (50, 100, 200):
                model = bar(elements, law, **plate)
                touch = FirstTouch(math.pi / 2.0, 0.0, -speed)
                run = simulate_impact(model, touch, model.parameters.time_step, 3.0 * length / wave)
                t, force = run.history["t"], run.history["force_normal"]
                errors.append(t[force > 0.5 * force.max()][-1] * wave / (2.0 * length) - 1.0)
            area = plate.get("width", 10.0 / 200) * plate.get("thickness", 1.0)
            middle = (t * wave > 0.2 * length) & (t * wave < 1.8 * length)
            expected = plate.get("density", 1.0) * wave * speed * area
            pressure = force[middle].mean() / expected - 1.0
            listed = ", ".join(f"{error:+.1e}" for error in errors)
            yield f"{name}, {law}: force; time of contact (50, 100, 200)", f"{pressure:+.1e}; {listed}"


def rigid_limit() -> Iterator[Row]:
    """The rigid impact with k to infinity against Stage 1."""
    from solver import RectangularBody, corner_impulse
    from solver.impact import CrushLaw, ImpactVehicle, WallContact, first_touch, solve_impact

    size, angle, speed, friction = (10.0, 2.438, 9979.0), math.radians(15.0), 25.034, 0.47
    for e in (0.05, 0.22, 0.9):
        exact = corner_impulse(RectangularBody(*size), speed, angle, friction, e, convention="newton").omega
        velocities = []
        for k in (1e10, 4e10):
            vehicle = ImpactVehicle(*size)
            contact = WallContact(CrushLaw(k, 0.0, e), friction)
            touch = first_touch(vehicle, angle, speed)
            first = solve_impact(vehicle, contact, touch, end=0.01, tolerance=1e-9)
            velocities.append(first.end.omega)
        limit = 2.0 * velocities[1] - velocities[0]  # what is left goes with the duration, 1/sqrt(k)
        yield f"rigid, k to infinity, e = {e}: omega over newton - 1", f"{limit / exact - 1.0:+.1e}"


def against_rigid() -> Iterator[Row]:
    """FE against the rigid vehicle, conservation, and time."""
    outcomes = []
    for modulus in ("2e11", "8e11", "3.2e12"):
        plan = ImpactCase(*read_scene(SCENE, (f"plate.youngs_modulus={modulus}",)))
        outcomes.append(attempt(plan))
    first, four, sixteen = (outcome.difference for outcome in outcomes)
    for k in (1, 2):
        listed = ", ".join(f"{first[f'strike_{k}.{name}']:+.2e}" for name in COMPARED)
        yield f"FE at 200 GPa over rigid - 1, strike {k}: {', '.join(COMPARED)}", listed
        limit = [(4.0 * sixteen[n] - four[n]) / 3.0 for n in (f"strike_{k}.{name}" for name in COMPARED)]
        yield "the same, extrapolated to a rigid plate", ", ".join(f"{value:+.1e}" for value in limit)
    outcome = outcomes[0]
    h, mass, touch = outcome.run.history, outcome.fe_plan.model.mass, outcome.fe_plan.case.touch
    across = np.abs(mass * (h["v_gy"] - touch.v_gy) - h["normal_impulse"]).max() / (mass * 25.0)
    along = np.abs(mass * (h["v_gx"] - touch.v_gx) - h["tangential_impulse"]).max() / (mass * 25.0)
    own_spin = h["angular_momentum"] - h["moment_impulse"]
    spin = np.abs(own_spin - own_spin[0]).max() / np.abs(h["angular_momentum"]).max()
    text = f"{across:.0e}, {along:.0e}, {spin:.0e}"
    yield "momentum across, along, angular, against the wall's force", text
    energy = np.abs(energy_error(outcome)).max() / (0.5 * mass * 25.034**2)
    yield "energy with crush and friction, over the initial", f"{energy:.0e}"


def loop_time() -> Iterator[Row]:
    """FE impacts of the truck and of the train."""
    for what, scene, end in (("impact", SCENE, 0.7), ("train", TRAIN, 1.2)):
        plan = ImpactCase(*read_scene(scene, (f"time.end={end}",)))
        elements = plan.plan().model.parameters.table.connectivity.shape[1]
        times = [attempt(plan).run.time_loop_s for _ in range(9)]
        yield f"FE {what}, {elements} elements, {end} s: loop and records", f"{spread(times)} s, 9 runs"


def rigid_trains() -> Iterator[Row]:
    """One rigid train, and samples of `study uncertainty`."""
    plan = ImpactCase(*read_scene(TRAIN, ("time.end=1.2",)))
    arguments = plan.vehicle, plan.contact, plan.touch, 1.2
    times = [_processor(lambda: solve_impact(*arguments, trailers=plan.trailers))[0] for _ in range(12)][1:]
    yield "rigid train, 1.2 s", f"{1e3 * statistics.median(times):.0f} ms ({1e3 * min(times):.0f} least)"
    inputs = _drawn(plan, 512)
    random = np.random.default_rng(2)
    for low, high in ((0.02, 0.1), (0.1, 0.4)):
        inputs["contact.restitution"] = random.uniform(low, high, 512)
        seconds, impacts = _processor(lambda: plan.impacts(inputs, interval=5e-4))
        yield f"512 rigid trains, restitution {low:g} to {high:g}", f"{1e3 * seconds / 512:.2f} ms each"
        few = {key: values[:128] for key, values in inputs.items()}
        errors = _both_errors(_true_errors(plan, few, impacts), impacts.error[:128])
        yield "  error of the largest strike; stated", errors


def rigid_samples() -> Iterator[Row]:
    """Processor time and errors of impact-mash-tl4-sut with all inputs."""
    plan = ImpactCase(*read_scene("impact-mash-tl4-sut"))
    inputs = _drawn(plan, 512)
    times = [_processor(lambda: plan.many(inputs))[0] for _ in range(6)][1:]  # the first compiles
    seconds = min(times) / 512
    yield (
        "an impact with all inputs",
        f"{1e3 * seconds:.2f} ms ({1e3 * statistics.median(times) / 512:.2f} median)",
    )
    yield "100 000 of them, two cores; asked: 12 s", f"{0.5e5 * seconds:.0f} s"
    impacts = plan.impacts(inputs, interval=5e-4)
    few = {key: values[:128] for key, values in inputs.items()}
    errors = _both_errors(_true_errors(plan, few, impacts), impacts.error[:128])
    yield "error of the largest strike; stated", errors


def _drawn(plan: ImpactCase, samples: int) -> dict[str, np.ndarray]:
    """Draw samples of the ranges of `study uncertainty`."""
    random = np.random.default_rng(1)
    return {item.key: random.uniform(item.lower, item.upper, samples) for item in impact_ranges(plan)}


def _true_errors(plan: ImpactCase, inputs: dict[str, np.ndarray], impacts: Impacts) -> np.ndarray:
    """Largest change of the largest strike at a finer tolerance.

    Of peak and impulse, in the first samples.
    """
    fine, errors = plan.impacts(inputs, tolerance=MANY_TOLERANCE / 64.0), []
    for i in range(fine.error.size):
        coarse, exact = impacts.impulse[:, i], fine.impulse[:, i]
        k, j = np.nanargmax(coarse), np.nanargmax(exact)
        peak = abs(impacts.peak_force[k, i] / fine.peak_force[j, i] - 1.0)
        errors.append(max(peak, abs(coarse[k] / exact[j] - 1.0)))
    return np.array(errors)


def _both_errors(true: np.ndarray, stated: np.ndarray) -> str:
    """Median and largest true and stated errors, and the number above."""
    above = f"{np.count_nonzero(true > stated)} of {true.size} above"
    return f"{np.median(true):.0e}, most {max(true):.0e}; {np.median(stated):.0e}, {max(stated):.0e}; {above}"


def _processor(call: Callable[[], Any]) -> tuple[float, Any]:
    """Return the processor time of a call [s] and its answer."""
    began = time.process_time()
    result = call()
    return time.process_time() - began, result


def whole_run() -> Iterator[Row]:
    """Processor time of the train's run in its own process."""
    for what, changes in (("without stated error", ("verify.companion=false",)), ("with stated error", ())):
        command = (
            "run",
            TRAIN,
            "--no-pictures",
            *(f"--set={change}" for change in ("time.end=1.2", *changes)),
        )
        times = [process(ROOT, command).processor for _ in range(6)][1:]  # the first compiles
        yield f"FE train, 1.2 s, whole run {what}", f"{spread(times)} s"


def meshes() -> Iterator[Row]:
    """Peaks and impulses on three meshes, at 200 GPa and 8 Hz."""
    soft = ("plate.first_frequency=8 Hz", "plate.youngs_modulus=")
    for name, changes in (("200 GPa", ()), ("8 Hz", soft)):
        rows = []
        for mesh in ("[20, 6]", "[40, 12]", "[80, 24]"):
            keys = (*changes, "contact.patch_length=1", f"plate.elements={mesh}", "time.end=0.46")
            outcome = attempt(ImpactCase(*read_scene(SCENE, keys)))
            rows.append([v for s in outcome.fe.strikes[:2] for v in (s.peak_force, s.impulse)])
        coarse, middle, fine = np.array(rows)
        orders = np.log2(np.abs(coarse - middle) / np.abs(middle - fine))
        last = ", ".join(f"{value:.1e}" for value in np.abs(fine / middle - 1.0))
        text = f"{', '.join(f'{order:.1f}' for order in orders)}; {last}"
        yield f"meshes, {name}: order of peak, impulse, each strike; last change", text


def filters() -> Iterator[Row]:
    """CFC gain at CFC/0.6, and the mean of a half sine."""
    from postprocess.signals.filters import cfc_filter, moving_mean

    for interval in (1e-4, 5e-5):
        t = interval * np.arange(40_000)
        for frequency_class in (60, 180):
            wave = np.sin(2.0 * math.pi * frequency_class / 0.6 * t)
            passed = cfc_filter(wave, interval, frequency_class)[5000:-5000]
            gain = passed.std() / wave[5000:-5000].std()
            name = f"CFC {frequency_class} at {1e-3 / interval:.0f} kHz: gain at CFC/0.6, times sqrt 2, - 1"
            yield name, f"{gain * math.sqrt(2.0) - 1.0:+.1e}"
    half, edges = 0.1, 1e-5 * np.arange(30_001)
    inside = np.clip((edges - 0.1) / half, 0.0, 1.0)
    force = np.diff((1.0 - np.cos(math.pi * inside)) * half / math.pi) / 1e-5
    exact = 2.0 * half / (math.pi * 0.05) * math.sin(math.pi * 0.05 / (2.0 * half))
    difference = moving_mean(force, 1e-5, 0.05).max() / exact - 1.0
    yield "50 ms mean of a half sine of 100 ms over the formula - 1", f"{difference:+.1e}"


FUNCTIONS = (filters, rigid_limit, against_rigid, loop_time, whole_run, rigid_trains, rigid_samples)
PARTS = {part.__name__: part for part in (*FUNCTIONS, striking_bars, bouncing_bar, meshes)}

if __name__ == "__main__":
    for name in command_line.options(__doc__, ("parts", PARTS)).parts:
        print(printed([pairs(list(PARTS[name]()))]), flush=True)
