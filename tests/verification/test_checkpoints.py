"""Verification: a run that goes on from a checkpoint gives the bits and the files of one that was left alone."""

import functools
import json
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fem.run import corner, impact, observers
from tailslap import cli, errors
from tailslap.case.corner.case import CornerCase
from tailslap.case.impact.case import ImpactCase
from tailslap.files import checkpoints
from tailslap.files.checkpoints import checkpointed, next_checkpoint
from tailslap.scene.read import read_scene


class Stopping:
    """Keeps a copy each time, and interrupts the run at one of them."""

    def __init__(self, at, kept=None):
        self.left, self.kept = at, kept

    def load(self):
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


@pytest.mark.parametrize("at", [1, 20, 45])
def test_the_loop_goes_on_with_the_same_bits(at):
    fe_plan = CornerCase(*read_scene("paper-table-3")).plan()

    def run(keeper):
        duration = fe_plan.case.motion.strike.t
        kept = {"rows": 300, "snapshots": 6, "checkpoint": keeper}
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


def loaded(place, definition, resume, count=1):
    """Sizes of what the first runs of a command find, which is then interrupted."""
    found: list[observers.Arrays | None] = []

    def interrupted_command():
        with checkpointed(place, definition, resume):
            found.extend(next_checkpoint().load() for _ in range(count))
            raise KeyboardInterrupt

    with pytest.raises(errors.Interrupted, match="--resume"):
        interrupted_command()
    return [None if each is None else each["x"].size for each in found]


def test_a_run_into_a_folder_that_is_not_there_yet(tmp_path, monkeypatch):
    """As the first run of a user is, where it takes long enough for a checkpoint."""
    monkeypatch.setattr(checkpoints, "SAVE_S", 0.0)
    monkeypatch.chdir(tmp_path)
    assert cli._status(["run", "paper-abaqus", "--no-pictures", "--quiet"]) == 0
    assert [path.name for path in tmp_path.joinpath("results").iterdir()] == ["paper-abaqus"]


def test_files_belong_to_one_definition(tmp_path, monkeypatch):
    monkeypatch.setattr(checkpoints, "SAVE_S", 0.0)
    place = tmp_path / "out"
    keepers = checkpoints.Checkpoints(place, {"scene": 1}, False)
    for size in (3, 4):
        keepers.next().save(functools.partial(dict, x=np.arange(size)))
    assert (len(list(tmp_path.iterdir())), loaded(place, {"scene": 1}, True, 3)) == (2, [3, 4, None])
    assert (loaded(place, {"scene": 2}, True), loaded(place, {"scene": 1}, False)) == ([None], [None])
    (tmp_path / ".out.checkpoint-1.npz").write_bytes(b"torn")
    with checkpointed(place, {"scene": 1}, True):
        assert next_checkpoint().load() is None
    assert list(tmp_path.iterdir()) == []


LONG = ("--set", "plate.youngs_modulus=1e17", "--set", "corner.reaction=none", "--no-pictures")
OFTEN = """
import sys
from tailslap.cli import main
from tailslap.files import checkpoints
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
    while not list(broken.glob("results/.*.npz")):
        assert process.poll() is None, "it was done before it could be killed"
        assert time.monotonic() < end
        time.sleep(0.05)
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
