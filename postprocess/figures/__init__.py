"""Figures by matplotlib, as SVG inside pages or as PNG files."""
