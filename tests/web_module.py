"""Run kernels as WebAssembly beside Python."""

import functools
import math

import numpy as np
import wasmtime

from machine_code import web_assembly

ENGINE = wasmtime.Engine()


@functools.cache
def compiled(code):
    """Return a module for this machine, which scenes of one kind share."""
    return wasmtime.Module(ENGINE, code)


class Module:
    """Kernels in a module with its memory, called by name."""

    def __init__(self, calls):
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
        return wasmtime.Func(self.store, item.type, getattr(math, item.name))

    def call(self, name, numbers=1):
        """Call a kernel, and return the first numbers of its result."""
        result, arguments = self.layout.calls[name]
        self.exports[name](self.store, result, arguments)
        return self._bytes[result : result + 8 * numbers].view(np.float64)

    def __getitem__(self, name):
        place = self.layout.arrays[name]
        size = np.dtype(place.kind).itemsize * math.prod(place.shape)
        return self._bytes[place.at : place.at + size].view(place.kind).reshape(place.shape)
