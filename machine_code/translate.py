"""Translation of kernels from Python to LLVM's language.

A kernel has numbers, arrays of them, tuples, NamedTuples and None; loops, branches and calls. Each expression is
translated where it stands, from the types of the arguments on, so that a branch on `is None`, on the length of a tuple
or on another constant is decided here. A function becomes one of LLVM for each structure of its arguments, or is
merged into its caller. Nothing is allocated, and nothing raises: indices are those of an array, or negative constants.
"""

import itertools
import re
from collections.abc import Callable

from machine_code.expressions import Arguments
from machine_code.llvm_text import FUSED, REORDERED, FunctionText
from machine_code.statements import Statements
from machine_code.values import (
    INTEGER,
    LOGICAL,
    Implementation,
    PythonFunction,
    Value,
    leaves,
    rebuilt,
    refuse,
    structure,
)

Resolve = Callable[[object, Arguments], Implementation | None]
"""Function that returns the implementation of a callee, or None."""


class Translation:
    """Text of a kernel with the functions that it calls.

    resolve: see `Resolve`. is_compact: True where no loop is unrolled or vectorised. check_indices: True to end the
    process at an index outside an array.
    """

    def __init__(self, resolve: Resolve, is_compact: bool, check_indices: bool) -> None:
        self.resolve, self.is_compact, self.check_indices = resolve, is_compact, check_indices
        self.texts: list[str] = []
        self.declarations: set[str] = set()
        self._functions: dict[object, tuple[str, Value] | None] = {}
        self._merging: list[object] = []
        self._numbers = itertools.count()

    def kernel(self, called: Implementation, symbol: str, read: Callable[[FunctionText], Arguments]) -> Value:
        """Translate a kernel.

        It writes the numbers of its result behind one another. read: reads its arguments from the memory at
        `%arguments`. Returns the result, whose operands have no meaning outside.
        """
        code, result = self._translated(called, read, _store_result)
        self.texts.append(code.text(f"define void @{symbol}(ptr %result, ptr %arguments) #0"))
        return result

    def call(self, code: FunctionText, called: Implementation, arguments: Arguments) -> Value:
        """Call a function, which is translated once for each structure of arguments."""
        key = called.function, *map(structure, arguments)
        if key not in self._functions:
            self._functions[key] = None
            self._functions[key] = self._new_function(called, arguments)
        function = self._functions[key]
        if function is None:
            refuse(f"{called.function.__qualname__}, which calls itself")
        symbol, result = function
        operands = _listed(arguments)
        kinds = [kind for kind, _ in leaves(result)]
        if not kinds:
            code.add(f"call void @{symbol}({operands})")
            return result
        returned = f"{{{', '.join(kinds)}}}"
        whole = code.value(f"call {returned} @{symbol}({operands})")
        return rebuilt(
            result, (code.value(f"extractvalue {returned} {whole}, {i}") for i in range(len(kinds)))
        )

    def merged(self, code: FunctionText, called: Implementation, arguments: Arguments) -> Value:
        """Add the code of a function to its caller's."""
        key = called.function, *map(structure, arguments)
        if key in self._merging:
            refuse(f"{called.function.__qualname__}, which calls itself")
        self._merging.append(key)
        result = Statements(self, code, called).run(arguments)
        self._merging.pop()
        return result

    def _new_function(self, called: Implementation, arguments: Arguments) -> tuple[str, Value]:
        names = (f"%a{i}" for i in itertools.count())
        parameters = tuple(rebuilt(value, names) for value in arguments)
        code, result = self._translated(called, lambda code: parameters, _return_result)
        kinds = [kind for kind, _ in leaves(result)]
        symbol = symbol_of(f"f{next(self._numbers)}", called.function)
        returned = f"{{{', '.join(kinds)}}}" if kinds else "void"
        self.texts.append(code.text(f"define internal {returned} @{symbol}({_listed(parameters)}) #0"))
        return symbol, result

    def _translated(
        self,
        called: Implementation,
        read: Callable[[FunctionText], Arguments],
        finish: Callable[[FunctionText, Value], None],
    ) -> tuple[FunctionText, Value]:
        """Return the text of a function."""
        code = FunctionText(self.check_indices, REORDERED if called.is_reordered else FUSED)
        result = Statements(self, code, called).run(read(code))
        finish(code, result)
        return code, result


def symbol_of(prefix: str, function: PythonFunction) -> str:
    """Return LLVM's name of a function."""
    return f"{prefix}_{re.sub('[^0-9A-Za-z_]', '_', function.__name__)}"


def _store_result(code: FunctionText, result: Value) -> None:
    for place, (kind, operand) in enumerate(leaves(result)):
        if kind == LOGICAL:
            kind, operand = INTEGER, code.value(f"zext i1 {operand} to i64")
        code.add(f"store {kind} {operand}, ptr {code.item('%result', INTEGER, str(place))}")
    code.leave("void")


def _listed(arguments: Arguments) -> str:
    """Return types and operands of arguments."""
    return ", ".join(f"{kind} {operand}" for value in arguments for kind, operand in leaves(value))


def _return_result(code: FunctionText, result: Value) -> None:
    numbers = list(leaves(result))
    if not numbers:
        code.leave("void")
        return
    kinds = f"{{{', '.join(kind for kind, _ in numbers)}}}"
    whole = "poison"
    for place, (kind, operand) in enumerate(numbers):
        whole = code.value(f"insertvalue {kinds} {whole}, {kind} {operand}, {place}")
    code.leave(f"{kinds} {whole}")
