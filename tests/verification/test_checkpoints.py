"""Verification: a run resumed from a checkpoint has the bits and files of an undisturbed one."""

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
    """Keeps a copy each time, and interrupts the run at one of them."""

    def __init__(self, at, kept=None):
        self.left, self.kept = at, kept

    def load(self, sizes):
        if self.kept is not None:  # the expected shapes are those of the arrays
            assert sizes(len(self.kept["rows"])) == {name: array.shape for name, array in self.kept.items()}
        return self.kept

    def save(self, arrays):
        self.left -= 1
        if self.left == 0:
            self.kept = {name: np.array(array) for name, array in arrays().items()}
            raise KeyboardInterrupt


def same(a, b):
    """All numbers of two runs, bit for bit, but for the times that they took."""
    for name in set(vars(a)) - {"setup_s", "time_loop_s", "strike", "snapshots"}:
        mine, its = getattr(a, name), getattr(b, name)
        for key in mine if isinstance(mine, dict) else [()]:
            assert_array_equal(np.asarray(mine[key] if key else mine), np.asarray(its[key] if key else its))


@pytest.mark.parametrize(("at", "snapshots"), [(1, 6), (20, 6), (45, 6), (20, 1), (30, 400)])
def test_the_loop_goes_on_with_the_same_bits(at, snapshots):
    fe_plan = CornerCase(*read_scene("paper-table-3")).plan()

    def run(keeper):
        duration = fe_plan.case.motion.strike.t
        kept = {"rows": 300, "snapshots": snapshots, "checkpoint": keeper}
        return corner.simulate(fe_plan.model, fe_plan.start, duration, **kept)

    stopping = Stopping(at)
    with pytest.raises(KeyboardInterrupt):
        run(stopping)
    resumed, whole = run(Stopping(0, stopping.kept)), run(None)
    same(resumed, whole)
    same(resumed.snapshots, whole.snapshots)
    assert resumed.strike.values == whole.strike.values
    assert_array_equal(resumed.strike.velocities, whole.strike.velocities)


WALL_THAT_GIVES = (
    "wall.length=36 m", "wall.depth=0.3 m", "wall.height=1 m", "wall.elements=[60,1]",
    "wall.foundation_stiffness=100 MN/m^2",
)  # fmt: skip


@pytest.mark.parametrize("wall", [(), WALL_THAT_GIVES], ids=["rigid wall", "wall that gives"])
def test_a_whole_impact_goes_on_with_the_same_bits(wall):
    scene = ("time.end=0.4", "plate.elements=[8,3]", *wall)
    fe_plan = ImpactCase(*read_scene("impact-mash-tl4-sut", scene)).plan()

    def run(keeper):
        return impact.simulate_impact(fe_plan.model, fe_plan.touch, fe_plan.sample, 0.4, checkpoint=keeper)

    stopping = Stopping(2)
    with pytest.raises(KeyboardInterrupt):
        run(stopping)
    same(run(Stopping(0, stopping.kept)), run(None))


def keeper(place, definition, resume=False, run=1):
    """Of a run of the command, by its number."""
    keepers = checkpoints.Checkpoints(place, definition, resume)
    for _ in range(run):
        keepers.next()
    return keepers


def kept(place, definition, size, run=1):
    """Write a checkpoint with `size` rows of three numbers, and return its file."""
    arrays = {"x": np.arange(2.0), "rows": np.arange(3.0 * size).reshape(size, 3)}
    keeper(place, definition, run=run).save(lambda: arrays)
    return Path(f"{keeper(place, definition)._own}{run}")


def rows_found(place, definition, resume=True, run=1, width=3):
    found = keeper(place, definition, resume, run).load(lambda rows: {"rows": (rows, width), "x": (2,)})
    return found and len(found["rows"])


@pytest.fixture
def at_once(monkeypatch):
    """Checkpoints at each stop of a run."""
    monkeypatch.setattr(checkpoints, "SAVE_S", 0.0)


def test_a_run_into_a_folder_that_is_not_there_yet(tmp_path, monkeypatch, at_once):
    """As the first run of a user is, where it takes long enough for a checkpoint."""
    monkeypatch.chdir(tmp_path)
    assert cli._status(["run", "paper-abaqus", "--no-pictures", "--quiet"]) == 0
    assert [path.name for path in tmp_path.joinpath("results").iterdir()] == ["paper-abaqus"]


def test_files_belong_to_one_definition(tmp_path, at_once, capsys):
    """Each run has its own; those of another scene are neither read nor touched, but named."""
    place, one, other = tmp_path / "out", {"scene": 1}, {"scene": 2}
    files = [kept(place, one, 3), kept(place, one, 4, run=2)]
    theirs = kept(place, other, 5)
    assert [rows_found(place, one, run=run) for run in (1, 2, 3)] == [3, 4, None]
    assert (rows_found(place, other), rows_found(place, one, resume=False)) == (5, None)
    assert capsys.readouterr().err == ""
    before = theirs.read_bytes()
    with checkpointed(place, {"scene": 3}, True):
        checkpoint = next_checkpoint()
        assert checkpoint is not None
        assert checkpoint.load(lambda length: {}) is None
    stay = ", ".join(sorted(path.name for path in (*files, theirs)))
    assert f"checkpoints of other scenes or versions are kept: {stay}; the run" in capsys.readouterr().err
    with checkpointed(place, one, True):
        assert set(tmp_path.iterdir()) == {*files, theirs}
    assert (list(tmp_path.iterdir()), theirs.read_bytes(), capsys.readouterr().err) == ([theirs], before, "")
    theirs.unlink()
    with checkpointed(place, one, True):
        pass
    assert capsys.readouterr().err.endswith("this run has no checkpoint; the run starts from the beginning\n")


def test_places_of_long_names_have_their_own(tmp_path, at_once):
    places = [tmp_path / ("\N{OGHAM LETTER BEITH}" * 80 + end) for end in "ab"]
    kept(places[0], {}, 3)
    assert [rows_found(place, {}) for place in places] == [3, None]


def flipped(content, at):
    return content[:at] + bytes([content[at] ^ 16]) + content[at + 1 :]


@pytest.mark.parametrize("damage", [
    *(lambda whole, at=at: flipped(whole, at) for at in (0, 31, 32, 39, 40, -1)),
    *(lambda whole, n=n: whole[:n] for n in (0, 10, 40, -8, -1)),
    lambda whole: whole + bytes(24), lambda whole: b"torn",
])  # fmt: skip
def test_a_damaged_file_is_told_and_not_read(tmp_path, at_once, capsys, damage):
    path = kept(tmp_path / "out", {}, 3)
    path.write_bytes(damage(path.read_bytes()))
    assert rows_found(tmp_path / "out", {}) is None
    said = capsys.readouterr().err
    assert f"the checkpoint {path} is damaged; the run starts from the beginning" in said


def test_a_file_of_another_kind_run_or_form_is_told_and_not_read(tmp_path, at_once, capsys):
    place = tmp_path / "out"
    path, second = kept(place, {}, 3), kept(place, {}, 3, run=2)
    for width in (2, 4, 10**15):
        assert rows_found(place, {}, width=width) is None
    whole = path.read_bytes()
    path.write_bytes(second.read_bytes())
    assert rows_found(place, {}) is None
    path.write_bytes(whole)
    assert rows_found(place, {}) == 3
    for make in (os.mkfifo, os.mkdir, lambda path: os.symlink("/dev/zero", path)):
        path.unlink()
        make(path)
        assert rows_found(place, {}) is None
        path = path.rename(tmp_path / make.__name__) and path
        path.touch()
    assert capsys.readouterr().err.count("is damaged") == 7


def test_only_what_there_is_is_promised(tmp_path, at_once):
    """Interrupted before a checkpoint, or with a damaged or foreign one, the message mentions none."""
    place = tmp_path / "out"
    arrays = functools.partial(dict[str, np.ndarray], rows=np.zeros((1, 3)))

    def command(act):
        with checkpointed(place, {}, True):
            act(next_checkpoint())
            raise KeyboardInterrupt

    kept(place, {"scene": 2}, 3)
    kept(place, {}, 3).write_bytes(b"torn")
    for act in (lambda it: None, lambda it: it.load(lambda rows: {"rows": (rows, 3)})):
        with pytest.raises(KeyboardInterrupt) as caught:
            command(act)
        assert not isinstance(caught.value, errors.Interrupted)
    for act in (lambda it: it.save(arrays), lambda it: it.load(lambda rows: {"rows": (rows, 3)})):
        with pytest.raises(errors.Interrupted, match="--resume"):
            command(act)


RUN = ["run", "paper-abaqus", "--no-pictures", "--quiet", "--out", "out"]


@pytest.mark.parametrize("change", [
    lambda a: {"state.positions": a["state.positions"][:, :4]},
    lambda a: {"state.positions": a["state.positions"].T, "state.velocities": a["state.velocities"].T},
    lambda a: {"rows": a["rows"][:, :-1]}, lambda a: {"rows": a["rows"][:1]}, lambda a: {"rows": a["rows"][:0]},
    lambda a: {"rows": np.vstack([a["rows"]] * 9)}, lambda a: {"last": np.zeros(0)}, lambda a: {"more": np.zeros(3)},
    lambda a: {"seen": a["seen"].T}, lambda a: {"state.sums": np.zeros(3)}, lambda a: {},
])  # fmt: skip
def test_arrays_of_other_shapes_never_reach_compiled_code(tmp_path, monkeypatch, capsys, at_once, change):
    """A file with correct digest and name is used only with the arrays that the run has at that row."""
    monkeypatch.chdir(tmp_path)
    save, found = checkpoints.Checkpoints.save, []

    def interrupted(self, arrays):
        found.append({name: np.array(array) for name, array in arrays().items()})
        if len(found) == 20:
            save(self, lambda: {**found[-1], **change(found[-1])})
            raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(checkpoints.Checkpoints, "save", interrupted)
        assert cli._status(RUN) == 130
    assert "--resume" in capsys.readouterr().err
    assert cli._status([*RUN, "--resume"]) == 0
    assert ("is damaged; the run starts" in capsys.readouterr().err) == bool(change(found[-1]))


LONG = ("--set", "plate.youngs_modulus=1e17", "--set", "corner.reaction=none", "--no-pictures")
OFTEN = """
import sys
from tailslap.cli import main
from tailslap.storage import checkpoints
checkpoints.SAVE_S = 0.3
main(sys.argv[1:])
"""
"""Checkpoints as soon as they may be, so that on no machine the run ends before the first."""


def started(folder, *more):
    command = [sys.executable, "-c", OFTEN, "run", "paper-table-3", *LONG, *more]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def files(folder):
    """Result files, of the summary what does not depend on the clock."""
    found = {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix == ".csv"}
    summary = json.loads((folder / "summary.json").read_text())
    return {**found, **{name: value for name, value in summary.items() if name != "cost"}}


@pytest.mark.long
@pytest.mark.parametrize("sent", [signal.SIGKILL, signal.SIGTERM])
def test_a_run_that_is_killed_and_resumed_leaves_the_same_files(tmp_path, sent):
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    whole.mkdir()
    broken.mkdir()
    process, end = started(broken), time.monotonic() + 240.0
    while not list(broken.glob("results/.p*.checkpoint-*")):  # a partial file begins with two dots
        assert process.poll() is None, "it was done before it could be killed"
        assert time.monotonic() < end
        time.sleep(0.05)
    time.sleep(0.1)  # until its folder is on the disk
    process.send_signal(sent)
    said = process.communicate(timeout=60)[1]
    assert (sent == signal.SIGKILL) or (process.returncode == 130 and b"--resume" in said)
    for folder, more in ((broken, ("--resume",)), (whole, ())):
        done = started(folder, *more)
        assert done.communicate(timeout=300)[1] == b""
        assert done.returncode == 0
    results = [folder / "results" / "paper-table-3" for folder in (broken, whole)]
    assert files(results[0]) == files(results[1])
    assert [path.name for path in (broken / "results").iterdir()] == ["paper-table-3"]
