"""Figures as SVG inside pages, written directly (`svg`) or by matplotlib, or as PNG files."""
