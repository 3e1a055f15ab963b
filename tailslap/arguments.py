"""Check of the arguments of the functions of `import tailslap`: names, and types by their annotations."""

import functools
import inspect
import os
import re
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral, Real
from types import UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

from tailslap.errors import InputError, Verbatim, one_of

Function = TypeVar("Function", bound=Callable[..., Any])
UnitSystem = Literal["si", "us"]

NUMBERS = {int: Integral, float: Real}
"""Types that are accepted for those of Python, NumPy's among them."""


def checked_arguments(function: Function) -> Function:
    """Decorator: an argument of another type raises InputError, one of an unknown name TypeError with the nearest."""
    signature = inspect.signature(function)
    known = signature.parameters
    takes_any = any(own.kind is own.VAR_KEYWORD for own in known.values())

    @functools.wraps(function)
    def checked(*arguments: Any, **options: Any) -> Any:
        for name in () if takes_any else options.keys() - known.keys():
            hint = one_of(name, known, "its arguments are")
            raise TypeError(f"{function.__name__}() has no argument {name!r}; {hint}")
        for name, value in signature.bind_partial(*arguments, **options).arguments.items():
            several = known[name].kind is inspect.Parameter.VAR_POSITIONAL
            for item in value if several else (value,):
                _demand_type(function, name, item)
        return function(*arguments, **options)

    return checked  # type: ignore[return-value]


def _demand_type(function: Callable[..., Any], name: str, value: Any) -> None:
    """Raise InputError for a value that is not of the annotated type, or that no path and no file can have."""
    if not _is_of(value, _annotated(function, name)):
        described = re.search(rf"^ *\*?{name} : (.*)$", function.__doc__ or "", re.MULTILINE)
        allowed = described[1] if described else str(_annotated(function, name))
        raise InputError(name, Verbatim(repr(value)), f"allowed is {allowed}")
    text = os.fspath(value) if isinstance(value, os.PathLike) else value
    if isinstance(text, str) and not _is_encodable(text):
        raise InputError(name, text, "allowed is text without null characters and lone surrogates")


@functools.cache
def _annotated(function: Callable[..., Any], name: str) -> Any:
    """The type of a parameter; Any for one without annotation."""
    kind = inspect.signature(function).parameters[name].annotation
    if kind is inspect.Parameter.empty:
        return Any
    return eval(kind, function.__globals__) if isinstance(kind, str) else kind


def _is_of(value: Any, kind: Any) -> bool:
    """True for a value of the type; as sequences count all that have a length and are neither text nor mapping."""
    origin, inner = get_origin(kind) or kind, get_args(kind)
    if origin in (Union, UnionType):
        return any(_is_of(value, one) for one in inner)
    if origin is Any or origin is Literal:
        return origin is Any or (isinstance(value, str) and value in inner)
    if origin is Mapping:
        return isinstance(value, Mapping) and all(
            _is_of(part, one) for item in value.items() for part, one in zip(item, inner, strict=True)
        )
    if origin in (Sequence, tuple):
        is_row = all(hasattr(value, name) for name in ("__len__", "__iter__"))
        return (
            is_row
            and not isinstance(value, str | bytes | Mapping)
            and all(_is_of(item, inner[0]) for item in value)
        )
    if origin in NUMBERS:
        return isinstance(value, NUMBERS[origin]) and not isinstance(value, bool)
    return isinstance(value, type(None) if origin is None else origin)


def _is_encodable(text: str) -> bool:
    try:
        return b"\0" not in os.fsencode(text)
    except UnicodeEncodeError:
        return False
