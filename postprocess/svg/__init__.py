"""Plots as SVG text, written directly: scales with round ticks, marks, and charts made of them."""
