"""Run kernels as WebAssembly beside Python."""

import ctypes
import functools
import math

import numpy as np
import wasmtime
from wasmtime import _ffi

from machine_code import web_assembly

ENGINE = wasmtime.Engine()
NOTHING = ctypes.CFUNCTYPE(None, ctypes.c_void_p)()
"""Finalizer that is not called."""


@functools.cache
def compiled(code):
    """Return a module for this machine, which scenes of one kind share."""
    return wasmtime.Module(ENGINE, code)


def of_numbers(function, count):
    """Return a function of numbers for `wasmtime_func_new_unchecked`.

    The functions of wasmtime.Func take ten times as long, and a motion has 100 000 calls.
    """

    def call(_, caller, numbers, size):
        numbers[0].f64 = function(*(numbers[k].f64 for k in range(count)))
        return 0

    return _ffi.wasmtime_func_unchecked_callback_t(call)


class Module:
    """Kernels in a module with its memory, called by name."""

    def __init__(self, calls):
        self.functions = []
        self.layout = web_assembly.layout(calls)
        self.store = wasmtime.Store(ENGINE)
        self.module = compiled(web_assembly.module(calls))
        pages = -(-self.layout.size // web_assembly.PAGE)
        self.memory = wasmtime.Memory(self.store, wasmtime.MemoryType(wasmtime.Limits(pages, None)))
        self.exports = wasmtime.Instance(
            self.store, self.module, [self._imported(item) for item in self.module.imports]
        ).exports(self.store)
        for place in self.layout.arrays.values():
            self._put(place.at, place.content)
        for at, content in self.layout.slots:
            self._put(at, content)

    @property
    def _bytes(self):
        """Memory of the module, which wasmtime would copy item by item."""
        return np.ctypeslib.as_array(self.memory.data_ptr(self.store), (self.memory.data_len(self.store),))

    def _put(self, at, content):
        self._bytes[at : at + len(content)] = np.frombuffer(content, np.uint8)

    def _imported(self, item):
        if isinstance(item.type, wasmtime.MemoryType):
            return self.memory
        if isinstance(item.type, wasmtime.GlobalType):
            return wasmtime.Global(self.store, item.type, wasmtime.Val.i32(web_assembly.STACK))
        kinds = [*item.type.params, *item.type.results]
        assert kinds == [wasmtime.ValType.f64()] * len(kinds)
        self.functions.append(of_numbers(getattr(math, item.name), len(item.type.params)))
        raw = _ffi.wasmtime_func_t()
        context = self.store._context()
        _ffi.wasmtime_func_new_unchecked(
            context, item.type.ptr(), self.functions[-1], None, NOTHING, ctypes.byref(raw)
        )
        return wasmtime.Func._from_raw(raw)

    def call(self, name, numbers=1):
        """Call a kernel, and return the first numbers of its result."""
        result, arguments = self.layout.calls[name]
        self.exports[name](self.store, result, arguments)
        return self._bytes[result : result + 8 * numbers].view(np.float64)

    def __getitem__(self, name):
        place = self.layout.arrays[name]
        size = np.dtype(place.kind).itemsize * math.prod(place.shape)
        return self._bytes[place.at : place.at + size].view(place.kind).reshape(place.shape)
