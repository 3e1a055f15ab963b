"""Verify how compiled code is stored, loaded and called."""

import fcntl
import gc
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from fem.explicit.time_loop import advance
from fem.run.corner import Stepper
from machine_code import llvm_code
from machine_code.compiled import compile_once, compiled
from machine_code.object_code import UnknownTypeError, flattened
from machine_code.system import folder
from machine_code.system.folder import USUAL_S, one_process_compiles


class Inner(NamedTuple):
    """An array, and an absent part of a scene."""

    values: np.ndarray
    absent: None


class Outer(NamedTuple):
    """Tuples in tuples, as the parameters of the time loop."""

    inner: Inner
    pair: tuple[float, int]
    nothing: tuple[()]
    some: bool


class Sums(NamedTuple):
    """What `add` returns."""

    total: float
    size: int
    some: bool
    inner: tuple[float, float]


def add(outer, rows, counts, fixed, flags, factor):
    """Sum of all arguments with different weights."""
    first, second, third = 10.0 * outer.pair[0] + 100.0 * outer.pair[1], 0.0, 0.0
    for value in outer.inner.values:
        first += value
    if factor is not None:
        second = 7.0 * factor
    for i in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            third += (1 + i + 5 * j) * rows[i, j]
    some = outer.some and flags[0]
    counts[0] += 1
    return Sums(first + second + third, counts.size + fixed.size, some, (second, third))


def double(value):
    """Compiled in no time."""
    return 2.0 * value


FACTOR = 2.0


def by_factor(value):
    """Use a constant and a function of the module."""
    return FACTOR * value if value > 0.0 else double(value)


def arguments(factor, step):
    rows = np.arange(24.0).reshape(4, 6)[:, ::step]
    fixed = np.arange(3, dtype=np.int32)
    fixed.flags.writeable = False
    outer = Outer(Inner(np.linspace(0.0, 1.0, 5), None), (0.5, -3), (), True)
    return outer, rows, np.zeros(2, dtype=np.int32), fixed, np.array([step == 2]), factor


@pytest.fixture
def kernel(keeping):
    return compiled(add)


@pytest.mark.parametrize("factor", [None, 0.25])
@pytest.mark.parametrize("step", [1, 2])
def test_the_same_as_in_python(kernel, factor, step):
    """Arrays, numbers and nested tuples have the exact result."""
    in_python, in_code = arguments(factor, step), arguments(factor, step)
    result = kernel(*in_code)
    assert (result, [type(item) for item in result]) == (add(*in_python), [float, int, bool, tuple])
    assert type(result) is Sums
    assert in_code[2].tolist() == [1, 0]
    assert kernel.has_code(*in_code)


def subtract(outer, rows, counts, fixed, flags, factor):
    """Function of the arguments of `add` with another result."""
    return Sums(-outer.pair[0], -counts.size, not flags[0], (0.0, 0.0))


def with_header(code, header):
    """Replace the header of a file, with its new digest."""
    contents = header + b"\n" + code[32:].partition(b"\n")[2]
    return hashlib.sha256(contents).digest() + contents


def with_other(code, **changes):
    """Set keys of the header of a file."""
    header = json.loads(code[32:].partition(b"\n")[0])
    return with_header(code, json.dumps(header | changes).encode())


RESULTS: tuple[Any, ...] = (
    {}, [], "x", 3, ["d"], [3, 4, "d"], ["os", "path", "d"], ["antigravity", "Sums", "d"], [*["builtins"] * 2]
)  # fmt: skip


def set_key(key, value):
    """Return damage that sets a key of the header to a value."""
    return lambda code: with_other(code, **{key: value})


DAMAGE: dict[str, Callable[[bytes], bytes]] = {
    "cut": lambda code: code[:-100],
    "empty": lambda code: b"",
    "without a digest": lambda code: b"{}\n",
    "one byte": lambda code: code.replace(b"q", b"d", 1),
    "more": lambda code: code + b"\0",
    "no JSON": lambda code: with_header(code, b"\xff{"),
    "deep": lambda code: with_header(code, b"[" * 50_000),
    "long": lambda code: with_header(code, code[32:].partition(b"\n")[0] + b" " * 2**16),
    **{f"JSON {text!r}": partial(with_header, header=text) for text in (b"[]", b"3", b"null", b'"{}"')},
    **{key: set_key(key, "other") for key in
        ("kernel", "arguments", "values", "sources", "processor", "versions", "settings", "symbol", "more")},
    **{f"result {result}": set_key("result", result) for result in RESULTS},
    "types": lambda code: with_other(code, symbol=7, versions=None, values=["d"]),
}  # fmt: skip
"""Contents of a file, made from the right one."""


def test_kept_code_is_loaded_and_corrupted_code_is_not(kernel, monkeypatch):
    """Corrupted code is compiled again, intact code loaded."""
    inputs, path = arguments(None, 1), kernel.path(*arguments(None, 1))
    assert not path.exists()
    result, modules = kernel(*inputs), set(sys.modules)
    code = path.read_bytes()
    for how, damage in DAMAGE.items():
        path.write_bytes(damage(code))
        assert not compiled(add).has_code(*inputs), how
    assert "antigravity" not in sys.modules.keys() - modules
    assert compiled(add)(*inputs) == result
    monkeypatch.setattr(llvm_code, "compile_kernel", pytest.fail)
    assert compiled(add)(*inputs) == result


def test_code_copied_over_another_s_is_compiled_anew(kernel):
    """Code of another kernel, or for other types, is compiled again."""
    inputs, another_kernel = arguments(None, 1), compiled(subtract)
    for wrong in ((another_kernel, inputs), (kernel, arguments(0.25, 1))):
        assert wrong[0](*wrong[1])
        shutil.copy(wrong[0].path(*wrong[1]), kernel.path(*inputs))
        again = compiled(add)
        assert not again.has_code(*inputs)
        assert again(*inputs) == add(*inputs)


def sparse(path):
    path.touch(0o600)
    os.truncate(path, 2**40)


def give_away(path):
    """A copy of the file that belongs to another user."""
    shutil.copy(path.with_suffix(".whole"), path)
    os.chown(path, 65534, -1)


ODD = {
    "pipe": os.mkfifo,
    "device": lambda path: path.symlink_to("/dev/zero"),
    "link": lambda path: path.symlink_to(shutil.copy(path.with_suffix(".whole"), path.with_suffix(".other"))),
    "folder": Path.mkdir,
    "huge": sparse,
    "open to all": lambda path: shutil.copy(path.with_suffix(".whole"), path) and path.chmod(0o644),
    "another's": give_away,
}
"""What may stand in the place of a file."""


@pytest.mark.parametrize("how", ODD)
def test_what_is_no_file_of_this_user_s_alone_is_not_opened(keeping, how):
    """It is neither opened nor waited for, and replaced where possible."""
    if how == "another's" and os.geteuid():
        pytest.skip("root alone gives files away")
    kernel, seconds = compiled(double), folder.cache_folder() / folder.TIME_FILE
    assert kernel(1.5) == 3.0
    path = kernel.path(1.5)
    folder.save_time(7.0)
    for file in (path, seconds):
        shutil.move(file, file.with_suffix(".whole"))
        ODD[how](file)
    assert folder.expected_time() == USUAL_S
    again = compiled(double)
    assert not again.has_code(1.5)
    assert again(1.5) == 3.0
    assert compiled(double).has_code(1.5) == (how != "folder")


@pytest.mark.parametrize("how", ["open to all", "readable", "another's", "link"])
def test_in_a_folder_of_others_nothing_is_loaded_or_kept(keeping, how, tmp_path, monkeypatch):
    """The message states the time of compilation."""
    messages: list[str] = []
    place = folder.cache_folder()
    assert compiled(double)(1.5) == 3.0
    if how == "link":
        place.rename(tmp_path / "elsewhere")
        place.symlink_to(tmp_path / "elsewhere")
    elif how == "another's":
        monkeypatch.setattr(os, "geteuid", lambda: place.stat().st_uid + 1)
    else:
        place.chmod(0o777 if how == "open to all" else 0o755)
    before = {path: path.stat().st_mtime_ns for path in place.iterdir()}
    again = compiled(double)
    assert not again.has_code(1.5)
    compile_once(lambda: again(1.5), again, 1.5, on_compile=messages.append)
    assert again(1.5) == 3.0
    message = rf"compiled in \d+ s, not kept for the next run: {place}: .*inaccessible to others.*"
    assert re.fullmatch(message, messages[1])
    assert {path: path.stat().st_mtime_ns for path in place.iterdir()} == before


def test_the_folder_is_made_for_this_user_alone(keeping):
    kernel = compiled(double)
    assert kernel(1.5) == 3.0
    created = [folder.cache_folder(), kernel.path(1.5)]
    assert [path.stat().st_mode & 0o777 for path in created] == [0o700, 0o600]


def test_below_a_folder_that_may_not_be_searched_code_is_not_kept(keeping, tmp_path, monkeypatch):
    """As below the home of another user."""
    assert compiled(double)(2) == 4.0  # its source is read
    messages: list[str] = []
    closed = tmp_path / "home"
    closed.mkdir(0o000)
    monkeypatch.setattr(folder, "cache_folder", lambda: closed / "cache" / "code")
    user, again = os.geteuid(), compiled(double)
    os.seteuid(user or 65534)
    try:
        compile_once(lambda: again(1.5), again, 1.5, on_compile=messages.append)
    finally:
        os.seteuid(user)
        closed.chmod(0o700)
    assert again(1.5) == 3.0
    assert messages[1].endswith(f"not kept for the next run: {closed / 'cache' / 'code'}: Permission denied")


def test_a_bound_call_reads_its_arrays_anew(kernel):
    """It reads them at each call, and keeps those without another reference."""
    rows = np.arange(24.0).reshape(4, 6)
    again = kernel.bound(arguments(None, 1)[0], rows, *arguments(None, 1)[2:])
    gc.collect()
    for factor in (1.0, -2.0):
        rows[:] = factor * np.arange(24.0).reshape(4, 6)
        outer, _, *rest = arguments(None, 1)
        assert again() == add(outer, rows, *rest)


def chosen(first, value, other):
    return value if first else other


@pytest.mark.parametrize("first", [True, False, np.True_, np.False_])
def test_numbers_of_python_and_numpy_are_the_same(keeping, first):
    """Each has code, of one type for both."""
    kernel, pair = compiled(chosen), (7.5, -2.0)
    assert kernel(first, *pair) == kernel(bool(first), *map(np.float64, pair)) == pair[not first]
    assert kernel(first, 7, -2) == kernel(first, *map(np.int64, (7, -2))) == (7, -2)[not first]


def test_other_types_are_refused():
    for value in ("text", [1.0], np.zeros(2, dtype=object), np.zeros(2, dtype=">f8"), 2**63, 1j):
        with pytest.raises(UnknownTypeError):
            flattened((value,))


def test_a_second_run_does_without_the_compiler(tmp_path, python):
    """A sliding run and an impact are covered."""
    script = (
        "import sys, tailslap\n"
        "for scene in ('paper-table-3', 'impact-mash-tl4-sut'):\n"
        "    assert tailslap.run(scene, {'plate.elements': [8, 2]}).passed\n"
        "print('machine_code.llvm_code' in sys.modules)"
    )
    compiled_again = lambda: python(script, cwd=tmp_path, check=True).stdout.split()[-1] == "True"  # noqa: E731
    assert not (compiled_again() and compiled_again())


HEADER = "from machine_code.compiled import compiled\n"


@pytest.fixture
def printed(tmp_path, python):
    """Words that a script prints in a new process."""
    environment = os.environ | {"TAILSLAP_CACHE_DIR": str(tmp_path / "code")}

    def run(script, **variables):
        process = python(script, "-B", cwd=tmp_path, env=environment | variables)
        assert process.returncode == 0, process.stderr
        return process.stdout.split()

    return run


@pytest.mark.parametrize("caller", ["caller", "elsewhere.within.caller"])
def test_code_depends_on_the_functions_that_it_calls(caller, tmp_path, printed):
    """It is compiled again after a change in any package."""
    (tmp_path / "elsewhere" / "within").mkdir(parents=True)
    body = "@compiled\ndef twice(x):\n    return 2.0 * part(x)\n"
    calling = f"{HEADER}from elsewhere.called import part\n\n\n{body}"
    (tmp_path / f"{caller.replace('.', '/')}.py").write_text(calling)
    for factor in (3.0, 5.0, 3.0):
        called = f"{HEADER}\n\n@compiled\ndef part(x):\n    return {factor} * x\n"
        (tmp_path / "elsewhere" / "called.py").write_text(called)
        assert printed(f"from {caller} import twice; print(twice(1.0))") == [str(2.0 * factor)]
    assert len(list(tmp_path.glob("code/*/twice-*.code"))) == 2


CAPTURES = {
    "constant of another module": ("from values import K as factor", "factor * x"),
    "attribute of a module": ("import values", "values.K * x"),
    "attribute of a module within a package": ("import parts.inner", "parts.inner.K * x"),
    "attribute of a class": ("from values import Table", "Table.K * x"),
    "default of a record": ("from values import Record", "Record().k * x"),
    "array of a file": ("import numpy as np\nTABLE = np.loadtxt('table.txt')", "TABLE[1] * x"),
    "tuple of a closure": (
        "from values import K\ndef make(pair):\n    return lambda x: pair[1] * x",
        "scaled(x)",
    ),
    "function of a closure": (
        "from values import K\ndef make(pair):\n    return lambda x: pair[0](x)",
        "scaled(x)",
    ),
    "function two modules away": ("from parts.middle import part", "part(x)"),
    "choice of a law": ("from values import K\nfrom laws import force, Law", "force(Law(), x)"),
}
"""Where the factor of a kernel comes from, and how the kernel uses it."""

LAWS = """
from typing import NamedTuple
from machine_code.compiled import by_law
from values import K
class Law(NamedTuple):
    pass
class Laws:
    class law:
        inlined, force = (), lambda law, x: K * x
    def by_type(self, kind):
        return Laws.law if kind is Law else None
force = by_law(Laws(), "force")
"""


def test_code_depends_on_the_values_that_it_captures(tmp_path, printed):
    """Each kind of capture has a kernel, and three processes run all."""
    for i, (opening, body) in enumerate(CAPTURES.values()):
        bound = "\nscaled = make((lambda x: K * x, K))" if "make" in opening else ""
        text = f"{HEADER}{opening}{bound}\n@compiled\ndef kernel_{i}(x):\n    return {body}\n"
        (tmp_path / f"caller_{i}.py").write_text(text)
    count = len(CAPTURES)
    script = f"for i in range({count}): print(vars(__import__(f'caller_{{i}}'))[f'kernel_{{i}}'](2.0))"
    (tmp_path / "laws.py").write_text(LAWS)
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "middle.py").write_text("from parts.inner import part\n")
    for factor in (3.0, 5.0, 3.0):
        record = f"from typing import NamedTuple\nclass Record(NamedTuple):\n    k: float = {factor}\n"
        (tmp_path / "values.py").write_text(f"K = {factor}\nclass Table:\n    K = {factor}\n{record}")
        (tmp_path / "parts" / "inner.py").write_text(f"K = {factor}\ndef part(x):\n    return K * x\n")
        (tmp_path / "table.txt").write_text(f"1.0 {factor}")
        assert dict(zip(CAPTURES, printed(script), strict=True)) == dict.fromkeys(CAPTURES, str(2.0 * factor))
    assert [len(list(tmp_path.glob(f"code/*/kernel_{i}-*.code"))) for i in range(count)] == count * [2]


def test_code_of_an_edited_file_is_that_of_what_was_imported(tmp_path, printed):
    """A changed source is refused, unless its text was read before."""
    text = f"{HEADER}@compiled\ndef line(x):\n    return 3.0 * x\n@compiled\ndef other(x):\n    return line(x) + 1.0\n"
    (tmp_path / "law.py").write_text(text)
    edit = "open('law.py', 'w').write(text.replace('3.0', '7.0'))"
    script = f"import law; text = open('law.py').read(); {{first}}; {edit}; print(law.other(1.0))"
    refusal = f"try: {edit}; law.other(1.0)\nexcept TypeError as error: print('changed after' in str(error))"
    assert printed(f"import law\ntext = open('law.py').read()\n{refusal}") == ["True"]
    (tmp_path / "law.py").write_text(text)
    assert printed(script.format(first="law.line(1.0)")) == ["4.0"]
    (tmp_path / "law.py").write_text(text)
    assert printed("import law; print(law.other(1.0), law.line(1.0))") == ["4.0", "3.0"]
    (tmp_path / "law.py").write_text(text.replace("3.0", "7.0"))
    assert printed("import law; print(law.other(1.0), law.line(1.0))") == ["8.0", "7.0"]


def test_closures_of_one_function_have_code_of_their_own(keeping):
    def scaled(factor):
        return compiled(lambda x: factor * x)

    kernels = [scaled(factor) for factor in (2.0, 3.0, 2.0)]
    assert [kernel(5.0) for kernel in kernels] == [10.0, 15.0, 10.0]


def test_a_name_with_a_new_value_is_read_anew(keeping, monkeypatch):
    monkeypatch.setattr(sys.modules[__name__], "FACTOR", 2.0)
    kernel = compiled(by_factor)
    assert kernel(5.0) == 10.0
    monkeypatch.setattr(sys.modules[__name__], "FACTOR", 3.0)
    assert kernel(5.0) == 15.0
    monkeypatch.setattr(sys.modules[__name__], "double", lambda value: 7.0 * value)
    assert not kernel.is_loaded(5.0)


def test_a_function_of_the_c_library_is_loaded_in_a_second_process(tmp_path, printed):
    """A law from outside may call one, with any number of threads."""
    body = "@compiled\ndef gamma(x):\n    return math.gamma(x)\n"
    (tmp_path / "outside.py").write_text(f"import math\n{HEADER}\n\n{body}")
    for threads in ("1", "2"):
        assert printed("import outside; print(outside.gamma(5.0))", OMP_NUM_THREADS=threads) == ["24.0"]
    assert len(list(tmp_path.glob("code/*/gamma-*.code"))) == 1


def test_who_comes_second_waits_and_who_compiles_another_kind_does_not(tmp_path, monkeypatch):
    """The lock is held here, as another process holds it."""
    monkeypatch.setattr(folder, "PATIENCE_S", 0.3)
    code, entered, waited = tmp_path / "code" / "kind.code", threading.Event(), threading.Event()

    def compile_there(path, started):
        def compile_it():
            with one_process_compiles(path, waited.set):
                started.set()

        thread = threading.Thread(target=compile_it)
        thread.start()
        return thread

    with one_process_compiles(code, waited.set):
        second, third = compile_there(code, entered), threading.Event()
        assert waited.wait(60.0)
        assert not entered.is_set()
        compile_there(code.with_name("other.code"), third).join(60.0)
        assert third.is_set()
    assert entered.wait(60.0)
    second.join()
    with open(tmp_path / "code" / "kind.lock") as file:  # it is free again
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def test_without_a_folder_each_compiles_for_itself(tmp_path):
    (tmp_path / "file").write_text("")
    with one_process_compiles(tmp_path / "file" / "code" / "kind.code", pytest.fail):
        assert not (tmp_path / "file").is_dir()


def test_code_is_known_by_the_types_of_its_arguments(outcome):
    """After a run its step has code, for those types alone."""
    model = outcome("paper-table-3").fe_plan.model
    kernel, arguments = Stepper(model).step_call
    assert kernel.has_code(*arguments)
    assert not advance.has_code(1, 2.0, np.zeros(3))


def test_compiling_is_told_once_a_kind_with_the_time_of_the_last(keeping):
    messages: list[str] = []

    def use(value):
        function = compiled(double)  # as a new process has it
        compile_once(lambda: function(value), function, value, on_compile=messages.append)

    use(1.0)
    assert re.fullmatch(r"compiling the time loop .*: about 2 s\ncompiled in \d s", "\n".join(messages))
    use(2.0)
    assert len(messages) == 2
    folder.save_time(1234.0)
    use(3)  # another kind
    assert messages[2].endswith(": about 1234 s")
    assert (0.0 < folder.expected_time() < USUAL_S, len(messages)) == (True, 4)


@pytest.mark.parametrize("text", ["nan", "inf", "-1", "0", "3600", "1e999", "", "x", "1" * 40, "\xe9"])
def test_a_time_that_no_compiling_takes_is_not_believed(text, keeping):
    folder.write(folder.cache_folder() / folder.TIME_FILE, text.encode())
    assert folder.expected_time() == USUAL_S


@pytest.mark.long
def test_first_run_says_that_it_compiles_and_the_second_does_not(tmp_path):
    """Standard error is no terminal here."""
    command = [sys.executable, "-m", "tailslap.cli", "run", "paper-table-3", "--no-pictures"]
    environment = os.environ | {"TAILSLAP_CACHE_DIR": str(tmp_path / "code")}

    def standard_error():
        process = subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return process.stderr

    assert re.search(
        r"compiling the time loop .*: about 2 s\n.*compiled in \d+ s", standard_error(), re.DOTALL
    )
    assert "compil" not in standard_error()
