"""Plots as SVG text with scales, ticks, marks and charts."""
