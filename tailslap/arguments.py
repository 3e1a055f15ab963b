"""Check arguments of the functions of `import tailslap`.

Names are those of the signature, and types those of its annotations.
"""

import functools
import inspect
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence, Sized
from numbers import Integral, Real
from types import UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

from tailslap.errors import InputError, Verbatim, demand_encodable, one_of

Function = TypeVar("Function", bound=Callable[..., Any])
UnitSystem = Literal["si", "us"]

NUMBERS = {int: Integral, float: Real}
"""Types that are accepted for those of Python, NumPy's among them."""

SMALLEST_PICTURE, LARGEST_PICTURE = 300, 8000
"""Pixels along either side of a picture."""


def checked_arguments(function: Function) -> Function:
    """Decorate a function to check its arguments.

    An argument of another type raises InputError, one of an unknown name TypeError with the nearest name.
    """
    signature = inspect.signature(function)
    parameters = signature.parameters
    takes_any = any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters.values())

    @functools.wraps(function)
    def checked(*arguments: object, **options: object) -> object:
        for name in () if takes_any else options.keys() - parameters.keys():
            hint = one_of(name, parameters, "its arguments are")
            raise TypeError(f"{function.__name__}() has no argument {name!r}; {hint}")
        for name, value in signature.bind_partial(*arguments, **options).arguments.items():
            several = parameters[name].kind is inspect.Parameter.VAR_POSITIONAL
            for item in value if several else (value,):
                _demand_type(function, name, item)
        return function(*arguments, **options)

    return checked  # type: ignore[return-value]


def picture_pixels(size: str | Sequence[int] | None) -> tuple[int, int] | None:
    """Return width and height [pixels] of a pair or a text.

    Texts are like "1600x700". Raises InputError for other values; None is returned.
    """
    if size is None:
        return None
    sides = re.split(r"\s*[xX×]\s*", size.strip()) if isinstance(size, str) else [*map(str, size)]
    pixels = [int(side) for side in sides if re.fullmatch(r"\d{1,5}", side)]
    if len(sides) != 2 or len(pixels) != 2 or min(pixels) < SMALLEST_PICTURE or max(pixels) > LARGEST_PICTURE:
        allowed = (
            f"allowed is WIDTHxHEIGHT in pixels, like 1600x700, each {SMALLEST_PICTURE} to {LARGEST_PICTURE}"
        )
        raise InputError("--picture-size", size if isinstance(size, str) else Verbatim(size), allowed)
    return pixels[0], pixels[1]


def _demand_type(function: Callable[..., object], name: str, value: object) -> None:
    """Raise InputError for a value of another type than the annotated one.

    Text must be encodable.
    """
    if not _is_of(value, _annotated(function, name)):
        described = re.search(rf"^ *\*?{name} : (.*)$", function.__doc__ or "", re.MULTILINE)
        allowed = described[1] if described else str(_annotated(function, name))
        raise InputError(name, Verbatim(repr(value)), f"allowed is {allowed}")
    text = os.fspath(value) if isinstance(value, os.PathLike) else value
    if isinstance(text, str):
        demand_encodable(name, text)


@functools.cache
def _annotated(function: Callable[..., object], name: str) -> object:
    """Return the type of a parameter, `object` for one without annotation."""
    kind = inspect.signature(function).parameters[name].annotation
    if kind is inspect.Parameter.empty:
        return object
    return eval(kind, function.__globals__) if isinstance(kind, str) else kind


def _is_of(value: object, kind: Any) -> bool:
    """Return True for a value of the type.

    Everything that has a length and is neither text nor mapping counts as a sequence.
    """
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
        return (
            isinstance(value, Sized)
            and isinstance(value, Iterable)
            and not isinstance(value, str | bytes | Mapping)
            and all(_is_of(item, inner[0]) for item in value)
        )
    if origin in NUMBERS:
        return isinstance(value, NUMBERS[origin]) and not isinstance(value, bool)
    return isinstance(value, type(None) if origin is None else origin)
