"""Text of a function in LLVM's language, block by block."""

from collections.abc import Iterator
from contextlib import contextmanager

from machine_code.values import FLOAT, INTEGER, LOGICAL, NAMES, RANKS, Number, integer, logical, real, refuse

FUSED, REORDERED = "contract", "contract reassoc nsz"
"""Optimisations of floats: a product and a sum in one rounding, and any order of sums in marked functions.

Elsewhere sums keep their order and zeros their sign: NaN, infinity and the error terms of sums are those of Python.
"""


class Block:
    """Instructions without a jump but at their end.

    assigned: variables that have a value whenever the block is reached; None while no jump leads to it.
    """

    def __init__(self, label: str) -> None:
        self.label, self.lines, self.is_closed = label, [f"{label}:"], False
        self.assigned: frozenset[str] | None = None


class FunctionText:
    """Function of LLVM that is being written, at the end of `block`.

    has_checks: True to end the process where a check fails. floats: optimisations of its operations on floats.
    """

    def __init__(self, has_checks: bool, floats: str = FUSED) -> None:
        self._has_checks, self.floats = has_checks, floats
        self._count, self._slots = 0, ["entry:"]
        self._blocks: list[Block] = []
        self.block = self.new_block()
        self.block.assigned = frozenset()
        self.begin(self.block)

    def text(self, header: str) -> str:
        """Return the text of the function."""
        lines = [line for block in self._blocks for line in block.lines]
        return "\n".join([f"{header} {{", *self._slots, f"br label %{self._blocks[0].label}", *lines, "}"])

    def new_block(self) -> Block:
        """Return a block that is not yet part of the text."""
        self._count += 1
        return Block(f"b{self._count}")

    def begin(self, block: Block) -> Block:
        """Continue the text in this block."""
        self._blocks.append(block)
        self.block = block
        return block

    def add(self, line: str) -> None:
        """Add an instruction without a result."""
        self.block.lines.append(line)

    def value(self, instruction: str) -> str:
        """Add an instruction and return the operand of its result."""
        self._count += 1
        operand = f"%v{self._count}"
        self.block.lines.append(f"{operand} = {instruction}")
        return operand

    def number(self, kind: str, instruction: str) -> Number:
        """Add an instruction and return its result of this type."""
        return Number(kind, self.value(instruction))

    def slot(self, kind: str) -> str:
        """Return the address of memory for a variable."""
        self._count += 1
        self._slots.append(f"%s{self._count} = alloca {kind}")
        return f"%s{self._count}"

    def new_variable(self) -> str:
        """Return the name of a variable for `assign`."""
        self._count += 1
        return f"x{self._count}"

    def assign(self, variable: str) -> None:
        """Note that a variable has a value from here on."""
        if self.block.assigned is not None:
            self.block.assigned |= {variable}

    def is_assigned(self, variable: str) -> bool:
        """Return True if a variable is certain to have a value here."""
        return self.block.assigned is None or variable in self.block.assigned

    @property
    def is_reached(self) -> bool:
        """True if the end of the block can be reached."""
        return self.block.assigned is not None and not self.block.is_closed

    def jump(self, block: Block) -> None:
        """End the block, if it has no end, with a jump."""
        self._end(f"br label %{block.label}", block)

    def branch(self, condition: str, true: Block, false: Block) -> None:
        """End the block with a jump to one of two blocks."""
        self._end(f"br i1 {condition}, label %{true.label}, label %{false.label}", true, false)

    def leave(self, result: str) -> None:
        """End the block with the function's result."""
        self._end(f"ret {result}")

    def _end(self, line: str, *following: Block) -> None:
        here = self.block
        if not here.is_closed:
            self.add(line)
            here.is_closed = True
            for block in following:
                if here.assigned is not None:
                    block.assigned = here.assigned & (
                        here.assigned if block.assigned is None else block.assigned
                    )

    @contextmanager
    def loop(
        self, start: str, stop: str, step: int = 1, properties: str = ""
    ) -> Iterator[tuple[str, Block, Block]]:
        """Repeat the instructions of the block for each integer of a range.

        Yields the integer, and the blocks of the next integer and behind the loop. properties: of the loop.
        """
        counter = self.slot(INTEGER)
        head, body, later, after = (self.new_block() for _ in range(4))
        self.add(f"store i64 {start}, ptr {counter}")
        self.jump(head)
        self.begin(head)
        i = self.value(f"load i64, ptr {counter}")
        self.branch(self.value(f"icmp {'slt' if step > 0 else 'sgt'} i64 {i}, {stop}"), body, after)
        self.begin(body)
        yield i, later, after
        self.jump(later)
        self.begin(later)
        following = self.value(f"add nsw i64 {self.value(f'load i64, ptr {counter}')}, {step}")
        self.add(f"store i64 {following}, ptr {counter}")
        self.jump(head)
        self.block.lines[-1] += properties
        self.begin(after)

    def check(self, condition: str) -> None:
        """End the process where a condition fails, if that is checked."""
        if self._has_checks:
            holds, fails = self.new_block(), self.new_block()
            self.branch(self.value(condition), holds, fails)
            self.begin(fails)
            self.add("call void @llvm.trap()")
            self._end("unreachable")
            self.begin(holds)

    def item(self, address: str, kind: str, index: str) -> str:
        """Return the address of an item of an array."""
        return self.value(f"getelementptr inbounds {kind}, ptr {address}, i64 {index}")

    def product(self, a: str, b: str) -> str:
        """Return the product of two indices."""
        if "1" in (a, b):
            return b if a == "1" else a
        return self.whole("mul", a, b)

    def sum(self, a: str, b: str) -> str:
        """Return the sum of two indices."""
        if "0" in (a, b):
            return b if a == "0" else a
        return self.whole("add", a, b)

    def whole(self, operation: str, a: str, b: str) -> str:
        """Return the result of an operation on indices, which cannot overflow."""
        if a.lstrip("-").isdigit() and b.lstrip("-").isdigit():
            values = {"add": int(a) + int(b), "sub": int(a) - int(b), "mul": int(a) * int(b)}
            return str(values[operation])
        return self.value(f"{operation} nsw i64 {a}, {b}")

    def converted(self, number: Number, kind: str) -> Number:
        """Return a number in this type, which is not narrower."""
        if number.kind == kind:
            return number
        if RANKS[number.kind] > RANKS[kind]:
            refuse(f"{NAMES[number.kind]} where {NAMES[kind]} is needed")
        if number.constant is not None:
            return real(float(number.constant)) if kind == FLOAT else integer(int(number.constant))
        operation = "sitofp" if number.kind == INTEGER else "uitofp" if kind == FLOAT else "zext"
        return self.number(kind, f"{operation} {number.kind} {number.operand} to {kind}")

    def truth(self, number: Number) -> Number:
        """Return True where a number is not zero."""
        if number.kind == LOGICAL:
            return number
        if number.constant is not None:
            return logical(bool(number.constant))
        if number.kind == INTEGER:
            return self.number(LOGICAL, f"icmp ne i64 {number.operand}, 0")
        return self.number(LOGICAL, f"fcmp une double {number.operand}, {real(0.0).operand}")
