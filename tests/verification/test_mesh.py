"""Verify that meshes have the requested nodes, elements and groups."""

import threading

import gmsh
import numpy as np
import pytest

from meshes import plate_mesh, wall_mesh
from meshes.rectangle import gmsh_model

PLATE_GROUPS = {"plate", "side_pe", "side_kp", "side_hk", "side_eh"}
PLATE_GROUPS |= {"corner_p", "corner_e", "corner_h", "corner_k"}


def test_the_papers_counts():
    plate, wall = plate_mesh(10.0, 2.438, (20, 6)), wall_mesh(-10.0, 30.0, 5.0, (60, 10))
    assert (len(plate.cells_dict["quad"]), len(plate.points)) == (120, 147)
    assert (len(wall.cells_dict["quad"]), len(wall.points)) == (600, 671)


def test_nodes_lie_on_the_lattice_to_the_bit():
    points = plate_mesh(10.0, 2.438, (20, 6)).points
    x, y = -10.0 + np.arange(21) * 0.5, np.arange(7) * (2.438 / 6)
    expected = {(a, b) for a in x for b in y}
    assert {(a, b) for a, b in points[:, :2]} == expected


def test_elements_are_counter_clockwise_and_fill_the_plate():
    mesh = plate_mesh(10.0, 2.438, (5, 3))
    corners = mesh.points[mesh.cells_dict["quad"], :2]
    following = np.roll(corners, -1, axis=1)
    areas = 0.5 * (corners[..., 0] * following[..., 1] - corners[..., 1] * following[..., 0]).sum(axis=1)
    np.testing.assert_allclose(areas, 10.0 * 2.438 / 15, rtol=1e-12)


CORNERS = [("corner_p", (0.0, 0.0)), ("corner_e", (-10.0, 0.0))]
CORNERS += [("corner_h", (-10.0, 2.438)), ("corner_k", (0.0, 2.438))]


@pytest.mark.parametrize(("group", "place"), CORNERS)
def test_corners_carry_their_names(group, place):
    mesh = plate_mesh(10.0, 2.438, (4, 2))
    cell = mesh.cells_dict["vertex"][mesh.cell_sets_dict[group]["vertex"]]
    np.testing.assert_array_equal(mesh.points[cell.item(), :2], place)


@pytest.mark.parametrize(
    ("group", "axis", "at"),
    [("side_pe", 1, 0.0), ("side_eh", 0, -10.0), ("side_hk", 1, 2.438), ("side_kp", 0, 0.0)],
)
def test_sides_carry_their_names(group, axis, at):
    mesh = plate_mesh(10.0, 2.438, (4, 2))
    lines = mesh.cells_dict["line"][mesh.cell_sets_dict[group]["line"]]
    assert len(lines) == (4, 2)[1 - axis]
    np.testing.assert_array_equal(mesh.points[lines][..., axis], at)


def test_every_group_is_named():
    assert set(plate_mesh(10.0, 2.438, (2, 2)).cell_sets) == PLATE_GROUPS
    groups = {"wall", "wall_face", "wall_back", "wall_start", "wall_end"}
    assert set(wall_mesh(0.0, 3.0, 1.0, (2, 2)).cell_sets) == groups


def test_works_outside_the_main_thread_and_prints_nothing(capfd):
    plates = []
    threads = [threading.Thread(target=lambda: plates.append(plate_mesh(1.0, 1.0, (3, 2)))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert ([len(mesh.points) for mesh in plates], capfd.readouterr()) == ([12] * 4, ("", ""))


def test_gmsh_is_closed_after_success_and_after_an_error():
    plate_mesh(1.0, 1.0, (1, 1))
    assert not gmsh.isInitialized()
    with pytest.raises(ZeroDivisionError), gmsh_model("fails"):
        raise ZeroDivisionError
    assert not gmsh.isInitialized()


def test_the_callers_own_session_stays_open_and_as_it_was():
    gmsh.initialize(interruptible=False)
    try:
        gmsh.model.add("theirs")
        plate_mesh(1.0, 1.0, (2, 2))
        assert gmsh.isInitialized()
        assert (gmsh.model.list(), gmsh.model.getCurrent()) == (["", "theirs"], "theirs")
    finally:
        gmsh.finalize()


def test_a_mesh_leaves_the_signal_handlers_as_they_are(python):
    """Libraries within gmsh set default handlers, tested in a process."""
    code = (
        "import os, signal\nsignal.signal(signal.SIGTERM, lambda *_: print('caught', flush=True))\n"
        "from meshes import plate_mesh\nplate_mesh(10.0, 2.0, (4, 2))\n"
        "os.kill(os.getpid(), signal.SIGTERM)\n"
    )
    process = python(code)
    assert (process.returncode, process.stdout) == (0, "caught\n")


@pytest.mark.parametrize("thread", [False, True])
def test_a_mesh_leaves_ignored_signals_ignored(thread, python):
    """A closed pipe raises, and HUP is ignored under nohup."""
    code = (
        "import os, signal, threading\nsignal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
        "from meshes import plate_mesh\nmesh = lambda: plate_mesh(10.0, 2.0, (4, 2))\n"
        f"{'worker = threading.Thread(target=mesh); worker.start(); worker.join()' if thread else 'mesh()'}\n"
        "reading, writing = os.pipe()\nos.close(reading)\nos.kill(os.getpid(), signal.SIGHUP)\n"
        "try:\n    os.write(writing, b'x')\nexcept BrokenPipeError:\n    print('raised')\n"
    )
    process = python(code)
    assert (process.returncode, process.stdout) == (0, "raised\n")
