"""Verification: nodes of another program as a motion of the centre of mass, and files that are cut short."""

import numpy as np
import pytest

from postprocess.comparison.nodal import centre_of_mass_history, read_calculix
from tailslap import cli

NODES = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]])
MASSES = np.array([1.0, 2.0, 3.0, 2.0])
T = np.array([0.1, 0.2, 0.3])
SPIN, SPEED = -1.5, (3.0, -0.5)


def rigid_nodes():
    """Nodes that turn about their centre of mass at SPIN from t = 0 while that moves at SPEED."""
    centre = MASSES @ NODES / MASSES.sum()
    c, s = np.cos(SPIN * T)[:, None, None], np.sin(SPIN * T)[:, None, None]
    x, y = (NODES - centre)[:, :1], (NODES - centre)[:, 1:]
    arm = np.concatenate([c * x - s * y, s * x + c * y], axis=2)
    displacements = centre + np.multiply.outer(T, SPEED)[:, None] + arm - NODES
    velocities = np.array(SPEED) + SPIN * np.stack([-arm[..., 1], arm[..., 0]], axis=2)
    return displacements, velocities


def write_dat(path, displacements, velocities):
    """The lines that CalculiX 2.20 prints by *NODE PRINT with U, V."""
    lines = []
    for t, *both in zip(T, displacements, velocities, strict=True):
        for name, values in zip(("displacements", "velocities"), both, strict=True):
            lines += ["", f" {name} (vx,vy,vz) for set PLATE and time  {t:.7E}", ""]
            lines += [f"{n:10d} {x:13.6E} {y:13.6E} {0:13.6E}" for n, (x, y) in enumerate(values, 1)]
    path.write_text("\n".join(lines) + "\n")
    rows = [f"{n},{x},{y},{m}" for n, ((x, y), m) in enumerate(zip(NODES, MASSES, strict=True), 1)]
    path.with_name("nodes.csv").write_text("\n".join(["node,x,y,mass", *rows]) + "\n")
    return path


def test_rigid_rotation_is_exact():
    displacements, velocities = rigid_nodes()
    found = centre_of_mass_history(NODES, MASSES, T, displacements, velocities)
    centre = MASSES @ NODES / MASSES.sum()
    assert found["omega"] == pytest.approx(SPIN, rel=1e-14)
    assert found["rotation"] == pytest.approx(SPIN * T, rel=1e-14)
    assert np.transpose([found["v_gx"], found["v_gy"]]) == pytest.approx(np.tile(SPEED, (3, 1)), rel=1e-14)
    assert found["x_g"] == pytest.approx(centre[0] + SPEED[0] * T, rel=1e-14)
    assert found["y_g"] == pytest.approx(centre[1] + SPEED[1] * T, rel=1e-14)


def test_calculix_file_gives_the_same_motion(tmp_path):
    """Seven digits of the file."""
    displacements, velocities = rigid_nodes()
    found = read_calculix(write_dat(tmp_path / "plate.dat", displacements, velocities))
    assert found.numbers.tolist() == [1, 2, 3, 4]
    assert found.t == pytest.approx(T, rel=1e-15)
    assert found.displacements == pytest.approx(displacements, rel=1e-6)
    assert found.velocities == pytest.approx(velocities, rel=1e-6)


def test_compare_reads_calculix(tmp_path, capsys):
    path = write_dat(tmp_path / "plate.dat", *rigid_nodes())
    reference = tmp_path / "exact.csv"
    reference.write_text("t,omega,v_gx,v_gy\n" + "".join(f"{t},{SPIN},{SPEED[0]},{SPEED[1]}\n" for t in T))
    assert cli._status(["compare", str(reference), str(path), "--out", str(tmp_path / "out")]) == 0
    assert "All 3 histories" in capsys.readouterr().out


CUT = {
    "a line": (lambda text: text[:-20], "line 42 is cut short"),
    "a block": (lambda text: "\n".join(text.splitlines()[:-1]) + "\n", "1 nodes are missing at 0.3 s"),
    "an instant": (lambda text: text[: text.rindex(" velocities")], "velocities are missing at 0.3 s"),
    "no velocities": (lambda text: text.replace("velocities", "stresses"), "no velocities of nodes"),
}


@pytest.mark.parametrize(("cut", "said"), CUT.values(), ids=CUT)
def test_file_cut_short_is_refused(cut, said, tmp_path, capsys):
    path = write_dat(tmp_path / "plate.dat", *rigid_nodes())
    path.write_text(cut(path.read_text()))
    assert cli._status(["compare", str(path), str(path), "--out", str(tmp_path / "out")]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_other_nodes_are_refused(tmp_path, capsys):
    path = write_dat(tmp_path / "plate.dat", *rigid_nodes())
    table = path.with_name("nodes.csv")
    table.write_text(table.read_text().replace("\n4,", "\n7,"))
    assert cli._status(["compare", str(path), str(path)]) == 2
    assert "plate.dat and nodes.csv only: 4, 7" in capsys.readouterr().err
    table.unlink()
    assert cli._status(["compare", str(path), str(path)]) == 2
    assert "in nodes.csv beside it, are missing" in capsys.readouterr().err
