"""Comparison of two solutions.

Differences, error measures, orders of convergence.
"""
