"""Uncertainty of the peak force

Distribution over the ranges of the inputs: a study of 2 000 samples.
"""

from pathlib import Path

import tailslap

found = tailslap.study("uncertainty", "mash-tl4-sut", samples=2000)
Path("uncertainty.svg").write_text(found.charts["histogram"].svg)
