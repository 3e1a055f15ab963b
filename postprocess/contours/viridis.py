"""The colour map viridis, without the libraries that have it too."""

import numpy as np
from numpy.typing import NDArray

KNOTS = """
    440154 46075a 470d60 471365 48186a 481d6f 482374 482878 472d7b 46327e 453781 443b84 424086
    404588 3e4989 3d4e8a 3b528b 39568c 375b8d 355f8d 33638d 31678e 2f6b8e 2e6f8e 2c728e 2a768e
    297a8e 277e8e 26828e 25858e 23898e 228d8d 21918c 1f948c 1f988b 1e9c89 1fa088 20a386 22a785
    25ab82 28ae80 2db27d 32b67a 38b977 3fbc73 46c06f 4ec36b 56c667 5ec962 67cc5c 70cf57 7ad151
    84d44b 8ed645 98d83e a2da37 addc30 b8de29 c2df23 cde11d d8e219 e2e418 ece51b f6e620 fde725
"""
"""Every fourth of its 256 colours and the last, by van der Walt and Smith (2015), dedicated to the public domain."""


def viridis(count: int) -> NDArray[np.float64]:
    """So many of its colours from end to end, red, green and blue from 0 to 1, shape (count, 3)."""
    knots = np.array([[int(knot[i : i + 2], 16) for i in (0, 2, 4)] for knot in KNOTS.split()]) / 255.0
    numbers = np.minimum(4 * np.arange(len(knots)), 255)
    asked = np.minimum(np.floor(256.0 * np.linspace(0.0, 1.0, count)), 255.0)
    return np.column_stack([np.interp(asked, numbers, part) for part in knots.T])
