"""Verification: decks of a scene for other solvers, and the motion that CalculiX computes with them."""

import json
import os
import shlex
import shutil
import subprocess

import meshio
import numpy as np
import pytest

from postprocess.comparison.nodal import read_nodes
from postprocess.report.page import read_history
from tailslap import cli

FRICTIONLESS = "corner.reaction=none"
COARSE = ("--set", FRICTIONLESS, "--set", "plate.elements=[4,2]")
CAR = """
name = "car"
[vehicle]
length = "4.6 m"
width = "1.8 m"
mass = "1500 kg"
[start]
angle = 0.4
omega = 1.9
corner_speed = "26 m/s"
[corner]
reaction = "none"
[plate]
thickness = "40 mm"
youngs_modulus = "200 GPa"
poissons_ratio = 0.3
elements = [10, 4]
"""
COACH = """
name = "coach"
[vehicle]
length = "13 m"
width = "2.55 m"
mass = "18 t"
[impact]
speed = "70 km/h"
angle = "20 deg"
friction = 0.3
restitution = 0.1
convention = "newton"
[corner]
reaction = "none"
patch_length = "2 m"
[plate]
thickness = "60 mm"
youngs_modulus = "210 GPa"
poissons_ratio = 0.28
elements = [12, 3]
distortion = 0.1
"""

needs_ccx = pytest.mark.skipif(
    not shutil.which("ccx"), reason="CalculiX is not installed (apt-get install calculix-ccx)"
)


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(*arguments):
    """Status of the command."""
    return cli._status(list(arguments))


def fake_ccx(folder, script, monkeypatch):
    """Put a program of this name first on the path."""
    program = folder / "bin" / "ccx"
    program.parent.mkdir()
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}:{os.environ['PATH']}")


def section(text, keyword):
    """Lines of numbers behind the first keyword that begins like this."""
    lines = iter(text.splitlines())
    next(line for line in lines if line.startswith(keyword))
    found = []
    for line in lines:
        if line.startswith("*"):
            break
        found.append([float(cell) for cell in line.split(",")])
    return np.array(found)


def test_deck_holds_the_mass_and_the_motion_of_the_rigid_body(elsewhere):
    """Mass, moment of inertia, momentum and spin of density times brick volumes are those of the rectangle."""
    assert written("export", "paper-table-3", "--to", "calculix", "--set", FRICTIONLESS) == 0
    folder = elsewhere / "results" / "paper-table-3-calculix"
    assert {path.name for path in folder.glob("[!.]*")} == {
        "plate.inp",
        "README.md",
        "nodes.csv",
        "rigid.csv",
    }
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
def test_commands_of_the_readme_run(elsewhere, capsys):
    assert written("export", "paper-table-3", "--to", "calculix", *COARSE, "--out", "deck") == 0
    lines = (elsewhere / "deck" / "README.md").read_text().splitlines()
    run, compare = (shlex.split(line) for line in lines if line.startswith("    "))
    os.chdir("deck")
    assert subprocess.run(run, capture_output=True).returncode == 0
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
def test_calculix_confirms_the_paper_on_a_coarse_mesh(elsewhere, capsys):
    """Exact motion without friction at the tail-slap: -3.2868596947 m/s, 0.6573719389 rad/s; also at the instant."""
    summary = confirmed(capsys, "paper-table-3", "--set", FRICTIONLESS, "--set", "plate.elements=[10,4]")
    demand_agreement(summary)
    assert summary["calculix"]["v_gy"] == pytest.approx(-3.2868596947, rel=3e-4)
    assert summary["calculix"]["omega"] == pytest.approx(0.6573719389, rel=3e-4)
    folder = elsewhere / "results" / "paper-table-3-confirm"
    history = read_history((folder / "calculix.csv").read_bytes())
    for key, exact in (("v_gy", -3.2868596947), ("omega", 0.6573719389)):
        assert np.interp(0.0, -history["theta"], history[key]) == pytest.approx(exact, rel=3e-4)
    names = {path.name for path in folder.glob("[!.]*")}
    assert {"report.html", "summary.json", "plate.inp", "README.md", "calculix.csv", "rigid.csv"} <= names


@needs_ccx
@pytest.mark.parametrize("text", [CAR, COACH], ids=["car", "coach"])
def test_calculix_confirms_own_vehicles(text, elsewhere, capsys):
    """One corner node; a distorted mesh on a support patch, whose start is that of Stage 1."""
    (elsewhere / "own.toml").write_text(text)
    demand_agreement(confirmed(capsys, "own.toml"))


@needs_ccx
@pytest.mark.long
def test_calculix_confirms_the_paper(elsewhere, capsys):
    demand_agreement(confirmed(capsys, "paper-table-3", "--set", FRICTIONLESS))


@needs_ccx
def test_another_motion_is_not_confirmed(elsewhere, capsys, monkeypatch):
    """A deck with a spin that is 0.1 % larger fails, exit status 1."""
    from tailslap.exports import deck

    own = deck.Deck.velocities.fget
    monkeypatch.setattr(deck.Deck, "velocities", property(lambda self: 1.001 * own(self)))
    assert written("confirm", "paper-table-3", *COARSE) == 1
    assert "does not confirm" in capsys.readouterr().out


REFUSED = {
    "friction": ((), 'corner.reaction: given "drag"', 'no friction in CalculiX; allowed is "none"'),
    "material": ((FRICTIONLESS, "material.law=neo-hookean"), "material.law", "st-venant-kirchhoff"),
}


@pytest.mark.parametrize("command", [("confirm",), ("export", "--to", "calculix")], ids=["confirm", "export"])
@pytest.mark.parametrize(("changes", "key", "why"), REFUSED.values(), ids=REFUSED)
def test_scenes_that_calculix_cannot_have_are_refused(changes, key, why, command, elsewhere, capsys):
    given = [part for change in changes for part in ("--set", change)]
    assert written(command[0], "paper-table-3", *command[1:], *given) == 2
    said = capsys.readouterr().err
    assert key in said
    assert why in said
    assert not any(elsewhere.iterdir())


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


FAILURES = {
    "status": ("echo first; echo '*ERROR reading *ELASTIC'; exit 201", "ended with status 201"),
    "nothing": ("echo '*ERROR reading *ELASTIC'", "wrote no complete result"),
    "time": ("echo '*ERROR reading *ELASTIC'; exec sleep 60", "ran longer than --time-limit 1 s"),
}


@pytest.mark.parametrize(("script", "why"), FAILURES.values(), ids=FAILURES)
def test_solver_that_fails_ends_with_its_last_lines(
    script, why, elsewhere, capsys, monkeypatch, tmp_path_factory
):
    fake_ccx(tmp_path_factory.mktemp("fake"), script, monkeypatch)
    assert written("confirm", "paper-table-3", *COARSE, "--time-limit", "1") == 3
    said = capsys.readouterr().err
    assert why in said
    assert "*ERROR reading *ELASTIC" in said
    assert not any(elsewhere.iterdir())
