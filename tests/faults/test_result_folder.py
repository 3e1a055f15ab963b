"""Verify that a folder has one complete result after any failure.

One command at a time works in it, and files of others remain.
"""

import errno
import fcntl
import hashlib
import itertools
import json
import os
import shutil
import signal
import threading
from pathlib import Path

import pytest

import tailslap
from tailslap.cli import _status
from tailslap.errors import InputError, Interrupted
from tailslap.storage import folder, manifest
from tailslap.storage.folder import recover, result_folder
from tailslap.storage.manifest import LOCK, LOG, NAME, NEW, Origin, whole_file

RESULT = {"report.html": "page", "summary.json": "{}", "history.csv": "t\n"}


def write(place, texts, **options):
    with result_folder(place, **options) as new:
        for name, text in texts.items():
            (new / name).write_text(text)


def fill(place, **more):
    write(place, RESULT | {f"{name}.txt": text for name, text in more.items()})


def tree(folder):
    """Paths below a folder, with texts of files and targets of links."""
    paths = {str(path.relative_to(folder)): path for path in folder.rglob("*")}
    return {
        name: os.readlink(path) if path.is_symlink() else path.read_text() if path.is_file() else None
        for name, path in paths.items()
    }


@pytest.fixture
def place(tmp_path):
    """Folder with an earlier result, alone in its parent."""
    fill(tmp_path / "results" / "a", old="old")
    return tmp_path / "results" / "a"


def foreign(place, texts):
    """A folder with files of others."""
    place.mkdir()
    for name, text in texts.items():
        (place / name).write_text(text)
    return place


def refused(place, named):
    """Expect an error before any work, without changes."""
    before = tree(place.parent)
    with pytest.raises(InputError, match=named) as caught, result_folder(place):
        raise AssertionError
    assert caught.value.key == "--out"
    assert str(place) in str(caught.value)
    assert tree(place.parent) == before


def test_the_manifest_lists_what_was_written(place):
    contents = json.loads((place / NAME).read_text())
    assert (contents["program"], contents["command"], contents["scene"]) == ("tailslap", "", "")
    listed = {item["path"]: (item["size"], item["sha256"]) for item in contents["files"]}
    texts = {**RESULT, "old.txt": "old"}
    digests = {name: (len(text), hashlib.sha256(text.encode()).hexdigest()) for name, text in texts.items()}
    assert listed == digests


def test_absent_and_empty_folders_are_places_and_a_result_is_replaced(place):
    fill(place)
    assert set(tree(place)) == {*RESULT, NAME}
    (place.parent / "empty").mkdir(mode=0o700)
    fill(place.parent / "empty")
    assert set(tree(place.parent / "empty")) == {*RESULT, NAME}
    assert (place.parent / "empty").stat().st_mode & 0o777 == 0o700
    assert {path.name for path in place.parent.iterdir()} == {"a", "empty"}


def test_a_folder_with_a_summary_is_no_result(tmp_path, capsys):
    mine = foreign(tmp_path / "mine", {"thesis.txt": "x", "summary.json": "{}"})
    assert _status(["run", "paper-table-3", "--out", str(mine)]) == 2
    assert "thesis.txt" in capsys.readouterr().err
    message = (
        r"the folder contains other files \(summary.json, thesis.txt\); allowed is a new or empty folder"
    )
    refused(mine, message)


def test_results_within_are_kept(place):
    """A result in another one remains, and prevents a new one above."""
    refused(place.parent, r"other files \(a\)")
    outer = place.parents[1] / "outer"
    fill(outer)
    fill(outer / "b", kept="kept")
    before = tree(outer / "b")
    fill(outer)
    assert tree(outer / "b") == before


def test_what_was_added_stays(place, tmp_path):
    (place / "notes.txt").write_text("mine")
    (place / "plots" / "deep").mkdir(parents=True)
    (place / "plots" / "deep" / "a.txt").write_text("mine")
    (tmp_path / "elsewhere").mkdir()
    (place / "link").symlink_to(tmp_path / "elsewhere")
    (place / "history.csv").unlink()
    fill(place)
    added = {"notes.txt", "plots", "plots/deep", "plots/deep/a.txt", "link"}
    assert set(tree(place)) == {*RESULT, NAME, *added}
    assert (place / "plots" / "deep" / "a.txt").read_text() == "mine"
    assert os.readlink(place / "link") == str(tmp_path / "elsewhere")
    assert [path.name for path in place.parent.iterdir()] == ["a"]


@pytest.mark.parametrize("as_what", ["file", "link", "folder"])
def test_a_file_of_the_result_that_was_changed_is_refused(place, tmp_path, as_what):
    file = place / "history.csv"
    file.unlink()
    if as_what == "file":
        file.write_text("u\n")  # of the same size
    elif as_what == "link":
        (tmp_path / "saved.csv").write_text(RESULT["history.csv"])
        file.symlink_to(tmp_path / "saved.csv")
    else:
        file.mkdir()
    refused(place, r"its file history\.csv was modified")


def test_an_added_file_that_the_result_would_overwrite_is_refused_at_the_end(place):
    (place / "picture.txt").write_text("mine")
    before = tree(place.parent)
    with pytest.raises(InputError, match=r"its file picture\.txt does not belong to the result"):
        fill(place, picture="ours")
    assert tree(place.parent) == before


def forged(has_digest=True, **more):
    item = {"path": "thesis.txt", "size": 1, "sha256": hashlib.sha256(b"x").hexdigest()} | more
    content = {"program": "tailslap", "version": "0.1.0", "files": [item]}
    return json.dumps(content | ({"sha256": manifest._digest(content)} if has_digest else {}))


FOREIGN = [
    *("", "{", "[]", "null", "[" * 100_000, "\0", '{"program": "tailslap"}', '{"files": []}'),
    *('{"program": "tailslap", "files": {}}', '{"program": "tailslap", "files": [3]}'),
    *(forged(path=path) for path in ("../thesis.txt", "/etc/hostname", "a/../../x", "..", ".", "", "a\0b")),
    *(forged(has_digest=False), forged(path=3), forged(path=NAME)),
    *(forged(size="1"), forged(sha256=None), forged(sha256="x")),
]


@pytest.mark.parametrize("manifest", FOREIGN)
def test_a_manifest_that_is_not_ours_makes_no_result(tmp_path, manifest):
    (tmp_path / "thesis.txt").write_text("x")
    refused(foreign(tmp_path / "mine", {"thesis.txt": "x", NAME: manifest}), "other files")


def test_a_forged_manifest_reaches_nothing_outside(tmp_path):
    """It lists a link to a file outside, or is a link."""
    (tmp_path / "thesis.txt").write_text("x")
    mine = foreign(tmp_path / "mine", {NAME: forged()})
    (mine / "thesis.txt").symlink_to(tmp_path / "thesis.txt")
    refused(mine, r"its file thesis\.txt was modified")
    (mine / NAME).rename(tmp_path / "manifest")
    (mine / NAME).symlink_to(tmp_path / "manifest")
    refused(mine, "other files")
    (mine / NAME).unlink()
    os.mkfifo(mine / NAME)
    with pytest.raises(InputError, match="other files"):
        fill(mine)


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir, lambda path: os.symlink("elsewhere", path)])
def test_a_lock_that_is_no_file_is_refused_before_the_work_begins(tmp_path, make):
    place = tmp_path / "result"
    place.mkdir()
    make(place / LOCK)
    with pytest.raises(InputError, match="the folder cannot be locked: "), result_folder(place):
        pytest.fail("the work begins")
    assert os.listdir(place) == [LOCK]
    assert not (place / "elsewhere").exists()


@pytest.mark.parametrize(("changes", "name"), [
    ([], "truck"), (["name=truck"], "truck"), (["impact.speed=60 mph"], "truck+impact.speed=60mph"),
    (["contact.stiffness=2 MN/m", "plate.elements=[20, 6]"], "truck+contact.stiffness=2MN_m+plate.elements=20,6"),
    (["plate="], "truck+plate="), (["corner.friction=-0.1e-3"], "truck+corner.friction=-0.1e-3"),
])  # fmt: skip
def test_a_changed_scene_has_a_folder_of_its_own(changes, name):
    assert folder.default_place("truck", changes) == Path("results", name)
    assert folder.default_place("truck", changes, "-modes") == Path("results", f"{name}-modes")


def test_the_name_of_a_folder_is_bounded_and_tells_all_changes_apart():
    """Other changes are in its digest, which is reproducible."""
    long = "trailer=[{'length': '48 ft', 'width': 2.6, 'mass': 27770.0, 'hitch': 5.6, 'kingpin': 0.9}]"
    changes = [
        long, long.replace("0.9", "0.8"), "corner.reaction=a:b", "corner.reaction=a_b", "corner.reaction=Ä",
    ]  # fmt: skip
    names = [folder.default_place("truck", [change]) for change in changes]
    assert len({*names, *(folder.default_place("truck", [f"impact.speed={n}"]) for n in range(100))}) == 105
    for name, change in zip(names, changes, strict=True):
        assert name == folder.default_place("truck", [change])
        assert name.parent == Path("results")
        assert len(name.name) < 100
        assert name.name.isascii()


def test_a_link_to_a_folder_is_followed(place, tmp_path):
    link, dangling = tmp_path / "link", tmp_path / "dangling"
    link.symlink_to(place)
    dangling.symlink_to(tmp_path / "new")
    (place / "notes.txt").write_text("mine")
    for path, real in ((link, place), (dangling, tmp_path / "new")):
        fill(path)
        assert path.is_symlink()
        assert {*RESULT, NAME} <= set(tree(real))
    assert (place / "notes.txt").read_text() == "mine"
    (tmp_path / "file").write_text("mine")
    (tmp_path / "to-file").symlink_to(tmp_path / "file")
    with pytest.raises(InputError, match="it is a file"):
        fill(tmp_path / "to-file")


def test_a_sweep_s_folder_is_refused_even_with_a_manifest(place):
    (place / "sweep.json").write_text("{}")
    refused(place, "other files")


def test_a_result_of_more_than_files_is_a_mistake(tmp_path):
    with pytest.raises(ValueError, match="not a regular file"), result_folder(tmp_path / "a") as folder:
        (folder / "sub").mkdir()
    assert not list(tmp_path.iterdir())


ADDED = {"notes.txt": "mine", "plots/a.txt": "mine too"}
OLD, NEWER = ({"report.html": text, f"{text}.csv": text, "both.csv": text} for text in ("old", "newer"))
KILLED = -9


def texts(place):
    return {str(path.relative_to(place)): path.read_text() for path in place.rglob("*") if path.is_file()}


def seen(place):
    """The result as seen by a reader, None without one.

    Each file is as listed.
    """
    listed = manifest.read_manifest(folder.path_in(place, NAME).parent)
    for item in listed or ():
        assert manifest.entry(folder.path_in(place, item.path)) == item
    return listed and {item.path: folder.path_in(place, item.path).read_text() for item in listed}


@pytest.fixture
def earlier(tmp_path):
    """An earlier result to which a file and a folder were added."""
    write(tmp_path / "a", OLD)
    for name, text in ADDED.items():
        (tmp_path / "a" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "a" / name).write_text(text)
    return tmp_path / "a"


CALLS = ("fsync", "mkdir", "open", "replace", "rmdir", "unlink")


def break_at(patch, step, fail, calls=CALLS):
    """Call `fail` before a call of the system, or within a text."""
    count = itertools.count(1)
    write_text = Path.write_text

    def counted(call):
        def stepped(*arguments, **options):
            if next(count) == step:
                fail()
            return call(*arguments, **options)

        return stepped

    def torn(path, text, **options):
        if next(count) == step:
            write_text(path, text[: len(text) // 2], **options)
            fail()
        return write_text(path, text, **options)

    for name in calls:
        patch.setattr(os, name, counted(getattr(os, name)))
    if calls is CALLS:
        patch.setattr(Path, "write_text", torn)


def killed_at(step, function, *arguments, calls=CALLS):
    """Call a function in a process that is killed at a step.

    Returns True if it ended before.
    """
    if child := os.fork():
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != KILLED
    try:
        break_at(pytest.MonkeyPatch(), step, lambda: os.kill(os.getpid(), 9), calls)
        function(*arguments)
    finally:
        os._exit(0)


@pytest.mark.parametrize("has_earlier", [False, True])
def test_killed_at_every_step_the_folder_is_whole_and_the_next_one_clears_it(tmp_path, earlier, has_earlier):
    """Check a reader, one with write access, and the next command."""
    states = set()
    for step in itertools.count(1):
        place = tmp_path / f"{step}"
        if has_earlier:
            shutil.copytree(earlier, place)
        if killed_at(step, write, place, NEWER):
            break
        before = seen(place)
        assert before in (NEWER, OLD if has_earlier else None)
        logged = (place / LOG).exists()
        recover(place)
        assert seen(place) == before
        assert not logged or not {LOG, NEW, LOCK} & set(os.listdir(place))
        write(place, OLD)
        assert texts(place) == OLD | {NAME: texts(place)[NAME]} | (ADDED if has_earlier else {})
        states.add((before == NEWER, logged))
    assert step > 40
    assert states == {(False, False), (True, True), (True, False)}


def test_new_files_are_on_the_disk_before_the_log_and_moved_before_it_goes(earlier, monkeypatch, proc):
    """Files are synchronised in the order that recovery requires."""
    calls, fsync, replace, unlink = [], os.fsync, os.replace, os.unlink

    def synced(number):
        calls.append(("sync", Path(os.readlink(f"/proc/self/fd/{number}")).name))
        fsync(number)

    def noted(call):
        def called(*arguments, **options):
            calls.append((call.__name__, Path(arguments[0]).name))
            return call(*arguments, **options)

        return called

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(os, "replace", noted(replace))
    monkeypatch.setattr(os, "unlink", noted(unlink))
    write(earlier, NEWER)
    files = {*NEWER, NAME}
    assert calls.pop(0) == ("sync", "a")
    assert set(calls[: len(files)]) == {("sync", name) for name in files}
    moved = [("replace", name) for name in (*sorted(NEWER), NAME)]
    assert calls[len(files) :] == [
        *[("sync", NEW), ("sync", LOG), ("replace", LOG), ("sync", "a"), ("unlink", "old.csv"), *moved],
        *[("sync", "a"), ("unlink", LOG), ("sync", "a"), ("unlink", LOCK)],
    ]


def failures(place, earlier, failure, calls=CALLS):
    """Yield folders in which a write failed, with the error."""
    for step in itertools.count(1):
        folder, failed, caught = place / f"{step}", [], None
        shutil.copytree(earlier, folder)

        def fail():
            failed.append(step)  # noqa: B023
            raise failure

        with pytest.MonkeyPatch.context() as patch:
            break_at(patch, step, fail, calls)
            try:
                write(folder, NEWER)
            except (InputError, OSError, KeyboardInterrupt) as error:
                caught = error
        if not failed:
            break
        yield folder, caught
    assert step > 40


@pytest.mark.parametrize("failure", [OSError(5, "the disk is broken"), KeyboardInterrupt()])
def test_failure_at_each_step_leaves_the_earlier_result_or_the_new_one(tmp_path, earlier, failure):
    """A complete new result is announced, and the next command clears remains."""
    for place, caught in failures(tmp_path, earlier, failure):
        result = seen(place)
        assert result in (OLD, NEWER)
        if isinstance(failure, KeyboardInterrupt):
            assert isinstance(caught, KeyboardInterrupt)
            assert not (place / LOG).exists()
            assert isinstance(caught, Interrupted) <= (result == NEWER)
        else:
            announced = "the next command completes it" in str(caught)
            assert announced == (place / LOG).exists() <= (result == NEWER)
        write(place, NEWER)
        assert texts(place) == {**NEWER, **ADDED, NAME: texts(place)[NAME]}


@pytest.mark.parametrize("failure", [OSError(5, "the disk is broken"), KeyboardInterrupt()])
@pytest.mark.parametrize("is_there", [False, True])
def test_failure_while_it_is_filled_leaves_what_was_there(tmp_path, earlier, failure, is_there):
    place = earlier if is_there else tmp_path / "x" / "y"
    before = tree(tmp_path)
    with pytest.raises(type(failure)), result_folder(place) as new:  # noqa: PT012
        (new / "report.html").write_text("half")
        raise failure
    assert tree(tmp_path) == before


def half_done(place):
    """Make a folder whose log has two of four files renamed."""
    assert not killed_at(4, write, place, NEWER, calls=("replace",))
    (place / LOCK).unlink()
    assert sorted(os.listdir(place / NEW)) == [NAME, "report.html"]


def test_a_reader_that_may_not_write_looks_through_the_log(earlier, monkeypatch):
    half_done(earlier)
    before = tree(earlier)
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may always
    recover(earlier)
    assert seen(earlier) == NEWER
    assert tree(earlier) == before


def test_a_damaged_log_is_refused_by_readers_and_writers_and_nothing_is_changed(earlier):
    half_done(earlier)
    text = (earlier / LOG).read_text()
    flipped = (text[:k] + chr(ord(text[k]) ^ 1) + text[k + 1 :] for k in range(0, len(text), 29))
    forged = json.loads(text)
    forged["old"].append(forged["old"][0] | {"path": "../thesis.txt"})
    digest = manifest._digest({name: forged[name] for name in ("old", "new")})
    for damaged_text in (*flipped, "", text[:-1], "[]", "{}", json.dumps(forged | {"sha256": digest})):
        if damaged_text == text:
            continue
        (earlier / LOG).write_text(damaged_text)
        before = tree(earlier)
        for opened in (recover, seen, lambda place: write(place, NEWER)):
            with pytest.raises(InputError, match=f"its file {LOG}, of an interrupted command, is damaged"):
                opened(earlier)
        assert tree(earlier) == before
    (earlier / LOG).write_text(text)
    recover(earlier)
    assert seen(earlier) == NEWER


def test_a_new_file_that_was_damaged_since_is_refused(earlier):
    half_done(earlier)
    (earlier / NEW / "report.html").write_text("other")
    before = tree(earlier)
    damaged = rf"its file {NEW}/report\.html, of an interrupted command, is damaged"
    with pytest.raises(InputError, match=damaged):
        recover(earlier)
    assert tree(earlier) == before


def test_what_the_user_changed_after_a_kill_is_kept(earlier):
    """A modified file that is to be replaced is refused, others remain."""
    half_done(earlier)
    (earlier / "report.html").write_text("edited")
    with pytest.raises(InputError, match=r"its file report\.html was modified"):
        recover(earlier)
    (earlier / "report.html").rename(earlier / "kept.html")
    (earlier / "both.csv").write_text("edited too")
    recover(earlier)
    files = texts(earlier)
    assert (files["kept.html"], files["both.csv"], files["report.html"]) == ("edited", "edited too", "newer")
    assert not (earlier / LOG).exists()


def test_a_link_in_place_of_the_new_files_is_not_followed(earlier, tmp_path):
    half_done(earlier)
    (earlier / NEW).rename(tmp_path / "mine")
    (earlier / NEW).symlink_to(tmp_path / "mine")
    before = tree(tmp_path)
    with pytest.raises(InputError, match="damaged"):
        recover(earlier)
    (earlier / LOG).rename(tmp_path / "log")
    with pytest.raises(InputError, match="cannot be written"):
        write(earlier, NEWER)
    (tmp_path / "log").rename(earlier / LOG)
    assert tree(tmp_path) == before


def test_who_comes_second_is_refused_at_once_and_a_reader_is_not(earlier):
    with result_folder(earlier) as new:
        (new / "report.html").write_text("first")
        before = tree(earlier)
        with pytest.raises(InputError, match="another command uses this folder"):
            write(earlier, NEWER)
        recover(earlier)
        assert (tree(earlier), seen(earlier)) == (before, OLD)
    assert seen(earlier) == {"report.html": "first"}


def test_a_reader_waits_for_who_is_moving_its_files(earlier, monkeypatch):
    half_done(earlier)
    monkeypatch.setattr(folder, "PATIENCE_S", 0.0)
    with manifest.locked_file(earlier / LOCK):
        with pytest.raises(InputError, match="another command uses this folder"):
            recover(earlier)
        monkeypatch.setattr(folder, "PATIENCE_S", 60.0)
        reader = threading.Thread(target=recover, args=(earlier,))
        reader.start()
        reader.join(0.2)
        assert reader.is_alive()
    reader.join()
    assert seen(earlier) == NEWER
    assert LOG not in os.listdir(earlier)


def test_the_lock_goes_with_its_process_and_what_that_has_left_is_dropped(tmp_path):
    place, (ready, filling) = tmp_path / "out", os.pipe()
    if not (child := os.fork()):
        try:
            with result_folder(place) as new:
                (new / "half.csv").write_text("1,")
                os.write(filling, b".")
                signal.pause()
        finally:
            os._exit(0)
    os.close(filling)
    assert os.read(ready, 1) == b"."
    refused(place, "another command uses this folder")
    assert (place / NEW / "half.csv").exists()
    os.kill(child, signal.SIGKILL)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == KILLED
    write(place, OLD)
    assert set(texts(place)) == {*OLD, NAME}


def test_a_file_system_without_locks_is_refused(tmp_path, monkeypatch):
    def refuse(number, how):
        raise OSError(errno.ENOTSUP, os.strerror(errno.ENOTSUP))

    monkeypatch.setattr(fcntl, "flock", refuse)
    with pytest.raises(InputError, match="the folder cannot be locked: Operation not supported"):
        write(tmp_path / "x" / "y", OLD)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_was_removed_meanwhile_is_said_to_be(earlier):
    with pytest.raises(InputError, match="was removed"), result_folder(earlier) as new:  # noqa: PT012
        shutil.rmtree(earlier)
        new.mkdir(parents=True)
        (new / "report.html").write_text("x")
    assert seen(earlier) is None


def test_numbers_that_are_committed_stay_where_pictures_fail(earlier):
    with pytest.raises(ZeroDivisionError), result_folder(earlier) as new:  # noqa: PT012
        (new / "report.html").write_text("numbers")
        folder.commit(new.parent)
        (new / "report.html").write_text("pictures")
        raise ZeroDivisionError
    assert seen(earlier) == {"report.html": "numbers"}
    assert set(os.listdir(earlier)) == {"report.html", NAME, "notes.txt", "plots"}


RUN = Origin("run", "a")


OTHERS = [Origin("run", "b"), Origin("modes", "a"), Origin("run", "a", ("impact.speed=20",)), folder.UNKNOWN]


@pytest.mark.parametrize("origin", OTHERS)
def test_a_result_of_another_command_or_scene_is_replaced_by_force_alone(tmp_path, origin):
    place = tmp_path / "a"
    write(place, OLD, origin=RUN)
    write(place, OLD, origin=RUN)
    before = tree(place)
    message = "the folder contains the result of `tailslap run a`; --force replaces it"
    with pytest.raises(InputError, match=message):
        write(place, NEWER, origin=origin)
    assert tree(place) == before
    write(place, NEWER, origin=origin, force=True)
    assert (seen(place), manifest.read_origin(place)) == (NEWER, origin)


SET = ["--set", "corner.reaction=none", "--set", "impact.speed=20"]


@pytest.mark.parametrize("command", ["run", "study cost", "modes", "confirm", "export abaqus"])
def test_a_changed_scene_is_another_one(tmp_path, command, capsys):
    """Results of a changed scene are replaced by --force alone."""
    place, words = tmp_path / "a", [*command.split()[:1], "paper-table-3", "--out", str(tmp_path / "a"), *SET]
    words[1:1] = {"study cost": ["cost"], "export abaqus": ["--to", "abaqus"]}.get(command, [])
    write(place, OLD, origin=Origin(command, "paper-table-3", ("impact.speed=21",)))
    before = tree(place)
    assert _status(words) == 2
    message = f"the result of `tailslap {command} paper-table-3 --set impact.speed=21`; --force replaces it"
    assert message in capsys.readouterr().err
    assert tree(place) == before


def test_a_loaded_result_has_the_changes_of_its_scene(rigid_results, tmp_path):
    changed = tailslap.rigid("paper-table-3", {"impact.speed": 20.0})
    with pytest.raises(InputError, match="the result of `tailslap rigid paper-table-3`; --force"):
        changed.save(rigid_results[0])
    assert tailslap.load(changed.save(tmp_path / "a")).changes == changed.changes == ("impact.speed=20.0",)


def test_an_input_is_never_replaced(tmp_path):
    place, link = tmp_path / "a", tmp_path / "link"
    write(place, OLD, origin=RUN)
    link.symlink_to(place)
    before = tree(place)
    for path in (place, link, place / "both.csv", link / "both.csv"):
        with pytest.raises(InputError, match="it is an input of the command"):
            write(place, NEWER, inputs=[tmp_path, path], force=True)
    assert tree(place) == before
    write(place, NEWER, inputs=[tmp_path / "b", place / "no.csv"], origin=RUN)


@pytest.fixture
def rigid_results(tmp_path):
    """Two folders with the result of `tailslap rigid`."""
    rigid = tailslap.rigid("paper-table-3")
    return rigid.save(tmp_path / "V"), rigid.save(tmp_path / "W")


GATED = {
    "run": "run paper-table-3", "study": "study cost paper-table-3",
    "sweep": "sweep paper-table-3 --vary corner.friction=0.1:0.2:2", "modes": "modes paper-table-3",
    "paper": "paper", "compare": "compare {second} {second}", "export": "export {second} --to csv",
}  # fmt: skip


@pytest.mark.parametrize("command", GATED)
def test_every_command_is_refused_another_s_result_before_it_computes(
    tmp_path, rigid_results, command, capsys
):
    """Results of other commands are replaced by --force alone."""
    place, second = rigid_results
    before = tree(tmp_path)
    words = [*GATED[command].format(second=second).split(), "--out", str(place)]
    assert _status(words) == 2
    message = "the folder contains the result of `tailslap rigid paper-table-3`; --force"
    assert message in capsys.readouterr().err
    assert tree(tmp_path) == before
    with manifest.locked_file(place / LOCK):
        assert _status([*words, "--force"]) == 2
        assert "another command uses this folder" in capsys.readouterr().err
    (place / LOCK).unlink()
    (place / NAME).unlink()
    assert _status([*words, "--force"]) == 2
    assert "the folder contains other files" in capsys.readouterr().err


@pytest.mark.parametrize(
    "command", ["compare {place} {second}", "compare {second} {place}", "export {place} --to csv"]
)
def test_no_command_replaces_its_input(tmp_path, rigid_results, command, capsys):
    place, second = rigid_results
    before = tree(tmp_path)
    for more in ([], ["--force"]):
        words = command.format(place=place, second=second).split()
        assert _status([*words, "--out", str(place), *more]) == 2
        assert "it is an input of the command" in capsys.readouterr().err
    assert tree(tmp_path) == before


def test_an_export_over_a_rigid_result_by_force(rigid_results):
    place, second = rigid_results
    (place / "notes.txt").write_text("mine")
    assert _status(["export", str(second), "--to", "csv", "--out", str(place), "--force"]) == 0
    assert set(texts(place)) == {"rigid.csv", "notes.txt", NAME}
    assert manifest.read_origin(place) == Origin("export csv", "paper-table-3")


def test_a_file_is_whole_or_the_earlier_one_and_two_writers_follow_each_other(tmp_path):
    path = tmp_path / "definition.json"
    for step in itertools.count(1):
        path.write_text("old")

        def replace():
            with whole_file(path) as partial:
                partial.write_text("new")

        if killed_at(step, replace):
            break
        assert path.read_text() in ("old", "new")
    with whole_file(path) as partial:
        partial.write_text("first")
        writer = threading.Thread(target=replace)
        writer.start()
        writer.join(0.1)
        assert writer.is_alive()
    writer.join()
    assert texts(tmp_path) == {"definition.json": "new"}


RARE = errno.ENOMEM, errno.ESTALE, errno.ENOSPC, errno.EMFILE


@pytest.mark.parametrize(
    "number", [errno.EACCES, errno.EIO, *(pytest.param(e, marks=pytest.mark.long) for e in RARE)]
)
def test_an_error_of_the_system_is_none_of_what_is_absent(tmp_path, earlier, number, monkeypatch):
    """The manifest remains at each call, and the next command succeeds."""
    monkeypatch.setattr(os, "fsync", lambda number: None)
    error = OSError(number, os.strerror(number))
    for place, _ in failures(tmp_path, earlier, error, (*CALLS, "lstat")):
        assert seen(place) in (OLD, NEWER)
        assert LOG not in os.listdir(place) or seen(place) == NEWER
        write(place, NEWER)
        assert seen(place) == NEWER
