"""Translation of a function's statements to LLVM's language."""

import ast
import re
from collections.abc import Iterator
from contextlib import contextmanager

from machine_code import source
from machine_code.arrays import fill, load, load_item, store_item
from machine_code.expressions import Arguments, Caller, Expressions, Slot
from machine_code.llvm_text import Block, FunctionText
from machine_code.values import (
    INTEGER,
    NOTHING,
    Array,
    Implementation,
    Known,
    Nothing,
    Number,
    Record,
    TranslationError,
    Value,
    integer,
    refuse,
)

SHORT_LOOP = "!0"
"""Name of the properties of loops that LLVM neither vectorises nor unrolls."""

METADATA = (
    f'{SHORT_LOOP} = distinct !{{{SHORT_LOOP}, !{{!"llvm.loop.unroll.runtime.disable"}}, '
    '!{!"llvm.loop.vectorize.enable", i1 false}}'
)

RENAMED = re.compile(r"\b([A-Za-z_]\w*)\.\d+\b")
"""Name of one of several variables of a name, as `source` calls them."""

UNROLLED = 32
"""Longest loop over the items of a tuple that is written out."""


class Statements(Expressions):
    """A function, translated at the end of `code`."""

    def __init__(self, kernel: Caller, code: FunctionText, called: Implementation) -> None:
        super().__init__(kernel, code, called)
        self._is_compact = called.is_compact or kernel.is_compact
        self._loops: list[tuple[Block, Block]] = []
        self._result: Slot | None = None
        self._end: Block | None = None

    def run(self, arguments: Arguments) -> Value:
        """Translate the function for these arguments and return its result."""
        parameters = source.parameters_of(self.node)
        if len(parameters) != len(arguments):
            refuse(
                f"{self.function.__qualname__} has {len(parameters)} parameters, and {len(arguments)} arguments"
            )
        for name, value in zip(parameters, arguments, strict=True):
            self._store_name(name, value)
        statements = source.body_of(self.node)
        returns = [node for s in statements for node in ast.walk(s) if isinstance(node, ast.Return)]
        if len(returns) == 1 and returns[0] is statements[-1]:
            self._block(statements[:-1])
            return self._returned(returns[0])
        self._end = self.code.new_block()
        self._block(statements)
        with self._located(self.node):
            if self.code.is_reached and self._result and not isinstance(self._result.value, Nothing):
                refuse(f"an end of {self.function.__qualname__} without return, where others return a value")
        self.code.jump(self._end)
        self.code.begin(self._end)
        return self._load(self._result) if self._result else NOTHING

    def _block(self, statements: list[ast.stmt]) -> None:
        """Translate statements up to one that jumps away."""
        for statement in statements:
            if not self.code.is_reached:
                return
            with self._located(statement):
                translate = getattr(self, f"_do_{type(statement).__name__}", None)
                if translate is None:
                    refuse(f"{type(statement).__name__} statement")
                translate(statement)

    @contextmanager
    def _located(self, node: ast.stmt | source.Function) -> Iterator[None]:
        """Name the line of a statement or function in its errors."""
        try:
            yield
        except TranslationError as error:
            place = error.place or f"{self.function.__code__.co_filename}:{node.lineno}"
            raise TranslationError(RENAMED.sub(r"\1", error.args[0]), place) from None

    def _returned(self, node: ast.Return) -> Value:
        with self._located(node):
            return self._value(node.value) if node.value else NOTHING

    def _do_Expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):
            self._value(node.value)

    def _do_Pass(self, node: ast.Pass) -> None:
        pass

    def _do_Assign(self, node: ast.Assign) -> None:
        value = self._value(node.value)
        for target in node.targets:
            self._assign(target, value)

    def _do_AugAssign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Name):
            before = self._value(ast.copy_location(ast.Name(node.target.id, ast.Load()), node))
            self._store_name(node.target.id, self._binary(node.op, before, self._value(node.value)))
        elif isinstance(node.target, ast.Subscript):
            array = self._array(node.target.value)
            item = self._element(array, node.target.slice)
            if item.shape:
                refuse("an operation on a part of an array")
            before = load_item(self.code, item)
            store_item(self.code, item, self._binary(node.op, before, self._value(node.value)))
        else:
            refuse(f"an operation on {ast.unparse(node.target)}")

    def _do_Return(self, node: ast.Return) -> None:
        value = self._returned(node)
        if self._result is None:
            self._result = self._new_slot(value)
        self._store(self._result, value, "the result")
        assert self._end is not None
        self.code.jump(self._end)

    def _do_If(self, node: ast.If) -> None:
        yes, no, after = self.code.new_block(), self.code.new_block(), self.code.new_block()
        decided = self._branch(node.test, yes, no)
        if decided is not None:
            self._block(node.body if decided else node.orelse)
            return
        for block, statements in ((yes, node.body), (no, node.orelse)):
            self.code.begin(block)
            self._block(statements)
            self.code.jump(after)
        self.code.begin(after)

    def _do_While(self, node: ast.While) -> None:
        if node.orelse:
            refuse("else of a loop")
        head, body, after = self.code.new_block(), self.code.new_block(), self.code.new_block()
        self.code.jump(head)
        self.code.begin(head)
        decided = self._branch(node.test, body, after)
        if decided is not None:
            self.code.jump(body if decided else after)
        self.code.begin(body)
        self._loop_body(node.body, head, after)
        self.code.jump(head)
        self.code.begin(after)

    def _do_Break(self, node: ast.Break) -> None:
        self.code.jump(self._loops[-1][1])

    def _do_Continue(self, node: ast.Continue) -> None:
        self.code.jump(self._loops[-1][0])

    def _do_For(self, node: ast.For) -> None:
        if node.orelse:
            refuse("else of a loop")
        iterated = node.iter
        if isinstance(iterated, ast.Call) and self._value(iterated.func) == Known(range):
            bounds = [self._integer(argument) for argument in iterated.args]
            if self._is_over_tuple(iterated) and len(bounds) == 1:
                self._write_out(node, tuple(integer(i) for i in range(int(bounds[0].constant or 0))))
            else:
                start, stop, *step = bounds if len(bounds) > 1 else [integer(0), *bounds]
                self._count(node, start, stop, step[0] if step else None)
            return
        values = self._value(iterated)
        if isinstance(values, Record):
            self._write_out(node, values.items)
        elif isinstance(values, Array) and values.shape:
            self._count(node, integer(0), Number(INTEGER, values.shape[0]), over=values)
        else:
            refuse("a loop over a number")

    def _is_over_tuple(self, iterated: ast.Call) -> bool:
        """Return True for the range of a tuple's length."""
        length = iterated.args[0]
        return (
            isinstance(length, ast.Call)
            and self._value(length.func) == Known(len)
            and isinstance(values := self._value(length.args[0]), Record)
            and len(values.items) <= UNROLLED
        )

    def _write_out(self, node: ast.For, values: tuple[Value, ...]) -> None:
        """Translate a loop's body for each of these values."""
        after = self.code.new_block()
        for value in values:
            following = self.code.new_block()
            self._assign(node.target, value)
            self._loop_body(node.body, following, after)
            self.code.jump(following)
            self.code.begin(following)
        self.code.jump(after)
        self.code.begin(after)

    def _count(
        self,
        node: ast.For,
        start: Number,
        stop: Number,
        step: Number | None = None,
        over: Array | None = None,
    ) -> None:
        """Translate a loop over integers, or over the items of an array."""
        step = step or integer(1)
        if not step.constant:
            refuse("a range with a variable step")
        properties = f", !llvm.loop {SHORT_LOOP}" if self._is_compact and stop.constant is None else ""
        loop = self.code.loop(start.operand, stop.operand, int(step.constant), properties)
        with loop as (i, later, after):
            self._assign(node.target, Number(INTEGER, i) if over is None else load(self.code, over, i))
            self._loop_body(node.body, later, after)

    def _loop_body(self, statements: list[ast.stmt], later: Block, after: Block) -> None:
        self._loops.append((later, after))
        self._block(statements)
        self._loops.pop()

    def _assign(self, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            self._store_name(target.id, value)
        elif isinstance(target, ast.Tuple):
            values = self._items(value, len(target.elts))
            for part, item in zip(target.elts, values, strict=True):
                self._assign(part, item)
        elif isinstance(target, ast.Subscript):
            element = self._element(self._array(target.value), target.slice)
            (fill if element.shape else store_item)(self.code, element, value)
        else:
            refuse(f"an assignment to {ast.unparse(target)}")

    def _items(self, value: Value, count: int) -> tuple[Value, ...]:
        """Return the items of a tuple of this length."""
        if isinstance(value, Array):
            refuse(f"an assignment of an array, whose length may vary, to {count} variables")
        if not isinstance(value, Record) or len(value.items) != count:
            refuse(f"an assignment to {count} variables")
        return value.items
