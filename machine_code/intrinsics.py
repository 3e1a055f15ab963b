"""Instructions of the processor and functions of the C library in kernels."""

from collections.abc import Callable
from typing import NoReturn

from machine_code.expressions import Caller
from machine_code.llvm_text import FunctionText
from machine_code.values import INTEGER, ITEMS, NOTHING, Array, Number, Value, refuse


class Intrinsic:
    """A function that adds its own instructions to compiled code."""

    def __init__(self, add: Callable[..., Value]) -> None:
        self.intrinsic = add

    def __call__(self, *arguments: object) -> NoReturn:
        raise NotImplementedError("only compiled code can call this")


def library_function(name: str, count: int) -> Intrinsic:
    """Return a function of the C library.

    Its `count` arguments are addresses, and its result is ignored.
    """

    def add(kernel: Caller, code: FunctionText, *addresses: Number) -> Value:
        if len(addresses) != count:
            refuse(f"{name} with {len(addresses)} arguments")
        kernel.declarations.add(f"declare i32 @{name}({', '.join(['i64'] * count)})")
        code.value(f"call i32 @{name}({', '.join(f'i64 {address.operand}' for address in addresses)})")
        return NOTHING

    return Intrinsic(add)


def _address(code: FunctionText, array: Value, index: Value) -> str:
    """Return the address of an item of an array of integers."""
    if not isinstance(array, Array) or ITEMS[array.item] != INTEGER or not isinstance(index, Number):
        refuse("an atomic operation on other than an array of integers")
    return code.item(array.data, INTEGER, index.operand)


def _load(kernel: Caller, code: FunctionText, array: Value, index: Value) -> Value:
    return code.number(INTEGER, f"load atomic i64, ptr {_address(code, array, index)} acquire, align 8")


def _store(kernel: Caller, code: FunctionText, array: Value, index: Value, number: Number) -> Value:
    address = _address(code, array, index)
    code.add(f"store atomic i64 {number.operand}, ptr {address} release, align 8")
    return NOTHING


def _add(kernel: Caller, code: FunctionText, array: Value, index: Value, number: Number) -> Value:
    address = _address(code, array, index)
    return code.number(INTEGER, f"atomicrmw add ptr {address}, i64 {number.operand} acq_rel")


atomic_load = Intrinsic(_load)
"""Read item `index` of an array; the compiler must not reorder it."""

atomic_store = Intrinsic(_store)
"""Write an item. A thread that reads it sees all that this thread wrote before."""

atomic_add = Intrinsic(_add)
"""Add to an item and return its value before. The next thread sees all that this one wrote before."""
