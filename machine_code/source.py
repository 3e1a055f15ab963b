"""Syntax trees of functions."""

import ast
import functools
import itertools
import linecache
import os
from collections.abc import Iterable, Iterator
from types import CodeType, FunctionType

from machine_code.captures import code_text, nested_codes
from machine_code.values import TranslationError

Function = ast.FunctionDef | ast.Lambda

Names = dict[str, list[ast.Name]]
"""Occurrences of each name."""

Place = tuple[tuple[int, int], ...]
"""Blocks around a statement, each with the number of the statement in it."""


def tree_of(function: FunctionType) -> Function:
    """Return the syntax tree of a function or lambda.

    Raises TranslationError where its source is not available, or no longer that of the function, and for other than
    plain parameters.
    """
    code = function.__code__
    node = _node(code)
    if node is None and os.path.isfile(code.co_filename):  # a file that is gone keeps the text that was read
        linecache.checkcache(code.co_filename)
        node = _node(code)
    if node is None:
        raise TranslationError(
            f"the source of {function.__qualname__} is not available, or was changed after its import: "
            f"{code.co_filename}:{code.co_firstlineno}"
        )
    arguments = node.args
    if arguments.vararg or arguments.kwarg or arguments.kwonlyargs or arguments.defaults:
        what = "parameters with defaults, by name alone, or in any number"
        raise TranslationError(what, f"{code.co_filename}:{code.co_firstlineno}")
    if isinstance(node, ast.FunctionDef) and not hasattr(node, "is_separated"):
        node.is_separated = True  # type: ignore[attr-defined]
        body = list(map(_Part, node.body))
        total = {name: len(nodes) for name, nodes in _merged(part.names for part in body).items()}
        _separate(body, total, set(parameters_of(node)), itertools.count(1))
    return node


def _node(code: CodeType) -> Function | None:
    """Return the tree of a function, or None for another code."""
    functions, codes = _functions("".join(linecache.getlines(code.co_filename)))
    nodes = functions.get((code.co_firstlineno, code.co_name), [])
    if len(nodes) > 1:  # several lambdas in a line
        nodes = [node for node in nodes if _contains(node, code)]
    return nodes[0] if nodes and (code.co_firstlineno, code_text(code)) in codes else None


@functools.cache
def _functions(text: str) -> tuple[dict[tuple[int, str], list[Function]], set[tuple[int, str]]]:
    """Return the functions of a file by first line and name.

    The second result contains first lines and digests of their codes.
    """
    functions: dict[tuple[int, str], list[Function]] = {}
    try:
        tree = ast.parse(text)
        codes = nested_codes(compile(tree, "", "exec", dont_inherit=True))
        digests = {(code.co_firstlineno, code_text(code)) for code in codes}
    except (SyntaxError, ValueError):
        return {}, set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
            functions.setdefault((first, node.name), []).append(node)
        elif isinstance(node, ast.Lambda):
            functions.setdefault((node.lineno, "<lambda>"), []).append(node)
    return functions, digests


def _contains(node: Function, code: CodeType) -> bool:
    """Return True if the instructions of the code lie within the node."""
    begin, end = (node.lineno, node.col_offset), (node.end_lineno or 0, node.end_col_offset or 0)
    return all(
        begin <= (line, column) and (last_line or line, last_column or column) <= end
        for line, last_line, column, last_column in code.co_positions()
        if line and column
    )


class _Part:
    """A statement with the names in it.

    own: names in its expressions; names: those of the blocks within it too.
    """

    def __init__(self, statement: ast.stmt) -> None:
        self.statement = statement
        self.own: Names = {}
        for child in ast.iter_child_nodes(statement):
            if not isinstance(child, ast.stmt):
                for node in ast.walk(child):
                    if isinstance(node, ast.Name):
                        self.own.setdefault(node.id, []).append(node)
        self.blocks: list[list[_Part]] = [
            list(map(_Part, getattr(statement, part, []))) for part in ("body", "orelse")
        ]
        self.names: Names = _merged([self.own, *(part.names for block in self.blocks for part in block)])

    def begins(self, name: str) -> bool:
        """Return True if the statement assigns a name before every use."""
        direct = self.own.get(name, [])
        if isinstance(self.statement, ast.AugAssign) or any(isinstance(n.ctx, ast.Load) for n in direct):
            return False
        return bool(direct) or all(_is_new(name, _events(name, block)) for block in self.blocks)

    def early(self, name: str) -> list[ast.Name] | None:
        """Return the uses of a name before the statement assigns it.

        The result is None for a statement that does not assign it for certain.
        """
        if not isinstance(self.statement, ast.Assign):
            return None
        in_value = {id(node) for node in ast.walk(self.statement.value)}
        uses = [n for n in self.own[name] if isinstance(n.ctx, ast.Load)]
        is_assigned = len(uses) < len(self.own[name])
        return uses if is_assigned and all(id(n) in in_value for n in uses) else None


def _events(name: str, block: list[_Part]) -> list[_Part]:
    """Return the statements of a block in which a name occurs."""
    return [part for part in block if name in part.names]


def _merged(parts: Iterable[Names]) -> Names:
    names: Names = {}
    for part in parts:
        for name, nodes in part.items():
            names.setdefault(name, []).extend(nodes)
    return names


def _separate(body: list[_Part], total: dict[str, int], assigned: set[str], count: Iterator[int]) -> None:
    """Rename variables of the same name.

    A block that assigns a name without a use of its value has another variable of that name, whose type may differ.
    total: occurrences of the variable of a name in this block; assigned: names with a value before it.
    """
    within: dict[int, dict[str, int]] = {id(part): {} for part in body}
    for name, nodes in _merged(part.names for part in body).items():
        events = _events(name, body)
        if len(nodes) != total[name] or not (name in assigned or _is_new(name, events)):
            for part in events:
                within[id(part)][name] = total[name]
            continue
        for part, occurrences in _variables(name, events, count):
            within[id(part)][name] = occurrences
    for part in body:
        for block in part.blocks:
            _separate(block, within[id(part)], set(), count)


def _is_new(name: str, events: list[_Part]) -> bool:
    """Return True if no statement uses the value from before these.

    A loop or a branch may be passed over, so that the value from before it remains.
    """
    for part in events:
        if not part.begins(name):
            return False
        if part.early(name) is not None:
            break
    return True


def _variables(name: str, events: list[_Part], count: Iterator[int]) -> Iterator[tuple[_Part, int]]:
    """Rename a variable from each statement that assigns it without a use.

    Yields the statements, each with the occurrences of the variable that the name is within it.
    """
    groups: list[tuple[list[_Part], list[ast.Name]]] = [([], [])]
    for number, part in enumerate(events):
        uses = part.early(name)
        if uses is not None:
            groups[-1][1].extend(uses)
            ids = {id(n) for n in uses}
            groups.append(([part], [n for n in part.names[name] if id(n) not in ids]))
        elif _is_new(name, events[number:]):
            groups.append(([part], list(part.names[name])))
        else:
            groups[-1][0].append(part)
            groups[-1][1].extend(part.names[name])
    for parts, nodes in groups:
        new = f"{name}.{next(count)}" if any(isinstance(n.ctx, ast.Store) for n in nodes) else None
        for node in nodes if new and parts and nodes is not groups[0][1] else []:
            node.id = new or name
        yield from ((part, len(nodes)) for part in parts)


def parameters_of(node: Function) -> list[str]:
    """Return the names of a function's parameters."""
    return [argument.arg for argument in (*node.args.posonlyargs, *node.args.args)]


def body_of(node: Function) -> list[ast.stmt]:
    """Return the statements of a function, a lambda's as one return."""
    if isinstance(node, ast.Lambda):
        return [ast.copy_location(ast.Return(node.body), node.body)]
    return node.body


def bound_once(node: Function) -> set[str]:
    """Return the variables with one assignment that comes before every use.

    They need no memory: each is the value of its expression.
    """
    places: dict[str, list[Place]] = {name: [()] for name in parameters_of(node)}
    uses: list[tuple[str, Place]] = []
    _visit(list(map(_Part, body_of(node))), (), places, uses)
    late = {name for name, place in uses if name in places and not _is_before(places[name][0], place)}
    return {name for name, assigned in places.items() if len(assigned) == 1} - late


def _visit(
    body: list[_Part], around: Place, places: dict[str, list[Place]], uses: list[tuple[str, Place]]
) -> None:
    """Collect the assignments and uses of names in a block."""
    for number, part in enumerate(body):
        place = (*around, (id(body), number))
        is_loop, is_changed = (isinstance(part.statement, kind) for kind in (ast.For, ast.AugAssign))
        target_place = (*place, (id(part.blocks[0]), -1)) if is_loop else place
        for node in (node for nodes in part.own.values() for node in nodes):
            if isinstance(node.ctx, ast.Store):
                places.setdefault(node.id, []).extend([target_place] * (1 + is_changed))
            else:
                uses.append((node.id, place))
        for block in part.blocks:
            _visit(block, place, places, uses)


def _is_before(assignment: Place, use: Place) -> bool:
    """Return True if control passes the assignment before the use."""
    if not assignment:
        return True
    *around, (block, number) = assignment
    depth = len(around)
    return (
        len(use) > depth and list(use[:depth]) == around and use[depth][0] == block and use[depth][1] > number
    )
