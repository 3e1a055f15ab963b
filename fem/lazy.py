"""Modules that are imported on first use."""

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import LazyLoader, find_spec, module_from_spec
from typing import Any


def lazy_names(
    package: str, modules: Mapping[str, str]
) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """Return `__all__`, `__getattr__` and `__dir__` of a package (PEP 562).

    modules: public names by the module that defines them. A module is imported when one of its names is used.
    """
    home = {name: module for module, names in modules.items() for name in names.split()}

    def attribute(name: str) -> Any:
        if name not in home:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{home[name]}"), name)

    return (sorted(home), attribute, lambda: sorted(home))


def defer(package: str, names: str) -> None:
    """Let modules of a package be loaded when they are first used.

    It serves libraries that import all names of another one and use few.
    """
    owner = import_module(package)
    for name in names.split():
        path, spec = f"{package}.{name}", find_spec(f"{package}.{name}")
        if path not in sys.modules and spec is not None and spec.loader is not None:
            spec.loader = LazyLoader(spec.loader)
            sys.modules[path] = module = module_from_spec(spec)
            spec.loader.exec_module(module)
            setattr(owner, name, module)
