"""Translation of expressions and names to LLVM's language."""

import ast
import builtins
from collections.abc import Hashable
from types import ModuleType
from typing import NamedTuple, Protocol

from machine_code import arithmetic, source
from machine_code.arrays import Index, load_item, part_of, place_in
from machine_code.complex_numbers import complex_binary, is_complex, magnitude, negative
from machine_code.llvm_text import Block, FunctionText
from machine_code.values import (
    FLOAT,
    INTEGER,
    LOGICAL,
    NAMES,
    Array,
    Implementation,
    Known,
    Nothing,
    Number,
    Record,
    Value,
    as_number,
    constant,
    described,
    integer,
    leaves,
    logical,
    rebuilt,
    refuse,
    structure,
)

Arguments = tuple[Value, ...]

INDEX_OPERATIONS: dict[type[ast.operator], str] = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul"}


class Slot(NamedTuple):
    """Memory of a variable that is assigned more than once.

    variable: its name in `FunctionText.assign`.
    """

    value: Value
    addresses: tuple[str, ...]
    variable: str


class Caller(Protocol):
    """The kernel of which a function is a part.

    declarations: of functions of the C library; is_compact: True where no loop is unrolled.
    """

    declarations: set[str]
    is_compact: bool

    def resolve(self, function: object, arguments: Arguments, /) -> Implementation | None:
        """Return the implementation of a callee, or None."""

    def call(self, code: FunctionText, called: Implementation, arguments: Arguments) -> Value:
        """Call a function and return its result."""

    def merged(self, code: FunctionText, called: Implementation, arguments: Arguments) -> Value:
        """Add the code of a function and return its result."""


class Expressions:
    """Names of a function and their values, at the end of `code`."""

    def __init__(self, kernel: Caller, code: FunctionText, called: Implementation) -> None:
        self.kernel, self.code, self.function = kernel, code, called.function
        self.node = source.tree_of(self.function)
        self._names: dict[str, Value | Slot] = {}
        cells = (cell.cell_contents for cell in self.function.__closure__ or ())
        closure = dict(zip(self.function.__code__.co_freevars, cells, strict=True))
        self._scopes = closure, self.function.__globals__, vars(builtins)
        self._local = {*self.function.__code__.co_varnames, *self.function.__code__.co_cellvars}
        self._once = source.bound_once(self.node)

    def _value(self, node: ast.expr) -> Value:
        """Return the value of an expression."""
        method = getattr(self, f"_of_{type(node).__name__}", None)
        if method is None:
            refuse(ast.unparse(node))
        return method(node)

    def _number(self, node: ast.expr) -> Number:
        return as_number(self._value(node))

    def _integer(self, node: ast.expr) -> Number:
        number = self._number(node)
        if number.kind != INTEGER:
            refuse(f"{NAMES[number.kind]} as an index: {ast.unparse(node)}")
        return number

    def _array(self, node: ast.expr) -> Array:
        value = self._value(node)
        if not isinstance(value, Array):
            refuse(f"{ast.unparse(node)} is not an array")
        return value

    def _element(self, array: Array, index: ast.expr) -> Array:
        """Return the part of an array at an index.

        One item is an array without dimensions.
        """
        indices = index.elts if isinstance(index, ast.Tuple) else [index]
        return part_of(self.code, array, list(map(self._index, indices)))

    def _index(self, node: ast.expr) -> Index:
        if not isinstance(node, ast.Slice):
            return self._place(node)
        if node.step is not None:
            refuse("a slice with a step")
        lower, upper = (self._place(bound) if bound else None for bound in (node.lower, node.upper))
        return lower, upper

    def _place(self, node: ast.expr) -> Number:
        """Return an index.

        Its sums and products stay within 64 bits, as no array is longer, which LLVM has to know to vectorise.
        """
        operation = INDEX_OPERATIONS.get(type(node.op)) if isinstance(node, ast.BinOp) else None
        if operation is None:
            return self._integer(node)
        assert isinstance(node, ast.BinOp)
        first = self._place(node.left)
        operand = self.code.whole(operation, first.operand, self._place(node.right).operand)
        return Number(INTEGER, operand, int(operand) if operand.lstrip("-").isdigit() else None)

    # Names

    def _store_name(self, name: str, value: Value) -> None:
        if name in self._once:
            self._names[name] = value
            return
        slot = self._names.get(name)
        if not isinstance(slot, Slot):
            slot = self._names[name] = self._new_slot(value)
        self._store(slot, value, name)
        self.code.assign(slot.variable)

    def _new_slot(self, value: Value) -> Slot:
        """Return memory for a variable, or for a function's result."""
        addresses = tuple(self.code.slot(kind) for kind, _ in leaves(value))
        return Slot(value, addresses, self.code.new_variable())

    def _store(self, slot: Slot, value: Value, name: str) -> None:
        """Store a value of the slot's structure."""
        if structure(value) != structure(slot.value):
            refuse(f"{name.partition('.')[0]}, which is {described(slot.value)} and {described(value)}")
        for (kind, operand), address in zip(leaves(value), slot.addresses, strict=True):
            self.code.add(f"store {kind} {operand}, ptr {address}")

    def _load(self, slot: Slot) -> Value:
        kinds = [kind for kind, _ in leaves(slot.value)]
        loads = (
            self.code.value(f"load {kind}, ptr {place}")
            for kind, place in zip(kinds, slot.addresses, strict=True)
        )
        return rebuilt(slot.value, loads)

    # Conditions

    def _branch(self, test: ast.expr, yes: Block, no: Block, is_value: bool = False) -> bool | None:
        """Jump to one of two blocks by a condition.

        A condition that is known is returned instead, without a jump. is_value: True where the condition itself is
        the value, and not its truth alone.
        """
        if isinstance(test, ast.BoolOp):
            return self._branch_of_many(test, yes, no, is_value)
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            decided = self._branch(test.operand, no, yes)
            return None if decided is None else not decided
        number = self._number(test)
        if is_value and number.kind != LOGICAL:
            refuse(f"the value of `and` or `or` for {NAMES[number.kind]}: {ast.unparse(test)}")
        truth = self.code.truth(number)
        if truth.constant is not None:
            return bool(truth.constant)
        self.code.branch(truth.operand, yes, no)
        return None

    def _branch_of_many(self, test: ast.BoolOp, yes: Block, no: Block, is_value: bool) -> bool | None:
        """Jump by conditions joined by `and` or `or`."""
        is_and, jumped = isinstance(test.op, ast.And), False
        for condition in test.values:
            following = self.code.new_block()
            decided = self._branch(condition, *((following, no) if is_and else (yes, following)), is_value)
            if decided is None:
                jumped = True
                self.code.begin(following)
            elif decided != is_and:  # later conditions do not matter
                if not jumped:
                    return decided
                self.code.jump(no if is_and else yes)
                return None
        if not jumped:
            return is_and
        self.code.jump(yes if is_and else no)
        return None

    def _condition(self, test: ast.expr) -> Number:
        """Return the truth of conditions joined by `and` or `or`."""
        yes, no, after = (self.code.new_block() for _ in range(3))
        decided = self._branch(test, yes, no, is_value=True)
        if decided is not None:
            return logical(decided)
        for block in (yes, no):
            self.code.begin(block)
            self.code.jump(after)
        self.code.begin(after)
        return self.code.number(LOGICAL, f"phi i1 [true, %{yes.label}], [false, %{no.label}]")

    # Kinds of expressions

    def _of_Constant(self, node: ast.Constant) -> Value:
        return constant(node.value)

    def _of_Name(self, node: ast.Name) -> Value:
        name = node.id
        if name in self._names:
            value = self._names[name]
            if not isinstance(value, Slot):
                return value
            if self.code.is_assigned(value.variable):
                return self._load(value)
        variable = name.partition(".")[0]
        if variable in self._local:
            refuse(f"the variable {variable}, which may have no value here")
        for scope in self._scopes:
            if name in scope:
                return constant(scope[name])
        return refuse(f"the name {name}")

    def _of_Tuple(self, node: ast.Tuple) -> Value:
        return Record(tuple, tuple(map(self._value, node.elts)))

    def _of_Attribute(self, node: ast.Attribute) -> Value:
        value, name = self._value(node.value), node.attr
        if isinstance(value, Record) and is_complex(value) and name in ("real", "imag"):
            return value.items[name == "imag"]
        if isinstance(value, Record) and name in getattr(value.kind, "_fields", ()):
            return value.items[value.kind._fields.index(name)]
        if isinstance(value, Array) and name == "shape":
            return Record(tuple, tuple(Number(INTEGER, size) for size in value.shape))
        if isinstance(value, Array) and name == "size":
            size = "1"
            for length in value.shape:
                size = self.code.product(size, length)
            return Number(INTEGER, size)
        if isinstance(value, Known) and isinstance(value.content, ModuleType | type):
            for owner in getattr(value.content, "__mro__", (value.content,)):
                if name in vars(owner):
                    return constant(vars(owner)[name])
        return refuse(f"the attribute {name}")

    def _of_Subscript(self, node: ast.Subscript) -> Value:
        value = self._value(node.value)
        if isinstance(value, Array):
            element = self._element(value, node.slice)
            return element if element.shape else load_item(self.code, element)
        if not isinstance(value, Record):
            refuse(f"an item of {ast.unparse(node.value)}")
        if isinstance(node.slice, ast.Slice):
            ends = [
                self._number(part).constant if part else None for part in (node.slice.lower, node.slice.upper)
            ]
            return Record(tuple, value.items[slice(*(None if end is None else int(end) for end in ends))])
        item: Value = value
        for index in node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]:
            if not isinstance(item, Record):
                refuse(f"an item of a number: {ast.unparse(node)}")
            item = self._chosen_item(item.items, self._integer(index))
        return item

    def _chosen_item(self, items: tuple[Value, ...], index: Number) -> Value:
        """Return the item of a tuple at an index, which may vary."""
        if index.constant is not None:
            if not -len(items) <= index.constant < len(items):
                refuse(f"item {index.constant} of {len(items)}")
            return items[int(index.constant)]
        if not items:
            refuse("an item of no items")
        index = Number(INTEGER, place_in(self.code, index, str(len(items))))
        result = items[0]
        for i, item in enumerate(items[1:], start=1):
            is_item = arithmetic.compare(self.code, ast.Eq(), index, integer(i))
            result = self._selected(is_item, item, result)
        return result

    def _selected(self, condition: Number, a: Value, b: Value) -> Value:
        """Return the first value where the condition holds, else the second.

        They have the same structure.
        """
        if structure(a) != structure(b):
            refuse(f"{described(a)} or {described(b)}, by an index that varies")
        pairs = zip(leaves(a), leaves(b), strict=True)
        selected = (
            self.code.value(f"select i1 {condition.operand}, {kind} {first}, {kind} {second}")
            for (kind, first), (_, second) in pairs
        )
        return rebuilt(a, selected)

    def _of_BinOp(self, node: ast.BinOp) -> Value:
        first = self._value(node.left)
        return self._binary(node.op, first, self._value(node.right))

    def _binary(self, operator: ast.operator, first: Value, second: Value) -> Value:
        if is_complex(first) or is_complex(second):
            return complex_binary(self.code, operator, first, second)
        return arithmetic.binary(self.code, operator, as_number(first), as_number(second))

    def _of_UnaryOp(self, node: ast.UnaryOp) -> Value:
        value = self._value(node.operand)
        if is_complex(value) and isinstance(node.op, ast.USub):
            return negative(self.code, value)
        return arithmetic.unary(self.code, node.op, as_number(value))

    def _of_BoolOp(self, node: ast.BoolOp) -> Value:
        return self._condition(node)

    def _of_Compare(self, node: ast.Compare) -> Value:
        if len(node.ops) > 1 and not all(
            isinstance(n, ast.Name | ast.Constant) for n in node.comparators[1:]
        ):
            refuse("a chain of comparisons with more than names: " + ast.unparse(node))
        if isinstance(node.ops[0], ast.Is | ast.IsNot):
            is_none = isinstance(self._value(node.left), Nothing)
            if len(node.ops) > 1 or not isinstance(self._value(node.comparators[0]), Nothing):
                refuse("`is` with other than None")
            return logical(is_none == isinstance(node.ops[0], ast.Is))
        if isinstance(node.ops[0], ast.In) and len(node.ops) == 1:
            return self._is_among(self._number(node.left), self._value(node.comparators[0]))
        former, result = self._number(node.left), None
        for operator, comparator in zip(node.ops, node.comparators, strict=True):
            latter = self._number(comparator)
            truth = arithmetic.compare(self.code, operator, former, latter)
            result = truth if result is None else arithmetic.binary(self.code, ast.BitAnd(), result, truth)
            former = latter
        assert result is not None
        return result

    def _is_among(self, number: Number, values: Value) -> Number:
        """Return True where a number is one of a tuple."""
        if not isinstance(values, Record):
            refuse("`in` with other than a tuple")
        if number.kind == FLOAT:
            refuse("`in` of a float, where Python compares objects")
        result = logical(False)
        for value in values.items:
            is_equal = arithmetic.compare(self.code, ast.Eq(), number, as_number(value))
            result = arithmetic.binary(self.code, ast.BitOr(), result, is_equal)
        return result

    def _of_IfExp(self, node: ast.IfExp) -> Value:
        code = self.code
        blocks = code.new_block(), code.new_block()
        decided = self._branch(node.test, *blocks)
        if decided is not None:
            return self._value(node.body if decided else node.orelse)
        after, ends = code.new_block(), []
        for block, branch in zip(blocks, (node.body, node.orelse), strict=True):
            code.begin(block)
            ends.append((self._value(branch), code.block))
            code.jump(after)
        (first, one), (second, two) = ends
        if structure(first) != structure(second):
            refuse(f"{described(first)} or {described(second)}, by a condition")
        code.begin(after)
        pairs = zip(leaves(first), leaves(second), strict=True)
        joined = (
            code.value(f"phi {kind} [{a}, %{one.label}], [{b}, %{two.label}]") for (kind, a), (_, b) in pairs
        )
        return rebuilt(first, joined)

    def _of_Call(self, node: ast.Call) -> Value:
        callee = self._value(node.func)
        if not isinstance(callee, Known):
            refuse(f"a call of {ast.unparse(node.func)}")
        function = callee.content
        arguments = tuple(map(self._value, node.args))
        if not isinstance(function, Hashable) or any(isinstance(part, ast.Starred) for part in node.args):
            refuse(f"a call of {ast.unparse(node)}")
        if isinstance(function, type) and hasattr(function, "_fields"):
            named = {word.arg: self._value(word.value) for word in node.keywords}
            return self._record(function, arguments, named)
        if node.keywords:
            refuse("arguments by name")
        if function is len and len(arguments) == 1:
            return self._length(arguments[0])
        if (intrinsic := getattr(function, "intrinsic", None)) is not None:
            return intrinsic(self.kernel, self.code, *arguments)
        if function is abs and len(arguments) == 1 and is_complex(arguments[0]):
            return magnitude(self.code, arguments[0])
        if function in arithmetic.FUNCTIONS or function in arithmetic.EXTREMES:
            return arithmetic.call_function(self.code, function, *map(as_number, arguments))
        called = self.kernel.resolve(function, arguments)
        if called is None:
            refuse(f"a call of {ast.unparse(node.func)}")
        if called.is_merged:
            return self.kernel.merged(self.code, called, arguments)
        return self.kernel.call(self.code, called, arguments)

    def _record(self, kind: type, arguments: Arguments, named: dict[str | None, Value]) -> Value:
        """Return a NamedTuple of these fields."""
        fields: tuple[str, ...] = kind._fields  # type: ignore[attr-defined]
        values = dict(zip(fields, arguments, strict=False)) | named
        defaults = {name: constant(value) for name, value in kind._field_defaults.items()}  # type: ignore[attr-defined]
        complete = defaults | values
        if complete.keys() != set(fields) or len(arguments) > len(fields):
            refuse(f"{kind.__name__} with these fields: {', '.join(map(str, values))}")
        return Record(kind, tuple(complete[name] for name in fields))

    def _length(self, value: Value) -> Value:
        if isinstance(value, Record):
            return integer(len(value.items))
        if isinstance(value, Array) and value.shape:
            return Number(INTEGER, value.shape[0])
        return refuse("the length of a number")
