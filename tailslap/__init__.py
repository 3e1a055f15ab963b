"""Finite-element verification of the rigid-body method for vehicle impact on bridge parapets."""

__version__ = "0.1.0"
