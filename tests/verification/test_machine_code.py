"""Verification: compiled code kept on disk is called rightly without Numba, and its threads sleep while they wait."""

import fcntl
import gc
import os
import re
import subprocess
import sys
import threading
import time
from typing import NamedTuple

import numpy as np
import pytest

from fem.explicit.parallel import _meet, new_meeting
from fem.explicit.time_loop import advance
from fem.machine_code import folder, object_code
from fem.machine_code.arguments import Prepared, UnknownTypeError, flattened
from fem.machine_code.compiled import compile_once, compiled
from fem.machine_code.folder import USUAL_S, one_process_compiles
from fem.machine_code.object_code import read_code
from fem.run.corner import Stepper
from tailslap.case.corner.case import CornerCase
from tailslap.case.corner.decisions import ELEMENTS_A_THREAD, open_threads
from tailslap.scene.read import read_scene


class Inner(NamedTuple):
    """An array, and a part that a scene lacks."""

    values: np.ndarray
    absent: None


class Outer(NamedTuple):
    """As a loop's parameters are: tuples in tuples."""

    inner: Inner
    pair: tuple[float, int]
    nothing: tuple[()]
    some: bool


class Sums(NamedTuple):
    """What `add` returns."""

    total: float
    count: int
    some: bool
    inner: tuple[float, float]


def add(outer, rows, whole, fixed, flags, factor):
    """Uses every number that it is given, in a way that tells them apart, and memory of its own."""
    own = np.zeros(3)
    own[0] = outer.inner.values.sum() + 10.0 * outer.pair[0] + 100.0 * outer.pair[1]
    if factor is not None:
        own[1] = 7.0 * factor
    for i in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            own[2] += (1 + i + 5 * j) * rows[i, j]
    some = outer.some and flags[0]
    whole[0] += 1
    return Sums(own.sum(), whole.size + fixed.size, some, (own[1], own[2]))


def arguments(factor, step):
    rows = np.arange(24.0).reshape(4, 6)[:, ::step]
    fixed = np.arange(3, dtype=np.uint8)
    fixed.flags.writeable = False
    outer = Outer(Inner(np.linspace(0.0, 1.0, 5), None), (0.5, -3), (), True)
    return outer, rows, np.zeros(2, dtype=np.int32), fixed, np.array([step == 2]), factor


@pytest.fixture
def kernel(tmp_path, monkeypatch):
    monkeypatch.setattr(folder, "cache_folder", lambda: tmp_path / "code")
    return compiled(add)


@pytest.mark.parametrize("factor", [None, 0.25])
@pytest.mark.parametrize("step", [1, 2])
def test_the_same_as_in_python(kernel, factor, step):
    """Exact: contiguous and strided arrays, several sizes of numbers, tuples in tuples, a tuple in a result."""
    in_python, in_code = arguments(factor, step), arguments(factor, step)
    found = kernel(*in_code)
    assert (found, [type(item) for item in found]) == (add(*in_python), [float, int, bool, tuple])
    assert type(found) is Sums
    assert in_code[2].tolist() == [1, 0]
    assert kernel.has_code(*in_code)


def test_kept_code_is_loaded_and_corrupted_code_is_not(kernel):
    given = arguments(None, 1)
    assert not kernel.path(*given).exists()
    kernel(*given)
    path = kernel.path(*given)
    kept = path.read_bytes()
    for corrupted in (kept[:-100], b"{}\n", b"", kept.replace(b"q", b"d", 1)):
        path.write_bytes(corrupted)
        assert read_code(path) is None
        again = compiled(add)
        assert again(*given) == kernel(*given)
        assert read_code(path) is not None
    loaded = compiled(add)
    loaded.dispatcher = None  # Numba is not asked
    assert loaded(*given) == kernel(*given)


@pytest.mark.parametrize("missing", ["to compile", "to load"])
def test_without_a_name_of_numbas_own_it_goes_through_numba(kernel, missing, monkeypatch):
    """As in another version of Numba, which promises neither of these names."""
    from numba.core.codegen import CodeLibrary

    if missing == "to compile":
        monkeypatch.delattr(CodeLibrary, "_get_compiled_object")
    else:
        monkeypatch.setattr(object_code, "EXTENSION_SUFFIXES", [])  # its functions for memory are not found
        monkeypatch.setattr(object_code, "_engine", object_code._engine.__wrapped__)
    in_python, in_code = arguments(0.25, 2), arguments(0.25, 2)
    prepared = (Prepared(in_code[0]), *in_code[1:])
    found = kernel(*prepared)
    assert found == add(*in_python)
    assert type(found) is Sums
    assert (in_code[2].tolist(), kernel.bound(*prepared)()) == ([1, 0], found)
    assert not kernel.has_code(*prepared)


def test_a_bound_call_reads_its_arrays_anew(kernel):
    """It sees what is in them at each call, and keeps those that nobody else does."""
    rows = np.arange(24.0).reshape(4, 6)
    again = kernel.bound(arguments(None, 1)[0], rows, *arguments(None, 1)[2:])
    gc.collect()
    for factor in (1.0, -2.0):
        rows[:] = factor * np.arange(24.0).reshape(4, 6)
        outer, _, *rest = arguments(None, 1)
        assert again() == add(outer, rows, *rest)


def test_other_types_are_refused():
    for value in ("text", [1.0], np.zeros(2, dtype=object), np.zeros(2, dtype=">f8"), 2**63, 1j):
        with pytest.raises(UnknownTypeError):
            flattened((value,))


def test_a_second_run_does_without_numba(tmp_path, python):
    """Both ways of a whole run: sliding along the wall, and an impact from event to event."""
    script = (
        "import sys, tailslap\n"
        "for scene in ('paper-table-3', 'impact-mash-tl4-sut'): assert tailslap.run(scene).passed\n"
        "print('numba' in sys.modules)"
    )
    said = [python(script, cwd=tmp_path, check=True) for _ in range(2)]
    assert said[1].stdout.split()[-1] == "False"


def test_code_of_another_package_depends_on_all_of_it(tmp_path, python):
    """A kernel calls others of its package: where one of them has changed, it is compiled anew."""
    package = tmp_path / "elsewhere" / "within"
    package.mkdir(parents=True)
    header = "from fem.machine_code.compiled import compiled\n"
    body = "@compiled\ndef whole(x):\n    return 2.0 * part(x)\n"
    (package / "caller.py").write_text(f"{header}from elsewhere.called import part\n\n\n{body}")
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "code")}
    script = "from elsewhere.within.caller import whole; print(whole(1.0))"
    for factor in (3.0, 5.0, 3.0):
        called = f"{header}\n\n@compiled\ndef part(x):\n    return {factor} * x\n"
        (package.parent / "called.py").write_text(called)
        done = python(script, "-B", cwd=tmp_path, env=environment)
        assert done.stdout == f"{2.0 * factor}\n", done.stderr
    assert len(list(tmp_path.glob("code/*/whole-*.code"))) == 2


def test_a_function_that_numba_has_of_its_own_is_found_in_a_second_process(tmp_path, python):
    """As a law from outside may call one."""
    header = "import math\nfrom fem.machine_code.compiled import compiled\n\n\n"
    body = "return math.gamma(x)\n"
    (tmp_path / "outside.py").write_text(f"{header}@compiled\ndef gamma(x):\n    {body}")
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "code")}
    for _ in range(2):
        script = "import outside; print(outside.gamma(5.0))"
        done = python(script, cwd=tmp_path, env=environment)
        assert done.stdout.split() == ["24.0"], done.stderr


def test_who_comes_second_waits_and_who_compiles_another_kind_does_not(tmp_path):
    """The lock is held here, as another process would hold it."""
    code, entered = tmp_path / "code" / "kind.code", threading.Event()

    def compile_there(path, told):
        def compile_it():
            with one_process_compiles(path):
                told.set()

        thread = threading.Thread(target=compile_it)
        thread.start()
        return thread

    with one_process_compiles(code):
        other, third = compile_there(code, entered), threading.Event()
        assert not entered.wait(0.2)
        compile_there(code.with_name("other.code"), third).join(60.0)
        assert third.is_set()
    assert entered.wait(60.0)
    other.join()
    with open(tmp_path / "code" / "kind.lock") as file:  # it is free again
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def test_without_a_folder_each_compiles_for_itself(tmp_path):
    (tmp_path / "file").write_text("")
    with one_process_compiles(tmp_path / "file" / "code" / "kind.code"):
        assert not (tmp_path / "file").is_dir()


def test_code_is_known_by_the_types_of_its_arguments(outcome):
    """After a run its step has code; for arguments of other types there is none."""
    model = outcome("paper-table-3").fe_plan.model
    kernel, *arguments = Stepper(model).step_call
    assert kernel.has_code(*arguments)
    assert not advance.has_code(1, 2.0, np.zeros(3))


def double(value):
    """A function to compile."""
    return 2.0 * value


def test_compiling_is_told_once_a_kind_with_the_time_of_the_last(tmp_path, monkeypatch):
    monkeypatch.setattr(folder, "cache_folder", lambda: tmp_path / "code")
    told = []

    def use(value):
        function = compiled(double)  # as a new process has it
        compile_once(lambda: function(value), function, value, on_compile=lambda *given: told.append(given))

    use(1.0)
    (expected, before), (spent, after) = told
    assert (expected, before, after) == (USUAL_S, False, True)
    assert 0.0 < spent < USUAL_S
    use(2.0)
    assert len(told) == 2
    use(3)  # another kind
    assert (told[2], len(told)) == ((pytest.approx(spent, abs=0.01), False), 4)


@pytest.mark.long
def test_first_run_says_that_it_compiles_and_the_second_does_not(tmp_path):
    """Standard error is no terminal here."""
    command = [sys.executable, "-m", "tailslap.cli", "run", "paper-table-3", "--no-pictures"]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "code")}

    def said():
        settings = {"capture_output": True, "text": True, "check": True}
        done = subprocess.run(command, env=environment, cwd=tmp_path, **settings)
        return done.stderr

    assert re.search(r"compiling the time loop .*: about 10 s\n.*compiled in \d+ s", said(), re.DOTALL)
    assert "compil" not in said()


LATE = 0.5


def test_who_waits_long_sleeps():
    """The processor time of a thread that waits half a second for another is a fraction of that."""
    _meet(new_meeting(), 1, 1)  # compiled
    meeting, spent = new_meeting(), []

    def wait():
        before = time.thread_time()
        _meet(meeting, 2, 1)
        spent.append(time.thread_time() - before)

    first = threading.Thread(target=wait)
    first.start()
    time.sleep(LATE)
    assert first.is_alive()
    _meet(meeting, 2, 1)
    first.join(10.0)
    assert spent
    assert spent[0] < 0.1 * LATE


def test_threads_meet_again_and_again():
    """Three threads and 2 000 meetings, on however few cores: none is missed, and all come to the end."""
    meeting, done = new_meeting(), []

    def attend(meeting):
        for turn in range(1, 2001):
            _meet(meeting, 3, turn)
        done.append(True)

    threads = [threading.Thread(target=attend, args=(meeting,), daemon=True) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert len(done) == 3


@pytest.mark.parametrize(
    ("elements", "used"), [((20, 6), 1), ((200, 60), 1), ((200, 100), 2), ((320, 96), 3)]
)
def test_threads_are_as_many_as_the_mesh_has_work_for(elements, used):
    plan = CornerCase(*read_scene("paper-table-3", (f"plate.elements={list(elements)}", "time.threads=3")))
    assert plan.scene.plate
    decisions = open_threads(plan, plan.scene.plate)
    assert plan.decided(decisions).scene.time.threads == used
    assert [decision.value for decision in decisions] == ([] if used == 3 else [used])
    for decision in decisions:
        assert "3 were asked for" in decision.why
        assert str(ELEMENTS_A_THREAD) in decision.why


def test_run_and_check_say_that_one_thread_is_used():
    plan = CornerCase(*read_scene("paper-table-3", ("time.threads=2",)))
    fe_plan = plan.plan()
    assert fe_plan.case.scene.time.threads == 1
    assert [decision.key for decision in fe_plan.decisions] == ["time.threads"]
    assert fe_plan.decisions[0].shown.startswith("time.threads = 1: 2 were asked for; ")
