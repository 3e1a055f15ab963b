"""Stability of a plate: growth by friction, what rounding feeds into it, and frequency and stress as it is deformed."""
