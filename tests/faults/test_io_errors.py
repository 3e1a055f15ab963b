"""Verify that errors other than ENOENT and ENOTDIR replace nothing."""

import contextlib
import errno
import io
import os
import socket

import numpy as np
import pytest
from failing_calls import is_supported, run_in_child

from postprocess.fields import formats, series
from tailslap import errors
from tailslap.campaign import sweep_run
from tailslap.campaign.records import Records, count
from tailslap.campaign.sweep_definition import make_definition
from tailslap.result import load
from tailslap.scene import read
from tailslap.storage import checkpoints, folder, manifest

ROWS = {0: {"run": 0, "status": "passed"}}
FIELDS = series.FieldSeries(
    "quad",
    np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]),
    np.array([[0, 1, 2, 3]]),
    np.array([0.0, 0.1]),
    {name: np.full((2, 4, 2), 0.3) for name in series.NODES},
    {name: np.full((2, 1), 0.7) for name in series.ELEMENTS},
)
TABLE = ({"t": np.linspace(0.0, 1.0, 9)}, {"t": "s"})
UNKNOWN = pytest.mark.parametrize("error", [errno.ENOMEM, errno.EACCES, errno.ESTALE, errno.EIO])
"""Errors after which a file may be there."""


@pytest.fixture
def fail(monkeypatch, proc):
    """Let calls of the system to files of a name fail."""

    def start(name, error, *calls):
        def wrapped(function):
            def call(path, *values, **options):
                target = os.readlink(f"/proc/self/fd/{path}") if isinstance(path, int) else os.fspath(path)
                if os.path.basename(target) == name:
                    raise OSError(error, os.strerror(error), target)
                return function(path, *values, **options)

            return call

        for place, function in calls:
            monkeypatch.setattr(place, function, wrapped(getattr(place, function)))

    yield start
    monkeypatch.undo()


LOOKS = ((os, "stat"), (os, "lstat"))
OPENS = ((os, "open"), (io, "open"))


@UNKNOWN
@pytest.mark.parametrize("calls", [LOOKS, OPENS])
def test_records_stay(tmp_path, fail, monkeypatch, error, calls):
    path = tmp_path / "records"
    rows = Records(path, {})
    rows.add(ROWS)
    rows.close()
    fail("records", error, *calls)
    with pytest.raises(OSError, match=os.strerror(error)):
        Records(path, {})
    monkeypatch.undo()
    assert count(path) == 1


@UNKNOWN
def test_the_number_of_records_is_not_guessed(tmp_path, fail, error):
    fail("records", error, *OPENS)
    with pytest.raises(OSError, match=os.strerror(error)):
        count(tmp_path / "records")


@UNKNOWN
def test_a_sweep_that_cannot_be_read_is_not_called_damaged(tmp_path, fail, error):
    sweep = make_definition("paper-table-3", (), ("corner.friction=0.1,0.2",), None, 1)
    with (
        sweep_run.sweep_folder(tmp_path / "sweep", sweep) as place,
        sweep_run.open_records(place, sweep) as rows,
    ):
        rows.add(ROWS)
    fail(sweep_run.DEFINITION, error, (io, "open"))
    with pytest.raises((OSError, errors.InputError), match=os.strerror(error)):
        sweep_run.sweep_folder(tmp_path / "sweep", sweep).__enter__()
    assert count(tmp_path / "sweep" / sweep_run.RECORDS) == 1


@UNKNOWN
@pytest.mark.parametrize("calls", [LOOKS, OPENS])
def test_a_checkpoint_that_cannot_be_read_is_not_begun_again(
    tmp_path, fail, capsys, monkeypatch, error, calls
):
    monkeypatch.setattr(checkpoints, "SAVE_S", 0.0)
    checkpoints.Checkpoints(tmp_path / "out", {}, False).next().save(lambda: {"rows": np.ones((1, 1))})
    (path,) = tmp_path.iterdir()
    content = path.read_bytes()
    keeper = checkpoints.Checkpoints(tmp_path / "out", {}, True).next()
    assert keeper.load(lambda rows: {"rows": (rows, 1)}) is not None
    fail(path.name, error, *calls)
    with pytest.raises(OSError, match=os.strerror(error)):
        keeper.load(lambda rows: {"rows": (rows, 1)})
    monkeypatch.undo()
    assert (path.read_bytes(), capsys.readouterr().err) == (content, "")


@UNKNOWN
@pytest.mark.parametrize("name", ["mash-tl4-sut", "mash-tl5-tractor-van", "mine"])
def test_a_scene_that_cannot_be_found_is_no_other(tmp_path, fail, monkeypatch, error, name):
    """A file may have the name of a scene of the program."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text("name = 'mine'\n")
    fail(name, error, *LOOKS)
    with pytest.raises((OSError, errors.InputError), match=os.strerror(error)):
        read.scene_text(name)


@UNKNOWN
def test_an_empty_folder_of_the_user_stays(tmp_path, fail, monkeypatch, error):
    (tmp_path / "out").mkdir()
    fail("out", error, *LOOKS)
    with (
        pytest.raises((OSError, errors.InputError), match=os.strerror(error)),
        folder.locked(tmp_path / "out"),
    ):
        raise AssertionError
    monkeypatch.undo()
    assert (tmp_path / "out").is_dir()


@UNKNOWN
@pytest.mark.parametrize("call", ["mkdir", "listdir"])
def test_a_result_that_is_complete_is_called_so(tmp_path, fail, monkeypatch, error, call):
    """The folder for new files fails after the last file is renamed."""

    def write():
        with folder.result_folder(tmp_path / "out") as new:
            (new / "summary.json").write_text("{}")
            if call == "listdir":
                folder.commit(new.parent)
            fail(manifest.NEW, error, (os, call))

    ending = f"the result.* is complete.*{os.strerror(error)}"
    with pytest.raises((OSError, errors.InputError), match=ending):
        write()
    monkeypatch.undo()
    listed = manifest.read_manifest(tmp_path / "out")
    assert listed
    assert [item.path for item in listed] == ["summary.json"]


def bind_socket(path):
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(path))


SPECIAL = (os.mkfifo, os.mkdir, bind_socket, lambda path: os.symlink("elsewhere", path))


@pytest.mark.parametrize("make", SPECIAL)
def test_what_is_no_regular_file_is_no_entry(tmp_path, make):
    make(tmp_path / "special")
    assert manifest.entry(tmp_path / "special") is None
    assert manifest.read_object(tmp_path / "special") == {}
    assert not errors.is_there(tmp_path / "special" / "below")
    assert errors.is_there(tmp_path / "special")


supported = pytest.mark.skipif(not is_supported(), reason="the kernel does not ask about calls")


def failed_calls(function, folder):
    """Yield answers of a function whose calls fail, one in each turn."""
    _, calls = run_in_child(function, str(folder))
    assert calls
    yield from (run_in_child(function, str(folder), n, errno.EIO)[0] for n in range(1, len(calls) + 1))


@supported
@pytest.mark.parametrize("kind", ["vtkhdf", "xdmf", "vtu", "msh", "csv", "parquet"])
def test_a_file_for_other_programs_is_whole_or_the_error_is_raised(tmp_path, kind):
    """Whatever the library does with errors, HDF5 and Arrow among them."""
    path, content = tmp_path / f"file.{kind}", TABLE if kind in ("csv", "parquet") else FIELDS

    def write():
        getattr(formats, f"write_{kind}")(path, content)
        return "written"

    write()
    complete, failures = path.read_bytes(), 0
    for text in failed_calls(write, tmp_path):
        failures += "Input/output error" in text
        assert "Input/output error" in text or (text, path.read_bytes()) == ("written", complete)
    assert failures


@supported
def test_a_lock_that_cannot_be_closed_is_released(tmp_path):
    def hold():
        with manifest.locked_file(tmp_path / "lock"):
            (tmp_path / "lock").unlink()
            return "held"

    _, calls = run_in_child(hold, str(tmp_path))
    assert calls[-1].name == "close"
    assert run_in_child(hold, str(tmp_path), len(calls), errno.EIO)[0] == "held"


@supported
def test_of_a_lock_that_fails_no_file_remains(tmp_path):
    """One of another process stays."""

    def names():
        with contextlib.suppress(OSError), manifest.locked_file(tmp_path / "lock"):
            (tmp_path / "lock").unlink()
        return " ".join(os.listdir(tmp_path))

    _, calls = run_in_child(names, str(tmp_path))
    count = [call.name for call in calls].index("unlink")
    assert [run_in_child(names, str(tmp_path), n, errno.EIO)[0] for n in range(1, count + 1)] == [""] * count
    (tmp_path / "lock").touch()
    assert [run_in_child(names, str(tmp_path), n, errno.EIO)[0] for n in range(1, 4)] == ["lock"] * 3


@supported
def test_a_file_that_cannot_be_read_is_not_called_damaged(tmp_path):
    with folder.result_folder(tmp_path / "result") as new:
        series.write_fields(new / series.FILE, FIELDS)
    stored = load.Stored(tmp_path / "result")

    def read():
        stored.read(series.FILE, series.read_fields)
        return "read"

    texts = [*failed_calls(read, tmp_path)]
    assert "damaged" not in "".join(texts)
    assert [text for text in texts if "Input/output error" not in text and text != "read"] == []
