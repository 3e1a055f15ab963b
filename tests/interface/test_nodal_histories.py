"""Verify nodes of other programs as a motion of their centre.

The files of LS-DYNA, ABAQUS and OpenRadioss are written here by their documented formats; none of these programs ran.
"""

import re
import shlex

import numpy as np
import pytest

from postprocess.comparison import nodal
from tailslap import cli

NODES = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]])
MASSES = np.array([1.0, 2.0, 3.0, 2.0])
T = np.array([0.1, 0.2, 0.3])
SPIN, SPEED = -1.5, (3.0, -0.5)


def rigid_nodes():
    """Nodes that rotate at SPIN about a centre with velocity SPEED."""
    centre = MASSES @ NODES / MASSES.sum()
    c, s = np.cos(SPIN * T)[:, None, None], np.sin(SPIN * T)[:, None, None]
    x, y = (NODES - centre)[:, :1], (NODES - centre)[:, 1:]
    arm = np.concatenate([c * x - s * y, s * x + c * y], axis=2)
    displacements = centre + np.multiply.outer(T, SPEED)[:, None] + arm - NODES
    velocities = np.array(SPEED) + SPIN * np.stack([-arm[..., 1], arm[..., 0]], axis=2)
    return displacements, velocities


def write(path, lines):
    """Write the lines of a file, and the nodes beside it."""
    path.write_text("\n".join(lines) + "\n")
    rows = [f"{n},{x},{y},{m}" for n, ((x, y), m) in enumerate(zip(NODES, MASSES, strict=True), 1)]
    path.with_name("nodes.csv").write_text("\n".join(["node,x,y,mass", *rows]) + "\n")
    return path


def write_dat(path, displacements, velocities):
    """The lines that CalculiX 2.20 prints by *NODE PRINT with U, V."""
    lines = []
    for t, *both in zip(T, displacements, velocities, strict=True):
        for name, values in zip(("displacements", "velocities"), both, strict=True):
            lines += ["", f" {name} (vx,vy,vz) for set PLATE and time  {t:.7E}", ""]
            lines += [f"{n:10d} {x:13.6E} {y:13.6E} {0:13.6E}" for n, (x, y) in enumerate(values, 1)]
    return write(path, lines)


def test_rigid_rotation_is_exact():
    displacements, velocities = rigid_nodes()
    motion = nodal.centre_of_mass_history(NODES, MASSES, T, displacements, velocities)
    centre = MASSES @ NODES / MASSES.sum()
    assert motion["omega"] == pytest.approx(SPIN, rel=1e-14)
    assert motion["rotation"] == pytest.approx(SPIN * T, rel=1e-14)
    assert np.transpose([motion["v_gx"], motion["v_gy"]]) == pytest.approx(np.tile(SPEED, (3, 1)), rel=1e-14)
    assert motion["x_g"] == pytest.approx(centre[0] + SPEED[0] * T, rel=1e-14)
    assert motion["y_g"] == pytest.approx(centre[1] + SPEED[1] * T, rel=1e-14)


def write_nodout(path, displacements, velocities):
    """A nodout file of LS-DYNA with translations and rotations."""
    heading = " n o d a l   p r i n t   o u t   f o r   t i m e  s t e p{:8d}{:30s}( at time{:14.7E} )"
    names = " nodal point  x-disp     y-disp      z-disp      x-vel       y-vel       z-vel       x-accl      y-accl"
    lines = ["{BEGIN LEGEND}", " Entity #        Title", "        1        corner", "{END LEGEND}"]
    for k, t in enumerate(T):
        head = heading.format(k, "", t)
        lines += ["", head, "", names + "      z-accl      x-coor      y-coor      z-coor"]
        for n, (u, v) in enumerate(zip(displacements[k], velocities[k], strict=True), 1):
            values = [*u, 0.0, *v, 0.0, *3 * [0.0], *(NODES[n - 1] + u), 0.0]
            lines.append(f"{n:10d}" + "".join(f"{value:12.4E}" for value in values))
        lines += ["", heading.format(k, "", t), "", " nodal point  x-rot      y-rot       z-rot"]
        lines += [f"{n:10d}" + 3 * f"{7.0:12.4E}" for n in range(1, 5)]
    return write(path, lines)


def write_field_report(path, displacements, velocities):
    """A report of ABAQUS for each frame, with minima and maxima."""
    lines = []
    for k, t in enumerate(T):
        title = "Field Output Report, written Mon Nov 23 10:07:54 2026"
        lines += [80 * "*", title, "", "Source 1", "---------", ""]
        frame = f"   Frame: Increment {10 * k:6d}: Step Time = {t:9.4g}"
        lines += ["   ODB: C:/temp/plate.odb", "   Step: slide", frame]
        lines += ["", "Loc 1 : Nodal values from source 1", "", 'Output sorted by column "Node Label".', ""]
        lines += ["Field Output reported at nodes for part: PLATE-1", ""]
        lines += ["            Node            U.U1            U.U2            V.V1            V.V2"]
        lines += ["           Label" + 4 * "          @Loc 1", 80 * "-"]
        rows = np.concatenate([displacements[k], velocities[k]], axis=1)
        lines += [f"{n:16d}" + "".join(f"{value:16.6E}" for value in row) for n, row in enumerate(rows, 1)]
        least = ("  Minimum            0.              0.", "      At Node               1               1")
        lines += ["", *least, ""]
    return write(path, lines)


def write_radioss(path, displacements, velocities):
    """The CSV of OpenRadioss with a file _TITLES.

    Titles have 100 characters, numbers six decimals.
    """
    totals = ["time", "INTERNAL ENERGY", "KINETIC ENERGY", "X-MOMENTUM", "Y-MOMENTUM", "Z-MOMENTUM", "MASS"]
    nodes = [f"{'plate 2':100s} {n} {'node ' + str(n):100s}" for n in range(1, 5)]
    names = [f"{node}  {q:10s} " for node in nodes for q in ("DX", "DY", "VX", "VY")]
    lines = [",".join(f'"{name}"' for name in totals + names)]
    for k, t in enumerate(T):
        rows = np.concatenate([displacements[k], velocities[k]], axis=1)
        lines.append(",".join(f"{value:f}" for value in [t, *6 * [0.0], *rows.ravel()]))
    return write(path, lines)


WRITERS = {"nodout": write_nodout, "abaqus.rpt": write_field_report, "plateT01.csv": write_radioss}
ALL_WRITERS = {"plate.dat": write_dat, **WRITERS}
ERRORS = {"plate.dat": 1e-6, "nodout": 2e-4, "abaqus.rpt": 1e-6, "plateT01.csv": 1e-5}
"""Relative errors by the digits of the files."""
LAST_LINES = {"plate.dat": 42, "nodout": 44, "abaqus.rpt": 77, "plateT01.csv": 4}


@pytest.fixture
def compared(tmp_path, capsys):
    """Compare a file with the exact motion or itself."""

    def compare(path, *reference):
        status = cli._status(
            ["compare", *map(str, reference or (path,)), str(path), "--out", str(tmp_path / "out")]
        )
        output = capsys.readouterr()
        return status, output.err or output.out

    return compare


def exact(folder, time="t"):
    """Write the motion of the centre of mass."""
    path = folder / "exact.csv"
    path.write_text(f"{time},omega,v_gx,v_gy\n" + "".join(f"{t},{SPIN},{SPEED[0]},{SPEED[1]}\n" for t in T))
    return path


@pytest.mark.parametrize("name", ALL_WRITERS)
def test_files_of_other_programs_give_the_same_motion(name, tmp_path, compared):
    """Agreement is to the digits of the files."""
    path = ALL_WRITERS[name](tmp_path / name, *rigid_nodes())
    motion, rel = nodal.read_centre_of_mass(path), ERRORS[name]
    assert motion["t"] == pytest.approx(T, rel=1e-6)
    assert motion["omega"] == pytest.approx(SPIN, rel=rel)
    assert np.transpose([motion["v_gx"], motion["v_gy"]]) == pytest.approx(np.tile(SPEED, (3, 1)), rel=rel)
    assert motion["rotation"] == pytest.approx(SPIN * T, rel=rel)
    status, output = compared(path, exact(tmp_path))
    assert status == 0
    assert "All 3 histories" in output


def without_last_line(text):
    return "\n".join(text.splitlines()[:-1]) + "\n"


COLUMNS_LEFT = "U.U1, U.U2, V.V1, V.V3"
TABLE, INSTANT = "\n\n n o d a l", " n o d a l   p r i n t   o u t ( at time 4.0E-01 )\n"
CUT = [
    ("plate.dat", lambda text: text[:-20], "line 42 is cut short"),
    ("plate.dat", without_last_line, "1 nodes are missing at 0.3 s"),
    ("plate.dat", lambda text: text[: text.rindex(" velocities")], "velocities are missing at 0.3 s"),
    ("plate.dat", lambda text: text.replace("velocities", "stresses"), "no velocities of nodes"),
    ("nodout", lambda text: text[: text.rindex(TABLE) - 20], "line 44 is cut short"),
    ("nodout", lambda text: without_last_line(text[: text.rindex(TABLE)]), "1 nodes are missing at 0.3 s"),
    ("nodout", lambda text: text + INSTANT, "4 nodes are missing at 0.4 s"),
    ("abaqus.rpt", lambda text: text[: text.rindex("  Minimum") - 20], "is cut short: '4"),
    ("abaqus.rpt", lambda text: text.replace("V.V2", "V.V3"), f"V.V2 are missing; the columns are {COLUMNS_LEFT}"),
    ("abaqus.rpt", lambda text: text + text, "0.1 s is there twice; allowed is one step"),
    ("plateT01.csv", lambda text: text[:-20], "line 4 is cut short: 21 of 23 entries"),
    ("plateT01.csv", lambda text: re.sub(r"\n([0-9.]+),0.000000,", r"\n\1,", text).replace("\n", ",\n"),
     "line 2 has no entry under plate 2 4 node 4 VY; its entries may be shifted"),
    ("plateT01.csv", lambda text: text.replace(",0.000000,", ",0.000000,7.0,", 1), "line 2 has 24 entries for 23"),
    ("plateT01.csv", lambda text: text.replace("  VY   ", "  VZ   "), "node 1 are missing: VY"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "cut", "words"), CUT)
def test_files_of_others_cut_short_are_refused(name, cut, words, tmp_path, compared):
    path = ALL_WRITERS[name](tmp_path / name, *rigid_nodes())
    path.write_text(cut(path.read_text()))
    status, said = compared(path)
    assert status == 2
    assert words in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e31])
@pytest.mark.parametrize("name", ALL_WRITERS)
def test_values_that_are_no_numbers_are_refused_by_line(name, value, tmp_path, compared):
    displacements, velocities = rigid_nodes()
    velocities[2, 3, 0] = value
    status, said = compared(ALL_WRITERS[name](tmp_path / name, displacements, velocities))
    assert status == 2
    assert f"line {LAST_LINES[name]}: given" in said
    assert "allowed are numbers of at most 1e+30" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ALL_WRITERS)
def test_instants_that_are_no_numbers_are_refused_by_line(name, tmp_path, compared, monkeypatch):
    monkeypatch.setitem(globals(), "T", np.array([0.1, 0.2, np.nan]))
    status, said = compared(ALL_WRITERS[name](tmp_path / name, *np.nan_to_num(rigid_nodes())))
    assert status == 2
    assert re.search(r'line \d+: given "nan"; allowed are numbers', said.lower())


@pytest.mark.parametrize(("row", "words"), [
    ("4,0.0,2.0,nan", 'line 5: given "nan"'), ("4,0.0,2.0,0", "line 5: the mass of a node must be positive"),
    ("4,0.0,2.0,2.0,7", "line 5 has more entries than names"),
    ("4,0.0,inf,2.0", 'line 5: given "inf"'), ("4,0.0", "must have the columns"), ("3,0.0,2.0,2.0", "has a node twice"),
])  # fmt: skip
def test_wrong_nodes_are_refused(row, words, tmp_path, compared):
    path = write_dat(tmp_path / "plate.dat", *rigid_nodes())
    table = path.with_name("nodes.csv")
    table.write_text("\n".join([*table.read_text().splitlines()[:-1], row]) + "\n")
    status, said = compared(path)
    assert (status, words in said) == (2, True)


@pytest.mark.parametrize("name", ALL_WRITERS)
def test_nodes_over_milliseconds_are_refused_with_the_option_for_them(name, tmp_path, compared, monkeypatch):
    reference, motion = exact(tmp_path, "t [s]"), rigid_nodes()
    monkeypatch.setitem(globals(), "T", 1e3 * T)
    path = ALL_WRITERS[name](tmp_path / name, *motion)
    status, said = compared(path, reference)
    assert status == 2
    assert "lasts 200 s and exact 0.2 s if times without a unit are seconds" in said
    assert compared(path, reference, *shlex.split(said[said.rindex("--columns") :]))[0] == 0


@pytest.mark.parametrize("name", ALL_WRITERS)
def test_nodes_that_are_missing_are_named(name, tmp_path, compared):
    path = ALL_WRITERS[name](tmp_path / name, *rigid_nodes())
    table = path.with_name("nodes.csv")
    table.write_text(table.read_text().replace("\n4,", "\n7,"))
    status, said = compared(path)
    assert (status, f"{name} and nodes.csv only: 4, 7" in said) == (2, True)
    table.unlink()
    status, said = compared(path)
    assert (status, "in nodes.csv beside it, are missing" in said) == (2, True)


def test_whole_model_histories_of_radioss_are_a_table(tmp_path):
    """Without columns of nodes it is a file with named columns."""
    path = tmp_path / "wholeT01.csv"
    path.write_text('"time","INTERNAL ENERGY","X-MOMENTUM"\n0.0,1.0,2.0\n0.1,1.0,3.0\n')
    assert nodal.reader_of(path) is None
