"""Signals of crash tests.

Filters, durations of strikes, design forces and occupant risk.
"""
