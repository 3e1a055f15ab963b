"""Verify that a resumed run has the bits of an undisturbed one."""

import functools
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fem.run import corner, impact
from tailslap import cli, errors
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact.case import ImpactCase
from tailslap.scene.read import read_scene
from tailslap.storage import checkpoints
from tailslap.storage.checkpoints import checkpointed, next_checkpoint


class Stopping:
    """Interrupts a run at one of its checkpoints, and stores this one."""

    def __init__(self, at, arrays=None):
        self.remaining, self.arrays = at, arrays

    def load(self, sizes):
        if self.arrays is not None:  # the expected shapes are those of the arrays
            shapes = {name: array.shape for name, array in self.arrays.items()}
            assert sizes(len(self.arrays["rows"])) == shapes
        return self.arrays

    def save(self, arrays):
        self.remaining -= 1
        if self.remaining == 0:
            self.arrays = {name: np.array(array) for name, array in arrays().items()}
            raise KeyboardInterrupt


def same(a, b):
    """All numbers of two runs are equal, except measured times."""
    for name in set(vars(a)) - {"setup_s", "time_loop_s", "strike", "snapshots"}:
        first, second = getattr(a, name), getattr(b, name)
        for key in first if isinstance(first, dict) else [()]:
            before, after = (np.asarray(value[key] if key else value) for value in (first, second))
            assert_array_equal(before, after)


@pytest.mark.parametrize(("at", "snapshots"), [(1, 6), (10, 6), (18, 6), (10, 1), (30, 400)])
def test_the_loop_goes_on_with_the_same_bits(at, snapshots):
    fe_plan = CornerCase(*read_scene("paper-table-3")).plan()

    def run(keeper):
        duration = fe_plan.case.motion.strike.t
        options = {"rows": 300, "snapshots": snapshots, "checkpoint": keeper}
        return corner.simulate(fe_plan.model, fe_plan.start, duration, **options)

    stopping = Stopping(at)
    with pytest.raises(KeyboardInterrupt):
        run(stopping)
    resumed, complete = run(Stopping(0, stopping.arrays)), run(None)
    same(resumed, complete)
    same(resumed.snapshots, complete.snapshots)
    assert resumed.strike.values == complete.strike.values
    assert_array_equal(resumed.strike.velocities, complete.strike.velocities)


LINEAR_TRUCK = str(Path(__file__).parents[2] / "examples" / "linear-truck.toml")
WALL_THAT_GIVES = (
    "wall.length=36 m", "wall.depth=0.3 m", "wall.height=1 m", "wall.elements=[60,1]",
    "wall.foundation_stiffness=100 MN/m^2",
)  # fmt: skip


@pytest.mark.parametrize(
    ("scene", "wall"),
    [("impact-mash-tl4-sut", ()), (LINEAR_TRUCK, WALL_THAT_GIVES)],
    ids=["rigid wall", "wall that gives"],
)
def test_a_whole_impact_goes_on_with_the_same_bits(scene, wall):
    changes = ("time.end=0.4", "plate.elements=[8,3]", *wall)
    fe_plan = ImpactCase(*read_scene(scene, changes)).plan()

    def run(keeper):
        return impact.simulate_impact(fe_plan.model, fe_plan.touch, fe_plan.sample, 0.4, checkpoint=keeper)

    stopping = Stopping(2)
    with pytest.raises(KeyboardInterrupt):
        run(stopping)
    same(run(Stopping(0, stopping.arrays)), run(None))


def keeper(place, definition, resume=False, run=1):
    """Of a run of the command, by its number."""
    keepers = checkpoints.Checkpoints(place, definition, resume)
    for _ in range(run):
        keepers.next()
    return keepers


def write_checkpoint(place, definition, size, run=1):
    """Write a checkpoint with `size` rows, and return its file."""
    arrays = {"x": np.arange(2.0), "rows": np.arange(3.0 * size).reshape(size, 3)}
    keeper(place, definition, run=run).save(lambda: arrays)
    return Path(f"{keeper(place, definition)._own}{run}")


def loaded_rows(place, definition, resume=True, run=1, width=3):
    arrays = keeper(place, definition, resume, run).load(lambda rows: {"rows": (rows, width), "x": (2,)})
    return arrays and len(arrays["rows"])


@pytest.fixture
def at_once(monkeypatch):
    """Checkpoints at each stop of a run."""
    monkeypatch.setattr(checkpoints, "SAVE_S", 0.0)


def test_a_run_into_a_folder_that_is_not_there_yet(tmp_path, monkeypatch, at_once):
    """The first run of a user has a checkpoint, and no folder."""
    monkeypatch.chdir(tmp_path)
    assert cli._status(["run", "paper-abaqus", "--no-pictures", "--quiet"]) == 0
    assert [path.name for path in tmp_path.joinpath("results").iterdir()] == ["paper-abaqus"]


def test_files_belong_to_one_definition(tmp_path, at_once, capsys):
    """Each run has a file, and those of other scenes remain."""
    place, scene, second_scene = tmp_path / "out", {"scene": 1}, {"scene": 2}
    files = [write_checkpoint(place, scene, 3), write_checkpoint(place, scene, 4, run=2)]
    theirs = write_checkpoint(place, second_scene, 5)
    assert [loaded_rows(place, scene, run=run) for run in (1, 2, 3)] == [3, 4, None]
    assert (loaded_rows(place, second_scene), loaded_rows(place, scene, resume=False)) == (5, None)
    assert capsys.readouterr().err == ""
    before = theirs.read_bytes()
    with checkpointed(place, {"scene": 3}, True):
        checkpoint = next_checkpoint()
        assert checkpoint is not None
        assert checkpoint.load(lambda length: {}) is None
    stay = ", ".join(sorted(path.name for path in (*files, theirs)))
    assert f"checkpoints of other scenes or versions are kept: {stay}; the run" in capsys.readouterr().err
    with checkpointed(place, scene, True):
        assert set(tmp_path.iterdir()) == {*files, theirs}
    assert (list(tmp_path.iterdir()), theirs.read_bytes(), capsys.readouterr().err) == ([theirs], before, "")
    theirs.unlink()
    with checkpointed(place, scene, True):
        pass
    assert capsys.readouterr().err.endswith("this run has no checkpoint; the run starts from the beginning\n")


def test_places_of_long_names_have_their_own(tmp_path, at_once):
    places = [tmp_path / ("\N{OGHAM LETTER BEITH}" * 80 + end) for end in "ab"]
    write_checkpoint(places[0], {}, 3)
    assert [loaded_rows(place, {}) for place in places] == [3, None]


def flipped(content, at):
    return content[:at] + bytes([content[at] ^ 16]) + content[at + 1 :]


@pytest.mark.parametrize("damage", [
    *(lambda content, at=at: flipped(content, at) for at in (0, 31, 32, 39, 40, -1)),
    *(lambda content, n=n: content[:n] for n in (0, 10, 40, -8, -1)),
    lambda content: content + bytes(24), lambda content: b"torn",
])  # fmt: skip
def test_a_damaged_file_is_told_and_not_read(tmp_path, at_once, capsys, damage):
    path = write_checkpoint(tmp_path / "out", {}, 3)
    path.write_bytes(damage(path.read_bytes()))
    assert loaded_rows(tmp_path / "out", {}) is None
    message = capsys.readouterr().err
    assert f"the checkpoint {path} is damaged; the run starts from the beginning" in message


def test_a_file_of_another_kind_run_or_form_is_told_and_not_read(tmp_path, at_once, capsys):
    place = tmp_path / "out"
    path, second = write_checkpoint(place, {}, 3), write_checkpoint(place, {}, 3, run=2)
    for width in (2, 4, 10**15):
        assert loaded_rows(place, {}, width=width) is None
    content = path.read_bytes()
    path.write_bytes(second.read_bytes())
    assert loaded_rows(place, {}) is None
    path.write_bytes(content)
    assert loaded_rows(place, {}) == 3
    for make in (os.mkfifo, os.mkdir, lambda path: os.symlink("/dev/zero", path)):
        path.unlink()
        make(path)
        assert loaded_rows(place, {}) is None
        path = path.rename(tmp_path / make.__name__) and path
        path.touch()
    assert capsys.readouterr().err.count("is damaged") == 7


def test_only_what_there_is_is_promised(tmp_path, at_once):
    """The message does not mention damaged or foreign checkpoints."""
    place = tmp_path / "out"
    arrays = functools.partial(dict[str, np.ndarray], rows=np.zeros((1, 3)))

    def command(act):
        with checkpointed(place, {}, True):
            act(next_checkpoint())
            raise KeyboardInterrupt

    write_checkpoint(place, {"scene": 2}, 3)
    write_checkpoint(place, {}, 3).write_bytes(b"torn")
    for act in (lambda it: None, lambda it: it.load(lambda rows: {"rows": (rows, 3)})):
        with pytest.raises(KeyboardInterrupt) as caught:
            command(act)
        assert not isinstance(caught.value, errors.Interrupted)
    for act in (lambda it: it.save(arrays), lambda it: it.load(lambda rows: {"rows": (rows, 3)})):
        with pytest.raises(errors.Interrupted, match="--resume"):
            command(act)


RUN = ["run", "paper-abaqus", "--set", "plate.elements=[6,2]", "--no-pictures", "--quiet", "--out", "out"]


@pytest.mark.parametrize("change", [
    lambda a: {"state.positions": a["state.positions"][:, :4]},
    lambda a: {"state.positions": a["state.positions"].T, "state.velocities": a["state.velocities"].T},
    lambda a: {"rows": a["rows"][:, :-1]}, lambda a: {"rows": a["rows"][:1]}, lambda a: {"rows": a["rows"][:0]},
    lambda a: {"rows": np.vstack([a["rows"]] * 9)}, lambda a: {"last": np.zeros(0)}, lambda a: {"more": np.zeros(3)},
    lambda a: {"seen": a["seen"].T}, lambda a: {"state.sums": np.zeros(3)}, lambda a: {},
])  # fmt: skip
def test_arrays_of_other_shapes_never_reach_compiled_code(tmp_path, monkeypatch, capsys, at_once, change):
    """A file with a correct digest is used with the expected shapes."""
    monkeypatch.chdir(tmp_path)
    save, saved = checkpoints.Checkpoints.save, []

    def interrupted(self, arrays):
        saved.append({name: np.array(array) for name, array in arrays().items()})
        if len(saved) == 20:
            save(self, lambda: {**saved[-1], **change(saved[-1])})
            raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(checkpoints.Checkpoints, "save", interrupted)
        assert cli._status(RUN) == 130
    assert "--resume" in capsys.readouterr().err
    assert cli._status([*RUN, "--resume"]) == 0
    assert ("is damaged; the run starts" in capsys.readouterr().err) == bool(change(saved[-1]))


LONG = ("--set", "plate.youngs_modulus=1e8 GPa", "--set", "corner.reaction=none", "--no-pictures")
OFTEN = """
import sys
from tailslap.cli import main
from tailslap.storage import checkpoints
checkpoints.SAVE_S = 0.3
main(sys.argv[1:])
"""
"""Checkpoints at short intervals, so that no run ends before the first."""


def started(folder, *more):
    words = ["run", "paper-table-3", *LONG, "--out", "results/paper-table-3", *more]
    command = [sys.executable, "-c", OFTEN, *words]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def files(folder):
    """Result files, of the summary what does not depend on the clock."""
    tables = {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix == ".csv"}
    summary = json.loads((folder / "summary.json").read_text())
    return {**tables, **{name: value for name, value in summary.items() if name != "cost"}}


@pytest.mark.long
@pytest.mark.parametrize("sent", [signal.SIGKILL, signal.SIGTERM])
def test_a_run_that_is_killed_and_resumed_leaves_the_same_files(tmp_path, sent):
    undisturbed, broken = tmp_path / "whole", tmp_path / "broken"
    undisturbed.mkdir()
    broken.mkdir()
    process, end = started(broken), time.monotonic() + 240.0
    while not list(broken.glob("results/.p*.checkpoint-*")):  # a partial file begins with two dots
        assert process.poll() is None, "it was done before it could be killed"
        assert time.monotonic() < end
        time.sleep(0.05)
    time.sleep(0.1)  # until its folder is on the disk
    process.send_signal(sent)
    message = process.communicate(timeout=60)[1]
    assert (sent == signal.SIGKILL) or (process.returncode == 130 and b"--resume" in message)
    for folder, more in ((broken, ("--resume",)), (undisturbed, ())):
        run = started(folder, *more)
        assert run.communicate(timeout=300)[1] == b""
        assert run.returncode == 0
    results = [folder / "results" / "paper-table-3" for folder in (broken, undisturbed)]
    assert files(results[0]) == files(results[1])
    assert [path.name for path in (broken / "results").iterdir()] == ["paper-table-3"]
