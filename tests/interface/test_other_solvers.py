"""Verify decks for other solvers, and their motion in CalculiX."""

import contextlib
import json
import os
import shlex
import shutil
import signal
import subprocess
import time
from pathlib import Path

import meshio
import numpy as np
import pytest
from processes import started

from postprocess.comparison.nodal import centre_of_mass_history, read_calculix, read_nodes
from tailslap import cli
from tailslap.result.load import read_history
from tailslap.scene.read import shipped_scenes

FRICTIONLESS = "corner.reaction=none"
OWN = {
    "car": (
        "paper-table-3", "vehicle.length=4.6 m", "vehicle.width=1.8 m", "vehicle.mass=1500 kg", "impact=",
        "start.angle=0.4", "start.omega=1.9", "start.corner_speed=26 m/s",
        "plate.thickness=40 mm", "plate.density=", "plate.elements=[6,2]",
    ),
    "coach": (
        "mash-tl4-sut", "vehicle.length=13 m", "vehicle.width=2.55 m", "vehicle.mass=18 t", "impact.speed=70 km/h",
        "impact.angle=20 deg", "impact.friction=0.3", "impact.restitution=0.1", "impact.convention=newton",
        "corner.patch_length=2 m", "plate.thickness=60 mm", "plate.youngs_modulus=210 GPa",
        "plate.poissons_ratio=0.28", "plate.elements=[8,2]", "plate.distortion=0.1",
    ),
}  # fmt: skip
"""Scenes with the changes that make them other vehicles."""

needs_ccx = pytest.mark.skipif(
    not shutil.which("ccx"), reason="CalculiX is not installed (apt-get install calculix-ccx)"
)


def sets(*changes):
    """Return --set options."""
    return [word for change in changes for word in ("--set", change)]


COARSE = sets(FRICTIONLESS, "plate.elements=[4,2]")


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(*arguments):
    """Status of the command."""
    return cli._status(list(arguments))


@pytest.fixture
def solver(tmp_path_factory, monkeypatch):
    """Put a stand-in for the solver first on the path."""

    def put(script):
        program = tmp_path_factory.mktemp("fake") / "ccx"
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        monkeypatch.setenv("PATH", f"{program.parent}:{os.environ['PATH']}")

    return put


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """Folder of the coarse deck that CalculiX has run."""
    folder = tmp_path_factory.mktemp("solved") / "deck"
    assert written("export", "paper-table-3", "--to", "calculix", *COARSE, "--out", str(folder)) == 0
    command, _ = commands_of_readme(folder)
    assert subprocess.run(command, cwd=folder, capture_output=True).returncode == 0
    return folder


def commands_of_readme(folder):
    """Commands that run the deck and compare its result, in words."""
    lines = (folder / "README.md").read_text().splitlines()
    return [shlex.split(line) for line in lines if line.startswith("    ")]


def section(text, keyword):
    """Lines of numbers behind the first keyword with this beginning."""
    lines = iter(text.splitlines())
    next(line for line in lines if line.startswith(keyword))
    rows = []
    for line in lines:
        if line.startswith("*"):
            break
        rows.append([float(cell) for cell in line.split(",") if cell.strip()])
    return np.array(rows)


def test_deck_holds_the_mass_and_the_motion_of_the_rigid_body(elsewhere):
    """Density times volumes of bricks have the rectangle's mass, inertia and momenta."""
    assert written("export", "paper-table-3", "--to", "calculix", "--set", FRICTIONLESS) == 0
    folder = elsewhere / "results" / f"paper-table-3+{FRICTIONLESS}-calculix"
    names = {path.name for path in folder.glob("[!.]*")}
    assert names == {"plate.inp", "README.md", "nodes.csv", "rigid.csv"}
    text = (folder / "plate.inp").read_text()
    mesh = meshio.read(folder / "plate.inp")
    (bricks,) = (block.data for block in mesh.cells if block.type == "hexahedron")
    sides = [mesh.points[bricks[:, k]] - mesh.points[bricks[:, 0]] for k in (1, 3, 4)]
    volume = np.linalg.det(np.stack(sides, axis=1)).sum()
    assert bricks.shape == (120, 8)
    assert volume == pytest.approx(10.0 * 2.438 * 0.053, rel=1e-10)
    density = section(text, "*DENSITY")[0, 0]
    numbers, places, masses = read_nodes(folder / "nodes.csv")
    assert masses.sum() == pytest.approx(density * volume, rel=1e-10)
    assert places == pytest.approx(mesh.points[:, :2], rel=1e-10, abs=1e-10)
    velocities = np.zeros((numbers.size, 2))
    for node, direction, value in section(text, "*INITIAL CONDITIONS, TYPE=VELOCITY"):
        velocities[int(node) - 1, int(direction) - 1] = value
    centre = masses @ places / masses.sum()
    phi, radius = 0.26 + np.arctan2(2.438, 10.0), 0.5 * np.hypot(10.0, 2.438)
    assert centre == pytest.approx([-radius * np.cos(phi), radius * np.sin(phi)], rel=1e-10)
    mean = masses @ velocities / masses.sum()
    assert mean == pytest.approx([25.053 - 0.707 * radius * np.sin(phi), -0.707 * radius * np.cos(phi)])
    arm, rate = places - centre, velocities - mean
    assert arm[:, 0] * rate[:, 1] - arm[:, 1] * rate[:, 0] == pytest.approx(0.707 * (arm**2).sum(axis=1))


@needs_ccx
def test_commands_of_the_readme_run(solved, monkeypatch, capsys):
    monkeypatch.chdir(solved)
    _, compare = commands_of_readme(solved)
    assert compare[0] == "tailslap"
    assert written(*compare[1:]) == 0
    assert "All 3 histories are within the limits" in capsys.readouterr().out


def confirmed(capsys, *arguments):
    """Summary of a confirmation."""
    assert written("confirm", *arguments, "--with", "calculix", "--json") == 0
    return json.loads(capsys.readouterr().out)


def demand_agreement(summary):
    assert summary["passed"]
    for key in ("v_gy", "omega"):
        assert summary["calculix"][key] == pytest.approx(summary["rigid"][key], rel=3e-4)


@needs_ccx
def test_friction_is_omitted_and_named(elsewhere, capsys, solver, solved):
    """The exact motion is that without friction, as is the deck."""
    solver(f"cmp plate.inp {solved}/plate.inp && cp {solved}/plate.dat .")
    summary = confirmed(capsys, "paper-table-3", *sets("plate.elements=[4,2]", "corner.friction=0.3"))
    assert "Friction is omitted from both models" in summary["certainty"]
    assert summary["rigid"]["v_gy"] == pytest.approx(-3.2868596947, abs=1e-9)


@needs_ccx
@pytest.mark.long
@pytest.mark.parametrize("elements", ["10,4", "20,6"])
def test_calculix_confirms_the_paper(elements, elsewhere, capsys):
    """-3.2868596947 m/s and 0.6573719389 rad/s at the tail-slap without friction."""
    summary = confirmed(capsys, "paper-table-3", *sets(FRICTIONLESS, f"plate.elements=[{elements}]"))
    demand_agreement(summary)
    assert summary["calculix"]["v_gy"] == pytest.approx(-3.2868596947, rel=3e-4)
    assert summary["calculix"]["omega"] == pytest.approx(0.6573719389, rel=3e-4)
    folder = elsewhere / "results" / f"paper-table-3+{FRICTIONLESS}+plate.elements={elements}-confirm"
    history = read_history((folder / "calculix.csv").read_bytes())
    for key, exact in (("v_gy", -3.2868596947), ("omega", 0.6573719389)):
        assert np.interp(0.0, -history["theta"], history[key]) == pytest.approx(exact, rel=3e-4)
    names = {path.name for path in folder.glob("[!.]*")}
    assert {"report.html", "summary.json", "plate.inp", "README.md", "calculix.csv", "rigid.csv"} <= names


@needs_ccx
@pytest.mark.long
@pytest.mark.parametrize("vehicle", OWN)
def test_calculix_confirms_own_vehicles(vehicle, elsewhere, capsys):
    """A single corner node, and a patch from Stage 1."""
    scene, *changes = OWN[vehicle]
    demand_agreement(confirmed(capsys, scene, *sets(FRICTIONLESS, *changes)))


@needs_ccx
@pytest.mark.long
def test_soft_plate_is_confirmed_within_its_oscillation(elsewhere, capsys):
    """The limit follows the oscillation of the start, below 0.2 %."""
    changes = (FRICTIONLESS, "plate.elements=[6,2]", "plate.youngs_modulus=20 GPa")
    summary = confirmed(capsys, "paper-table-3", *sets(*changes))
    assert summary["passed"]
    assert 3e-4 < summary["limit"] < 2e-3


def test_end_of_a_fitted_cubic_keeps_no_more_than_its_gain():
    """Sines of any phase, with up to 12 periods in the span."""
    from tailslap.exports.confirm import END_GAIN, MOST_GAIN

    t = np.linspace(-1.0, 0.0, 400)
    for periods in (0.2, 0.6, 1.0, 1.5, 2.0, 3.5, 6.0, 12.0):
        ends = [
            np.polyfit(t, np.sin(2.0 * np.pi * periods * t + p), 3)[-1] for p in np.linspace(0.0, 6.3, 40)
        ]
        bound = min(MOST_GAIN, END_GAIN / periods)
        assert 0.4 * bound < np.abs(ends).max() <= bound


@needs_ccx
def test_another_motion_is_not_confirmed(elsewhere, capsys, solver, solved):
    """That of a spin 0.1 % smaller fails with exit status 1."""
    solver(f"cp {solved}/plate.dat .")
    assert written("confirm", "paper-table-3", *COARSE) == 0
    assert written("confirm", "paper-table-3", *COARSE, "--set", "start.omega=0.707707") == 1
    assert "does not confirm" in capsys.readouterr().out


REFUSED = {
    "friction": ((), 'corner.reaction: given "drag"', 'no friction in CalculiX; allowed is "none"'),
    "material": ((FRICTIONLESS, "material.law=neo-hookean"), "material.law", "st-venant-kirchhoff"),
}


@pytest.mark.parametrize("command", [("confirm",), ("export", "--to", "calculix")], ids=["confirm", "export"])
@pytest.mark.parametrize(("changes", "key", "why"), REFUSED.values(), ids=REFUSED)
def test_scenes_that_calculix_cannot_have_are_refused(changes, key, why, command, elsewhere, capsys):
    if command == ("confirm",) and not changes:
        pytest.skip("confirm omits friction")
    assert written(command[0], "paper-table-3", *command[1:], *sets(*changes)) == 2
    message = capsys.readouterr().err
    assert key in message
    assert why in message
    assert not any(elsewhere.iterdir())


def test_the_refusal_of_friction_ends_with_a_command_that_is_accepted(elsewhere, capsys):
    text = (
        shipped_scenes()["paper-table-3"]
        .read_text()
        .replace('reaction = "drag"', 'reaction = "drag"\nfriction = 0.3')
    )
    Path("own.toml").write_text(text)
    assert written("export", "own.toml", "--to", "calculix") == 2
    command = shlex.split(capsys.readouterr().err.rpartition(": ")[2])
    assert command[:-4] == ["tailslap", "export", "own.toml", "--to", "calculix"]
    assert command[-4:] == ["--set", "corner.reaction=none", "--set", "corner.friction="]
    assert written(*command[1:]) == 0


def test_whole_impact_is_refused(elsewhere, capsys):
    assert written("export", "impact-mash-tl4-sut", "--to", "calculix") == 2
    assert "requires a constrained corner" in capsys.readouterr().err
    assert not any(elsewhere.iterdir())


def test_changes_of_a_result_are_refused(elsewhere, capsys):
    assert written("export", "results/none", "--to", "csv", "--set", "plate.thickness=20mm") == 2
    assert "csv is of a result, not of a scene" in capsys.readouterr().err


def test_missing_solver_is_named_with_its_package(elsewhere, capsys, monkeypatch):
    monkeypatch.setenv("PATH", str(elsewhere))
    assert written("confirm", "paper-table-3", *COARSE) == 2
    assert "apt-get install calculix-ccx" in capsys.readouterr().err
    assert not any(elsewhere.iterdir())


OLD_RESULT = "touch -d 2001-01-01 plate.dat"
FAILURES = {
    "status": ("exit 201", "ended with status 201; its last lines:"),
    "killed": ("kill -9 $$", "ended with status -9"),
    "nothing": ("", "no complete result, plate.dat is missing (tested with Calc"),
    "old": (OLD_RESULT, "is older than plate.inp: it is of an earlier run"),
    "time": ("exec sleep 60", "ran longer than --time-limit 0.5 s"),
}


@pytest.mark.parametrize(("script", "why"), FAILURES.values(), ids=FAILURES)
def test_solver_that_fails_ends_with_its_last_lines(script, why, elsewhere, capsys, solver):
    solver(f"echo first; echo '*ERROR reading *ELASTIC'\n{script}")
    limit = "0.5" if "--time-limit" in why else "60"
    assert written("confirm", "paper-table-3", *COARSE, "--time-limit", limit) == 3
    message = capsys.readouterr().err
    assert why in message
    assert "*ERROR reading *ELASTIC" in message
    assert not any(elsewhere.iterdir())


@needs_ccx
def test_result_of_another_run_is_not_compared(elsewhere, capsys, solver, solved):
    """A sound one, which would confirm the scene."""
    solver(f"cp {solved}/plate.dat . && {OLD_RESULT}")
    assert written("confirm", "paper-table-3", *COARSE) == 3
    assert "it is of an earlier run" in capsys.readouterr().err


def test_solver_without_output_and_velocities_is_named_so(elsewhere, capsys, solver):
    block = "printf ' displacements (vx,vy,vz) for set PLATE and time 0.1\\n\\n 1 0. 0. 0.\\n' > plate.dat"
    solver(block)
    assert written("confirm", "paper-table-3", *COARSE) == 3
    message = capsys.readouterr().err
    assert "it has no displacements or no velocities of nodes" in message
    assert "`ccx -v` prints the version); it printed nothing\n" in message


ENDLESS = {
    "prints": ("while :; do echo '*WARNING again and again'; done", "printed more than 0.3 MB"),
    "prints one line": ("exec tr '\\0' x < /dev/zero", "printed more than 0.3 MB"),
    "writes": ("exec cat /dev/zero > plate.dat", "wrote files of more than 3 MB"),
}


@pytest.mark.parametrize(("script", "why"), ENDLESS.values(), ids=ENDLESS)
def test_solver_without_end_is_ended(script, why, elsewhere, capsys, monkeypatch, solver):
    """What is on disk and in the message is bounded."""
    from tailslap.exports import calculix

    sizes, failed = [], calculix.failed

    def keep(why, folder):
        sizes.append((folder / "ccx.log").stat().st_size)
        return failed(why, folder)

    monkeypatch.setattr(calculix, "failed", keep)
    monkeypatch.setattr(calculix, "MAX_LOG", 300_000)
    solver(f"echo $$ > {elsewhere}/pid; {script}")
    assert written("confirm", "paper-table-3", *COARSE) == 3
    message = capsys.readouterr().err
    assert why in message
    assert len(message) < 2000
    assert sizes[0] <= 300_000
    assert not outliving(elsewhere / "pid")


def outliving(file):
    """Processes of `group_of` that live for two more seconds.

    SIGKILL takes effect when a process is next scheduled.
    """
    deadline = time.monotonic() + 2.0
    while (living := group_of(file)) and time.monotonic() < deadline:
        time.sleep(0.01)
    return living


def group_of(file):
    """Processes that live in the process group whose number a file holds."""
    group, living = int(file.read_text()), []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, group_number = path.read_text().rpartition(") ")[2].split()[:3]
            living += [path.parent.name] * (int(group_number) == group and state not in "ZX")
    return living


STUBBORN = "trap '' TERM; sleep 60 & while :; do sleep 1; done"


@pytest.mark.parametrize(
    "script",
    [STUBBORN, "sleep 60", "sleep 60 & exit 0", "yes & exit 0"],
    ids=["stubborn", "child", "left", "loud"],
)
def test_no_process_of_a_solver_outlives_it(script, elsewhere, capsys, monkeypatch, solver):
    """A solver that ignores SIGTERM, and children of scripts, are ended."""
    from tailslap.exports import calculix

    monkeypatch.setattr(calculix, "GRACE", 0.2)
    solver(f"echo $$ > {elsewhere}/pid; {script}")
    assert written("confirm", "paper-table-3", *COARSE, "--time-limit", "0.5") == 3
    assert not outliving(elsewhere / "pid")


def test_solver_ends_by_sigterm_where_it_obeys(elsewhere, solver):
    solver(f"trap 'echo cleared > {elsewhere}/said; exit' TERM; while :; do sleep 0.05; done")
    assert written("confirm", "paper-table-3", *COARSE, "--time-limit", "0.5") == 3
    assert (elsewhere / "said").read_text() == "cleared\n"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "SIGTERM"])
def test_interrupt_ends_the_solver_with_its_children(number, elsewhere, solver):
    """Children that ignore SIGTERM end even after a second interrupt."""
    script = (
        f"trap '' INT TERM; sleep 60 & echo $$ > {elsewhere}/new; mv {elsewhere}/new {elsewhere}/pid; wait"
    )
    solver(script)
    with started("confirm", "paper-table-3", *COARSE, stderr=subprocess.PIPE, text=True) as program:
        while not (elsewhere / "pid").exists():
            assert program.poll() is None
            time.sleep(0.05)
        program.send_signal(number)
        time.sleep(0.2)
        program.send_signal(number)
        message = program.communicate()[1]
    assert program.returncode == 130, message
    assert not outliving(elsewhere / "pid")


def plate_of(folder):
    """Positions, cells, velocities and lines of the plate for ABAQUS."""
    mesh, text = meshio.read(folder / "plate.inp"), (folder / "plate.inp").read_text()
    (cells,) = (block.data for block in mesh.cells if block.type in ("quad", "triangle"))
    lines = text[text.index("TYPE=VELOCITY") :].splitlines()[1:]
    rows = [line.split(",") for line in lines[: 2 * len(mesh.points)]]
    velocities = np.array([float(value) for _, _, value in rows]).reshape(-1, 2)
    return mesh.points[:, :2], cells, velocities, text


def export_abaqus(folder, *changes):
    assert written("export", "paper-table-3", "--to", "abaqus", *sets(*changes), "--out", str(folder)) == 0


@needs_ccx
@pytest.mark.long
def test_plate_of_the_abaqus_deck_moves_in_calculix_as_the_rigid_body(elsewhere):
    """Shells of the ABAQUS deck become a layer of bricks."""
    export_abaqus("deck", FRICTIONLESS, "plate.elements=[6,2]")
    folder = elsewhere / "deck"
    places, cells, velocities, text = plate_of(folder)
    deck = (folder / "slide-plane.inp").read_text()
    assert meshio.read(folder / "slide-plane.inp").points == pytest.approx(np.c_[places, 0.0 * places[:, 0]])
    assert "*BOUNDARY\nCORNER, 2, 2\n" in deck
    assert "CONNECTOR" not in deck
    corner = int(section(text, "*NSET, NSET=CORNER")[0, 0])
    thickness, _ = section(text, "*SHELL SECTION")[0]
    n, lines = len(places), ["*NODE, NSET=PLATE"]
    for z in (0, 1):
        lines += [
            f"{k + z * n}, {x!r}, {y!r}, {z * thickness}" for k, (x, y) in enumerate(places.tolist(), 1)
        ]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=VEHICLE"]
    lines += [", ".join(map(str, [k, *cell, *(cell + n)])) for k, cell in enumerate(cells + 1, 1)]
    lines += [text[text.index("*MATERIAL") : text.index("*SHELL")].rstrip()]
    lines += ["*SOLID SECTION, ELSET=VEHICLE, MATERIAL=STEEL", "*INITIAL CONDITIONS, TYPE=VELOCITY"]
    for z in (0, 1):
        for k, pair in enumerate(velocities.tolist(), 1):
            lines += [f"{k + z * n}, {axis}, {value!r}" for axis, value in enumerate(pair, 1)]
    lines += ["*BOUNDARY", f"{corner}, 2, 2", f"{corner + n}, 2, 2", *(f"{k}, 3, 3" for k in range(1, n + 1))]
    step, end = section(deck, "*DYNAMIC")[0]
    lines += ["*STEP, NLGEOM, INC=1000", "*DYNAMIC, DIRECT, ALPHA=-0.05", f"{step}, {end}"]
    lines += ["*NODE PRINT, NSET=PLATE", "U, V", "*END STEP"]
    (folder / "bricks.inp").write_text("\n".join(lines) + "\n")
    assert subprocess.run(["ccx", "bricks"], cwd=folder, capture_output=True).returncode == 0
    _, nodes, masses = read_nodes(folder / "nodes.csv")
    assert nodes == pytest.approx(places, rel=1e-10, abs=1e-10)
    assert masses.sum() == pytest.approx(7800.0 * 0.053 * 10.0 * 2.438, rel=1e-12)
    result = read_calculix(folder / "bricks.dat")
    both = np.tile(nodes, (2, 1)), np.tile(0.5 * masses, 2)
    history = centre_of_mass_history(*both, result.t, result.displacements, result.velocities)
    at = lambda name: np.interp(0.0, history["rotation"] - 0.26, history[name])  # noqa: E731
    assert at("v_gy") == pytest.approx(-3.2868596947, rel=3e-4)
    assert at("omega") == pytest.approx(0.6573719389, rel=3e-4)


def test_abaqus_deck_has_friction_by_a_connector_at_the_corner(elsewhere):
    export_abaqus("deck")
    folder = elsewhere / "deck"
    names = {"plate.inp", "slide-plane.inp", "contact-pair.inp", "README.md", "nodes.csv", "rigid.csv"}
    assert {path.name for path in folder.glob("[!.]*")} == names
    places, cells, _, text = plate_of(folder)
    assert cells.shape == (120, 4)
    deck, paper = ((folder / name).read_text() for name in ("slide-plane.inp", "contact-pair.inp"))
    corner = int(section(text, "*NSET, NSET=CORNER")[0, 0])
    assert places[corner - 1] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert section(deck, "*ELEMENT, TYPE=CONN3D2").tolist() == [[121, 148, corner]]
    assert section(deck, "*ORIENTATION").tolist() == [[0, 1, 0, 1, 0, 0]]
    assert "*CONNECTOR FRICTION, PREDEFINED\n0,\n*FRICTION\n0.47,\n" in deck
    assert "CORNER, 2, 2" not in deck
    assert "*BOUNDARY\nCORNER, 2, 2\n" in paper
    assert "*FRICTION\n0.47,\n" in paper
    side = [int(line.rstrip(",")) for line in paper[paper.index("SIDE_PE") :].splitlines()[1:22]]
    assert places[np.array(side) - 1, 1] == pytest.approx(-np.tan(0.26) * places[np.array(side) - 1, 0])
    first, second, third, _ = section(paper, "*NODE, NSET=GROUND")[1:, 1:]
    normal = np.cross(second - first, third - second)
    assert normal[1] > 0.0
    assert normal[[0, 2]] == pytest.approx([0.0, 0.0])


def test_abaqus_deck_refuses_what_its_connector_cannot_have(elsewhere, capsys):
    changes = ("corner.reaction=signed", "corner.reaction"), ("corner.patch_length=2", "patch_length")
    for change, key in changes:
        assert written("export", "paper-table-3", "--to", "abaqus", "--set", change) == 2
        assert key in capsys.readouterr().err
    assert not any(elsewhere.iterdir())
